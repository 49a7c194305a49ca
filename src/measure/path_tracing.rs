//! The reference: unbiased spectral path tracing at the same sensors (Kajiya 1986), with next-event estimation.
//!
//! Simple, slow, the judge of all other methods. It shares scene and ray caster with them and nothing of the mesh, the
//! rows or the exact clipping. Light of an emitter is found in two ways, by a point chosen on it and by a ray that
//! happens to land there, weighted by the balance heuristic (Veach and Guibas 1995): a chosen point alone has no finite
//! variance where an emitter meets a wall. Paths come in independent batches of well-spread points; their scatter gives
//! the confidence interval.

use glam::DVec3;
use rayon::prelude::*;

use super::options::Progress;
use super::probe::Probe;
use super::result::{BandValue, GridResult, SensorResult, Status};
use super::statement::student;
use crate::light::Emitter;
use crate::mesh::sample_polygon;
use crate::scene::{Grid, Sensor};
use crate::transport::caster::Ray;
use crate::transport::points::{Points, seed};
use crate::transport::{
    DirectScratch, Fork, Kind, Landing, LightPart, Optics, SUN, Tint, WindowLook, WindowSight, World, chance_weight,
    cosine_direction, deposit, follow, one_place_lx, pass_out, sun_direction, through_panes, transmittance_to,
    window_along,
};

/// Independent batches.
const BATCHES: usize = 32;
/// Bounces after which weak paths are ended by chance.
const ROULETTE_FROM: u32 = 3;
const MAX_BOUNCES: u32 = 10_000;
/// Dimensions of the point set that one bounce takes: emitter (3), direction (2), pane, roulette, spare, sun (2),
/// pane to the sky (3).
const STRIDE: u32 = 13;
/// The number that draws a plane of a cylinder: beyond those of all reflections.
const PLANE: u32 = STRIDE * (MAX_BOUNCES + 1);

/// Buffers of one thread.
pub(super) struct Tracer<'a> {
    world: &'a World,
    optics: &'a Optics,
    scratch: DirectScratch,
    tint: Tint,
    throughput: Vec<f32>,
    /// Sum of one path, reflected light.
    path: Vec<f32>,
    /// Direct light at the start of one path, per unit exitance of each group.
    direct: Vec<f64>,
    /// The side of a window with a BSDF that the path stands on: what passes it is no light of its own.
    receiver: Option<(u32, bool)>,
    /// Did the path meet an outside surface first?
    met_outside: bool,
    /// Cumulated power of the emitters, and each one's share.
    odds: &'a [(f64, f64)],
    cast: u64,
}

/// Cumulated odds of the emitters, then of the luminaires, by power in all bands, and each one's own.
pub(super) fn emitter_odds(world: &World, optics: &Optics) -> Vec<(f64, f64)> {
    let of_group = |group: usize| f64::from(optics.exitance[group].iter().sum::<f32>());
    let sides = world.emitters.list.iter().map(|e: &Emitter| e.area * of_group(e.group));
    let area_m2 = world.surfaces.frame.area_m2();
    let hung = world.emitters.luminaires.iter().map(|l| l.flux_lm / area_m2 * of_group(l.group));
    let powers: Vec<f64> = sides.chain(hung).collect();
    let total: f64 = powers.iter().sum();
    let mut sum = 0.0;
    powers
        .into_iter()
        .map(|power| {
            let own = if total > 0.0 { power / total } else { 0.0 }; // all may be off
            sum += own;
            (sum, own)
        })
        .collect()
}

impl<'a> Tracer<'a> {
    pub(super) fn new(world: &'a World, optics: &'a Optics, odds: &'a [(f64, f64)]) -> Self {
        Self {
            world,
            optics,
            scratch: DirectScratch::default(),
            tint: Tint::new(optics.pad),
            throughput: vec![1.0; optics.pad],
            path: vec![0.0; optics.pad],
            direct: vec![0.0; optics.columns()],
            receiver: None,
            met_outside: false,
            odds,
            cast: 0,
        }
    }

