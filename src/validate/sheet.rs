//! Where a suite enters its cases.

use serde::Serialize;

use crate::measure::SensorResult;

/// How a value is held against its reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Comparison {
    /// They differ by at most the stated error and the reference's uncertainty.
    Equal,
    /// The same for an error stated at 95 %: the interval is widened to 99.9 %, for among many cases some lie outside of
    /// the stated one, and how many is a case of its own.
    Estimate,
    /// The value is at least the reference, but for its uncertainty.
    AtLeast,
    /// The value is at most the reference, but for its uncertainty.
    AtMost,
}

/// Half-width of the normal distribution's 99.9 % interval over that of its 95 % interval.
const WIDER: f64 = 3.291 / 1.960;

/// One comparison.
#[derive(Clone, Debug, Serialize)]
pub struct Case {
    /// Names it within its suite.
    pub name: String,
    /// The fact that it holds.
    pub holds: String,
    /// Where the reference comes from.
    pub source: String,
    /// Unit of the four numbers; empty for ratios.
    pub unit: &'static str,
    /// How the two are compared.
    pub comparison: Comparison,
    /// What is known.
    pub reference: f64,
    /// How well.
    pub uncertainty: f64,
    /// What we compute.
    pub value: f64,
    /// The error that we state.
    pub error: f64,
    /// Do they agree?
    pub pass: bool,
}

impl Case {
    /// What the two may differ by.
    #[must_use]
    pub fn allowed(&self) -> f64 {
        match self.comparison {
            Comparison::Equal => self.error + self.uncertainty,
            Comparison::Estimate => WIDER * self.error + self.uncertainty,
            Comparison::AtLeast | Comparison::AtMost => self.uncertainty,
        }
    }

    fn agrees(&self) -> bool {
        let off = self.value - self.reference;
        // Comparisons with NaN are false: what is no number does not pass.
        match self.comparison {
            Comparison::Equal | Comparison::Estimate => off.abs() <= self.allowed(),
            Comparison::AtLeast => -off <= self.allowed(),
            Comparison::AtMost => off <= self.allowed(),
        }
    }
}

/// A number that is known, and how well.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub(super) value: f64,
    pub(super) uncertainty: f64,
}

/// Exact by formula, to rounding.
pub(super) fn exact(value: f64) -> Known {
    Known { value, uncertainty: 1e-12 * value.abs() }
}

/// Known to so much.
pub(super) fn known(value: f64, uncertainty: f64) -> Known {
    Known { value, uncertainty }
}

/// Lines for a reader, under a caption.
#[derive(Clone, Debug)]
pub struct Table {
    /// What it tells.
    pub caption: String,
    /// Heads of the columns.
    pub heads: Vec<String>,
    /// One text for each column.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    pub(super) fn new(caption: String, heads: Vec<String>) -> Self {
        Self { caption, heads, rows: Vec::new() }
    }
}

/// What a suite leaves besides its cases.
#[derive(Clone, Debug, Default)]
pub(super) struct Extras {
    pub(super) figures: Vec<(String, String)>,
    pub(super) tables: Vec<Table>,
    pub(super) files: Vec<(&'static str, String)>,
    pub(super) skipped: Option<&'static str>,
}

/// Collects the cases of a suite.
#[derive(Debug, Default)]
pub(super) struct Sheet {
    cases: Vec<Case>,
    extras: Extras,
    holds: String,
    source: String,
    unit: &'static str,
}

impl Sheet {
    /// What the next cases hold, by what source, in what unit.
    pub(super) fn topic(&mut self, holds: &str, source: &str, unit: &'static str) {
        holds.clone_into(&mut self.holds);
        source.clone_into(&mut self.source);
        self.unit = unit;
    }

    /// A value with an error that bounds it.
    pub(super) fn equal(&mut self, name: impl Into<String>, known: Known, value: f64, error: f64) {
        self.enter(name.into(), Comparison::Equal, known, value, error);
    }

    /// A value with an error stated at 95 %.
    pub(super) fn estimate(&mut self, name: impl Into<String>, known: Known, value: f64, error: f64) {
        self.enter(name.into(), Comparison::Estimate, known, value, error);
    }

