//! The Cornell box as a whole: time, processor time, rays and error side by side.
//!
//! `cargo bench --bench cornell` takes all; words behind `--` choose: `sensors`, `picture`. The true error is
//! taken against `validation/cornell/reference.csv` (path-traced, the form of irradiance.csv) where that is
//! stored. Mind that few bands err by themselves: nothing here is told apart from the noise.

mod common;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use clerestory::measure::{GridResult, Measurement, Silent, SolveOptions, Status, solve};
use clerestory::report::{Form, Provenance, write_all};
use clerestory::scene::{Scene, load};
use clerestory::spectrum::{BandMode, Bands};
use common::{Took, timed};

/// Range of the box's own 76 bands.
const RANGE_NM: (f64, f64) = (398.0, 702.0);

fn main() {
    // Cargo itself hands on `--bench`.
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let wants = |word: &str| words.is_empty() || words.iter().any(|w| w == word);
    if wants("sensors") {
        sensors();
    }
    if wants("picture") {
        picture();
    }
}

fn scene(file: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/cornell").join(file);
    load(&path).expect("the shipped scene is sound")
}

fn sensors() {
    let mut scene = scene("points.toml");
    let reference = Reference::read(&scene);
    let header = "  wall s   CPU s  M rays  elements  stated %  true %: median     RMS     95th  inside";
    println!("Cornell box, the points of five grids (stated, median; true against the reference)");
    println!("tolerance bands {header}");
    for tolerance in [0.05, 0.01] {
        for bands in [3, 9, 31, 81] {
            scene.bands = BandMode::Edges(edges(bands));
            let (m, took) = timed(|| run(&scene, tolerance));
            let errors = reference.as_ref().map(|r| r.compare(&m));
            println!("{:>8} % {bands:>5} {}", 100.0 * tolerance, row(&m, took, errors));
        }
    }
    println!();
}

fn picture() {
    let scene = scene("scene.toml");
    println!("Cornell box with its picture of 512 x 512 pixels, 76 bands, tolerance 5 %");
    let (m, took) = timed(|| run(&scene, 0.05));
    println!(
        "solve           {:>8.2} s {:>8.2} CPU s {:>8.1} M rays",
        took.wall_s,
        took.cpu_s,
        count(&m, "rays") / 1e6
    );
    for (stage, seconds) in &m.record.timings_s {
        println!("  {stage:<28} {seconds:>8.2} s");
    }
    for v in &m.views {
        println!(
            "  error of {}: {:.2} % median, {:.2} % 95th percentile",
            v.view.name,
            100.0 * v.error_median,
            100.0 * v.error_p95
        );
    }
    let dir = tempfile::tempdir().expect("a place for temporary files");
    let (files, took) = timed(|| write_all(dir.path(), &scene, &m, Form::default(), &Provenance::default()));
    let files = files.expect("finite results can be written");
    println!("write {} files  {:>8.2} s {:>8.2} CPU s", files.len(), took.wall_s, took.cpu_s);
    println!();
}

fn run(scene: &Scene, tolerance: f64) -> Measurement {
    let options = SolveOptions { tolerance, ..SolveOptions::default() };
    solve(scene, &options, &Silent).expect("the shipped scene has a solution")
}

fn edges(bands: usize) -> Vec<f64> {
    let (lo, hi) = RANGE_NM;
    (0..=bands).map(|k| lo + (hi - lo) * k as f64 / bands as f64).collect()
}

fn count(m: &Measurement, name: &str) -> f64 {
    m.record.counts.iter().find(|c| c.0 == name).map_or(f64::NAN, |c| c.1 as f64)
}

/// Percent, of the value or a tenth of its grid's mean, whichever is more.
struct Errors {
    median: f64,
    rms: f64,
    p95: f64,
    /// Share of the sensors whose true error is inside the stated one, widened by the reference's own.
    inside: f64,
}