    /// Irradiance per unit exitance from one point of one emitter, chosen by chance; weighted against [`Self::landed`].
    fn next_event(&mut self, x: DVec3, normal: DVec3, points: &Points, k: u32, dimension: u32) -> Option<(usize, f64)> {
        let want = points.get(k, dimension);
        let chosen = self.odds.iter().position(|o| want < o.0)?;
        let (a, b) = points.pair(k, dimension + 1);
        let sides = &self.world.emitters.list;
        if chosen >= sides.len() {
            // No ray lands on a luminaire: it has no rival.
            let luminaire = &self.world.emitters.luminaires[chosen - sides.len()];
            let light = one_place_lx(self.world, luminaire, x, normal, (a, b), &mut self.scratch);
            let light = light * self.kept(x - luminaire.position);
            return (light > 0.0).then(|| (luminaire.group, light / self.odds[chosen].1));
        }
        let emitter = &sides[chosen];
        let surface = &self.world.surfaces.list[emitter.surface];
        let d = surface.point(sample_polygon(&surface.outline, a, b)) - x;
        let cosines = normal.dot(d).max(0.0) * (-emitter.normal.dot(d)).max(0.0);
        if cosines <= 0.0 {
            return None;
        }
        let r2 = d.length_squared();
        let left = transmittance_to(self.world, x, d, emitter.surface, &mut self.scratch);
        let kernel = cosines / (std::f64::consts::PI * r2 * r2);
        let density = self.odds[chosen].1 / emitter.area;
        // A ray cannot land on an emitter that is itself a mirror or a pane.
        let rival = if self.world.kind(emitter.surface as u32) == Kind::Diffuse { kernel } else { 0.0 };
        let left = left * self.kept(-d);
        (left > 0.0).then(|| (emitter.group, kernel * left / (density + rival)))
    }

    /// Share of light along `travel` that does not pass the window where the path stands, over its mean.
    fn kept(&self, travel: DVec3) -> f64 {
        self.receiver.map_or(1.0, |side| WindowSight::keeps(self.world, side, travel.normalize_or_zero()))
    }

    /// Irradiance per unit exitance from where a ray from `x` landed, weighted against [`Self::next_event`]: the density
    /// of points chosen on the emitter against that of rays, both by its area.
    fn landed(&self, x: DVec3, normal: DVec3, surface: u32, front: bool, point: DVec3) -> Option<(usize, f64)> {
        let group = self.world.group(surface, front)?;
        let is_it = |e: &Emitter| e.surface == surface as usize && e.front == front;
        let chosen = self.world.emitters.list.iter().position(is_it)?;
        let emitter = &self.world.emitters.list[chosen];
        let d = point - x;
        let r2 = d.length_squared();
        let kernel = normal.dot(d).max(0.0) * (-emitter.normal.dot(d)).max(0.0) / (std::f64::consts::PI * r2 * r2);
        let density = self.odds[chosen].1 / emitter.area;
        (kernel > 0.0).then(|| (group, kernel / (kernel + density)))
    }

    /// Sun and sky by one ray each.
    fn daylight(&mut self, (x, normal): (DVec3, DVec3), points: &Points, k: u32, dimension: u32, is_direct: bool) {
        if self.world.daylight().is_none() {
            return;
        }
        self.tint.reset();
        let place = (points.get(k, dimension + 2), points.get(k, dimension + 3), points.get(k, dimension + 4));
        let panes = &self.optics.speculars;
        // From a window with a BSDF chance alone finds the panes: their direction tells what passes.
        let sky = if self.receiver.is_none() {
            through_panes(self.world, panes, (x, normal), place, &mut self.tint, &mut self.cast)
        } else {
            None
        };
        if let Some((group, factor)) = sky {
            self.add(group, factor, is_direct);
        }
        self.tint.reset();
        if let Some(cosine) = self.sun((x, normal), points.pair(k, dimension)) {
            self.add(self.optics.lamps + SUN, cosine, is_direct);
        }
        if self.world.has_bsdf() {
            let place = (points.get(k, dimension + 4), points.get(k, dimension + 3), points.get(k, dimension + 2));
            if let Some(look) = WindowLook::chosen(self.world, (x, normal), place) {
                let (a, b) = points.pair(k, dimension);
                self.through_window(x, look, (points.get(k, dimension + 5), a, b), is_direct);
            }
        }
        if self.receiver.is_some() {
            return; // its own light of the sun comes without images
        }
        let (images, scene) = (self.world.sun_images(), (self.world, &self.optics.speculars));
        let mut tint = std::mem::take(&mut self.tint);
        let mut cast = 0;
        images.by_paths(scene, (x, normal), points.pair(k, dimension), &mut tint, &mut cast, |cosine, tint| {
            self.add_tinted(self.optics.lamps + SUN, cosine, is_direct, tint);
        });
        (self.tint, self.cast) = (tint, self.cast + cast);
    }

