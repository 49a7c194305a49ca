//! Progressive refinement on its way: what it shows after the first light, after the second, after a few shots more.
//!
//! Source: Cohen, Chen, Wallace and Greenberg 1988, whose pictures of a museum show the same five stages.

use super::super::adaptive::Task;
use super::level::Level;
use crate::solve::dense::{ExchangeRows, OnDemand, Shooting};
use crate::transport::form_factor::{Analytic, is_closed};

/// Shots after the lights, for the picture before the last.
const FEW: usize = 24;
/// Unshot flux at which nothing is left to be seen, and shots at most, in sweeps over all patches.
const DONE: f64 = 1e-3;
const MOST_SWEEPS: usize = 50;

/// Radiosities to look at, with the ambient term in them.
#[derive(Debug)]
pub(super) struct Stage {
    pub(super) name: &'static str,
    pub(super) shots: usize,
    pub(super) unshot: f64,
    /// Patch by patch, band fastest.
    pub(super) radiosity: Vec<f64>,
}

impl Stage {
    fn new<R: ExchangeRows>(name: &'static str, state: &Shooting<'_, R>) -> Self {
        Self { name, shots: state.shots(), unshot: state.unshot(), radiosity: state.displayed(true) }
    }
}

/// Shoots once more from the start and keeps what is to be seen: the ambient term alone, one light shot, two lights shot,
/// [`FEW`] shots more, and the full solution. Lights that are not there have no stage.
pub(super) fn stages(task: &Task<'_>, level: &Level) -> Vec<Stage> {
    let analytic = Analytic::new(task.world, &*level.mesh);
    let rows = OnDemand::new(&analytic, &level.system.areas, is_closed(task.world, &*level.mesh));
    let mut state = Shooting::new(&level.system, rows, false);
    let mut list = vec![Stage::new("ambient only", &state)];
    let mut lights = Lights::new(level);
    for name in ["one light", "two lights"] {
        if lights.shoot_one(&mut state) {
            list.push(Stage::new(name, &state));
        }
    }
    if shoot_until(&mut state, FEW, 0.0) {
        list.push(Stage::new("24 shots", &state));
    }
    shoot_until(&mut state, MOST_SWEEPS * level.system.len(), DONE);
    list.push(Stage::new("full solution", &state));
    list
}

/// Shoots so many times, or until so little is unshot; were there so many to shoot?
fn shoot_until<R: ExchangeRows>(state: &mut Shooting<'_, R>, shots: usize, unshot: f64) -> bool {
    (0..shots).all(|_| state.unshot() > unshot && state.shoot().is_some())
}

/// The lights of a mesh: for each emitting surface how many of its patches have not shot yet.
struct Lights<'a> {
    level: &'a Level,
    left: Vec<usize>,
    dark: Vec<bool>,
}

impl<'a> Lights<'a> {
    fn new(level: &'a Level) -> Self {
        let bands = level.system.bands;
        let dark: Vec<bool> = level.system.emitted.chunks_exact(bands).map(|m| m.iter().all(|m| *m == 0.0)).collect();
        let surfaces = level.mesh.list().iter().map(|p| p.surface as usize + 1).max().unwrap_or(0);
        let mut left = vec![0; surfaces];
        for (p, _) in level.mesh.list().iter().zip(&dark).filter(|(_, dark)| !**dark) {
            left[p.surface as usize] += 1;
        }
        Self { level, left, dark }
    }

    /// Shoots until one more light has given all it emits; `false` where there is none.
    fn shoot_one<R: ExchangeRows>(&mut self, state: &mut Shooting<'_, R>) -> bool {
        if self.left.iter().all(|n| *n == 0) {
            return false;
        }
        while let Some(i) = state.shoot() {
            // A patch that shoots again gives what it reflects.
            if !std::mem::replace(&mut self.dark[i], true) {
                let left = &mut self.left[self.level.mesh.list()[i].surface as usize];
                *left -= 1;
                if *left == 0 {
                    return true;
                }
            }
        }
        false
    }
}
