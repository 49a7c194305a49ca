//! `clerestory check`.

use std::fmt::Write;
use std::process::ExitCode;

use serde_json::json;

use super::{CheckArgs, print};
use crate::Result;
use crate::light::{Daylight, Luminaires};
use crate::scene::{self, Diagnostic, Scene, Severity};

/// Reads, checks, and says what was found. Errors among the findings are exit code 2.
pub(super) fn run(args: &CheckArgs) -> Result<ExitCode> {
    let scene = scene::load(&args.scene)?;
    Daylight::new(&scene)?;
    let mut found = scene::check(&scene);
    let luminaires = Luminaires::new(&scene)?;
    let warning = |what: &String| Diagnostic { severity: Severity::Warning, what: what.clone(), mend: String::new() };
    found.extend(luminaires.warnings.iter().map(warning));
    print(&if args.json { json(&scene, &found) } else { text(&scene, &found) })?;
    let bad = found.iter().any(|d| d.severity == Severity::Error);
    Ok(if bad { ExitCode::from(2) } else { ExitCode::SUCCESS })
}

fn json(scene: &Scene, found: &[Diagnostic]) -> String {
    let findings: Vec<_> =
        found.iter().map(|d| json!({ "severity": d.severity.name(), "what": d.what, "mend": d.mend })).collect();
    let report = json!({
        "schema": 1,
        "title": scene.title,
        "faces": scene.faces.len(),
        "materials": scene.materials.len(),
        "sensors": scene.grids.iter().map(|g| g.sensors.len()).sum::<usize>(),
        "views": scene.views.len(),
        "findings": findings,
    });
    format!("{report:#}\n")
}

/// A number of things.
fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

fn text(scene: &Scene, found: &[Diagnostic]) -> String {
    let sensors: usize = scene.grids.iter().map(|g| g.sensors.len()).sum();
    let mut text = format!(
        "{}: {}, {}, {} with {}, {}\n",
        scene.title,
        counted(scene.faces.len(), "face"),
        counted(scene.materials.len(), "material"),
        counted(scene.grids.len(), "grid"),
        counted(sensors, "point"),
        counted(scene.views.len(), "view")
    );
    for d in found {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}: {}", d.severity.name(), d.what);
        if !d.mend.is_empty() {
            let _ = writeln!(text, "  mend: {}", d.mend);
        }
    }
    let count = |s: Severity| found.iter().filter(|d| d.severity == s).count();
    let _ = writeln!(text, "{} errors, {} warnings", count(Severity::Error), count(Severity::Warning));
    text
}
