//! Are the stated errors true? Boxes whose illuminances are known, solved with many seeds.

use super::References;
use super::radiosity::boxes;
use super::sheet::Sheet;
use crate::Result;
use crate::measure::{Method, SolveOptions};

/// Seeds of every box.
const SEEDS: u64 = 5;

pub(super) fn run(references: &References, sheet: &mut Sheet) -> Result<()> {
    let source = "boxes by quadrature (validation/references/boxes.csv), five seeds each";
    for tolerance in [0.1, 0.05, 0.02] {
        let (mut inside, mut holding, mut all) = (0, 0, 0);
        let mut ratios = Vec::new();
        for b in boxes(references)? {
            for seed in 1..=SEEDS {
                let m = b.build.solve_by(&SolveOptions { seed, tolerance, ..SolveOptions::default() })?;
                holding += m.grids[0].holding;
                for (s, (truth, uncertainty)) in m.grids[0].sensors.iter().zip(&b.truth) {
                    let off = (s.xyz[1] - truth).abs();
                    inside += usize::from(off <= s.error_lx + uncertainty);
                    ratios.push(s.error_lx / off.max(*uncertainty));
                    all += 1;
                }
            }
        }
        let percent = 100.0 * tolerance;
        ratios.sort_by(f64::total_cmp);
        sheet.topic("share of the points within their stated error", source, "");
        sheet.in_95_percent(format!("tolerance {percent} %"), inside, all);
        sheet.topic("share of the points that hold the tolerance", source, "");
        sheet.in_95_percent(format!("tolerance {percent} %"), holding, all);
        sheet.topic("median of stated over true error: a statement must say something", source, "");
        sheet.at_most(format!("tolerance {percent} %"), 8.0, ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN));
    }
    path_tracing(references, sheet, source)
}

/// The reference method's own intervals.
fn path_tracing(references: &References, sheet: &mut Sheet, source: &str) -> Result<()> {
    let (mut inside, mut all) = (0, 0);
    for b in boxes(references)? {
        for seed in 1..=SEEDS {
            let method = Method::PathTracing;
            let m = b.build.solve_by(&SolveOptions { seed, method, paths: Some(1024), ..SolveOptions::default() })?;
            for (s, (truth, uncertainty)) in m.grids[0].sensors.iter().zip(&b.truth) {
                inside += usize::from((s.xyz[1] - truth).abs() <= s.error_lx + uncertainty);
                all += 1;
            }
        }
    }
    sheet.topic("share of the points within their stated error", source, "");
    sheet.in_95_percent("path tracing, 1024 paths", inside, all);
    Ok(())
}
