//! A measured room: a growth chamber lit by four lamps in a box above a translucent ceiling, photon flux densities measured
//! at twelve points in two bands (Besnier and others, `photon_mapping`, MIT; the data stay where they are).
//!
//! The power of the lamps is not known, so that one factor for each band is fitted and what is left is judged. A method that
//! loses light between the surfaces shows it all the same: see the runs in which some of them reflect nothing.

mod chamber;

use super::References;
use super::references::{Row, rows_of};
use super::sheet::{Sheet, Table, known};
use crate::Result;
use crate::measure::{Measurement, Method, SolveOptions};
use chamber::{Chamber, Reflecting};

const TOLERANCE: f64 = 0.02;
/// Tolerance of the runs that only tell what the reflections do.
const ROUGH: f64 = 0.05;
/// Most that may be left after the fit, RMS.
const MOST_RMS: f64 = 0.08;
/// Paths of a point where path tracing judges.
const PATHS: u64 = 1 << 18;
/// What Radiance leaves by the same data.
const RADIANCE: &str = "Radiance, 8 bounces, everything Lambertian: 5.7 % in 655-665 nm";
const SOURCE: &str = "measured photon flux densities, growth chamber SEC2 (photon_mapping, MIT)";
/// The stored outcome, which stands in where the data are not at hand.
const STORED: &str = "validation/growth-chamber/results.csv";

/// What is left at a point of a run after the fit.
#[derive(Debug)]
struct Residual {
    reflecting: String,
    band: String,
    /// Of the point, mm.
    place: [f64; 3],
    /// Computed over measured, less one.
    value: f64,
    /// Stated error of the computed value, as a share of it.
    error: f64,
}

pub(super) fn run(references: &References, sheet: &mut Sheet) -> Result<()> {
    let Some(folder) = references.measured() else {
        sheet.skip("its data are not part of the program: give their folder by --data (validation/growth-chamber)");
        let stored = rows_of(references.text(STORED), STORED)?;
        let residuals: Vec<Residual> = stored.iter().map(read).collect::<Result<_>>()?;
        tables(&residuals, sheet);
        return Ok(());
    };
    let chamber = Chamber::read(folder)?;
    let mut residuals = Vec::new();
    for reflecting in Reflecting::ALL {
        let tolerance = if reflecting == Reflecting::Everywhere { TOLERANCE } else { ROUGH };
        let options = SolveOptions { tolerance, spectral: true, ..SolveOptions::default() };
        let m = chamber.build(reflecting).solve_by(&options)?;
        if reflecting == Reflecting::Everywhere {
            against_paths(&chamber, &m, sheet)?;
        }
        residuals.extend(fitted(&chamber, reflecting, &m));
    }
    judge(&residuals, sheet);
    tables(&residuals, sheet);
    sheet.file("growth_chamber.csv", csv_of(&residuals));
    Ok(())
}

/// The same scene by path tracing: what is left of the measured values is not the solver's.
fn against_paths(chamber: &Chamber, m: &Measurement, sheet: &mut Sheet) -> Result<()> {
    let (method, paths) = (Method::PathTracing, Some(PATHS));
    let options = SolveOptions { method, paths, seed: 7, spectral: true, ..SolveOptions::default() };
    let judge = chamber.build(Reflecting::Everywhere).solve_by(&options)?;
    sheet.topic("irradiance at a point of the chamber", "our path tracer, 262,144 paths a point", "a.u.");
    for (k, (lo, hi)) in m.bands.limits_nm().iter().enumerate() {
        for (i, (s, j)) in m.grids[0].sensors.iter().zip(&judge.grids[0].sensors).enumerate() {
            let (found, truth) = (s.spectral[k], j.spectral[k]);
            let truth = known(truth.irradiance, truth.error);
            sheet.estimate(format!("point {i}, {lo}-{hi} nm"), truth, found.irradiance, found.error);
        }
    }
    Ok(())
}

/// Fits one factor for each band: least squares through zero.
fn fitted(chamber: &Chamber, reflecting: Reflecting, m: &Measurement) -> Vec<Residual> {
    let mut residuals = Vec::new();
    for (k, (lo, hi)) in m.bands.limits_nm().iter().enumerate() {
        let found = || m.grids[0].sensors.iter().map(|s| s.spectral[k]);
        let measured = || chamber.points.iter().map(|p| p.photon_flux[k]);
        let (product, square) = found()
            .zip(measured())
            .fold((0.0, 0.0), |(p, s), (f, m)| (p + f.irradiance * m, s + f.irradiance * f.irradiance));
        let scale = product / square;
        for ((f, m), point) in found().zip(measured()).zip(&chamber.points) {
            residuals.push(Residual {
                reflecting: reflecting.name().into(),
                band: format!("{lo}-{hi} nm"),
                place: (1e3 * point.position_m).to_array().map(f64::round),
                value: scale * f.irradiance / m - 1.0,
                error: f.error / f.irradiance,
            });
        }
    }
    residuals
}

