//! The Cornell box as its camera saw it through seven filters, and photographs against that.
//!
//! ```text
//! cargo run --release --example cornell-camera -- filter out/scene/camera.exr filtered.exr
//! cargo run --release --example cornell-camera -- compare filtered.exr corners.csv PHOTOGRAPH...
//! ```

pub(crate) mod filters;
pub(crate) mod photograph;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clerestory::{Error, Result};

use filters::{Camera, read_exr, spectral, write_exr};
use photograph::{Place, Region, homography};

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let done = match args.as_slice() {
        ["filter", picture, out] => filter(Path::new(picture), Path::new(out)),
        ["compare", computed, corners, photographs @ ..] if !photographs.is_empty() => {
            compare(Path::new(computed), Path::new(corners), photographs).map(|text| print!("{text}"))
        }
        _ => Err(Error::malformed(
            "expected: filter PICTURE.exr OUT.exr, or compare FILTERED.exr CORNERS.csv PHOTOGRAPH...",
        )),
    };
    done.map_or_else(
        |e| {
            eprintln!("error: {e}");
            ExitCode::from(2)
        },
        |()| ExitCode::SUCCESS,
    )
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/cornell-camera")
}

/// Seven pictures of half floats, named as the filters.
pub(crate) fn filter(picture: &Path, out: &Path) -> Result<()> {
    let stack = read_exr(picture)?;
    let bands = spectral(&stack);
    if bands.is_empty() {
        return Err(Error::malformed("no spectral channels")
            .mend("solve the scene in more than one band")
            .in_file(picture));
    }
    write_exr(out, &Camera::read(&folder().join("camera.csv"))?.record(&bands, stack.width, stack.height))
}

/// A CSV file's rows of numbers, but for a first column of names.
fn table(path: &Path) -> Result<Vec<(String, Vec<f64>)>> {
    let broken = |what: String| Error::malformed(what).in_file(path);
    let mut reader = csv::Reader::from_path(path).map_err(|e| broken(e.to_string()))?;
    let mut rows = Vec::new();
    for (i, record) in reader.records().enumerate() {
        let record = record.map_err(|e| broken(e.to_string()))?;
        let numbers: std::result::Result<Vec<f64>, _> = record.iter().skip(1).map(str::parse).collect();
        let numbers = numbers.map_err(|_| broken("expected numbers after the name".into()).at_line(i + 2))?;
        if numbers.len() < 4 {
            return Err(
                broken(format!("{} numbers after the name, expected four or more", numbers.len())).at_line(i + 2)
            );
        }
        rows.push((record[0].to_owned(), numbers));
    }
    Ok(rows)
}

/// Where Cornell's camera has a point of the box (mm) in a picture of a width in pixels.
pub(crate) fn seen(point_mm: [f64; 3], width: f64) -> Place {
    // 25 mm of film behind 35 mm; +x is at the left.
    let scale = 35.0 / 25.0 / (point_mm[2] + 800.0);
    [width * (0.5 - (point_mm[0] - 278.0) * scale), width * (0.5 - (point_mm[1] - 273.0) * scale)]
}

/// Ratios by region as lines of CSV.
pub(crate) fn compare(computed: &Path, corners: &Path, photographs: &[&str]) -> Result<String> {
    let computed = read_exr(computed)?;
    let width = computed.width as f64;
    let pairs: Vec<(Place, Place)> = table(corners)?
        .into_iter()
        .filter(|(_, v)| v.len() >= 5)
        .map(|(_, v)| (seen([v[0], v[1], v[2]], width), [v[3], v[4]]))
        .collect();
    let Some(h) = homography(&pairs) else {
        return Err(Error::malformed("the corners tell no map")
            .mend("give name, x, y, z in mm, column, row of four corners or more, no three in a line")
            .in_file(corners));
    };
    // In pixels of a picture of 512.
    let scaled = |v: f64| (v * width / 512.0).round() as usize;
    let regions: Vec<Region> = table(&folder().join("regions.csv"))?
        .into_iter()
        .map(|(name, v)| Region { name, from: [scaled(v[0]), scaled(v[1])], to: [scaled(v[2]), scaled(v[3])] })
        .collect();
    let stacks = photographs.iter().map(|p| photograph::read(Path::new(p))).collect::<Result<Vec<_>>>()?;
    let (factor, ratios) = photograph::compare(&computed, &stacks, &h, &regions);
    if ratios.is_empty() {
        return Err(Error::malformed("no photograph has the name of a filter")
            .mend("name files or channels filter_02 to filter_16"));
    }
    let mut text = format!("picture,region,ratio,spread,pixels\nall,all,{factor:.6e},,\n");
    for r in ratios {
        text += &format!("{},{},{:.4},{:.4},{}\n", r.picture, r.region, r.mean, r.spread, r.pixels);
    }
    Ok(text)
}
