//! What a run writes: tables, maps, pictures and the run's record.
//!
//! In: a [`Measurement`] and its [`Scene`]. Out: files in one directory, each whole or not at all. Nothing
//! is computed here but means, colours and pictures; a value that is not finite is refused, never written.

mod alpha_opic;
mod annual;
mod annual_json;
mod annual_pictures;
mod annual_tables;
mod appraisal;
mod canvas;
mod chart;
mod curves;
mod drawing;
mod exr;
mod field;
mod figure;
mod file;
mod hdr;
mod isolines;
mod legend;
mod map;
mod modelling;
mod panel;
mod png;
mod polar;
mod run_json;
mod scale;
mod stages;
mod table;
mod text;
mod units;

use std::path::{Path, PathBuf};

use crate::error::{Error, ErrorKind, Result};
use crate::measure::{Ledger, Measurement, ViewResult};
use crate::scene::{GridLayout, Scene};

pub use annual::write_year;
pub use annual_json::year_json;
pub use chart::write_chart;
pub use curves::{Curve, CurvePanel, Curves, write_curves};
pub use polar::write_polar;
pub use run_json::run_json;
pub use stages::write_stages;
pub use units::{LUX_PER_FOOTCANDLE, Units};

/// How the run came about.
#[derive(Clone, Debug, Default)]
pub struct Provenance {
    /// Version of the program.
    pub version: String,
    /// The command line.
    pub command: Vec<String>,
    /// Threads used.
    pub threads: usize,
    /// Processor time, s, where the system tells it.
    pub cpu_s: Option<f64>,
    /// Wall time, s.
    pub wall_s: f64,
    /// Largest memory held, bytes, where the system tells it.
    pub peak_bytes: Option<u64>,
}

/// Writes a text as a file of `dir`, which is made if it is missing.
///
/// # Errors
/// Io with the file's name.
pub fn write_text(dir: &Path, name: &str, text: &str) -> Result<PathBuf> {
    std::fs::create_dir_all(dir).map_err(|e| Error::io(dir, &e))?;
    let path = dir.join(name);
    file::write_whole(&path, text.as_bytes())?;
    Ok(path)
}

/// What results are written in.
#[derive(Clone, Copy, Debug, Default)]
pub struct Form {
    /// Adds the irradiance in each band, where the bands are ranges of wavelengths.
    pub spectral: bool,
    /// Unit of illuminances in tables, maps and the record.
    pub units: Units,
}

/// Writes everything that the scene asks for into `dir`, which is made if it is missing; answers the files
/// written, in order.
///
/// # Errors
/// Io with the file's name; internal where a value is not finite or a picture has not its size.
pub fn write_all(
    dir: &Path,
    scene: &Scene,
    m: &Measurement,
    form: Form,
    provenance: &Provenance,
) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(dir).map_err(|e| Error::io(dir, &e))?;
    check_ledger(&m.ledger)?;
    let mut files = Vec::new();
    let mut write = |name: &str, bytes: Vec<u8>| -> Result<()> {
        let path = dir.join(name);
        let bytes = if name.ends_with(".csv") { form.units.table(bytes)? } else { bytes };
        file::write_whole(&path, &bytes)?;
        files.push(path);
        Ok(())
    };
    write("illuminance.csv", table::illuminance(scene, m)?)?;
    write("summary.csv", table::summary(m)?)?;
    if !m.states.is_empty() {
        write("states.csv", table::states(scene, m)?)?;
    }
    if !m.appraisal.requirements.is_empty() {
        write("requirements.csv", appraisal::requirements(&m.appraisal)?)?;
    }
    if !m.appraisal.surfaces.is_empty() {
        write("surfaces.csv", appraisal::surfaces(&m.appraisal)?)?;
    }
    if !scene.modelling.is_empty() {
        write("modelling.csv", modelling::modelling(scene, m)?)?;
    }
    if form.spectral && m.bands.is_spectral() {
        write("irradiance.csv", table::irradiance(m)?)?;
    }
    if let Some(scale) = &m.alpha_opic {
        write("alpha_opic.csv", alpha_opic::table(m, scale)?)?;
    }
    if !m.glare.is_empty() {
        write("glare.csv", table::glare(m)?)?;
    }
    let mut names = file::Names::default();
    for grid in &m.grids {
        let stem = names.claim(&grid.name, &[""]);
        if matches!(grid.layout, GridLayout::Raster { .. }) {
            write(&format!("{stem}.png"), map::illuminance(scene, grid, form.units)?)?;
        }
    }
    for result in &m.views {
        check_view(result, m.bands.len())?;
        let stem = names.claim(&result.view.name, &["", LUMINANCE]);
        write(&format!("{stem}.exr"), exr::encode(scene, m, result, provenance)?)?;
        write(&format!("{stem}.hdr"), hdr::encode(scene, result, provenance)?)?;
        write(&format!("{stem}.png"), png::tone_mapped(scene, result)?)?;
        write(&format!("{stem}{LUMINANCE}.png"), map::luminance(scene, result)?)?;
    }
    let record = form.units.record(run_json(scene, m, provenance));
    let mut text =
        serde_json::to_string_pretty(&record).map_err(|e| Error::new(ErrorKind::Internal, format!("run.json: {e}")))?;
    text.push('\n');
    write("run.json", text.into_bytes())?;
    Ok(files)
}

/// Ending of the false-colour picture of a view.
const LUMINANCE: &str = "_luminance";

/// A balance without NaN or infinities.
fn check_ledger(ledger: &Ledger) -> Result<()> {
    let lines = [
        ("emitted", &ledger.emitted),
        ("absorbed", &ledger.absorbed),
        ("escaped", &ledger.escaped),
        ("unexpanded", &ledger.unexpanded),
        ("sampling error", &ledger.sampling_error),
    ];
    for (name, line) in lines {
        if let Some(band) = line.iter().position(|v| !v.is_finite()) {
            return Err(Error::new(ErrorKind::Internal, format!("the {name} flux in band {band} is {}", line[band])));
        }
    }
    Ok(())
}

/// A picture of the right size without NaN or infinities.
fn check_view(result: &ViewResult, bands: usize) -> Result<()> {
    let view = &result.view;
    let pixels = view.width * view.height;
    let wrong = |what: String| Err(Error::new(ErrorKind::Internal, format!("view {:?}: {what}", view.name)));
    if pixels == 0 || result.xyz.len() != pixels || result.radiance.len() != pixels * bands {
        return wrong(format!(
            "{} × {} pixels in {bands} bands came with {} colours and {} radiances",
            view.width,
            view.height,
            result.xyz.len(),
            result.radiance.len()
        ));
    }
    let broken = (0..pixels).find(|&i| {
        let radiance = &result.radiance[i * bands..(i + 1) * bands];
        !result.xyz[i].iter().chain(radiance).all(|v| v.is_finite())
    });
    match broken {
        Some(i) => wrong(format!("pixel ({}, {}) is not finite", i % view.width, i / view.width)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod samples;
#[cfg(test)]
mod tests;
