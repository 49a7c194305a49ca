//! `clerestory solve`.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use super::{MethodArg, SolveArgs, print, progress};
use crate::measure::{self, Appraisal, Display, GridResult, Ledger, Measurement, SolveOptions, Status};
use crate::report::{self, Form, Units};
use crate::scene::{self, Scene};
use crate::{Error, Result};

/// Share of a grid's sensors that must hold the tolerance.
const HOLDING: f64 = 0.95;
/// Fewer hold.
const EXIT_NOT_HELD: u8 = 3;

/// Reads, solves, writes, and says what came out.
pub(super) fn run(args: &SolveArgs) -> Result<ExitCode> {
    check_method(args)?;
    let start = Instant::now();
    let pool = super::pool(args.run.threads)?;
    let scene = scene::load(&args.scene)?;
    if args.progressive.is_some() && scene.views.is_empty() {
        return Err(Error::malformed("--progressive writes pictures, and the scene has no view")
            .mend("add a [[views]] table to the scene, or leave --progressive out")
            .in_file(&args.scene));
    }
    warn(args, &scene.warnings);
    let mut measurement = {
        let progress = progress::progress(args.run.quiet);
        pool.install(|| measure::solve(&scene, &options(args), &*progress)).map_err(|e| e.in_file(&args.scene))?
    };
    let remarks = measure::remarks(&scene, &measurement);
    measurement.record.warnings.extend(remarks);
    warn(args, &measurement.record.warnings);
    let provenance = super::provenance(&pool, start);
    let folder = folder(args);
    let form = Form { spectral: args.spectral, units: args.units.into() };
    let mut files = pool.install(|| report::write_all(&folder, &scene, &measurement, form, &provenance))?;
    if let Some(dir) = &args.progressive {
        files.extend(report::write_stages(dir, &scene, &measurement)?);
    }
    if args.run.json {
        print(&format!("{:#}\n", form.units.record(report::run_json(&scene, &measurement, &provenance))))?;
    } else {
        print(&summary(&scene, &measurement, form.units, (&files, provenance.wall_s)))?;
    }
    Ok(exit_code(&measurement))
}

/// Refuses settings that the method does not have.
fn check_method(args: &SolveArgs) -> Result<()> {
    let is_classic = !matches!(args.method, MethodArg::Auto | MethodArg::PathTracing);
    let misplaced = [
        ("--paths", args.paths.is_some() && args.method != MethodArg::PathTracing, "--method path-tracing"),
        ("--shots", args.shots.is_some() && args.method != MethodArg::Progressive, "--method progressive"),
        ("--progressive", args.progressive.is_some() && args.method != MethodArg::Progressive, "--method progressive"),
        ("--patches", args.patches.is_some() && !is_classic, "a classic --method, as full-matrix"),
        ("--max-memory", args.max_memory.is_some() && is_classic, "--method auto or path-tracing"),
        ("--display", args.display.is_some() && !is_classic, "a classic --method, as full-matrix"),
    ];
    match misplaced.iter().find(|(_, wrong, _)| *wrong) {
        Some((flag, _, method)) => {
            Err(Error::malformed(format!("{flag} goes with {method}"))
                .mend(format!("add {method}, or leave {flag} out")))
        }
        None => Ok(()),
    }
}

fn options(args: &SolveArgs) -> SolveOptions {
    SolveOptions {
        tolerance: args.tolerance,
        method: args.method.into(),
        spectral: args.spectral,
        alpha_opic: args.alpha_opic,
        seed: args.run.seed,
        paths: args.paths,
        max_memory: args.max_memory,
        patches: args.patches,
        shots: args.shots,
        stages: args.progressive.is_some(),
        display: args.display.map_or_else(Display::default, Display::from),
    }
}

fn warn(args: &SolveArgs, warnings: &[String]) {
    if !args.run.quiet {
        for warning in warnings {
            progress::line(&format!("warning: {warning}"));
        }
    }
}

fn folder(args: &SolveArgs) -> PathBuf {
    let stem = || args.scene.file_stem().unwrap_or_else(|| "scene".as_ref());
    args.out.clone().unwrap_or_else(|| Path::new("out").join(stem()))
}

fn exit_code(m: &Measurement) -> ExitCode {
    let of_states = m.states.iter().filter(|s| s.held).flat_map(|s| &s.grids);
    let held = m.grids.iter().chain(of_states).map(GridLine::of).all(|line| line.ok == 0 || line.held() >= HOLDING);
    if held { ExitCode::SUCCESS } else { ExitCode::from(EXIT_NOT_HELD) }
}

