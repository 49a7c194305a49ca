//! The classic methods: a mesh, a dense system or links that act as one, and an error from two meshes.
//!
//! Each solves a scene twice, on a mesh and on one twice as coarse. Where the error falls with the power `p` of the size of a
//! patch, the finer one is off by the difference over `2^p − 1`. Twice the difference, and no less than twice its root mean
//! square over the grid, is the stated error: enough down to `p = 0.6`.

mod hierarchical;
mod level;
mod picture;
mod read;
mod stages;

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use super::adaptive::Task;
use super::appraisal::Appraisal;
use super::options::Method;
use super::probe::Probe;
use super::result::{BandValue, GridResult, Ledger, LeftOut, Measurement, Record, SensorResult, Setting, Status};
use super::run::count_holding;
use crate::error::{Error, Result};
use crate::scene::Grid;
use crate::scene::Receiver;
use crate::transport::World;
use crate::transport::form_factor::Work;
use level::{Level, MOST_PATCHES};
use read::{Reader, Reading};

/// Stated error over the difference between two meshes.
const DOUBLING: f64 = 2.0;
/// Patches along the longest side of the scene to begin with.
const FIRST_PATCHES: u32 = 4;
/// Pixels of a hemicube across a light that it shows to about 2 % (measured: `experiments/stability`).
const PIXELS: f64 = 5.0;

/// Solves a scene by a classic method.
///
/// # Errors
///
/// When the scene has daylight, luminaires, mirrors, glass or translucent surfaces, needs too many patches, or has no finite
/// solution.
pub(super) fn run(task: &Task<'_>, mut record: Record) -> Result<Measurement> {
    if task.world.daylight().is_some() {
        return Err(Error::unsupported(format!(
            "method {} knows no sky and no sun; the scene has [sky]",
            record.method
        ))
        .mend("use the default method or path-tracing"));
    }
    if !task.world.emitters.luminaires.is_empty() {
        return Err(Error::unsupported(format!(
            "method {} takes light from emitting faces alone; the scene has [[luminaires]]",
            record.method
        ))
        .mend("use the default method or path-tracing"));
    }
    if task.world.has_specular() || task.world.has_translucent() || task.world.has_bsdf() {
        return Err(Error::unsupported(format!(
            "method {} works with opaque diffuse surfaces alone; the scene has mirrors or glass, translucent surfaces, or windows with a BSDF",
            record.method
        ))
        .mend("use the default method or path-tracing"));
    }
    if task.scene.grids.iter().any(|g| g.receiver != Receiver::Plane) {
        return Err(Error::unsupported(format!("method {} knows no cylindrical illuminance", record.method))
            .mend("use the default method or path-tracing"));
    }
    let mut patches = task.options.patches.unwrap_or(FIRST_PATCHES);
    let start = Instant::now();
    let mut coarse = level(task, coarser(patches))?;
    let mut fine = level(task, patches)?;
    let mut work = Work::default();
    let mut grids = read_all(task, &fine, &coarse, &mut work);
    while task.options.patches.is_none() && !grids.iter().all(holds) && 4 * fine.mesh.list().len() <= MOST_PATCHES {
        patches *= 2;
        coarse = fine;
        fine = level(task, patches)?;
        grids = read_all(task, &fine, &coarse, &mut work);
    }
    record.timings_s.push(("solution and sensors".into(), start.elapsed().as_secs_f64()));
    describe(task, &mut record, patches, &fine, &coarse, &work);
    for grid in grids.iter().filter(|g| !holds(g)) {
        record.warnings.push(format!(
            "grid {:?}: fewer than 95 % of the points hold the tolerance with {patches} patches along the longest side",
            grid.name
        ));
    }
    let start = Instant::now();
    let mut views: Vec<_> = task.scene.views.iter().map(|v| picture::paint(task, v, &fine, &coarse)).collect();
    if task.options.stages && !views.is_empty() {
        task.progress.stage("pictures on the way", 0);
        let stages = stages::stages(task, &fine);
        for v in &mut views {
            v.stages = stages.iter().map(|s| picture::paint_stage(task, &v.view, &fine, s)).collect();
        }
    }
    if !views.is_empty() {
        record.timings_s.push(("pictures".into(), start.elapsed().as_secs_f64()));
    }
    let (bands, ledger) = (task.optics.bands.clone(), ledger(task, &fine));
    Ok(Measurement {
        bands,
        grids,
        states: Vec::new(),
        views,
        glare: Vec::new(),
        appraisal: Appraisal::default(),
        ledger,
        record,
        outdoor_lx: None,
        alpha_opic: None,
    })
}

