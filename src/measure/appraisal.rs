//! What a lighting engineer asks of a result: requirements kept or not, watts per area, surfaces of the room.

use super::result::{Glare, GridResult, Measurement, SensorResult, Status};
use crate::light::Luminaires;
use crate::scene::{Quantity, Scene};

/// Requirements, watts and surfaces.
#[derive(Clone, Debug, Default)]
pub struct Appraisal {
    /// Each limit that the scene sets.
    pub requirements: Vec<Judged>,
    /// Watts of the luminaires.
    pub power: Option<Power>,
    /// Mean illuminance and luminance of the surfaces of each material, then of those of each object.
    pub surfaces: Vec<RoomSurface>,
}

/// A limit against what was found.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Name of the grid.
    pub grid: String,
    /// Name of the state of the lights; empty for the scene as it stands.
    pub state: String,
    /// What is limited.
    pub quantity: Quantity,
    /// The limit.
    pub limit: f64,
    /// What was found, and the ends of its 95 % interval; nothing where nothing is known of it. A ratio to nothing is infinite.
    pub found: Option<[f64; 3]>,
    /// Kept?
    pub verdict: Verdict,
}

/// Is a limit kept?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// At both ends of the interval.
    Met,
    /// At neither.
    NotMet,
    /// At one: the error is too large to tell.
    Undecided,
    /// Nothing is known of the quantity.
    Unknown,
}

impl Verdict {
    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::NotMet => "not met",
            Self::Undecided => "undecided",
            Self::Unknown => "unknown",
        }
    }
}

/// Watts of the luminaires.
#[derive(Clone, Debug)]
pub struct Power {
    /// Of all luminaires whose watts are known, W.
    pub total_w: f64,
    /// Number of luminaires of which they are not.
    pub unknown: usize,
    /// Per area of the floor, W/m².
    pub density_w_m2: Option<f64>,
    /// The same per 100 lx of the mean of the grid named.
    pub density_w_m2_per_100_lx: Option<f64>,
}

/// The surfaces of a material, opaque and diffuse, or those of them in one object.
#[derive(Clone, Debug)]
pub struct RoomSurface {
    /// Name of the material.
    pub material: String,
    /// Name of the object or group of the drawing; `None` for all of the material.
    pub object: Option<String>,
    /// Front of the faces, or back.
    pub front: bool,
    /// Area of that side, m².
    pub area_m2: f64,
    /// Share of it on which elements were made; the rest matters to no sensor and is left out of the means.
    pub modelled_share: f64,
    /// Mean illuminance, lx, and its error at 95 %; nothing for black surfaces, of which only what they reflect is known.
    pub illuminance_lx: Option<[f64; 2]>,
    /// Mean luminance, cd/m², with emission, and its error at 95 %.
    pub luminance_cd_m2: [f64; 2],
}

/// Watts of the luminaires of a scene, before anything is solved.
pub(super) fn power(scene: &Scene, luminaires: &Luminaires) -> Option<Power> {
    if scene.luminaires.is_empty() {
        return None;
    }
    let mut power = Power { total_w: 0.0, unknown: 0, density_w_m2: None, density_w_m2_per_100_lx: None };
    for (row, watts) in scene.luminaires.iter().zip(&luminaires.power_w) {
        match watts {
            Some(watts) => power.total_w += watts * row.positions.len() as f64,
            None => power.unknown += row.positions.len(),
        }
    }
    Some(power)
}

/// Judges a result: what the scene requires, and the watts by what they refer to; `ra` is the general colour rendering index
/// of each table of luminaires, where it is known.
pub(super) fn appraise(scene: &Scene, ra: &[Option<f64>], m: &mut Measurement) {
    let judged = scene.requirements.iter().map(|r| {
        let grids = r.state.map_or(&m.grids, |k| m.states.get(k).map_or(&m.grids, |s| &s.grids));
        let cylinders = || scene.modelling.iter().find(|c| c.0 == r.grid).map(|c| &grids[c.1]);
        let grid = &grids[r.grid];
        let found = match r.quantity {
            Quantity::Mean => mean(grid),
            Quantity::Uniformity => uniformity(grid),
            Quantity::Cylindrical => cylinders().and_then(mean),
            Quantity::Ugr => glare(&m.glare, &grid.name, r.state.map_or("", |k| &scene.states[k].name)),
            Quantity::Ra => rendering(ra),
            Quantity::DirectMin => least(&direct(grid)),
            Quantity::DirectRatio => diversity(&direct(grid)),
        };
        let state = r.state.and_then(|k| m.states.get(k)).map_or_else(String::new, |s| s.name.clone());
        let is_lost = r.state.is_some() && state.is_empty();
        let found = found.filter(|_| !is_lost);
        let verdict = found.map_or(Verdict::Unknown, |f| verdict(f, r.limit, r.quantity.is_at_most()));
        Judged { grid: grid.name.clone(), state, quantity: r.quantity, limit: r.limit, found, verdict }
    });
    m.appraisal.requirements = judged.collect();
    if let (Some(power), Some(basis)) = (&mut m.appraisal.power, &scene.power) {
        let density = power.total_w / basis.area_m2;
        let known = power.unknown == 0;
        let mean_lx = basis.grid.and_then(|g| mean(&m.grids[g])).map(|f| f[0]).filter(|lx| *lx > 0.0);
        power.density_w_m2 = known.then_some(density);
        power.density_w_m2_per_100_lx = mean_lx.filter(|_| known).map(|lx| density * 100.0 / lx);
    }
}