/// A grid in figures; lx.
struct GridLine {
    ok: usize,
    holding: usize,
    mean: f64,
    min: f64,
    max: f64,
    median_error: f64,
}

impl GridLine {
    fn of(grid: &GridResult) -> Self {
        let ok: Vec<_> = grid.sensors.iter().filter(|s| s.status == Status::Ok).collect();
        let lux = || ok.iter().map(|s| s.xyz[1]);
        let mut errors: Vec<f64> = ok.iter().map(|s| s.error_lx).collect();
        errors.sort_by(f64::total_cmp);
        Self {
            ok: ok.len(),
            holding: grid.holding,
            mean: lux().sum::<f64>() / ok.len() as f64,
            min: lux().fold(f64::INFINITY, f64::min),
            max: lux().fold(f64::NEG_INFINITY, f64::max),
            median_error: errors.get(errors.len() / 2).copied().unwrap_or_default(),
        }
    }

    /// Share of the sensors that hold the tolerance.
    fn held(&self) -> f64 {
        self.holding as f64 / self.ok as f64
    }
}

/// What came out, for the terminal.
fn summary(scene: &Scene, m: &Measurement, units: Units, (files, wall_s): (&[PathBuf], f64)) -> String {
    let mut text = format!("{}\n", scene.title);
    table(&mut text, m, units);
    appraisal(&mut text, &m.appraisal, units);
    for view in &m.views {
        line(
            &mut text,
            &format!(
                "view {}: error {:.1} % (median), {:.1} % (95th percentile)",
                view.view.name,
                100.0 * view.error_median,
                100.0 * view.error_p95
            ),
        );
    }
    for left in &m.record.left_out {
        line(&mut text, &format!("left out: {}: {}", left.what, left.bound));
    }
    if let Some(open) = worst_closure(&m.ledger) {
        line(&mut text, &format!("energy balance: open by {} % at most, over all bands", two_digits(100.0 * open)));
    }
    let bands = if m.bands.len() == 1 { "1 band".to_owned() } else { format!("{} bands", m.bands.len()) };
    line(
        &mut text,
        &format!(
            "tolerance {} %, method {}, {bands}, {wall_s:.1} s; written:",
            two_digits(100.0 * m.record.tolerance),
            m.record.method
        ),
    );
    for file in files {
        line(&mut text, &format!("  {}", file.display()));
    }
    text
}

/// Largest share of the emitted flux that is missing from, or too much in, any band.
fn worst_closure(ledger: &Ledger) -> Option<f64> {
    let gone = |b: usize| ledger.absorbed[b] + ledger.escaped[b] + ledger.unexpanded[b];
    let bands = (0..ledger.emitted.len()).filter(|&b| ledger.emitted[b] > 0.0);
    bands.map(|b| (1.0 - gone(b) / ledger.emitted[b]).abs()).reduce(f64::max)
}

/// Requirements and watts.
fn appraisal(text: &mut String, a: &Appraisal, units: Units) {
    for j in &a.requirements {
        let name = j.quantity.name();
        let (name, unit) = match name.strip_suffix("_lx") {
            Some(stem) => (format!("{stem} {}", units.name()), units.lux()),
            None => (name.to_owned(), 1.0),
        };
        let state = if j.state.is_empty() { String::new() } else { format!(", {}", j.state) };
        let bound = if j.quantity.is_at_most() { "at most" } else { "at least" };
        let found = j.found.map_or_else(String::new, |[value, low, high]| {
            let [value, low, high] = [value, low, high].map(|v| figure(v / unit, (high - low) / unit));
            format!(": {value} ({low} to {high})")
        });
        let (limit, verdict) = (figure(j.limit / unit, 0.0), j.verdict.name());
        line(text, &format!("{}{state}: {name} {bound} {limit}: {verdict}{found}", j.grid));
    }
    let Some(power) = &a.power else { return };
    let mut told = format!("luminaires: {:.0} W", power.total_w);
    if power.unknown > 0 {
        let _ = write!(told, ", {} without known watts", power.unknown);
    }
    if let Some(density) = power.density_w_m2 {
        let _ = write!(told, ", {density:.2} W/m²");
    }
    if let Some(density) = power.density_w_m2_per_100_lx {
        let _ = write!(told, ", {:.3} W/m² per 100 {}", density * units.lux(), units.name());
    }
    line(text, &told);
}