    /// The illuminance of a sensor with its stated error; `placed` is what its place and a photometric table leave.
    pub(super) fn sensor(&mut self, name: impl Into<String>, known: Known, sensor: &SensorResult, placed: f64) {
        let known = Known { uncertainty: known.uncertainty + placed * known.value.abs(), ..known };
        self.estimate(name, known, sensor.xyz[1], sensor.error_lx);
    }

    pub(super) fn at_least(&mut self, name: impl Into<String>, limit: f64, value: f64) {
        self.enter(name.into(), Comparison::AtLeast, known(limit, 0.0), value, 0.0);
    }

    /// The share of trials in which something happens that should happen in 95 %: of so many trials, two standard
    /// deviations fewer may be.
    pub(super) fn in_95_percent(&mut self, name: impl Into<String>, hits: usize, trials: usize) {
        self.in_share(name, 0.95, hits, trials);
    }

    /// The same for any share.
    pub(super) fn in_share(&mut self, name: impl Into<String>, share: f64, hits: usize, trials: usize) {
        let n = trials.max(1) as f64;
        let slack = 2.0 * (share * (1.0 - share) / n).sqrt();
        self.enter(name.into(), Comparison::AtLeast, known(share, slack), hits as f64 / n, 0.0);
    }

    /// The cases whose name is this one, or begins with it and a comma.
    pub(super) fn named(&self, name: &str) -> impl Iterator<Item = &Case> {
        let begins =
            move |c: &&Case| c.name.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with(", "));
        self.cases.iter().filter(begins)
    }

    /// All cases.
    pub(super) fn cases(&self) -> &[Case] {
        &self.cases
    }

    pub(super) fn at_most(&mut self, name: impl Into<String>, limit: f64, value: f64) {
        self.enter(name.into(), Comparison::AtMost, known(limit, 0.0), value, 0.0);
    }

    /// A picture for the report.
    pub(super) fn figure(&mut self, caption: impl Into<String>, svg: String) {
        self.extras.figures.push((caption.into(), svg));
    }

    /// A table for the report.
    pub(super) fn table(&mut self, table: Table) {
        self.extras.tables.push(table);
    }

    /// A file beside the report.
    pub(super) fn file(&mut self, name: &'static str, text: String) {
        self.extras.files.push((name, text));
    }

    /// The suite cannot run, and why.
    pub(super) fn skip(&mut self, why: &'static str) {
        self.extras.skipped = Some(why);
    }

    fn enter(&mut self, name: String, comparison: Comparison, known: Known, value: f64, error: f64) {
        let mut case = Case {
            name,
            holds: self.holds.clone(),
            source: self.source.clone(),
            unit: self.unit,
            comparison,
            reference: known.value,
            uncertainty: known.uncertainty,
            value,
            error,
            pass: false,
        };
        case.pass = case.agrees();
        self.cases.push(case);
    }

    pub(super) fn finish(self) -> (Vec<Case>, Extras) {
        (self.cases, self.extras)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_fails_where_it_should() {
        let mut sheet = Sheet::default();
        sheet.equal("at the limit", known(1.0, 0.25), 1.5, 0.25);
        sheet.equal("beyond", known(1.0, 0.1), 1.5, 0.25);
        sheet.equal("no number", known(1.0, 0.1), f64::NAN, 0.25);
        sheet.equal("no error", known(1.0, 0.1), 1.0, f64::NAN);
        sheet.estimate("within 99.9 %", known(1.0, 0.0), 1.16, 0.1);
        sheet.estimate("beyond 99.9 %", known(1.0, 0.0), 1.17, 0.1);
        sheet.at_least("enough", 0.95, 0.96);
        sheet.at_least("too little", 0.95, 0.94);
        sheet.at_most("too much", 0.95, 0.96);
        let passed: Vec<bool> = sheet.finish().0.iter().map(|c| c.pass).collect();
        assert_eq!(passed, [true, false, false, false, true, false, true, false, false]);
    }
}
