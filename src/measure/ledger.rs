//! Where the light went: every line is summed on its own, and then they must close.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::result::Ledger;
use super::solved::Solved;
use crate::light::Emitter;
use crate::light::sun::disc;
use crate::mesh::{NO_ELEMENT, sample_polygon};
use crate::transport::caster::Ray;
use crate::transport::points::{Points, seed};
use crate::transport::{Fork, Landing, Optics, SUN, Tint, World, cosine_direction, follow, sun_direction};

/// Two-sided 99 % quantile of Student's t for the three degrees of freedom of four replicas: an open balance is to be a
/// bug, not bad luck.
const STUDENT_99: f64 = 5.841;
/// Rays in each set at a tolerance of 1 % or less: from all emitters together; from sky and ground; from the sun.
const MOST_RAYS: f64 = 32_768.0;
/// Rays from one group of emitters, at least.
const FEWEST_RAYS: u32 = 512;
/// Radius of the sphere about a scene of size one.
const RADIUS: f64 = 0.5;

/// What became of the light that leaves the emitters, before any diffuse reflection, by band.
struct Emitted {
    escaped: Vec<f64>,
    lost: Vec<f64>,
    unexpanded: Vec<f64>,
}

/// Draws up the balance of a solution, as finely as a run of this tolerance deserves.
pub(super) fn balance(world: &World, optics: &Optics, solved: &Solved, tolerance: f64, seed_of_run: u64) -> Ledger {
    let rays = ((MOST_RAYS * (0.01 / tolerance).min(1.0)) as u32).next_power_of_two();
    let n = optics.bands.len();
    let unit = world.surfaces.frame.area_m2();
    let areas = world.emitters.group_areas(unit);
    let solution = &solved.solution;
    let sets: Vec<Emitted> = (0..solution.replicas)
        .into_par_iter()
        .map(|r| shoot(world, optics, solved, &areas, rays, seed(&[seed_of_run, 5, r as u64])))
        .collect();
    let entered: Vec<Vec<f64>> = (0..solution.replicas)
        .into_par_iter()
        .map(|r| daylight_entering(world, optics, solved, rays, seed(&[seed_of_run, 6, r as u64])))
        .collect();
    let mut ledger = Ledger::default();
    for band in 0..n {
        let lamps: f64 = areas.iter().zip(&optics.exitance).map(|(a, m)| a * f64::from(m[band])).sum();
        let replicas = solution.replicas as f64;
        let mean = |f: &dyn Fn(usize) -> f64| (0..solution.replicas).map(f).sum::<f64>() / replicas;
        let absorbed = |r: usize| solution.absorbed[r][band] + solution.lost[r][band] + sets[r].lost[band];
        let escaped = |r: usize| solution.escaped[r][band] + sets[r].escaped[band];
        let unexpanded = |r: usize| sets[r].unexpanded[band];
        let emitted = |r: usize| lamps + entered[r][band];
        let closing = |r: usize| emitted(r) - absorbed(r) - escaped(r) - unexpanded(r);
        let centre = mean(&closing);
        let variance = mean(&|r| (closing(r) - centre).powi(2)) * replicas / (replicas - 1.0).max(1.0);
        ledger.emitted.push(mean(&emitted) * unit);
        ledger.absorbed.push(mean(&absorbed) * unit);
        ledger.escaped.push(mean(&escaped) * unit);
        ledger.unexpanded.push(mean(&unexpanded) * unit);
        ledger.sampling_error.push(STUDENT_99 * (variance / replicas).sqrt() * unit);
    }
    ledger
}

fn shoot(world: &World, optics: &Optics, solved: &Solved, areas: &[f64], rays: u32, stream: u64) -> Emitted {
    let n = optics.bands.len();
    let mut out = Emitted { escaped: vec![0.0; n], lost: vec![0.0; n], unexpanded: vec![0.0; n] };
    let mut tint = Tint::new(optics.pad);
    let rays = (rays / areas.len().max(1) as u32).max(FEWEST_RAYS);
    for (group, area) in areas.iter().enumerate() {
        let points = Points::new(seed(&[stream, group as u64]));
        let of_group: Vec<f64> =
            (0..n).map(|band| area * f64::from(optics.exitance[group][band]) / f64::from(rays)).collect();
        for k in 0..rays {
            let launch = launch(world, group, *area, &points, k);
            let ray = launch.ray;
            let flux: Vec<f64> = of_group.iter().map(|f| f * launch.weight).collect();
            let hit = world.caster.closest(&ray);
            tint.reset();
            let fork = Fork::Shot(points.get(k, 5));
            let landing = follow(world, optics, ray, hit, fork, &mut tint, &mut 0);
            if let Some(emitter) = launch.side.filter(|_| world.glowing()) {
                // What was modelled left with the elements' radiosity and is accounted there.
                let uv = world.surfaces.list[emitter.surface].uv(ray.at(0.0));
                let key = solved.mesh.key_at(emitter.surface, emitter.front, uv);
                if solved.mesh.find(key) == NO_ELEMENT {
                    enter(&mut out.unexpanded, &flux, |_| 1.0);
                } else if matches!(landing, Landing::Covered) {
                    enter(&mut out.lost, &flux, |_| 1.0);
                }
                continue;
            }
            let fate = match landing {
                Landing::Escaped { .. } | Landing::Scattered { .. } => Some(&mut out.escaped),
                Landing::Surface { surface, front, point, mirrored, .. } => {
                    let uv = world.surfaces.list[surface as usize].uv(point);
                    let key = solved.mesh.key_at(surface as usize, front, uv);
                    // Mirrors show no luminaires: what they pass on is not modelled.
                    let unseen = mirrored && launch.side.is_none();
                    (unseen || solved.mesh.find(key) == NO_ELEMENT).then_some(&mut out.unexpanded)
                }
                Landing::Covered | Landing::Lost => Some(&mut out.lost),
            };
            if let Some(sums) = fate {
                enter(sums, &flux, |band| tint.share(band));
            }
            if tint.panes > 0 || tint.scale != 1.0 || tint.coloured {
                enter(&mut out.lost, &flux, |band| 1.0 - tint.share(band));
            }
        }
    }
    out
}

