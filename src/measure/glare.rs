//! Discomfort glare of luminaires: the unified glare rating (CIE 117:1995).

use std::f64::consts::{LN_10, PI};

use glam::DVec3;

use super::adaptive::Task;
use super::probe::Probe;
use super::result::{Glare, GridResult, Status};
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

/// Guth's position index of a direction for a line of sight, both of any length; `None` behind the eye, and where the sight
/// is vertical.
///
/// The fit of Guth's data that evaluation programs use, `τ` from the vertical, `σ` from the line of sight, in degrees; below
/// the line of sight that of its height.
fn position_index(sight: DVec3, towards: DVec3) -> Option<f64> {
    let (sight, d) = (sight.normalize(), towards.normalize_or_zero());
    let right = sight.cross(DVec3::Z).try_normalize()?;
    let sigma = sight.dot(d).clamp(-1.0, 1.0).acos().to_degrees();
    if sigma >= 90.0 {
        return None;
    }
    let up = right.cross(sight);
    let tau = d.dot(right).abs().atan2(d.dot(up).max(0.0)).to_degrees();
    let linear = 35.2 - 0.31889 * tau - 1.22 * (-2.0 * tau / 9.0).exp();
    let square = 21.0 + 0.26667 * tau - 0.002963 * tau * tau;
    Some((linear * 1e-3 * sigma + square * 1e-5 * sigma * sigma).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_position_index_is_one_ahead_and_grows_aside() {
        let sight = DVec3::Y;
        assert!((position_index(sight, DVec3::Y).unwrap() - 1.0).abs() < 1e-12);
        // 20 degrees above: exp(33.98e-3 · 20 + 21e-5 · 400).
        let above = DVec3::new(0.0, 20f64.to_radians().cos(), 20f64.to_radians().sin());
        assert!((position_index(sight, above).unwrap() - (0.6796f64 + 0.084).exp()).abs() < 1e-9);
        // 20 degrees aside, τ = 90: linear 6.4999, square 20.9999.
        let aside = DVec3::new(20f64.to_radians().sin(), 20f64.to_radians().cos(), 0.0);
        assert!((position_index(sight, aside).unwrap() - (0.129_998f64 + 0.084_000).exp()).abs() < 1e-4);
        assert_eq!(position_index(sight, DVec3::NEG_Y), None);
        assert_eq!(position_index(DVec3::NEG_Z, DVec3::Y), None);
    }
}