    /// Light of the window with a BSDF that is met first in a direction.
    fn through_window(&mut self, x: DVec3, look: WindowLook, chances: (f64, f64, f64), is_direct: bool) {
        let (world, panes) = (self.world, &self.optics.speculars);
        let mut tint = std::mem::take(&mut self.tint);
        if tint.bands.len() != self.optics.pad {
            tint = Tint::new(self.optics.pad);
        }
        tint.reset();
        let mut cast = 0;
        let kept = self.kept(-look.direction);
        if let Some(window) = window_along(world, panes, x, look.direction, &mut tint, &mut cast) {
            let mut beyond = 0;
            window.shine((world, panes), look.direction, chances, &tint, &mut beyond, |group, light, tint| {
                self.add_tinted(group, kept * look.weight * light, is_direct, tint);
            });
            cast += beyond;
        }
        (self.tint, self.cast) = (tint, self.cast + cast);
    }

    /// The sun's light by one point of its disc, per unit of its irradiance face on, less what the tint tells.
    fn sun(&mut self, (x, normal): (DVec3, DVec3), (a, b): (f64, f64)) -> Option<f64> {
        let sun = self.world.daylight().and_then(|d| d.sun)?;
        let direction = sun_direction(&crate::light::sun::disc(sun), a, b);
        let cosine = normal.dot(direction);
        let is_up = cosine > 0.0 && direction.z > 0.0;
        let panes = &self.optics.speculars;
        let passes = is_up && pass_out(self.world, panes, x, direction, &mut self.tint, &mut self.cast);
        passes.then(|| cosine * self.kept(-direction))
    }