/// A ray that carries light of a group away.
struct Launch<'a> {
    ray: Ray,
    /// Its flux over the mean of the group's rays.
    weight: f64,
    /// The emitting side; none for luminaires.
    side: Option<&'a Emitter>,
}

/// The `k`th ray of a group: from sides by area and cosine, from luminaires by flux in even directions.
fn launch<'a>(world: &'a World, group: usize, area: f64, points: &Points, k: u32) -> Launch<'a> {
    let emitters = &world.emitters;
    let mut want = points.get(k, 4) * area;
    let mut take = |own: f64| {
        want -= own;
        want <= 0.0
    };
    let ((a, b), (c, d)) = (points.pair(k, 0), points.pair(k, 2));
    let mut sides = emitters.list.iter().filter(|e| e.group == group);
    if let Some(side) = sides.clone().find(|e| take(e.area)).or_else(|| sides.next_back()) {
        let surface = &world.surfaces.list[side.surface];
        let start = world.lift(surface.point(sample_polygon(&surface.outline, a, b)), side.normal);
        let ray = Ray::new(start, cosine_direction(side.normal, c, d));
        return Launch { ray, weight: 1.0, side: Some(side) };
    }
    let unit = world.surfaces.frame.area_m2();
    let mut hung = emitters.luminaires.iter().filter(|l| l.group == group);
    let height = 2.0 * c - 1.0;
    let direction = (DVec2::from_angle(TAU * d) * (1.0 - height * height).max(0.0).sqrt()).extend(height);
    let Some(l) = hung.clone().find(|l| take(l.flux_lm / unit)).or_else(|| hung.next_back()) else {
        return Launch { ray: Ray::new(DVec3::ZERO, direction), weight: 0.0, side: None };
    };
    let (start, normal) = l.start(direction, a, b);
    let weight = 4.0 * PI * l.intensity(direction) / l.flux_lm;
    Launch { ray: Ray::new(world.lift(start, normal), direction), weight, side: None }
}

/// Flux of sky, ground and sun that arrives on the elements, by band: parallel rays from all directions upon the sphere
/// about the scene. It shares nothing with the integrals that made the elements' direct light.
fn daylight_entering(world: &World, optics: &Optics, solved: &Solved, rays: u32, stream: u64) -> Vec<f64> {
    let n = optics.bands.len();
    let mut entered = vec![0.0; n];
    let Some(light) = world.daylight() else { return entered };
    let points = Points::new(stream);
    let mut tint = Tint::new(optics.pad);
    let mut shoot = |direction: DVec3, k: u32, group: usize, irradiance: f64, most_mirrors: u32| {
        let (a, b) = points.pair(k, 2);
        // A cosine-distributed direction lies over a uniform point of the disc.
        let above = cosine_direction(direction, a, b);
        let on_disc = above - direction * above.dot(direction);
        let ray = Ray::new((on_disc + direction) * RADIUS, -direction);
        let hit = world.caster.closest(&ray);
        tint.reset();
        let landing = follow(world, optics, ray, hit, Fork::Shot(points.get(k, 5)), &mut tint, &mut 0);
        let Landing::Surface { surface, front, point, .. } = landing else { return };
        let key = solved.mesh.key_at(surface as usize, front, world.surfaces.list[surface as usize].uv(point));
        // Windows with a BSDF throw on the sun that they see themselves.
        let is_sun = most_mirrors < u32::MAX;
        let too_far = is_sun && tint.scatterers > 0 && tint.scatterers + tint.mirrors > 1;
        if too_far || tint.mirrors > most_mirrors || solved.mesh.find(key) == NO_ELEMENT {
            return;
        }
        let flux = irradiance * PI * RADIUS * RADIUS / f64::from(rays);
        for (band, sum) in entered.iter_mut().enumerate() {
            *sum += flux * f64::from(optics.exitance[group][band]) * f64::from(tint.share(band));
        }
    };
    for k in 0..rays {
        let (a, b) = points.pair(k, 0);
        let height = 2.0 * a - 1.0;
        let direction = (DVec2::from_angle(TAU * b) * (1.0 - height * height).sqrt()).extend(height);
        if let Some((group, weight)) = world.background(direction) {
            // 4π of directions, each with the radiance weight/π.
            shoot(direction, k, group, 4.0 * weight, u32::MAX);
        }
    }
    if let Some(sun) = light.sun {
        let disc = disc(sun);
        for k in 0..rays {
            let (a, b) = points.pair(k, 6);
            // The elements get one reflection of the sun, no more.
            shoot(sun_direction(&disc, a, b), k, optics.lamps + SUN, 1.0, 1);
        }
    }
    entered
}

/// Adds a share of a ray's flux, band by band.
fn enter(sums: &mut [f64], flux: &[f64], share: impl Fn(usize) -> f32) {
    for (band, (sum, flux)) in sums.iter_mut().zip(flux).enumerate() {
        *sum += flux * f64::from(share(band));
    }
}