fn verdict([_, low, high]: [f64; 3], limit: f64, at_most: bool) -> Verdict {
    let keeps = |v: f64| if at_most { v <= limit } else { v >= limit };
    match (keeps(low), keeps(high)) {
        (true, true) => Verdict::Met,
        (false, false) => Verdict::NotMet,
        _ => Verdict::Undecided,
    }
}

fn lit(grid: &GridResult) -> Vec<&SensorResult> {
    grid.sensors.iter().filter(|s| s.status == Status::Ok).collect()
}

/// Mean by area where all points have one. Errors of neighbours may all point the same way: that of the mean is their mean.
fn mean(grid: &GridResult) -> Option<[f64; 3]> {
    let lit = lit(grid);
    let by_area = lit.iter().all(|s| s.area_m2.is_some_and(|a| a > 0.0));
    let weight = |s: &SensorResult| if by_area { s.area_m2.unwrap_or(1.0) } else { 1.0 };
    let whole: f64 = lit.iter().map(|s| weight(s)).sum();
    let of = |f: &dyn Fn(&SensorResult) -> f64| lit.iter().map(|s| weight(s) * f(s)).sum::<f64>() / whole;
    let (value, error) = (of(&|s| s.xyz[1]), of(&|s| s.error_lx));
    (!lit.is_empty()).then_some([value, (value - error).max(0.0), value + error])
}

/// Least of values that lie within intervals: between the least of their lower and the least of their upper ends.
fn least(values: &[[f64; 2]]) -> Option<[f64; 3]> {
    let of = |f: &dyn Fn(&[f64; 2]) -> f64| values.iter().map(f).reduce(f64::min);
    Some([of(&|v| v[0])?, of(&|v| (v[0] - v[1]).max(0.0))?, of(&|v| v[0] + v[1])?])
}

fn uniformity(grid: &GridResult) -> Option<[f64; 3]> {
    let [value, low, high] = mean(grid).filter(|m| m[1] > 0.0)?;
    let least = least(&lit(grid).iter().map(|s| [s.xyz[1], s.error_lx]).collect::<Vec<_>>())?;
    Some([least[0] / value, least[1] / high, (least[2] / low).min(1.0)])
}

/// Direct illuminances, each with its error: no reflected light counts, and the error is at most that of the whole.
fn direct(grid: &GridResult) -> Vec<[f64; 2]> {
    lit(grid).iter().map(|s| [s.direct_lx, s.error_lx.min(s.direct_lx)]).collect()
}

/// Greatest over least; infinite where a point gets nothing.
fn diversity(values: &[[f64; 2]]) -> Option<[f64; 3]> {
    let low = least(values)?;
    let greatest = |sign: f64| values.iter().map(|v| v[0] + sign * v[1]).reduce(f64::max);
    let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { f64::INFINITY };
    Some([ratio(greatest(0.0)?, low[0]), ratio(greatest(-1.0)?, low[2]), ratio(greatest(1.0)?, low[1])])
}

/// The largest rating of a grid's eyes in a state of the lights; nothing where no luminaire shines into any.
fn glare(all: &[Glare], grid: &str, state: &str) -> Option<[f64; 3]> {
    let rated = || all.iter().filter(|g| g.grid == grid && g.state == state).filter_map(|g| Some((g.ugr?, g.error)));
    let of = |sign: f64| rated().map(|(ugr, error)| ugr + sign * error).reduce(f64::max);
    Some([of(0.0)?, of(-1.0)?, of(1.0)?])
}

/// The least index among the luminaires, if all are known.
fn rendering(ra: &[Option<f64>]) -> Option<[f64; 3]> {
    let known: Option<Vec<f64>> = ra.iter().copied().collect();
    known?.into_iter().reduce(f64::min).map(|ra| [ra; 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_inside_the_interval_is_undecided() {
        assert_eq!(verdict([510.0, 505.0, 515.0], 500.0, false), Verdict::Met);
        assert_eq!(verdict([500.0, 495.0, 505.0], 500.0, false), Verdict::Undecided);
        assert_eq!(verdict([490.0, 485.0, 495.0], 500.0, false), Verdict::NotMet);
        assert_eq!(verdict([18.8, 18.7, 18.9], 19.0, true), Verdict::Met);
        assert_eq!(verdict([19.2, 19.1, 19.3], 19.0, true), Verdict::NotMet);
    }

    #[test]
    fn the_least_of_intervals_lies_between_the_least_ends() {
        // The second could be the least: 3 − 2 < 2 − 0.5, and no more than 2.5 is the least upper end.
        assert_eq!(least(&[[2.0, 0.5], [3.0, 2.0], [9.0, 0.1]]), Some([2.0, 1.0, 2.5]));
    }
}
