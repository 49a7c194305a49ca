//! Speed against accuracy, measured on the user's own scene.
//!
//! In: a [`Scene`] with grids. Every method runs over a ladder of settings fixed in advance; what it answers is compared at
//! all sensors with a path-traced reference of known uncertainty. Out: a [`Chart`] of [`Point`]s, one for each method and
//! setting, with the time it took, the error it made and the error it stated.
//!
//! What is compared is the illuminance of all sensors that have a reading. Errors are fractions of the mean of the
//! reference ([`Found::rms`], [`Found::bias`]) or of each sensor's own reading, but of no less than a hundredth of the mean
//! ([`Found::p95`], [`Found::largest`]).

mod clock;
mod ladder;
mod peer;
mod score;

use std::time::Instant;

pub use clock::{Cost, cpu_seconds};
pub use peer::read as read_peers;
pub use score::{Reading, Reference};

use crate::error::{Error, Result};
use crate::measure::{Measurement, Method, Progress, Silent, SolveOptions, solve};
use crate::scene::Scene;
use ladder::Rung;
use score::Score;

/// One method at one setting: medians over the repeats.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Point {
    /// Name of the method.
    pub method: String,
    /// The setting, in words.
    pub setting: String,
    /// Processor time of all threads, s: geometry, tree and all; without reading files.
    pub cpu_s: f64,
    /// Wall time, s.
    pub wall_s: f64,
    /// Rays cast.
    pub rays: Option<u64>,
    /// Form factors worked out.
    pub form_factors: Option<u64>,
    /// Most memory in use, 10⁶ bytes.
    pub peak_mem_mb: Option<f64>,
    /// What was found; `None` where the method failed.
    pub found: Option<Found>,
    /// Why it failed, or what a peer is; empty otherwise.
    pub note: String,
}

/// Errors of one method at one setting, fractions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Found {
    /// Root mean square error over the mean of the reference, the reference's own uncertainty taken off where it can be
    /// told apart.
    pub rms: f64,
    /// Mean error over the mean of the reference, signed.
    pub bias: f64,
    /// 95th percentile of a sensor's error over its reading.
    pub p95: f64,
    /// The largest.
    pub largest: f64,
    /// 95th percentile of a sensor's stated error over its reading; `None` where nothing is stated.
    pub stated_p95: Option<f64>,
    /// Share of the sensors whose stated error, with the reference's, covers the difference.
    pub coverage: Option<f64>,
    /// Is the error larger than twice the reference's uncertainty?
    pub resolved: bool,
}

/// Everything measured.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Title of the scene.
    pub title: String,
    /// Sensors compared.
    pub sensors: usize,
    /// The reference.
    pub reference: Reference,
    /// The points, method by method, cheap to dear.
    pub points: Vec<Point>,
    /// Threads in use.
    pub threads: usize,
    /// What the reader should know.
    pub notes: Vec<String>,
}

/// How thorough to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChartOptions {
    /// Five repeats, longer ladders, a better reference and a second one; without it minutes suffice.
    pub full: bool,
    /// Seed of the first repeat.
    pub seed: u64,
}

/// Runs all methods on a scene.
///
/// # Errors
///
/// When the scene has no grid with a reading, or cannot be solved at all.
pub fn run(scene: &Scene, options: &ChartOptions, progress: &dyn Progress) -> Result<Chart> {
    let mut scene = scene.clone();
    scene.views.clear(); // pictures are not compared
    if scene.grids.iter().all(|g| g.sensors.is_empty()) {
        return Err(Error::malformed("a chart compares illuminances, and the scene asks for none")
            .mend("add a [[grids]] table to the scene"));
    }
    let plan = ladder::Plan::new(options.full);
    progress.stage("reference: path tracing", 0);
    let reference = reference(&scene, options, &plan)?;
    let mut notes = Vec::new();
    if options.full {
        notes.push(second_reference(&scene, options, &reference)?);
    }
    let mut points = Vec::new();
    for (method, rungs) in &plan.ladders {
        progress.stage(method, rungs.len() as u64);
        for rung in rungs {
            let point = climb(&scene, method, rung, options, &plan, &reference);
            let enough = point.wall_s > plan.longest_s || point.found.is_none();
            points.push(point);
            progress.advance(1);
            if enough && !options.full {
                break;
            }
        }
    }
    Ok(Chart {
        title: scene.title.clone(),
        sensors: reference.len(),
        reference,
        points,
        threads: rayon::current_num_threads(),
        notes,
    })
}