    /// One path: direct light at its start is left in `self.direct`, all else in `self.path`. Was the start free?
    fn trace(&mut self, start: DVec3, facing: DVec3, points: &Points, k: u32) -> bool {
        self.path.fill(0.0);
        self.direct.fill(0.0);
        self.throughput.fill(1.0);
        self.met_outside = false;
        self.receiver = None;
        self.tint.reset();
        if let Some((group, factor)) = self.next_event(start, facing, points, k, 0) {
            self.add(group, factor, true);
        }
        self.daylight((start, facing), points, k, 8, true);
        let (mut x, mut normal) = (start, facing);
        for bounce in 0..MAX_BOUNCES {
            let base = bounce * STRIDE;
            let (a, b) = points.pair(k, base + 3);
            let ray = Ray::new(x, cosine_direction(normal, a, b));
            if self.world.has_bsdf() && self.world.daylight().is_some() {
                let look = WindowLook::by_chance(self.world, (x, normal), ray.along());
                let chances = (points.get(k, base + 7), points.get(k, base + 11), points.get(k, base + 12));
                self.through_window(x, look, chances, bounce == 0);
            }
            let kept = self.kept(-ray.along()) as f32;
            self.throughput.iter_mut().for_each(|t| *t *= kept);
            let hit = self.world.caster.closest(&ray);
            self.cast += 1;
            self.tint.reset();
            let fork = Fork::Chance(points.get(k, base + 5));
            let landing = follow(self.world, self.optics, ray, hit, fork, &mut self.tint, &mut self.cast);
            if let Landing::Escaped { direction, mirrored } = landing
                && let Some((group, light)) = self.world.background(direction)
            {
                let weight = if mirrored || self.receiver.is_some() {
                    1.0
                } else {
                    chance_weight(self.world, (x, normal), direction)
                };
                self.add(group, light * weight, bounce == 0);
            }
            let Landing::Surface { surface, front, point, mirrored, .. } = landing else {
                return bounce > 0 || !matches!(landing, Landing::Covered);
            };
            let s = &self.world.surfaces.list[surface as usize];
            // Next events do not see what mirrors show: such a landing has no rival.
            let seen = if mirrored {
                self.world.group(surface, front).map(|group| (group, 1.0))
            } else {
                self.landed(x, normal, surface, front, point)
            };
            self.met_outside |= bounce == 0 && self.world.is_outside(surface);
            if let Some((group, weight)) = seen {
                self.add(group, weight, bounce == 0 && !mirrored);
            }
            let mut chance = points.get(k, base + 6);
            let scatter = self.optics.scatter(s.material, front, &mut chance);
            let mut strongest = 0.0f32;
            for band in 0..self.throughput.len() {
                self.throughput[band] *= scatter.shares[band] / scatter.odds * self.tint.share(band);
                strongest = strongest.max(self.throughput[band]);
            }
            if bounce >= ROULETTE_FROM || strongest == 0.0 {
                let survival = strongest.min(0.95);
                if chance >= f64::from(survival) {
                    return true;
                }
                self.throughput.iter_mut().for_each(|t| *t /= survival);
            }
            normal = s.side_normal(front != scatter.passes);
            x = self.world.lift(s.point(s.uv(point)), normal);
            self.receiver = self.world.scatterer(surface).map(|_| (surface, front));
            self.tint.reset();
            if let Some((group, factor)) = self.next_event(x, normal, points, k, base + STRIDE) {
                self.add(group, factor, false);
            }
            self.daylight((x, normal), points, k, base + STRIDE + 8, false);
        }
        true
    }

    /// Adds light of a group that came through the tint: to the direct light of the start, or to the path.
    fn add(&mut self, group: usize, weight: f64, is_direct: bool) {
        let tint = std::mem::take(&mut self.tint);
        self.add_tinted(group, weight, is_direct, &tint);
        self.tint = tint;
    }

    fn add_tinted(&mut self, group: usize, weight: f64, is_direct: bool, tint: &Tint) {
        if is_direct && !tint.coloured {
            self.direct[group] += weight * f64::from(tint.scale);
            return;
        }
        if is_direct && group >= self.optics.lamps {
            let lamps = self.optics.lamps;
            return deposit(&mut self.direct[lamps..], group - lamps, weight, tint);
        }
        for band in 0..self.path.len() {
            let share = tint.share(band) * weight as f32;
            self.path[band] += self.throughput[band] * share * self.optics.exitance[group][band];
        }
    }
}

/// Sums of one batch.
struct Batch {
    reflected: Vec<f64>,
    /// The part of `reflected` that last left an outside surface.
    external: Vec<f64>,
    direct: Vec<f64>,
    paths: f64,
}

/// Traces `paths` paths from every sensor of a grid.
pub(super) fn grid(
    world: &World,
    optics: &Optics,
    grid: &Grid,
    stream: u64,
    paths: u64,
    spectral: bool,
    progress: &dyn Progress,
) -> (GridResult, u64) {
    let odds = emitter_odds(world, optics);
    let results: Vec<(SensorResult, u64)> = grid
        .sensors
        .par_iter()
        .enumerate()
        .with_max_len(1)
        .map_init(
            || Tracer::new(world, optics, &odds),
            |tracer, (i, s)| {
                let before = tracer.cast + tracer.scratch.rays;
                let probe = Probe::new(world, s, grid.receiver);
                let result = tracer.sensor(s, &probe, seed(&[stream, i as u64]), paths, spectral);
                progress.advance(1);
                (result, tracer.cast + tracer.scratch.rays - before)
            },
        )
        .collect();
    let rays = results.iter().map(|r| r.1).sum();
    let sensors: Vec<SensorResult> = results.into_iter().map(|r| r.0).collect();
    (GridResult { name: grid.name.clone(), layout: grid.layout.clone(), sensors, holding: 0 }, rays)
}

