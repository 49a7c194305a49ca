//! What a year writes: the hourly matrix for programs, tables and pictures for people.

use std::path::{Path, PathBuf};

use super::file::{Names, write_whole};
use super::{Provenance, annual_pictures, annual_tables, year_json};
use crate::annual::{GridYear, Year};
use crate::error::{Error, ErrorKind, Result};
use crate::scene::Scene;

/// Writes a year into `dir`, which is made if it is missing; answers the files written, in order.
///
/// # Errors
/// Io with the file's name; internal where a value is not finite.
pub fn write_year(dir: &Path, scene: &Scene, year: &Year, provenance: &Provenance) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(dir).map_err(|e| Error::io(dir, &e))?;
    check_finite(year)?;
    let mut names = Names::default();
    let mut all: Vec<(String, Vec<u8>)> = vec![
        ("metrics.csv".into(), annual_tables::points(scene.axes, year)?),
        ("grid_metrics.csv".into(), annual_tables::grids(year)?),
        ("annual.npy".into(), npy(year, |grid, i| grid.series.of(i))),
        ("annual_error.npy".into(), npy(year, |grid, i| grid.series.error_of(i))),
        ("annual.ill".into(), ill(year)),
        ("sun-up-hours.txt".into(), sun_up_hours(year)),
    ];
    for grid in &year.grids {
        let stem = names.claim(&grid.name, &annual_pictures::ENDINGS);
        let pictures = annual_pictures::pictures(scene, year, grid)?;
        all.extend(pictures.into_iter().map(|(ending, bytes)| (format!("{stem}{ending}.png"), bytes)));
    }
    let mut record = format!("{:#}", year_json(scene, year, provenance));
    record.push('\n');
    all.push(("run.json".into(), record.into_bytes()));
    let write = |(name, bytes): (String, Vec<u8>)| {
        let path = dir.join(name);
        write_whole(&path, &bytes).map(|()| path)
    };
    all.into_iter().map(write).collect()
}

/// No NaN and no infinity goes out.
fn check_finite(year: &Year) -> Result<()> {
    for grid in &year.grids {
        let s = &grid.series;
        if let Some(at) = s.lux.iter().zip(&s.error).position(|(v, e)| !v.is_finite() || !e.is_finite()) {
            let what = format!("grid {:?}, point {}: an hour is not finite", grid.name, at / s.hours.max(1));
            return Err(Error::new(ErrorKind::Internal, what));
        }
    }
    Ok(())
}

/// All sensors of all grids by all hours of the file, 32-bit floats, in NumPy's format 1.0: dark hours are zero.
fn npy<'a>(year: &'a Year, row: impl Fn(&'a GridYear, usize) -> &'a [f32]) -> Vec<u8> {
    let sensors: usize = year.grids.iter().map(|g| g.sensors.len()).sum();
    let total = year.climate.total;
    let mut header =
        format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({sensors}, {total}), }}").into_bytes();
    // Magic, version and length are ten bytes; the header ends at a multiple of 64 with a line feed.
    header.resize(
        (10 + header.len()).div_ceil(64) * 64 - 11 + if (10 + header.len()).is_multiple_of(64) { 64 } else { 0 },
        b' ',
    );
    header.push(b'\n');
    let mut bytes = Vec::with_capacity(10 + header.len() + 4 * sensors * total);
    bytes.extend_from_slice(b"\x93NUMPY\x01\x00");
    bytes.extend_from_slice(&(header.len() as u16).to_le_bytes());
    bytes.extend_from_slice(&header);
    let mut hours = vec![0.0f32; total];
    for grid in &year.grids {
        for i in 0..grid.sensors.len() {
            for (hour, lux) in year.climate.hours.iter().zip(row(grid, i)) {
                hours[hour.index] = *lux;
            }
            hours.iter().for_each(|h| bytes.extend_from_slice(&h.to_le_bytes()));
        }
    }
    bytes
}

/// One row a sensor, one column an hour with sun, lux; no header.
fn ill(year: &Year) -> Vec<u8> {
    let mut text = Vec::new();
    for grid in &year.grids {
        for i in 0..grid.sensors.len() {
            for (k, lux) in grid.series.of(i).iter().enumerate() {
                if k > 0 {
                    text.push(b' ');
                }
                // Whole numbers are written far faster than floats; the product is exact.
                if *lux < 100.0 {
                    let hundredths = (f64::from(*lux) * 100.0).round_ties_even() as u64;
                    push_number(&mut text, hundredths / 100);
                    let [tenth, hundredth] = [hundredths / 10 % 10, hundredths % 10].map(|d| b'0' + d as u8);
                    text.extend_from_slice(&[b'.', tenth, hundredth]);
                } else {
                    push_number(&mut text, lux.round_ties_even() as u64);
                }
            }
            text.push(b'\n');
        }
    }
    text
}

fn push_number(text: &mut Vec<u8>, number: u64) {
    if number >= 10 {
        push_number(text, number / 10);
    }
    text.push(b'0' + (number % 10) as u8);
}

/// The columns of the matrix: middle of each hour from the beginning of the year.
fn sun_up_hours(year: &Year) -> Vec<u8> {
    let lines: Vec<String> = year.climate.hours.iter().map(|h| format!("{:.1}\n", h.index as f64 + 0.5)).collect();
    lines.concat().into_bytes()
}
