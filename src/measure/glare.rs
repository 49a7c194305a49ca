//! Discomfort glare of luminaires: the unified glare rating (CIE 117:1995).

use std::f64::consts::{LN_10, PI};

use super::adaptive::Task;
use super::probe::Probe;
use super::result::{Glare, GridResult, Status};
use crate::light::position_index;
use crate::transport::{DirectScratch, luminaire_in_sight};

/// Rates the luminaires for the eyes at the points of the grids that ask for it, which look along their normals.
///
/// `UGR = 8 lg(0.25/Lb Σ L² ω/P²)`: `Lb` is the illuminance at the eye without that of lamps, over π; `L` the luminance of a
/// luminaire, `ω` the solid angle of what is seen of it, `P` Guth's position index. Points and lines have no luminance and
/// do not count.
pub(super) fn ratings(task: &Task<'_>, grids: &[GridResult]) -> Vec<Glare> {
    let mut scratch = DirectScratch::default();
    let mut all = Vec::new();
    for number in &task.scene.observers {
        let (asked, grid) = (&task.scene.grids[*number], &grids[*number]);
        for (point, (sensor, reading)) in asked.sensors.iter().zip(&grid.sensors).enumerate() {
            if reading.status != Status::Ok {
                continue;
            }
            let eye = Probe::new(task.world, sensor, asked.receiver);
            let mut sum = 0.0;
            for l in &task.world.emitters.luminaires {
                let Some(index) = position_index(eye.normal, l.position - eye.position) else { continue };
                let Some((luminance, solid_angle)) = luminaire_in_sight(task.world, l, eye.position, &mut scratch)
                else {
                    continue;
                };
                sum += luminance * luminance * solid_angle / (index * index);
            }
            let background_lx = reading.reflected_lx + reading.sky_lx + reading.sun_lx + reading.external_lx;
            let rated = sum > 0.0 && background_lx > 0.0;
            all.push(Glare {
                grid: grid.name.clone(),
                point,
                background_cd_m2: background_lx / PI,
                ugr: rated.then(|| 8.0 * (0.25 * PI / background_lx * sum).log10()),
                error: if rated { 8.0 / LN_10 * reading.error_lx / background_lx } else { 0.0 },
            });
        }
    }
    all
}