/// The path-traced reference: as many paths as fit into the time planned, told from a short run.
fn reference(scene: &Scene, options: &ChartOptions, plan: &ladder::Plan) -> Result<Reference> {
    let trace = |paths: u64, seed: u64| {
        let settings =
            SolveOptions { method: Method::PathTracing, paths: Some(paths), seed, ..SolveOptions::default() };
        solve(scene, &settings, &Silent)
    };
    let start = Instant::now();
    trace(ladder::LEAST_PATHS, options.seed)?;
    let rate = ladder::LEAST_PATHS as f64 / start.elapsed().as_secs_f64().max(1e-6);
    let wanted = (rate * plan.reference_s).log2().floor().clamp(10.0, 24.0);
    let paths = 1u64 << wanted as u32;
    // A stream of its own: no method may share its luck.
    let measurement = trace(paths, crate::transport::points::seed(&[options.seed, 13]))?;
    let reference = Reference::new(&measurement, paths, scene.axes);
    if reference.is_empty() {
        return Err(Error::impossible("no sensor of the scene has a reading").mend("`clerestory check` tells why"));
    }
    if reference.mean_lx <= 0.0 {
        return Err(Error::impossible("no sensor receives any light: there is nothing to compare"));
    }
    Ok(reference)
}

/// The default method at its finest against the reference: two methods that share scene and ray caster alone.
fn second_reference(scene: &Scene, options: &ChartOptions, reference: &Reference) -> Result<String> {
    let fine = SolveOptions { tolerance: 0.005, seed: options.seed + 100, ..SolveOptions::default() };
    let score = Score::new(&solve(scene, &fine, &Silent)?, reference);
    Ok(format!(
        "second reference: auto at 0.5 % differs by {:.3} % RMS, {:+.3} % in the mean",
        100.0 * score.found.rms,
        100.0 * score.found.bias
    ))
}

/// One run: what it cost, what was found, and its rays and form factors.
struct Run {
    cost: Cost,
    found: Found,
    counts: [Option<u64>; 2],
}

/// One rung, repeated; medians of all figures.
fn climb(
    scene: &Scene,
    method: &str,
    rung: &Rung,
    options: &ChartOptions,
    plan: &ladder::Plan,
    reference: &Reference,
) -> Point {
    let mut runs = Vec::new();
    let start = Instant::now();
    for repeat in 0..plan.repeats {
        let settings = SolveOptions { seed: options.seed + repeat, ..rung.options.clone() };
        clock::settle();
        let (outcome, cost) = clock::timed(|| solve(scene, &settings, &Silent));
        match outcome {
            Ok(m) => runs.push(Run { cost, found: Score::new(&m, reference).found, counts: counts(&m) }),
            Err(e) => {
                return Point {
                    method: method.into(),
                    setting: rung.setting.clone(),
                    cpu_s: cost.cpu_s,
                    wall_s: cost.wall_s,
                    note: e.to_string(),
                    ..Point::default()
                };
            }
        }
        if !options.full && start.elapsed().as_secs_f64() > plan.patience_s {
            break;
        }
    }
    let median = |f: &dyn Fn(&Run) -> f64| {
        let mut values: Vec<f64> = runs.iter().map(f).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let found = Found {
        rms: median(&|r| r.found.rms),
        bias: median(&|r| r.found.bias),
        p95: median(&|r| r.found.p95),
        largest: median(&|r| r.found.largest),
        stated_p95: runs[0].found.stated_p95.map(|_| median(&|r| r.found.stated_p95.unwrap_or(0.0))),
        coverage: runs[0].found.coverage.map(|_| median(&|r| r.found.coverage.unwrap_or(0.0))),
        resolved: runs.iter().filter(|r| r.found.resolved).count() * 2 > runs.len(),
    };
    Point {
        method: method.into(),
        setting: rung.setting.clone(),
        cpu_s: median(&|r| r.cost.cpu_s),
        wall_s: median(&|r| r.cost.wall_s),
        rays: runs[0].counts[0],
        form_factors: runs[0].counts[1],
        peak_mem_mb: runs.iter().filter_map(|r| r.cost.peak_mem_mb).reduce(f64::max),
        found: Some(found),
        note: String::new(),
    }
}

/// Rays and form factors of a run.
fn counts(m: &Measurement) -> [Option<u64>; 2] {
    ["rays", "form_factors"].map(|name| m.record.counts.iter().find(|c| c.0 == name).map(|c| c.1))
}

/// The points that no other beats in both time and error, from cheap to dear.
#[must_use]
pub fn pareto(points: &[Point]) -> Vec<&Point> {
    let mut list: Vec<(&Point, f64)> =
        points.iter().filter_map(|p| p.found.filter(|f| f.resolved).map(|f| (p, f.rms))).collect();
    list.sort_by(|a, b| a.0.cpu_s.total_cmp(&b.0.cpu_s).then(a.1.total_cmp(&b.1)));
    let mut best = f64::INFINITY;
    list.retain(|(_, rms)| {
        let better = *rms < best;
        best = best.min(*rms);
        better
    });
    list.into_iter().map(|(p, _)| p).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(cpu_s: f64, rms: f64, resolved: bool) -> Point {
        Point { cpu_s, found: Some(Found { rms, resolved, ..Found::default() }), ..Point::default() }
    }

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let failed = Point { cpu_s: 0.01, ..Point::default() };
        let points =
            [point(1.0, 0.02, true), failed, point(0.5, 0.05, true), point(2.0, 0.03, true), point(3.0, 0.001, false)];
        let front: Vec<f64> = pareto(&points).iter().map(|p| p.cpu_s).collect();
        assert_eq!(front, [0.5, 1.0]);
    }
}
