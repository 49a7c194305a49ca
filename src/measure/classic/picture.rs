//! Pictures from a solved mesh: radiosities, linear between patches, as in the classic papers.

use rayon::prelude::*;

use super::super::adaptive::Task;
use super::super::camera::Camera;
use super::super::options::Display;
use super::super::result::{PictureStage, ViewResult};
use super::level::Level;
use super::stages::Stage;
use crate::scene::View;
use crate::transport::caster::{MISS, Ray};

/// Samples across a pixel.
const ACROSS: usize = 2;

/// Paints a view from the finer of two meshes; what the coarser one shows tells the error.
pub(super) fn paint(task: &Task<'_>, view: &View, fine: &Level, coarse: &Level) -> ViewResult {
    let camera = Camera::new(view, &task.world.surfaces.frame);
    let bands = task.optics.bands.len();
    task.progress.stage(&format!("picture {}", view.name), 0);
    let mut radiance = vec![0.0f32; camera.width * camera.height * bands];
    let xyz: Vec<([f64; 3], f64)> = radiance
        .par_chunks_exact_mut(bands)
        .enumerate()
        .with_min_len(64)
        .map(|(pixel, out)| {
            let seen = pixel_of(task, &camera, fine, &fine.solved.radiosity, pixel);
            out.iter_mut().zip(&seen).for_each(|(o, l)| *o = *l as f32);
            let xyz = task.optics.bands.xyz(&seen);
            let other = task.optics.bands.xyz(&pixel_of(task, &camera, coarse, &coarse.solved.radiosity, pixel))[1];
            (xyz, if xyz[1] > 0.0 { (xyz[1] - other).abs() / xyz[1] } else { 0.0 })
        })
        .collect();
    let mut errors: Vec<f64> = xyz.iter().map(|p| p.1).filter(|e| *e > 0.0).collect();
    errors.sort_by(f64::total_cmp);
    let at = |share: usize| errors.get(errors.len() * share / 100).copied().unwrap_or(0.0);
    ViewResult {
        view: view.clone(),
        xyz: xyz.iter().map(|p| p.0.map(|x| x as f32)).collect(),
        radiance,
        error_median: at(50),
        error_p95: at(95),
        stages: Vec::new(),
    }
}

/// The same view with the radiosities of a stage of its mesh.
pub(super) fn paint_stage(task: &Task<'_>, view: &View, level: &Level, stage: &Stage) -> PictureStage {
    let camera = Camera::new(view, &task.world.surfaces.frame);
    let colour = |pixel| task.optics.bands.xyz(&pixel_of(task, &camera, level, &stage.radiosity, pixel));
    PictureStage {
        name: stage.name.into(),
        shots: stage.shots,
        unshot: stage.unshot,
        xyz: (0..camera.width * camera.height)
            .into_par_iter()
            .with_min_len(64)
            .map(|pixel| colour(pixel).map(|x| x as f32))
            .collect(),
    }
}

/// Radiance of a pixel from the radiosities of a mesh, W/(m² sr nm).
fn pixel_of(task: &Task<'_>, camera: &Camera, level: &Level, radiosity: &[f64], pixel: usize) -> Vec<f64> {
    let bands = task.optics.bands.len();
    let mut sum = vec![0.0; bands];
    let samples = (ACROSS * ACROSS) as f64;
    for k in 0..ACROSS * ACROSS {
        let place = |k: usize| (k as f64 + 0.5) / ACROSS as f64;
        let x = (pixel % camera.width) as f64 + place(k % ACROSS);
        let y = (pixel / camera.width) as f64 + place(k / ACROSS);
        let Some(direction) = camera.direction(x, y) else { continue };
        let ray = Ray::new(camera.eye(), direction);
        let hit = task.world.caster.closest(&ray);
        if hit.surface == MISS {
            continue;
        }
        let surface = &task.world.surfaces.list[hit.surface as usize];
        let (front, uv) = (surface.normal.dot(direction) < 0.0, surface.uv(ray.at(hit.t)));
        let linear = task.options.display != Display::Constant;
        let Some(shown) = level.shown(hit.surface as usize, front, uv, linear) else { continue };
        for (band, sum) in sum.iter_mut().enumerate() {
            *sum += shown.value(|i| radiosity[i * bands + band]) / (std::f64::consts::PI * samples);
        }
    }
    sum
}
