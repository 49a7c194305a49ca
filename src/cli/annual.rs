//! `clerestory annual`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use super::{AnnualArgs, cpu, print, progress};
use crate::Result;
use crate::annual::{self, AnnualOptions, Year};
use crate::measure::SolveOptions;
use crate::report;
use crate::scene;

/// Reads, computes the year, writes, and says what came out.
pub(super) fn run(args: &AnnualArgs) -> Result<ExitCode> {
    let start = Instant::now();
    let pool = super::pool(args.threads)?;
    let scene = scene::load(&args.scene)?;
    let options = AnnualOptions {
        solve: SolveOptions { tolerance: args.tolerance, seed: args.seed, ..SolveOptions::default() },
        weather: args.weather.clone(),
        parts: args.sky_patches.map(PatchCount::parts),
    };
    let year = {
        let progress = progress::progress(args.quiet);
        pool.install(|| annual::annual(&scene, &options, &*progress)).map_err(|e| e.in_file(&args.scene))?
    };
    let folder = args.out.clone().unwrap_or_else(|| {
        Path::new("out").join(args.scene.file_stem().unwrap_or_else(|| "scene".as_ref())).join("annual")
    });
    let files = pool.install(|| report::write_year(&folder, &year))?;
    print(&summary(&year, &files, start.elapsed().as_secs_f64()))?;
    let _ = cpu::seconds();
    Ok(ExitCode::SUCCESS)
}

use super::PatchCount;

fn summary(year: &Year, files: &[PathBuf], wall_s: f64) -> String {
    let mut text = format!("{}\n{:?}\n", year.weather, year.record.timings_s);
    for file in files {
        text += &format!("  {}\n", file.display());
    }
    text + &format!("{wall_s:.1} s\n")
}
