//! Where each method of the family fails, and what the default does on the same case.
//!
//! `cargo run --release --example stability` prints the numbers and writes them, with a chart, into this folder.

#[path = "../../tests/common/mod.rs"]
mod common;
mod form_factors;
mod rooms;
mod solvers;
#[path = "../../tests/where_methods_fail/tools.rs"]
mod tools;

use std::fmt::Write;
use std::path::PathBuf;

use clerestory::report::{Curve, CurvePanel, Curves, write_curves};

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Errors below rounding are drawn here.
const ROUNDING: f64 = 1e-16;

fn main() -> Outcome<()> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("experiments/stability");
    let mut out = Table { csv: "case,x,method,relative_error\n".into(), panels: Vec::new() };
    solvers::near_white(&mut out)?;
    form_factors::gap(&mut out);
    form_factors::sliver(&mut out);
    form_factors::hemicube(&mut out);
    rooms::run(&mut out)?;
    std::fs::write(folder.join("results.csv"), &out.csv)?;
    let curves = Curves {
        title: "Where methods fail".into(),
        subtitle: "relative error against what makes the case hard; the last curve of each panel is the default".into(),
        panels: out.panels,
    };
    write_curves(&folder, "failures", &curves)?;
    Ok(())
}

/// Numbers, printed, kept as CSV, and drawn.
struct Table {
    csv: String,
    panels: Vec<CurvePanel>,
}

impl Table {
    /// Enters the error of a method at a place; `None` where it refused.
    fn enter(&mut self, case: &str, x: f64, method: &str, error: Option<f64>) {
        let shown = error.map_or("refused".into(), |e| format!("{e:.3e}"));
        println!("{case:<14} {x:>9.1e}  {method:<44} {shown}");
        // Writing to a string cannot fail.
        let _ = writeln!(self.csv, "{case},{x:e},\"{method}\",{shown}");
    }

    /// Enters it and draws it into the panel begun last.
    fn draw(&mut self, case: &str, x: f64, method: &str, error: Option<f64>) {
        self.enter(case, x, method, error);
        let Some(panel) = self.panels.last_mut() else { return };
        let k = panel.curves.iter().position(|c| c.name == method).unwrap_or_else(|| {
            panel.curves.push(Curve { name: method.into(), ..Curve::default() });
            panel.curves.len() - 1
        });
        match error {
            Some(e) => panel.curves[k].points.push([x, e.abs().max(ROUNDING)]),
            None => panel.curves[k].refused.push(x),
        }
    }

    /// Begins a panel.
    fn panel(&mut self, heading: &str, x: &str) {
        let axes = [x.into(), "relative error".into()];
        self.panels.push(CurvePanel { heading: heading.into(), axes, curves: Vec::new() });
    }
}