/// The residuals of one run in one band.
fn of<'a>(residuals: &'a [Residual], reflecting: Reflecting, band: &str) -> Vec<&'a Residual> {
    residuals.iter().filter(|r| r.reflecting == reflecting.name() && r.band == band).collect()
}

/// The bands, in order.
fn bands(residuals: &[Residual]) -> Vec<&str> {
    let mut bands: Vec<&str> = residuals.iter().map(|r| r.band.as_str()).collect();
    bands.sort_unstable();
    bands.dedup();
    bands
}

fn rms(list: &[&Residual]) -> f64 {
    (list.iter().map(|r| r.value * r.value).sum::<f64>() / list.len().max(1) as f64).sqrt()
}

fn judge(residuals: &[Residual], sheet: &mut Sheet) {
    for band in bands(residuals) {
        sheet.topic("RMS left at twelve points after one factor for the band", SOURCE, "");
        sheet.at_most(band, MOST_RMS, rms(&of(residuals, Reflecting::Everywhere, band)));
        sheet.topic("the same without any reflection: the points must tell that it is missing", SOURCE, "");
        sheet.at_least(band, MOST_RMS, rms(&of(residuals, Reflecting::Nowhere, band)));
    }
}

/// The upper plane over the lower one, computed over measured: no factor enters. Height and places of each pair.
fn plane_ratios(list: &[&Residual]) -> Vec<([f64; 2], f64)> {
    let (low, high) =
        list.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| (l.min(r.place[2]), h.max(r.place[2])));
    let at = |z: f64, x: f64, y: f64| list.iter().find(|r| r.place == [x, y, z]);
    list.iter()
        .filter(|r| r.place[2] == low)
        .filter_map(|r| {
            let above = at(high, r.place[0], r.place[1])?;
            Some(([r.place[0], r.place[1]], (1.0 + above.value) / (1.0 + r.value)))
        })
        .collect()
}

fn tables(residuals: &[Residual], sheet: &mut Sheet) {
    let bands = bands(residuals);
    let percent = |v: f64| format!("{:.1} %", 100.0 * v);
    let heads = |first: &str| std::iter::once(first.to_owned()).chain(bands.iter().map(|b| (*b).to_owned())).collect();
    let mut fits = Table::new(
        format!(
            "Growth chamber: RMS left at twelve measured points after one factor for each band ({RADIANCE}; command and date: \
                 validation/growth-chamber)"
        ),
        heads("surfaces that reflect"),
    );
    for reflecting in Reflecting::ALL {
        let row = bands.iter().map(|b| percent(rms(&of(residuals, reflecting, b))));
        fits.rows.push(std::iter::once(reflecting.name().to_owned()).chain(row).collect());
    }
    let full: Vec<Vec<&Residual>> = bands.iter().map(|b| of(residuals, Reflecting::Everywhere, b)).collect();
    let mut points =
        Table::new("Growth chamber: computed over measured, less one, at each point".into(), heads("x, y, z in mm"));
    for i in 0..full.first().map_or(0, Vec::len) {
        let [x, y, z] = full[0][i].place;
        let row = full.iter().map(|list| format!("{:+.1} %", 100.0 * list[i].value));
        points.rows.push(std::iter::once(format!("{x}, {y}, {z}")).chain(row).collect());
    }
    let mut planes = Table::new(
        "Growth chamber: the upper plane over the lower one, computed over measured; no factor enters".into(),
        heads("x, y in mm"),
    );
    let ratios: Vec<_> = full.iter().map(|list| plane_ratios(list)).collect();
    for i in 0..ratios.first().map_or(0, Vec::len) {
        let [x, y] = ratios[0][i].0;
        let row = ratios.iter().map(|list| format!("{:.3}", list[i].1));
        planes.rows.push(std::iter::once(format!("{x}, {y}")).chain(row).collect());
    }
    for table in [fits, points, planes] {
        sheet.table(table);
    }
}

fn csv_of(residuals: &[Residual]) -> String {
    let mut text = "reflecting,band,x_mm,y_mm,z_mm,residual_percent,error_percent\n".to_owned();
    for r in residuals {
        let [x, y, z] = r.place;
        text += &format!("{},{},{x},{y},{z},{:.3},{:.3}\n", r.reflecting, r.band, 100.0 * r.value, 100.0 * r.error);
    }
    text
}

fn read(row: &Row) -> Result<Residual> {
    Ok(Residual {
        reflecting: row.text("reflecting")?.into(),
        band: row.text("band")?.into(),
        place: [row.number("x_mm")?, row.number("y_mm")?, row.number("z_mm")?],
        value: row.number("residual_percent")? / 100.0,
        error: row.number("error_percent")? / 100.0,
    })
}
