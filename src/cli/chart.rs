//! `clerestory chart`.

use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

use super::{ChartArgs, print, progress};
use crate::Result;
use crate::chart::{self, Chart, ChartOptions};
use crate::report;
use crate::scene;

/// Reads, measures, writes, and says what came out.
pub(super) fn run(args: &ChartArgs) -> Result<ExitCode> {
    let pool = super::pool(args.threads)?;
    let scene = scene::load(&args.scene)?;
    // Peers are read first: an hour of measuring is not lost to a slip in their file.
    let peers = args.peer.iter().map(|p| chart::read_peers(p)).collect::<Result<Vec<_>>>()?;
    let options = ChartOptions { full: args.full, seed: args.seed };
    let mut chart = {
        let progress = progress::progress(args.quiet);
        pool.install(|| chart::run(&scene, &options, &*progress)).map_err(|e| e.in_file(&args.scene))?
    };
    chart.points.extend(peers.into_iter().flatten());
    let stem = || args.scene.file_stem().unwrap_or_else(|| "scene".as_ref());
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(stem()));
    let files = report::write_chart(&folder, &chart)?;
    let mut text = summary(&chart);
    for file in files {
        let _ = writeln!(text, "  {}", file.display());
    }
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// The points, for the terminal.
fn summary(chart: &Chart) -> String {
    let mut text = format!(
        "{}: {} points; reference {} paths a point, its own error {:.3} % RMS\n",
        chart.title,
        chart.sensors,
        chart.reference.paths,
        100.0 * chart.reference.uncertainty
    );
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{:<27} {:<26} {:>8} {:>8} {:>8} {:>9}",
        "method", "setting", "cpu s", "RMS %", "bias %", "covered %"
    );
    for p in &chart.points {
        let _ = match &p.found {
            Some(f) => writeln!(
                text,
                "{:<27} {:<26} {:>8.2} {:>8.3} {:>8.3} {:>9}{}",
                p.method,
                p.setting,
                p.cpu_s,
                100.0 * f.rms,
                100.0 * f.bias,
                f.coverage.map_or("-".into(), |c| format!("{:.1}", 100.0 * c)),
                if f.resolved { "" } else { "  not told from the reference" }
            ),
            None => writeln!(text, "{:<27} {:<26} {:>8.2} failed: {}", p.method, p.setting, p.cpu_s, p.note),
        };
    }
    for note in &chart.notes {
        let _ = writeln!(text, "{note}");
    }
    text.push_str("written:\n");
    text
}
