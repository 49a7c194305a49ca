//! The validation suite: what the program computes against what is known, for a person to run again.
//!
//! In: names of suites. Out: [`Suite`]s of [`Case`]s, each with its reference, how well that is known, our value, the
//! error we state for it, and whether the two agree. What is exact by formula is computed here; what is not lies in
//! `validation/references`, each value with its source, and is part of the program.

mod cie_171;
mod colour;
mod cornell;
mod coverage;
mod energy;
mod ferren;
mod figure;
mod form_factors;
mod growth_chamber;
mod luminaires;
mod page;
mod published;
mod radiosity;
mod references;
mod report;
mod scenes;
mod sheet;
mod sky;
mod stability;

use std::time::Instant;

use crate::Result;
use crate::measure::Progress;

pub use references::References;
pub use report::{json, write};
use sheet::Sheet;
pub use sheet::{Case, Comparison, Table};

/// A family of cases.
#[derive(Clone, Debug)]
pub struct Suite {
    /// Its name.
    pub name: &'static str,
    /// What it is about, in a line.
    pub about: &'static str,
    /// Its cases.
    pub cases: Vec<Case>,
    /// Pictures for the report: caption and SVG.
    pub figures: Vec<(String, String)>,
    /// Tables for the report.
    pub tables: Vec<Table>,
    /// Files beside the report: name and text.
    pub files: Vec<(&'static str, String)>,
    /// Why it did not run, if it did not.
    pub skipped: Option<&'static str>,
    /// Wall time, s.
    pub seconds: f64,
}

impl Suite {
    /// Cases that do not agree with their reference.
    pub fn failures(&self) -> impl Iterator<Item = &Case> {
        self.cases.iter().filter(|c| !c.pass)
    }
}

type Run = fn(&References, &mut Sheet) -> Result<()>;

/// Name, subject and code of every suite, in the order of the report.
const SUITES: [(&str, &str, Run); 12] = [
    (
        "form-factors",
        "factors of polygons, points and blocked pairs against closed forms and quadrature",
        form_factors::run,
    ),
    ("radiosity", "interreflection in furnaces and boxes, by every method", radiosity::run),
    ("energy", "flux that is emitted is absorbed or leaves", energy::run),
    ("stability", "what breaks other programs: scale, place, reflectance near one, slivers, leaks", stability::run),
    ("colour", "tristimulus values, differences, temperatures, rendering, action spectra", colour::run),
    ("sky", "sixteen skies and the place of the sun", sky::run),
    ("cie-171", "analytic cases of CIE 171:2006, electric light and daylight", cie_171::run),
    ("luminaires", "photometric files against their formulas, and written anew", luminaires::run),
    ("cornell", "the measured Cornell box against path tracing", cornell::run),
    ("ferren", "boards with hidden colours, in 41 bands, against path tracing", ferren::run),
    (
        "growth-chamber",
        "a measured room, lamps behind a translucent ceiling (its data are not part of the program: --data)",
        growth_chamber::run,
    ),
    ("coverage", "are the stated errors true?", coverage::run),
];

/// The names of the suites.
pub fn names() -> impl Iterator<Item = &'static str> {
    SUITES.iter().map(|s| s.0)
}

/// Runs the suites of these names, all of them where none is named.
///
/// # Errors
/// Malformed for an unknown name or a broken reference; whatever a suite's scenes come to.
pub fn run(asked: &[String], references: &References, progress: &dyn Progress) -> Result<Vec<Suite>> {
    if let Some(unknown) = asked.iter().find(|a| !names().any(|n| n == a.as_str())) {
        let all: Vec<&str> = names().collect();
        return Err(crate::Error::malformed(format!("no suite is called {unknown:?}"))
            .mend(format!("name some of: {}", all.join(", "))));
    }
    let wanted = |name: &str| asked.is_empty() || asked.iter().any(|a| a == name);
    let chosen = SUITES.iter().filter(|s| wanted(s.0));
    chosen
        .map(|(name, about, code)| {
            progress.stage(name, 0);
            let start = Instant::now();
            let mut sheet = Sheet::default();
            code(references, &mut sheet)?;
            let (cases, extras) = sheet.finish();
            let sheet::Extras { figures, tables, files, skipped } = extras;
            let seconds = start.elapsed().as_secs_f64();
            Ok(Suite { name, about, cases, figures, tables, files, skipped, seconds })
        })
        .collect()
}
