//! Pictures by path tracing.

use rayon::prelude::*;

use super::sight::{add_background, look};
use super::{ACROSS, STREAM};
use crate::measure::adaptive::Task;
use crate::measure::camera::Camera;
use crate::measure::path_tracing::{Tracer, emitter_odds};
use crate::measure::result::ViewResult;
use crate::measure::statement::student;
use crate::scene::View;
use crate::transport::caster::{MISS, Ray};
use crate::transport::points::seed;

/// One picture by path tracing: `paths` paths from every pixel.
pub(in crate::measure) fn trace(task: &Task<'_>, view: &View, number: usize, paths: u64) -> ViewResult {
    let (world, optics) = (task.world, task.optics);
    let camera = Camera::new(view, &world.surfaces.frame);
    let odds = emitter_odds(world, optics);
    let stream = seed(&[task.options.seed, STREAM, 100 + number as u64]);
    let samples = ACROSS * ACROSS;
    let each = (paths / samples as u64).max(1) as u32;
    let n = optics.bands.len();
    task.progress.stage(&format!("picture {}", view.name), camera.height as u64);
    let mut radiance = vec![0.0f32; camera.width * camera.height * n];
    let errors: Vec<f64> = radiance
        .par_chunks_exact_mut(n)
        .enumerate()
        .with_min_len(16)
        .map_init(
            || Tracer::new(world, optics, &odds),
            |tracer, (pixel, out)| {
                let mut values = Vec::with_capacity(samples);
                for k in 0..samples {
                    let mut own = vec![0.0f32; optics.pad];
                    pixel_sample(
                        task,
                        &camera,
                        tracer,
                        (pixel, k),
                        seed(&[stream, pixel as u64, k as u64]),
                        each,
                        &mut own,
                    );
                    values.push(own.iter().zip(&optics.xyz[1]).map(|(l, w)| f64::from(l * w)).sum::<f64>());
                    out.iter_mut().zip(&own).for_each(|(o, v)| *o += v / samples as f32);
                }
                if pixel % camera.width == 0 {
                    task.progress.advance(1);
                }
                let mean = values.iter().sum::<f64>() / samples as f64;
                let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (samples - 1) as f64;
                let half = student((samples - 1) as f64) * (variance / samples as f64).sqrt();
                if mean > 0.0 { half / mean } else { 0.0 }
            },
        )
        .collect();
    let mut sorted: Vec<f64> = errors.into_iter().filter(|e| *e > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    ViewResult {
        view: view.clone(),
        xyz: radiance
            .chunks_exact(n)
            .map(|l| optics.bands.xyz(&l.iter().map(|x| f64::from(*x)).collect::<Vec<_>>()).map(|x| x as f32))
            .collect(),
        radiance,
        error_median: sorted.get(sorted.len() / 2).copied().unwrap_or(0.0),
        error_p95: sorted.get(sorted.len() * 95 / 100).copied().unwrap_or(0.0),
        stages: Vec::new(),
    }
}

fn pixel_sample(
    task: &Task<'_>,
    camera: &Camera,
    tracer: &mut Tracer<'_>,
    (pixel, k): (usize, usize),
    stream: u64,
    paths: u32,
    out: &mut [f32],
) {
    let place = |j: usize| (j as f64 + 0.5) / ACROSS as f64;
    let x = (pixel % camera.width) as f64 + place(k % ACROSS);
    let y = (pixel / camera.width) as f64 + place(k / ACROSS);
    let Some(direction) = camera.direction(x, y) else { return };
    let mut sights = Vec::new();
    look(task.world, task.optics, Ray::new(camera.eye(), direction), &mut sights);
    for (branch, sight) in sights.iter().enumerate() {
        if sight.surface == MISS {
            add_background(task.world, task.optics, sight, 1.0, out);
            continue;
        }
        let light = tracer.irradiance(sight.point, sight.normal, seed(&[stream, branch as u64]), paths);
        let (shares, emitted) = sight.leaving(task.world, task.optics);
        for band in 0..out.len() {
            let leaving = shares[band] * light[band] + emitted.map_or(0.0, |m| m[band]);
            out[band] += leaving * sight.tint.as_ref().map_or(1.0, |t| t[band]) * std::f32::consts::FRAC_1_PI;
        }
    }
}