fn row(m: &Measurement, took: Took, errors: Option<Errors>) -> String {
    let mut stated: Vec<f64> = m.grids.iter().flat_map(|g| relative(g, |_, s| s.error_lx)).collect();
    let truth = errors.map_or("   no reference stored".into(), |e| {
        format!("{:>15.2} {:>7.2} {:>8.2} {:>6.1} %", e.median, e.rms, e.p95, e.inside)
    });
    format!(
        "{:>9.2} {:>7.2} {:>7.2} {:>9} {:>9.2} {truth}",
        took.wall_s,
        took.cpu_s,
        count(m, "rays") / 1e6,
        count(m, "elements"),
        percentile(&mut stated, 0.5)
    )
}

/// `f` of every lit sensor in percent of its scale.
fn relative(g: &GridResult, f: impl Fn(usize, &clerestory::measure::SensorResult) -> f64) -> Vec<f64> {
    let lit: Vec<_> = g.sensors.iter().enumerate().filter(|(_, s)| s.status == Status::Ok).collect();
    let mean = lit.iter().map(|(_, s)| s.xyz[1]).sum::<f64>() / lit.len().max(1) as f64;
    lit.iter().map(|(i, s)| 100.0 * f(*i, s) / s.xyz[1].max(0.1 * mean)).collect()
}

fn percentile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let at = (share * values.len().saturating_sub(1) as f64).round() as usize;
    values.get(at).copied().unwrap_or(f64::NAN)
}

/// Path-traced illuminances, lx: value and half-width at 95 %.
struct Reference(HashMap<(String, usize), (f64, f64)>);

impl Reference {
    fn read(scene: &Scene) -> Option<Self> {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("validation/cornell/reference.csv");
        let mut reader = csv::Reader::from_path(path).ok()?;
        let mut spectra: HashMap<(String, usize), Vec<[f64; 4]>> = HashMap::new();
        for record in reader.records() {
            let record = record.expect("reference.csv is a table");
            let figure = |c: usize| record[c].parse::<f64>().expect("reference.csv holds numbers");
            let point = record[1].parse().expect("reference.csv counts its points");
            spectra.entry((record[0].to_owned(), point)).or_default().push([2, 3, 4, 5].map(figure));
        }
        let first = spectra.values().next()?;
        let edges: Vec<f64> = first.iter().map(|b| b[0]).chain(first.last().map(|b| b[1])).collect();
        let light = scene.materials.iter().find_map(|m| m.emission.as_ref())?;
        let (bands, _) = Bands::plan(&BandMode::Edges(edges), &[], &[(&light.radiance, 1.0)], 0.05).ok()?;
        let lux = |spectrum: &[[f64; 4]], column: usize| {
            bands.xyz(&spectrum.iter().map(|b| b[column]).collect::<Vec<_>>())[1]
        };
        // Bands of one path share its noise: their half-widths add up.
        Some(Self(spectra.into_iter().map(|(key, s)| (key, (lux(&s, 2), lux(&s, 3)))).collect()))
    }

    fn compare(&self, m: &Measurement) -> Errors {
        let mut errors = Vec::new();
        let mut inside = 0;
        for g in &m.grids {
            let of = |i: usize| self.0.get(&(g.name.clone(), i)).copied().unwrap_or((f64::NAN, f64::NAN));
            errors.extend(relative(g, |i, s| (s.xyz[1] - of(i).0).abs()).into_iter().filter(|e| e.is_finite()));
            let lit = g.sensors.iter().enumerate().filter(|(_, s)| s.status == Status::Ok);
            inside += lit.filter(|(i, s)| (s.xyz[1] - of(*i).0).abs() <= s.error_lx + of(*i).1).count();
        }
        let n = errors.len().max(1) as f64;
        Errors {
            rms: (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
            median: percentile(&mut errors, 0.5),
            p95: percentile(&mut errors, 0.95),
            inside: 100.0 * inside as f64 / n,
        }
    }
}
