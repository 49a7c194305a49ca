//! Discomfort glare of luminaires: the unified glare rating (CIE 117:1995).

use std::f64::consts::{LN_10, PI};

use super::adaptive::Task;
use super::probe::Probe;
use super::result::{Glare, GridResult, SensorResult, StateResult, Status};
use crate::light::position_index;
use crate::transport::{DirectScratch, luminaire_in_sight};

/// `L² ω/P²` of a luminaire at full light, and its channel.
type Dazzle = (f64, usize);

/// Rates the luminaires for the eyes at the points of the grids that ask for it, which look along their normals: for the
/// scene as it stands, then for each state of the lights.
///
/// `UGR = 8 lg(0.25/Lb Σ L² ω/P²)`: `Lb` is the illuminance at the eye without that of lamps, over π; `L` the luminance of a
/// luminaire, `ω` the solid angle of what is seen of it, `P` Guth's position index. Points and lines have no luminance and
/// do not count.
pub(super) fn ratings(task: &Task<'_>, grids: &[GridResult], states: &[StateResult]) -> Vec<Glare> {
    let mut scratch = DirectScratch::default();
    let (mut all, mut of_states) = (Vec::new(), vec![Vec::new(); states.len()]);
    for number in &task.scene.observers {
        let (asked, grid) = (&task.scene.grids[*number], &grids[*number]);
        for (point, (sensor, reading)) in asked.sensors.iter().zip(&grid.sensors).enumerate() {
            if reading.status != Status::Ok {
                continue;
            }
            let seen = in_sight(task, &Probe::new(task.world, sensor, asked.receiver), &mut scratch);
            let place = |state: &str| (grid.name.clone(), point, state.to_owned());
            all.push(rating(place(""), seen.iter().map(|s| s.0).sum(), reading));
            for ((state, levels), list) in states.iter().zip(&task.channels.states).zip(&mut of_states) {
                // Luminance, twice, goes with the level.
                let sum = seen.iter().map(|(dazzle, channel)| dazzle * levels.levels[*channel].powi(2)).sum();
                list.push(rating(place(&state.name), sum, &state.grids[*number].sensors[point]));
            }
        }
    }
    all.extend(of_states.into_iter().flatten());
    all
}

/// The luminaires that shine into an eye.
fn in_sight(task: &Task<'_>, eye: &Probe, scratch: &mut DirectScratch) -> Vec<Dazzle> {
    let mut seen = Vec::new();
    for l in &task.world.emitters.luminaires {
        let Some(index) = position_index(eye.normal, l.position - eye.position) else { continue };
        let Some((luminance, solid_angle)) = luminaire_in_sight(task.world, l, eye.position, scratch) else { continue };
        seen.push((luminance * luminance * solid_angle / (index * index), task.channels.of_group[l.group]));
    }
    seen
}

fn rating((grid, point, state): (String, usize, String), sum: f64, reading: &SensorResult) -> Glare {
    let background_lx = reading.reflected_lx + reading.sky_lx + reading.sun_lx + reading.external_lx;
    let rated = sum > 0.0 && background_lx > 0.0;
    Glare {
        grid,
        point,
        state,
        background_cd_m2: background_lx / PI,
        ugr: rated.then(|| 8.0 * (0.25 * PI / background_lx * sum).log10()),
        error: if rated { 8.0 / LN_10 * reading.error_lx / background_lx } else { 0.0 },
    }
}
