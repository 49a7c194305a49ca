//! The measured Cornell box against path tracing of 1,048,576 paths a point.

use std::collections::BTreeMap;

use super::References;
use super::figure::{Map, maps};
use super::sheet::{Sheet, known};
use crate::error::{Error, Result};
use crate::measure::{self, Silent, SolveOptions, Status};

/// The bands of the scene, and the two of the 76 that the stored reference holds.
const ALL_BANDS: &str = "range_nm = [398, 702]";
const TWO_BANDS: &str = "range_nm = [546, 554]";
const TOLERANCE: f64 = 0.01;
const SOURCE: &str =
    "our path tracer: validation/cornell/points.toml --method path-tracing --paths 1048576 --spectral --seed 7";

/// A point's reference: irradiance and 95 % half-width.
type Truth = BTreeMap<(String, usize, u32), (f64, f64)>;

pub(super) fn run(references: &References, sheet: &mut Sheet) -> Result<()> {
    let scene = references.scene("validation/cornell", "points.toml", |t| t.replace(ALL_BANDS, TWO_BANDS))?;
    let options = SolveOptions { tolerance: TOLERANCE, spectral: true, ..SolveOptions::default() };
    let m = measure::solve(&scene, &options, &Silent)?;
    let mut truth = Truth::new();
    for row in references.rows("cornell.csv")? {
        let key = (row.text("grid")?.to_owned(), row.number("point")? as usize, row.number("band_lo_nm")? as u32);
        truth.insert(key, (row.number("irradiance_W_m2_nm")?, row.number("error_W_m2_nm")?));
    }
    let (mut inside, mut all) = (0, 0);
    let mut pictures = Vec::new();
    for grid in &m.grids {
        let mut cells = vec![None; grid.sensors.len()];
        for (band, (lo, _)) in m.bands.limits_nm().iter().enumerate() {
            let mut off = Vec::new();
            for (i, s) in grid.sensors.iter().enumerate().filter(|(_, s)| s.status == Status::Ok) {
                let key = (grid.name.clone(), i, *lo as u32);
                let Some((reference, error)) = truth.get(&key) else {
                    let point = format!("{} {i} at {lo} nm", grid.name);
                    return Err(Error::malformed(format!("no point {point}")).in_file("cornell.csv"));
                };
                let found = s.spectral[band];
                off.push((found.irradiance / reference - 1.0, found.error / reference, error / reference));
                inside += usize::from((found.irradiance - reference).abs() <= found.error + error);
                all += 1;
                cells[i] = Some(found.irradiance);
            }
            score(sheet, &format!("{} at {lo} nm", grid.name), &off);
        }
        pictures.push(Map { title: grid.name.replace('_', " "), columns: 10, cells });
    }
    sheet.topic("share of the points within their stated error", SOURCE, "");
    sheet.in_95_percent("all surfaces", inside, all);
    sheet.figure("Irradiance of the five surfaces at 550 nm, W/(m² nm), 10 × 10 points each", maps(&pictures));
    Ok(())
}

/// Bias and RMS of a surface. What is allowed is that which is stated: for the bias the mean stated error (errors of one
/// surface may have one sign), for the RMS the standard error of a point that just holds the tolerance at 95 %.
fn score(sheet: &mut Sheet, name: &str, off: &[(f64, f64, f64)]) {
    let n = off.len().max(1) as f64;
    let mean = |of: &dyn Fn(&(f64, f64, f64)) -> f64| off.iter().map(of).sum::<f64>() / n;
    let uncertainty = mean(&|o| o.2 * o.2).sqrt();
    sheet.topic("mean relative difference over a surface", SOURCE, "");
    sheet.equal(name, known(0.0, uncertainty / n.sqrt()), mean(&|o| o.0), mean(&|o| o.1));
    sheet.topic("RMS relative difference over a surface", SOURCE, "");
    sheet.at_most(name, TOLERANCE / 1.96, mean(&|o| o.0 * o.0).sqrt());
}