/// The mesh that tells the error: twice as coarse; of a single patch twice as fine.
fn coarser(patches: u32) -> u32 {
    if patches == 1 { 2 } else { patches.div_ceil(2) }
}

fn level(task: &Task<'_>, patches: u32) -> Result<Level> {
    task.progress.stage(&format!("{patches} patches along the longest side"), 0);
    let size = longest(task.world) / f64::from(patches);
    match task.options.method {
        Method::Hierarchical => hierarchical::solve(task, size, patches, task.accuracy()),
        _ => Level::solve(task, size, task.accuracy()),
    }
}

/// Longest side of any surface, in the program's frame.
fn longest(world: &World) -> f64 {
    world.surfaces.list.iter().map(|s| s.extent.max_element()).fold(0.0, f64::max)
}

fn holds(grid: &GridResult) -> bool {
    let lit = grid.sensors.iter().filter(|s| s.status == Status::Ok).count();
    grid.holding as f64 >= super::adaptive::HOLD * lit as f64
}

fn read_all(task: &Task<'_>, fine: &Level, coarse: &Level, work: &mut Work) -> Vec<GridResult> {
    let readers = [Reader::new(task, fine), Reader::new(task, coarse)];
    task.scene.grids.iter().map(|grid| read_grid(task, grid, &readers, fine, work)).collect()
}

/// A sensor read on both meshes, and the work of it.
struct Read {
    status: Status,
    readings: Option<[Reading; 2]>,
    rays: u64,
    factors: u64,
}

fn read_grid(task: &Task<'_>, grid: &Grid, readers: &[Reader<'_>; 2], fine: &Level, work: &mut Work) -> GridResult {
    let read: Vec<Read> = grid
        .sensors
        .par_iter()
        .with_min_len(4)
        .map(|sensor| {
            let probe = Probe::new(task.world, sensor, grid.receiver);
            let mut work = Work::default();
            let lit = probe.status == Status::Ok;
            let readings = lit.then(|| [0, 1].map(|k: usize| readers[k].read(sensor, &probe, &mut work)));
            Read { status: probe.status, readings, rays: work.all_rays(), factors: work.all_factors() }
        })
        .collect();
    let readings: Vec<&[Reading; 2]> = read.iter().filter_map(|r| r.readings.as_ref()).collect();
    let luminous = |x: &[f64]| task.optics.bands.xyz(x)[1];
    let ambient = luminous(&fine.solved.ambient).abs();
    let pairs: Vec<[f64; 2]> = readings.iter().map(|r| [luminous(&r[0].whole()), luminous(&r[1].whole())]).collect();
    let mut y = stated(&pairs, fine.solved.iteration, ambient).into_iter();
    let mut by_band: Vec<std::vec::IntoIter<f64>> = Vec::new();
    if task.options.spectral {
        by_band.extend((0..task.optics.bands.len()).map(|b| {
            let band = |r: &Reading| r.direct[b] + r.reflected[b];
            let pairs: Vec<[f64; 2]> = readings.iter().map(|r| [band(&r[0]), band(&r[1])]).collect();
            stated(&pairs, fine.solved.iteration, fine.solved.ambient[b].abs()).into_iter()
        }));
    }
    let mut sensors = Vec::with_capacity(read.len());
    for (sensor, read) in grid.sensors.iter().zip(&read) {
        work.rays += read.rays;
        work.factors += read.factors;
        let mut result = SensorResult::new(sensor, read.status);
        if let Some([fine, _]) = &read.readings {
            let whole = fine.whole();
            result.xyz = task.optics.bands.xyz(&whole);
            result.error_lx = y.next().unwrap_or(f64::INFINITY);
            result.direct_lx = luminous(&fine.direct);
            result.reflected_lx = result.xyz[1] - result.direct_lx;
            let errors = by_band.iter_mut().map(|e| e.next().unwrap_or(f64::INFINITY));
            result.spectral =
                whole.iter().zip(errors).map(|(value, error)| BandValue { irradiance: *value, error }).collect();
        }
        sensors.push(result);
    }
    let mut result = GridResult { name: grid.name.clone(), layout: grid.layout.clone(), sensors, holding: 0 };
    result.holding = count_holding(&result, task.options.tolerance);
    result
}

