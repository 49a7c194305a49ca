//! Skies and the sun.

use glam::DVec3;

use super::References;
use super::scenes::Build;
use super::sheet::{Sheet, exact, known};
use crate::light::Daylight;
use crate::light::sky::{Sky, SkyModel, cie_coefficients};
use crate::light::sun::{Air, Moment, Place, SunPosition};
use crate::spectrum::Bands;
use crate::transport::{DirectScratch, LightPart, Optics, World, direct};
use crate::{Error, Result};
use std::f64::consts::PI;

/// Relative error that we claim for light of the sky on a point in the open: quadrature stops where a finer rule changes
/// nothing beyond 2e-3 and takes the finer value.
const QUADRATURE: f64 = 1e-4;
/// Digits of the stored integrals.
const STORED: f64 = 1e-7;
/// Error that we claim for the place of the sun, degrees.
const SUN_DEG: f64 = 0.01;

pub(super) fn run(references: &References, sheet: &mut Sheet) -> Result<()> {
    closed_forms(sheet)?;
    skies(references, sheet)?;
    sun(references, sheet)
}

/// Illuminance at points in the open under a sky of 10,000 lx.
fn open_field(number: u8, sun_deg: (f64, f64), normals: &[DVec3]) -> Result<Vec<f64>> {
    let mut b = Build::new();
    let black = b.paint(0.0, 0.0);
    // A scene must hold something: a plate far below.
    b.rectangle(DVec3::new(-0.05, -0.05, -5.0), DVec3::X * 0.1, DVec3::Y * 0.1, black);
    b.sky(number, sun_deg, 0.0);
    let world = World::with_daylight(&b.0, Daylight::new(&b.0)?);
    let (bands, _) = Bands::plan(&b.0.bands, &[], &[], 0.01)?;
    let optics = Optics::new(&b.0, &world, bands);
    let mut scratch = DirectScratch::for_tolerance(0.01);
    let read = |n: &DVec3| {
        let mut factors = vec![0.0; world.groups()];
        let x = world.lift(world.surfaces.frame.to_local(DVec3::ZERO), *n);
        direct(&world, x, *n, 1, &mut scratch, &mut factors);
        optics.lux_of_direct(&factors, &[1.0], LightPart::Sky)
    };
    Ok(normals.iter().map(read).collect())
}

fn closed_forms(sheet: &mut Sheet) -> Result<()> {
    let sides = [DVec3::Z, DVec3::Y, DVec3::new(0.0, 1.0, 1.0).normalize()];
    sheet.topic("illuminance under an even sky", "closed form: (1 + cos tilt) / 2", "lx");
    for (value, (name, share)) in open_field(5, (60.0, 180.0), &sides)?.into_iter().zip([
        ("horizontal", 1.0),
        ("vertical", 0.5),
        ("tilted by 45°", 0.5 + 0.5 * 0.5f64.sqrt()),
    ]) {
        sheet.equal(name, exact(1e4 * share), value, QUADRATURE * value);
    }
    sheet.topic(
        "illuminance under CIE's older overcast sky",
        "closed form of (1 + 2 sin γ) / 3 (Moon and Spencer 1942)",
        "lx",
    );
    for (value, (name, share)) in open_field(16, (60.0, 180.0), &sides[..2])?
        .into_iter()
        .zip([("horizontal", 1.0), ("vertical", (PI / 2.0 + 4.0 / 3.0) / (7.0 * PI / 3.0))])
    {
        sheet.equal(name, exact(1e4 * share), value, QUADRATURE * value);
    }
    Ok(())
}

fn toward(altitude_deg: f64, azimuth_deg: f64) -> DVec3 {
    SunPosition { altitude_deg, azimuth_deg }.direction(0.0)
}

fn skies(references: &References, sheet: &mut Sheet) -> Result<()> {
    let source = "quadrature of ISO 15469:2004 by another program";
    let sides = [("north", DVec3::Y), ("east", DVec3::X), ("south", DVec3::NEG_Y), ("west", DVec3::NEG_X)];
    for row in references.rows("skies.csv")? {
        let sun_deg = (row.number("sun_altitude_deg")?, row.number("sun_azimuth_deg")?);
        let number = row.number("sky")? as u8;
        let model = if number == 16 {
            SkyModel::Overcast
        } else {
            let unknown = || Error::malformed(format!("no CIE sky {number}")).in_file("skies.csv");
            SkyModel::Cie(cie_coefficients(number).ok_or_else(unknown)?)
        };
        let name = format!("sky {number}, sun at {}°, {}°", sun_deg.0, sun_deg.1);
        let reference = row.number("horizontal_over_zenith")?;
        sheet.topic("horizontal illuminance over zenith luminance", source, "sr");
        let value = Sky::new(model, toward(sun_deg.0, sun_deg.1)).horizontal_over_zenith();
        sheet.equal(name.as_str(), known(reference, 1e-8 * reference), value, STORED * value);
        sheet.topic("vertical over horizontal illuminance", source, "");
        let found = open_field(number, sun_deg, &sides.map(|s| s.1))?;
        for (value, (side, _)) in found.into_iter().zip(sides) {
            let reference = row.number(side)?;
            let value = value / 1e4;
            sheet.equal(format!("{name}, {side}"), known(reference, STORED * reference), value, QUADRATURE * value);
        }
    }
    Ok(())
}

fn sun(references: &References, sheet: &mut Sheet) -> Result<()> {
    sheet.topic(
        "angle between the sun and its reference place",
        "NREL solar position algorithm, by another program",
        "°",
    );
    for row in references.rows("sun.csv")? {
        let utc = row.text("utc")?;
        let place = Place { latitude_deg: row.number("latitude_deg")?, longitude_deg: row.number("longitude_deg")? };
        let air = Air { pressure_hpa: row.number("pressure_hPa")?, temperature_c: row.number("temperature_C")? };
        let unread = || Error::malformed(format!("{utc:?} is no time")).in_file("sun.csv");
        let moment = moment(utc).ok_or_else(unread)?;
        let found = SunPosition::at(&moment, place, air)?;
        let wanted = toward(row.number("apparent_altitude_deg")?, row.number("azimuth_deg")?);
        let off_deg = found.direction(0.0).angle_between(wanted).to_degrees();
        sheet.equal(format!("{} {utc}", row.text("place")?), known(0.0, 1e-6), off_deg, SUN_DEG);
    }
    Ok(())
}

/// Of `2003-04-25T12:26:56Z`.
fn moment(utc: &str) -> Option<Moment> {
    let part = |range: std::ops::Range<usize>| utc.get(range)?.parse::<f64>().ok();
    let seconds: f64 = utc.get(17..)?.trim_end_matches('Z').parse().ok()?;
    Some(Moment {
        year: part(0..4)? as i32,
        month: part(5..7)? as u32,
        day: part(8..10)? as u32,
        hours: part(11..13)? + part(14..16)? / 60.0 + seconds / 3600.0,
    })
}