impl Tracer<'_> {
    fn sensor(&mut self, sensor: &Sensor, probe: &Probe, stream: u64, paths: u64, spectral: bool) -> SensorResult {
        let mut result = SensorResult::new(sensor, probe.status);
        if probe.status != Status::Ok {
            return result;
        }
        let per_batch = (paths / BATCHES as u64).max(1) as u32;
        let batches: Vec<Batch> =
            (0..BATCHES).map(|b| self.batch(probe, seed(&[stream, b as u64]), per_batch)).collect();
        let n = self.optics.bands.len();
        let bands = |b: &Batch| -> Vec<f64> {
            (0..n)
                .map(|band| {
                    let direct = self.optics.direct_in_band(&b.direct, band);
                    (b.reflected[band] + direct) / b.paths
                })
                .collect()
        };
        let by_batch: Vec<Vec<f64>> = batches.iter().map(bands).collect();
        let half_width = |f: &dyn Fn(&[f64]) -> f64| {
            let values: Vec<f64> = by_batch.iter().map(|b| f(b)).collect();
            let mean = values.iter().sum::<f64>() / BATCHES as f64;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (BATCHES - 1) as f64;
            (mean, student((BATCHES - 1) as f64) * (variance / BATCHES as f64).sqrt())
        };
        let means: Vec<BandValue> = (0..n)
            .map(|band| {
                let (irradiance, error) = half_width(&|b| b[band]);
                BandValue { irradiance, error }
            })
            .collect();
        let optics = self.optics;
        result.error_lx = half_width(&|b| optics.bands.xyz(b)[1]).1;
        result.xyz = optics.bands.xyz(&means.iter().map(|b| b.irradiance).collect::<Vec<_>>());
        let mean = |f: &dyn Fn(&Batch) -> f64| batches.iter().map(|b| f(b) / b.paths).sum::<f64>() / BATCHES as f64;
        let part = |part| mean(&|b| optics.lux_of_direct(&b.direct, &[1.0], part));
        let lux = |bands: &[f64]| optics.bands.xyz(&bands[..n])[1];
        let external = mean(&|b| lux(&b.external));
        result.direct_lx = part(LightPart::Lamps);
        result.sun_lx = part(LightPart::Sun);
        result.sky_lx = part(LightPart::Sky);
        result.external_lx = part(LightPart::Ground) + external;
        result.reflected_lx = mean(&|b| lux(&b.reflected)) - external;
        if spectral {
            result.spectral = means;
        }
        result
    }

    fn batch(&mut self, probe: &Probe, stream: u64, paths: u32) -> Batch {
        let points = Points::new(stream);
        let mut batch = Batch {
            reflected: vec![0.0; self.optics.pad],
            external: vec![0.0; self.optics.pad],
            direct: vec![0.0; self.optics.columns()],
            paths: 0.0,
        };
        for k in 0..paths {
            let normal = probe.facing.plane(points.get(k, PLANE));
            if !self.trace(probe.position, normal, &points, k) {
                continue;
            }
            batch.paths += 1.0;
            for (sum, factor) in batch.direct.iter_mut().zip(&self.direct) {
                *sum += factor;
            }
            for (sum, v) in batch.reflected.iter_mut().zip(&self.path) {
                *sum += f64::from(*v);
            }
            if self.met_outside {
                for (sum, v) in batch.external.iter_mut().zip(&self.path) {
                    *sum += f64::from(*v);
                }
            }
        }
        batch.paths = batch.paths.max(1.0);
        batch
    }

    /// Irradiance at a point by `paths` paths, by band: for pictures.
    pub(super) fn irradiance(&mut self, x: DVec3, normal: DVec3, stream: u64, paths: u32) -> Vec<f32> {
        let probe = Probe { position: x, eye: x, normal, facing: normal.into(), status: Status::Ok };
        let batch = self.batch(&probe, stream, paths);
        (0..self.optics.pad)
            .map(|band| {
                ((batch.reflected[band] + self.optics.direct_in_band(&batch.direct, band)) / batch.paths) as f32
            })
            .collect()
    }
}
