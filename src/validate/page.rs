//! `VALIDATION.md`: the state of the validation on one page.

use std::fmt::Write;

use super::figure::escaped;
use super::{Case, Comparison, Suite, Table};

/// What no case of the suite holds.
const NOT_VALIDATED: [&str; 10] = [
    "Measured rooms, but for one: the growth chamber, twelve points in two bands, with a fitted power of its lamps. Nothing \
     compares with a measured luminance. The Cornell box has measured geometry, reflectances and lamp spectrum, and a \
     path-traced reference.",
    "CIE 171:2006, section 4 (measured luminaires in a room): its tables are not public. Section 6 has no numbers.",
    "The tables that CIE 171:2006 prints: exact values by quadrature take their place, for some printed ones are wrong.",
    "A year of daylight and its metrics: held by the tests of the source, not by this suite.",
    "Perez's sky and weather files: held by the tests of the source, not by this suite.",
    "Mirrors, glazing units of several panes, translucent sheets: held by the tests of the source; here clear single \
     panes alone.",
    "Discomfort glare, pictures, and the spectrum of several bands beyond two bands of the Cornell box.",
    "The mean of many energy balances: each closes within what it states, but at a tolerance of 5 % the mean over seeds has a \
     surplus, 0.06 % of the flux at a reflectance of 0.5, 0.2 % at 0.8, 0.6 % at 0.95 (known, far below the tolerance).",
    "Luminance: comparisons are of illuminance, irradiance and chromaticity.",
    "Surfaces that are not Lambertian, fluorescence, participating media: the program does not compute them.",
];

/// Number of cases and of failures.
pub(super) fn counts(suites: &[Suite]) -> (usize, usize) {
    (suites.iter().map(|s| s.cases.len()).sum(), suites.iter().map(|s| s.failures().count()).sum())
}

/// Difference over what is allowed, of cases with two sides.
fn ratio(c: &Case) -> Option<f64> {
    let two_sided = matches!(c.comparison, Comparison::Equal | Comparison::Estimate);
    (two_sided && c.allowed() > 0.0).then(|| (c.value - c.reference).abs() / c.allowed())
}

/// A number with six digits, without needless zeros.
pub(super) fn figure(v: f64) -> String {
    if v == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e6).contains(&v.abs()) {
        return format!("{v:.3e}");
    }
    let decimals = (5.0 - v.abs().log10().floor()).clamp(0.0, 8.0) as usize;
    let text = format!("{v:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The page.
pub(super) fn markdown(suites: &[Suite]) -> String {
    let (cases, failed) = counts(suites);
    let mut text = format!(
        "# Validation\n\nWritten by `clerestory validate -o DIR`; the same folder holds every case as a page \
         (`index.html`), as CSV and as JSON.\n\n{cases} cases, {failed} failed. A case passes where our value and the \
         reference differ by at most the error we state and the uncertainty of the reference. Where the stated error \
         is statistical (95 %), a single case may use the 99.9 % interval, and how many lie within the stated one is a \
         case of its own.\n\n| suite | about | cases | failed | median off / allowed | largest |\n|---|---|---|---|---|---|\n"
    );
    for s in suites {
        let mut ratios: Vec<f64> = s.cases.iter().filter_map(ratio).collect();
        ratios.sort_by(f64::total_cmp);
        let at = |k: usize| ratios.get(k).map_or("–".to_owned(), |r| format!("{r:.2}"));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} |",
            s.name,
            s.about,
            s.cases.len(),
            if s.skipped.is_some() { "skipped".into() } else { s.failures().count().to_string() },
            at(ratios.len() / 2),
            at(ratios.len().saturating_sub(1))
        );
    }
    sources(&mut text, suites);
    for s in suites {
        s.tables.iter().for_each(|t| table(&mut text, t));
    }
    text.push_str("\n## What is not validated here\n\n");
    for line in NOT_VALIDATED {
        let _ = writeln!(text, "- {line}");
    }
    text
}

fn table(text: &mut String, t: &Table) {
    let _ = writeln!(text, "\n{}:\n\n| {} |\n|{}", t.caption, t.heads.join(" | "), "---|".repeat(t.heads.len()));
    for row in &t.rows {
        let _ = writeln!(text, "| {} |", row.join(" | "));
    }
}

/// Which source holds how many cases.
fn sources(text: &mut String, suites: &[Suite]) {
    text.push_str("\n## By source\n\n| suite | source | cases |\n|---|---|---|\n");
    for s in suites {
        let mut rest: Vec<&str> = s.cases.iter().map(|c| c.source.split(", 5.").next().unwrap_or_default()).collect();
        rest.sort_unstable();
        for same in rest.chunk_by(|a, b| a == b) {
            let _ = writeln!(text, "| {} | {} | {} |", s.name, same[0], same.len());
        }
    }
}

/// The same limits for the page in HTML.
pub(super) fn html_limits() -> String {
    let items: String = NOT_VALIDATED.iter().map(|l| format!("<li>{}</li>", escaped(l))).collect();
    format!("<h2>What is not validated here</h2><ul>{items}</ul>\n")
}
