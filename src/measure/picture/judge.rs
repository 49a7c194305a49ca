//! The error of a picture, stated at pixels spread over it, and the rays that its noise asks for.

use glam::DVec3;
use rayon::prelude::*;

use super::sight::look;
use crate::measure::adaptive::Task;
use crate::measure::camera::Camera;
use crate::measure::gather::{Field, Gatherer, REPLICAS, SetSums};
use crate::measure::solved::Solved;
use crate::measure::statement::{Readings, Stated, design_effect, state};
use crate::transport::caster::{MISS, Ray};
use crate::transport::points::seed;

/// Share of the tolerance that the noise of a pixel may take.
const NOISE: f64 = 0.45;
/// Exponent by which the variance of well-spread rays falls with their number.
const DECAY: f64 = 1.4;
/// Rays of a first look, and most rays, at one place.
pub(super) const FIRST_RAYS: u32 = 256;
const MOST_RAYS: u32 = 1 << 12;
/// Places at which the error is stated.
const JUDGED: usize = 400;

/// What decides how many rays a place needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    /// Variance of [`FIRST_RAYS`] well-spread rays against that of as many independent ones.
    design: f64,
    /// Mean illuminance of what the picture shows, lx.
    mean: f64,
    pub(super) tolerance: f64,
}

impl Noise {
    /// Rays that keep the noise of an illuminance to its share of the tolerance, when `1 / share` such readings are
    /// averaged; `variance` is that of one ray.
    pub(super) fn rays(&self, variance: f64, illuminance: f64, share: f64) -> u32 {
        let least = f64::from(FIRST_RAYS) / 2.0;
        let scale = illuminance.max(0.1 * self.mean);
        if variance <= 0.0 || scale <= 0.0 {
            return least as u32;
        }
        let now = self.design * variance / f64::from(FIRST_RAYS);
        let allowed = (NOISE * self.tolerance * scale / 1.96).powi(2);
        let wanted = share * f64::from(FIRST_RAYS) * (now / allowed).powf(1.0 / DECAY);
        wanted.clamp(least, f64::from(MOST_RAYS)) as u32
    }
}

/// A place whose error is stated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) pixel: usize,
    point: DVec3,
    normal: DVec3,
}

/// What the judged places tell of a picture.
pub(super) struct Judged {
    pub(super) places: Vec<Place>,
    pub(super) stated: Vec<Stated>,
    pub(super) noise: Noise,
    pub(super) rays: u64,
}

/// States the error of the irradiance at some pixels, each with the rays that its noise asks for.
pub(super) fn judge(task: &Task<'_>, camera: &Camera, main: &Solved, twin: &Solved, stream: u64) -> Judged {
    let places = judged_places(task, camera);
    let (first, cast) = read_all(task, &places, main, twin, stream, &vec![FIRST_RAYS; places.len()]);
    let values: Vec<f64> = state(&first, 0.0).iter().map(|s| s.value).collect();
    let noise = Noise {
        design: design_effect(&first),
        mean: values.iter().sum::<f64>() / values.len().max(1) as f64,
        tolerance: task.options.tolerance,
    };
    let rays: Vec<u32> =
        first.iter().zip(&values).map(|(r, v)| noise.rays(r.naive * f64::from(FIRST_RAYS), *v, 1.0)).collect();
    let (second, more) = read_all(task, &places, main, twin, stream, &rays);
    Judged { stated: state(&second, 0.0), places, noise, rays: cast + more }
}

/// Points seen by pixels spread over the picture, with their normals.
fn judged_places(task: &Task<'_>, camera: &Camera) -> Vec<Place> {
    let pixels = camera.width * camera.height;
    let stride = (pixels as f64 / JUDGED as f64).max(1.0);
    let mut sights = Vec::new();
    (0..pixels.min(JUDGED))
        .filter_map(|k| {
            let pixel = ((k as f64 + 0.5) * stride) as usize % pixels;
            let (x, y) = ((pixel % camera.width) as f64 + 0.5, (pixel / camera.width) as f64 + 0.5);
            look(task.world, task.optics, Ray::new(camera.eye(), camera.direction(x, y)?), &mut sights);
            sights.first().filter(|s| s.surface != MISS).map(|s| Place { pixel, point: s.point, normal: s.normal })
        })
        .collect()
}

/// Reads every place with its number of rays.
fn read_all(
    task: &Task<'_>,
    places: &[Place],
    main: &Solved,
    twin: &Solved,
    stream: u64,
    rays: &[u32],
) -> (Vec<Readings>, u64) {
    let field =
        Field { world: task.world, optics: task.optics, main, twin: Some(twin), spectral: false, squares: false };
    let readings: Vec<(Readings, u64)> = places
        .par_iter()
        .zip(rays)
        .enumerate()
        .map_init(
            || Gatherer::new(&field),
            |g, (i, (place, rays))| {
                let before = g.cast + g.scratch.rays;
                let reading =
                    read(task, g, place.point, place.normal, seed(&[stream, 2, i as u64]), rays / REPLICAS as u32);
                (reading, g.cast + g.scratch.rays - before)
            },
        )
        .collect();
    let cast = readings.iter().map(|r| r.1).sum();
    (readings.into_iter().map(|r| r.0).collect(), cast)
}

fn read(task: &Task<'_>, g: &mut Gatherer<'_>, x: DVec3, normal: DVec3, stream: u64, set: u32) -> Readings {
    let optics = task.optics;
    let factors = g.direct(x, normal, stream);
    let direct = optics.xyz_of_direct(&factors, &[1.0])[1];
    let mut reading = Readings::default();
    let (mut mean, mut square) = (0.0, 0.0);
    let mut sets = Vec::with_capacity(REPLICAS);
    for a in 0..REPLICAS {
        let mut sums = SetSums::new(optics, REPLICAS, true);
        g.gather(x, normal.into(), seed(&[stream, a as u64]), (0, set), &mut sums);
        for b in 0..REPLICAS {
            let reflected = sums.xyz(b, optics, &[1.0], false)[1];
            reading.main[a][b] = direct + reflected;
            reading.twin[a][b] = direct + sums.xyz(b, optics, &[1.0], true)[1];
            mean += reflected / (REPLICAS * REPLICAS) as f64;
        }
        square += sums.mean_square_y(&[1.0]) / REPLICAS as f64;
        sets.push(sums);
    }
    let rays = f64::from(set * REPLICAS as u32);
    reading.naive = (square - mean * mean).max(0.0) / rays;
    reading.skewness = SetSums::square_of_skewness(&sets) / rays;
    reading
}
