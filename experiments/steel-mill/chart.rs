//! What a solve costs against the size of the hall: each in a process of its own, as its record tells.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use clerestory::report::{Curve, CurvePanel, Curves, write_curves};
use serde_json::Value;

use super::hall::Size;
use super::{Outcome, write};

/// Sizes from one bay to 480; the last would have about a million elements.
const SIZES: [(usize, usize); 9] = [(1, 1), (1, 2), (1, 5), (1, 10), (1, 20), (2, 20), (2, 60), (5, 60), (8, 60)];

/// One solve.
struct Run {
    size: Size,
    polygons: usize,
    elements: f64,
    rays: f64,
    cpu_s: f64,
    peak_mb: f64,
    planned_mb: f64,
}

/// Solves the first `count` sizes with the program at `binary`; scenes and results go into `work`, table and chart into
/// `folder`.
pub(crate) fn chart(binary: &Path, work: &Path, folder: &Path, count: usize) -> Outcome<()> {
    let mut runs = Vec::new();
    for (aisles, bays) in SIZES.into_iter().take(count) {
        let run = solve(binary, &work.join(format!("{aisles}x{bays}")), Size { aisles, bays })?;
        println!(
            "{aisles} x {bays}: {} polygons, {} elements, {} rays, {:.1} CPU s, {:.0} MB ({:.0} planned)",
            run.polygons, run.elements, run.rays, run.cpu_s, run.peak_mb, run.planned_mb
        );
        runs.push(run);
        std::fs::write(folder.join("cost.csv"), table(&runs))?;
    }
    draw(folder, &runs)
}

fn solve(binary: &Path, folder: &Path, size: Size) -> Outcome<Run> {
    let polygons = write(size, None, folder)?;
    let status = Command::new(binary)
        .args(["solve", "--quiet", "-o"])
        .args([folder.join("out"), folder.join("scene.toml")])
        .stdout(std::process::Stdio::null())
        .status()?;
    if status.code().is_none_or(|code| code != 0 && code != 3) {
        return Err(format!("{} ended with {status}", binary.display()).into());
    }
    let record: Value = serde_json::from_slice(&std::fs::read(folder.join("out/run.json"))?)?;
    let number =
        |path: &str| record.pointer(path).and_then(Value::as_f64).ok_or_else(|| format!("run.json has no {path}"));
    Ok(Run {
        size,
        polygons,
        elements: number("/counts/elements")?,
        rays: number("/counts/rays")?,
        cpu_s: number("/cpu_s")?,
        peak_mb: number("/memory/peak_bytes")? / 1e6,
        planned_mb: number("/memory/planned_bytes")? / 1e6,
    })
}

fn table(runs: &[Run]) -> String {
    let mut text = "aisles,bays,polygons,elements,rays,cpu_s,peak_MB,planned_MB\n".to_owned();
    for r in runs {
        let (Size { aisles, bays }, polygons) = (r.size, r.polygons);
        let _ = writeln!(
            text,
            "{aisles},{bays},{polygons},{},{},{:.2},{:.1},{:.1}",
            r.elements, r.rays, r.cpu_s, r.peak_mb, r.planned_mb
        );
    }
    text
}

/// Exponent `k` of `y = c N^k` by least squares of the logarithms.
fn slope(points: &[[f64; 2]]) -> f64 {
    let logs: Vec<[f64; 2]> = points.iter().map(|p| p.map(f64::ln)).collect();
    let n = logs.len() as f64;
    let mean = |axis: usize| logs.iter().map(|p| p[axis]).sum::<f64>() / n;
    let (x, y) = (mean(0), mean(1));
    logs.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>() / logs.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>()
}

fn draw(folder: &Path, runs: &[Run]) -> Outcome<()> {
    type Quantity = (&'static str, fn(&Run) -> f64);
    let quantities: [Quantity; 3] =
        [("processor time, s", |r| r.cpu_s), ("rays", |r| r.rays), ("memory at the peak, MB", |r| r.peak_mb)];
    let panels = quantities.map(|(name, of)| {
        let points: Vec<[f64; 2]> = runs.iter().map(|r| [r.elements, of(r)]).collect();
        let slope = slope(&points);
        println!("{name}: N^{slope:.2}");
        let middle = points[points.len() / 2];
        let limit = points.iter().map(|p| [p[0], middle[1] * (p[0] / middle[0]).powf(1.1)]).collect();
        let curve = |name: String, points| Curve { name, points, refused: Vec::new() };
        CurvePanel {
            heading: name.into(),
            axes: ["elements".into(), name.into()],
            curves: vec![curve(format!("measured, N^{slope:.2}"), points), curve("N^1.1".into(), limit)],
        }
    });
    let curves = Curves {
        title: "What a solve costs against the size of the hall".into(),
        subtitle: format!(
            "steel mills of {} polygons, 240 points on the floor, three bands, tolerance 5 %",
            runs.iter().map(|r| r.polygons.to_string()).collect::<Vec<_>>().join(", ")
        ),
        panels: panels.into(),
    };
    write_curves(folder, "cost", &curves)?;
    Ok(())
}
