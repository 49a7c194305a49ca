//! `clerestory validate`.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::{ValidateArgs, print, progress};
use crate::Result;
use crate::validate::{self, References, Suite};

/// Some case fails.
const EXIT_FAILED: u8 = 1;

/// Runs the suites, writes the report, and says what came out.
pub(super) fn run(args: &ValidateArgs) -> Result<ExitCode> {
    let pool = super::pool(args.threads)?;
    let mut references = References::default();
    if let Some(folder) = &args.data {
        references = references.with_measured(folder);
    }
    let suites = {
        let progress = progress::progress(args.quiet);
        pool.install(|| validate::run(&args.suites, &references, &*progress))?
    };
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join("validate"));
    // Without a folder, JSON is wanted alone.
    let files = if args.json && args.out.is_none() { Vec::new() } else { validate::write(&folder, &suites)? };
    if args.json {
        print(&format!("{:#}\n", validate::json(&suites)))?;
    } else {
        print(&summary(&suites, &files))?;
    }
    let failed = suites.iter().any(|s| s.failures().next().is_some());
    Ok(if failed { ExitCode::from(EXIT_FAILED) } else { ExitCode::SUCCESS })
}

/// The suites for the terminal, and every case that failed.
fn summary(suites: &[Suite], files: &[PathBuf]) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{:<14} {:>6} {:>7} {:>8}", "suite", "cases", "failed", "seconds");
    for s in suites {
        match s.skipped {
            Some(why) => _ = writeln!(text, "{:<14} skipped: {why}", s.name),
            None => {
                let failed = s.failures().count();
                let _ = writeln!(text, "{:<14} {:>6} {failed:>7} {:>8.1}", s.name, s.cases.len(), s.seconds);
            }
        }
    }
    for (s, c) in suites.iter().flat_map(|s| s.failures().map(move |c| (s, c))) {
        let _ = writeln!(
            text,
            "failed: {} / {} / {}: {} ± {} against {} ± {} {}",
            s.name, c.holds, c.name, c.value, c.error, c.reference, c.uncertainty, c.unit
        );
    }
    for file in files {
        let _ = writeln!(text, "  {}", file.display());
    }
    text
}