/// Errors of the sensors of a grid from their values on two meshes: of the difference, and of no less than its relative root
/// mean square; what the solver left; the ambient term where one stands for light not shot.
fn stated(pairs: &[[f64; 2]], iteration: f64, ambient: f64) -> Vec<f64> {
    let count = pairs.len().max(1) as f64;
    let mean = pairs.iter().map(|p| p[0]).sum::<f64>() / count;
    let scale = |p: &[f64; 2]| p[0].max(0.1 * mean).max(1e-300);
    let square = pairs.iter().map(|p| ((p[0] - p[1]) / scale(p)).powi(2)).sum::<f64>() / count;
    pairs
        .iter()
        .map(|p| (DOUBLING * (p[0] - p[1]).abs().max(square.sqrt() * scale(p))).hypot(ambient) + iteration * p[0])
        .collect()
}

fn describe(task: &Task<'_>, record: &mut Record, patches: u32, fine: &Level, coarse: &Level, work: &Work) {
    let setting = |name: &str, value: String, why: &str| Setting { name: name.into(), value, why: why.into() };
    let why =
        if task.options.patches.is_some() { "as asked" } else { "doubled until the stated error of the sensors holds" };
    record.settings.extend([
        setting("patches along the longest side", patches.to_string(), why),
        setting("form factors", fine.solved.closure.clone(), "made reciprocal and closed together"),
        setting("solver", fine.solved.solver.clone(), "residual below a thousandth of the tolerance"),
    ]);
    record.counts.extend([
        ("patches".into(), fine.mesh.list().len() as u64),
        ("rays".into(), fine.solved.rays + coarse.solved.rays + work.rays),
        ("form_factors".into(), fine.solved.factors + coarse.solved.factors + work.factors),
        ("iterations".into(), fine.solved.iterations as u64),
    ]);
    if task.options.method == Method::Hemicube {
        record.warnings.extend(coarse_hemicube(task, fine));
    }
    record.counts.extend(fine.solved.links.map(|links| ("links".into(), links)));
    if fine.solved.ambient.iter().any(|a| *a != 0.0) {
        record.left_out.push(LeftOut {
            what: "light not shot yet".into(),
            bound: format!(
                "an ambient term of {:.3} lx stands for it, included in the error",
                task.optics.bands.xyz(&fine.solved.ambient)[1]
            ),
        });
    }
}

/// Tells of lights too small for the hemicubes: they alias, or are missed, and two meshes need not tell.
fn coarse_hemicube(task: &Task<'_>, fine: &Level) -> Option<String> {
    let world = task.world;
    let resolution = level::hemicube(world, &*fine.mesh, fine.size).resolution as f64;
    let corners = || world.surfaces.list.iter().flat_map(|s| &s.vertices);
    let needed = world.emitters.list.iter().map(|e| {
        let centre = e.vertices.iter().sum::<DVec3>() / e.vertices.len() as f64;
        let longest = e.vertices.iter().map(|v| 2.0 * v.distance(centre)).fold(0.0, f64::max);
        let distance = corners().map(|v| v.distance(centre)).fold(0.0, f64::max);
        PIXELS * 2.0 * distance * longest / e.area
    });
    let most = needed.fold(0.0, f64::max);
    (most > resolution).then(|| {
        format!(
            "hemicubes of {resolution} pixels: the smallest light covers {:.2} of a pixel's width from across the scene; \
             {most:.0} pixels would show it to about 2 %: use more --patches, or --method gathering",
            PIXELS * resolution / most
        )
    })
}

/// Where the light went, each line summed on its own; empty where no matrix tells.
fn ledger(task: &Task<'_>, level: &Level) -> Ledger {
    let mut ledger = Ledger::default();
    let Some(matrix) = &level.solved.matrix else { return ledger };
    let (system, unit) = (&level.system, task.world.surfaces.frame.area_m2());
    for band in 0..system.bands {
        let sum = |f: &dyn Fn(usize, usize) -> f64| {
            (0..system.len()).map(|i| system.areas[i] * f(i, i * system.bands + band)).sum::<f64>() * unit
        };
        ledger.emitted.push(sum(&|_, k| system.emitted[k]));
        ledger.absorbed.push(sum(&|_, k| (1.0 - system.rho[k]) * matrix.irradiance[k]));
        ledger.escaped.push(sum(&|i, k| matrix.open[i] * level.solved.radiosity[k]));
        ledger.unexpanded.push(0.0);
        ledger.sampling_error.push(0.0);
    }
    ledger
}
