//! `clerestory compare`.

use std::fmt::Write;
use std::process::ExitCode;

use super::{CompareArgs, print};
use crate::compare::{self, Comparison};
use crate::{Result, report};

/// Reads both, compares, writes, and says what came out.
pub(super) fn run(args: &CompareArgs) -> Result<ExitCode> {
    let computed = compare::result(&args.result)?;
    let found = compare::measured(&args.measured, &computed)?;
    let mut text =
        if args.json { format!("{:#}\n", serde_json::json!({ "comparisons": found })) } else { lines(&found) };
    if let Some(folder) = &args.out {
        for (name, content) in [("compare.csv", table(&found)), ("compare.svg", compare::svg(&found))] {
            let path = report::write_text(folder, name, &content)?;
            if !args.json {
                let _ = writeln!(text, "  {}", path.display());
            }
        }
    }
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn lines(found: &[Comparison]) -> String {
    let mut text =
        format!("{:<16} {:>6} {:>10} {:>10} {:>10} {:>8}\n", "quantity", "points", "bias", "RMS", "worst", "inside");
    for c in found {
        let figure = |v: f64| if c.quantity.is_relative() { format!("{:.2} %", 100.0 * v) } else { format!("{v:.4}") };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:<16} {:>6} {:>10} {:>10} {:>10} {:>6.1} %",
            c.quantity.column(),
            c.points,
            figure(c.bias),
            figure(c.rms),
            figure(c.worst),
            100.0 * c.share_inside
        );
    }
    text
}

fn table(found: &[Comparison]) -> String {
    let mut text = "quantity,grid,point,measured,uncertainty,computed,error\n".to_owned();
    for c in found {
        for p in &c.pairs {
            // A name may hold a comma.
            let grid = format!("\"{}\"", p.grid.replace('"', "\"\""));
            let (m, v) = (p.measured, p.computed);
            let name = c.quantity.column();
            let _ = writeln!(text, "{name},{grid},{},{},{},{},{}", p.point, m.value, m.error, v.value, v.error);
        }
    }
    text
}