fn table(text: &mut String, m: &Measurement, units: Units) {
    if m.grids.is_empty() {
        return;
    }
    let of_states = m.states.iter().flat_map(|s| s.grids.iter().map(|g| (format!("{}, {}", g.name, s.name), g)));
    let grids: Vec<(String, &GridResult)> = m.grids.iter().map(|g| (g.name.clone(), g)).chain(of_states).collect();
    let unit = units.name();
    let width = grids.iter().map(|g| g.0.chars().count()).max().unwrap_or(0).max(4);
    line(
        text,
        &format!(
            "{:<width$} {:>7} {:>10} {:>10} {:>10} {:>10} {:>7}",
            "grid",
            "points",
            format!("mean {unit}"),
            format!("min {unit}"),
            format!("max {unit}"),
            format!("error {unit}"),
            "holding"
        ),
    );
    for (name, grid) in grids {
        let g = GridLine::of(grid);
        if g.ok == 0 {
            line(text, &format!("{name:<width$} {:>7} every point is covered or inside a solid", 0));
            continue;
        }
        let error = g.median_error / units.lux();
        let [mean, min, max] = [g.mean, g.min, g.max].map(|v| figure(v / units.lux(), error));
        let error = two_digits(error);
        line(
            text,
            &format!(
                "{name:<width$} {:>7} {mean:>10} {min:>10} {max:>10} {error:>10} {:>5.1} %",
                g.ok,
                100.0 * g.held()
            ),
        );
    }
}

fn line(text: &mut String, content: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{content}");
}

/// A value to the second digit of its error, but to four significant digits at most.
fn figure(value: f64, error: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let size = magnitude(value);
    if !(-4..7).contains(&size) {
        return format!("{value:.3e}");
    }
    let of_error = if error > 0.0 && error.is_finite() { 1 - magnitude(error) } else { i32::MAX };
    fixed(value, of_error.min(3 - size))
}

/// Two significant digits, without zeros at the end.
fn two_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = magnitude(value);
    if !(-4..7).contains(&magnitude) {
        return format!("{value:.1e}");
    }
    let text = fixed(value, 1 - magnitude);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn magnitude(value: f64) -> i32 {
    value.abs().log10().floor() as i32
}

fn fixed(value: f64, decimals: i32) -> String {
    let decimals = usize::try_from(decimals).unwrap_or(0);
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::measure::SensorResult;
    use crate::scene::GridLayout;

    fn sensor(lux: f64, error_lx: f64, status: Status) -> SensorResult {
        SensorResult {
            position: DVec3::ZERO,
            normal: DVec3::Z,
            area_m2: None,
            status,
            xyz: [lux; 3],
            error_lx,
            direct_lx: 0.0,
            sun_lx: 0.0,
            sky_lx: 0.0,
            external_lx: 0.0,
            reflected_lx: 0.0,
            spectral: Vec::new(),
        }
    }

    #[test]
    fn a_grid_is_summed_up_over_its_readable_sensors() {
        let sensors = vec![
            sensor(100.0, 3.0, Status::Ok),
            sensor(9e9, 1.0, Status::Covered),
            sensor(300.0, 1.0, Status::Ok),
            sensor(200.0, 2.0, Status::Ok),
        ];
        let line = GridLine::of(&GridResult { name: "g".to_owned(), layout: GridLayout::Points, sensors, holding: 3 });
        assert_eq!(
            (line.ok, line.mean, line.min, line.max, line.median_error, line.held()),
            (3, 200.0, 100.0, 300.0, 2.0, 1.0)
        );
    }

    #[test]
    fn figures_end_with_their_error() {
        let shown = [(327.387, 5.52), (13.94, 5.52), (1234.56, 0.01), (0.012_345_6, 0.0), (1e12, 1.0), (0.0, 1.0)];
        let shown = shown.map(|(value, error)| figure(value, error));
        assert_eq!(shown, ["327.4", "13.9", "1235", "0.01235", "1.000e12", "0"]);
        assert_eq!([5.0, 0.25, 5.523, 123.0, 1e-9].map(two_digits), ["5", "0.25", "5.5", "123", "1.0e-9"]);
    }

    #[test]
    fn the_worst_band_speaks_for_the_balance() {
        let mut ledger = Ledger {
            emitted: vec![10.0, 0.0, 10.0],
            absorbed: vec![9.0, 0.0, 9.0],
            escaped: vec![1.0, 0.0, 1.5],
            unexpanded: vec![0.0; 3],
            sampling_error: vec![0.0; 3],
        };
        assert!(worst_closure(&ledger).is_some_and(|w| (w - 0.05).abs() < 1e-12));
        ledger.emitted.fill(0.0);
        assert_eq!(worst_closure(&ledger), None);
    }
}
