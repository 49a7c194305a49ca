//! `clerestory annual`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use super::{AnnualArgs, PatchCount, print, progress};
use crate::Result;
use crate::annual::{self, AnnualOptions, GridYear, Year};
use crate::measure::SolveOptions;
use crate::report;
use crate::scene::{self, Scene};

/// Reads, computes the year, writes, and says what came out.
pub(super) fn run(args: &AnnualArgs) -> Result<ExitCode> {
    let start = Instant::now();
    let pool = super::pool(args.run.threads)?;
    let scene = scene::load(&args.scene)?;
    warn(args, &scene.warnings);
    let options = AnnualOptions {
        solve: SolveOptions { tolerance: args.tolerance, seed: args.run.seed, ..SolveOptions::default() },
        weather: args.weather.clone(),
        parts: args.sky_patches.map(PatchCount::parts),
    };
    let year = {
        let progress = progress::progress(args.run.quiet);
        pool.install(|| annual::annual(&scene, &options, &*progress)).map_err(|e| e.in_file(&args.scene))?
    };
    warn(args, &year.record.warnings);
    let provenance = super::provenance(&pool, start);
    let folder = args.out.clone().unwrap_or_else(|| {
        Path::new("out").join(args.scene.file_stem().unwrap_or_else(|| "scene".as_ref())).join("annual")
    });
    let files = pool.install(|| report::write_year(&folder, &scene, &year, &provenance))?;
    if args.run.json {
        print(&format!("{:#}\n", report::year_json(&scene, &year, &provenance)))?;
    } else {
        print(&summary(&scene, &year, &files, start.elapsed().as_secs_f64()))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn warn(args: &AnnualArgs, warnings: &[String]) {
    if !args.run.quiet {
        warnings.iter().for_each(|w| progress::line(&format!("warning: {w}")));
    }
}

/// What came out, for the terminal.
fn summary(scene: &Scene, year: &Year, files: &[PathBuf], wall_s: f64) -> String {
    let mut text =
        format!("{}\nweather of {}, {} hours with sun\n", scene.title, year.weather, year.climate.hours.len());
    for grid in &year.grids {
        of_grid(&mut text, grid);
    }
    // Writing to a string cannot fail.
    for left in &year.record.left_out {
        let _ = writeln!(text, "left out: {}: {}", left.what, left.bound);
    }
    let _ = writeln!(text, "tolerance {} %, {wall_s:.1} s; written:", 100.0 * year.record.tolerance);
    for file in files {
        let _ = writeln!(text, "  {}", file.display());
    }
    text
}

fn of_grid(text: &mut String, grid: &GridYear) {
    let Some(m) = &grid.metrics.grid else {
        let _ = writeln!(text, "{}: every point is covered or inside a solid", grid.name);
        return;
    };
    let percent = |v: f64| 100.0 * v;
    let points = grid.metrics.points.iter().flatten().count();
    let _ = writeln!(text, "{} ({points} points, {} hours of presence)", grid.name, m.present_hours);
    let line = |text: &mut String, name: &str, value: String| {
        let _ = writeln!(text, "  {name:<40} {value}");
    };
    let s = m.spatial_autonomy;
    line(text, "sDA300/50", format!("{:.1} % ± {:.1} %", percent(s.value), percent(s.error)));
    line(text, "ASE1000,250", format!("{:.1} %", percent(m.sunlight_exposure[0])));
    let mean = &m.mean;
    for (name, f) in [
        ("mean daylight autonomy, 300 lx", mean.autonomy),
        ("mean continuous autonomy, 300 lx", mean.continuous_autonomy),
        ("mean useful daylight, 300 to 3,000 lx", mean.useful[2]),
    ] {
        line(text, name, format!("{:.1} % ± {:.1} %", percent(f.value), percent(f.error)));
    }
    line(text, "mean daylight factor", format!("{:.2} %", percent(mean.overcast.daylight_factor)));
    let levels = m.en17037_hourly.map(annual::Level::name);
    let certain = if levels[1] == levels[2] { String::new() } else { format!(" ({} to {})", levels[1], levels[2]) };
    line(text, "EN 17037, by hours", format!("{}{certain}", levels[0]));
    line(text, "EN 17037, by daylight factor", m.en17037_factor.name().to_owned());
    line(text, "LEED v4.1, option 1", format!("{} of 3 points", m.leed_points[0]));
    if let Some(e) = &m.equinox {
        line(text, "LEED v4.1, option 2", format!("{} of 3 points", e.leed_points));
    }
    line(text, "BREEAM HEA 01", if m.breeam { "met" } else { "not met" }.to_owned());
}
