//! Where the light went: every line is summed on its own, and then they must close.

use rayon::prelude::*;

use super::gather::Solved;
use super::result::Ledger;
use crate::mesh::{NO_ELEMENT, sample_polygon};
use crate::transport::caster::Ray;
use crate::transport::points::{Points, seed};
use crate::transport::{Fork, Landing, Optics, Tint, World, cosine_direction, follow};

/// Two-sided 99 % quantile of Student's t for the three degrees of freedom of four replicas: an open balance is to be a
/// bug, not bad luck.
const STUDENT_99: f64 = 5.841;
/// Rays from each group of emitters, in each set.
const RAYS: u32 = 1 << 15;

/// What became of the light that leaves the emitters, before any diffuse reflection, by band.
struct Emitted {
    escaped: Vec<f64>,
    lost: Vec<f64>,
    unexpanded: Vec<f64>,
}

/// Draws up the balance of a solution.
pub(super) fn balance(world: &World, optics: &Optics, solved: &Solved, seed_of_run: u64) -> Ledger {
    let n = optics.bands.len();
    let unit = world.surfaces.frame.area_m2();
    let areas = world.emitters.group_areas();
    let solution = &solved.solution;
    let sets: Vec<Emitted> =
        (0..solution.replicas).into_par_iter().map(|r| shoot(world, optics, solved, &areas, seed_of_run, r)).collect();
    let mut ledger = Ledger::default();
    for band in 0..n {
        let emitted: f64 = areas.iter().zip(&optics.exitance).map(|(a, m)| a * f64::from(m[band])).sum();
        let replicas = solution.replicas as f64;
        let mean = |f: &dyn Fn(usize) -> f64| (0..solution.replicas).map(f).sum::<f64>() / replicas;
        let absorbed = |r: usize| solution.absorbed[r][band] + solution.lost[r][band] + sets[r].lost[band];
        let escaped = |r: usize| solution.escaped[r][band] + sets[r].escaped[band];
        let unexpanded = |r: usize| sets[r].unexpanded[band];
        let closing = |r: usize| emitted - absorbed(r) - escaped(r) - unexpanded(r);
        let centre = mean(&closing);
        let variance = mean(&|r| (closing(r) - centre).powi(2)) * replicas / (replicas - 1.0).max(1.0);
        ledger.emitted.push(emitted * unit);
        ledger.absorbed.push(mean(&absorbed) * unit);
        ledger.escaped.push(mean(&escaped) * unit);
        ledger.unexpanded.push(mean(&unexpanded) * unit);
        ledger.sampling_error.push(STUDENT_99 * (variance / replicas).sqrt() * unit);
    }
    ledger
}

fn shoot(world: &World, optics: &Optics, solved: &Solved, areas: &[f64], seed_of_run: u64, set: usize) -> Emitted {
    let n = optics.bands.len();
    let mut out = Emitted { escaped: vec![0.0; n], lost: vec![0.0; n], unexpanded: vec![0.0; n] };
    let mut tint = Tint::new(optics.pad);
    for (group, area) in areas.iter().enumerate() {
        let members: Vec<_> = world.emitters.list.iter().filter(|e| e.group == group).collect();
        let points = Points::new(seed(&[seed_of_run, 5, group as u64, set as u64]));
        let flux: Vec<f64> =
            (0..n).map(|band| area * f64::from(optics.exitance[group][band]) / f64::from(RAYS)).collect();
        for k in 0..RAYS {
            let mut want = points.get(k, 4) * area;
            let emitter = members
                .iter()
                .find(|e| {
                    want -= e.area;
                    want <= 0.0
                })
                .unwrap_or(&members[members.len() - 1]);
            let surface = &world.surfaces.list[emitter.surface];
            let (a, b) = points.pair(k, 0);
            let (c, d) = points.pair(k, 2);
            let start = world.lift(surface.point(sample_polygon(&surface.outline, a, b)), emitter.normal);
            let ray = Ray::new(start, cosine_direction(emitter.normal, c, d));
            let hit = world.caster.closest(&ray);
            tint.reset();
            let fork = Fork::Chance(points.get(k, 5));
            let landing = follow(world, optics, ray, hit, fork, &mut tint, &mut 0);
            if world.glowing() {
                // What was modelled left with the elements' radiosity and is accounted there.
                let uv = surface.uv(start);
                let key = solved.mesh.key_at(emitter.surface, emitter.front, uv);
                if solved.mesh.find(key) == NO_ELEMENT {
                    enter(&mut out.unexpanded, &flux, |_| 1.0);
                } else if matches!(landing, Landing::Covered) {
                    enter(&mut out.lost, &flux, |_| 1.0);
                }
                continue;
            }
            let fate = match landing {
                Landing::Escaped { .. } => Some(&mut out.escaped),
                Landing::Surface { surface, front, point, .. } => {
                    let uv = world.surfaces.list[surface as usize].uv(point);
                    let key = solved.mesh.key_at(surface as usize, front, uv);
                    (solved.mesh.find(key) == NO_ELEMENT).then_some(&mut out.unexpanded)
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

/// Adds a share of a ray's flux, band by band.
fn enter(sums: &mut [f64], flux: &[f64], share: impl Fn(usize) -> f32) {
    for (band, (sum, flux)) in sums.iter_mut().zip(flux).enumerate() {
        *sum += flux * f64::from(share(band));
    }
}
