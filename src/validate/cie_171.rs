//! The analytic cases of CIE 171:2006 (sections 5.2 to 5.14), with the exact values in place of those that the report
//! prints with errors.

use std::f64::consts::PI;

use glam::DVec3;

use super::References;
use super::published;
use super::references::Row;
use super::scenes::{Build, axial, half_degrees};
use super::sheet::{Sheet, exact, known};
use crate::light::Daylight;
use crate::spectrum::Bands;
use crate::transport::{DirectScratch, GlazingUnit, LightPart, Optics, World, direct};
use crate::{Error, Result};

/// Tolerance at which electric cases are solved.
const TOLERANCE: f64 = 0.01;
/// Ten digits are stored.
const DIGITS: f64 = 1e-9;
/// A table in half degrees is off by 1e-5, a sensor 4e-6 of the scene above its plane by 4e-5 at 2.4 m.
const PLACED: f64 = 1e-4;
/// Two rules for the sky may differ by this share at a tolerance of 1 % before a triangle of it is divided.
const RULES: f64 = 1e-3;
/// Skies whose references are good to 1e-5.
const COARSER: [u8; 7] = [2, 4, 6, 8, 10, 13, 14];
/// A disc of 48 corners is off by 2e-3 of its radius: 3e-3 of the light 5 cm from its edge, and 1e-3 more.
const CORNERS: f64 = 4e-3;

pub(super) fn run(references: &References, sheet: &mut Sheet) -> Result<()> {
    let rows = references.rows("cie171_electric.csv")?;
    sources(&rows, sheet)?;
    flux_shares(&rows, sheet)?;
    glass(&rows, sheet)?;
    reflectors(&rows, sheet)?;
    interreflection(sheet)?;
    daylight(references, sheet)?;
    published::tables(references, sheet)
}

fn of<'a>(rows: &'a [Row], test: &str) -> Vec<&'a Row> {
    rows.iter().filter(|r| r.text("test").is_ok_and(|t| t == test)).collect()
}

/// 5.2 and 5.3: point, area and disc sources.
fn sources(rows: &[Row], sheet: &mut Sheet) -> Result<()> {
    let cosine = |v: f64| v.to_radians().cos().max(0.0);
    let sources: [(&str, &str, Vec<u8>, DVec3, f64); 5] = [
        ("5.2a", "E = I cos θ / d²", axial("0 0 0", &half_degrees(), |v| 1000.0 * cosine(v)), DVec3::Z * 3.0, PLACED),
        (
            "5.2-isotropic",
            "E = I cos θ / d²",
            axial("0 0 0", &[0.0, 180.0], |_| 1e4 / (4.0 * PI)),
            DVec3::Z * 3.0,
            PLACED,
        ),
        (
            "5.2-table",
            "E = I cos θ / d², candelas linear in the angle",
            axial("0 0 0", &[0.0, 30.0, 60.0, 90.0], |v| [1000.0, 800.0, 250.0, 0.0][(v / 30.0) as usize]),
            DVec3::Z * 2.4,
            PLACED,
        ),
        (
            "5.3",
            "E = π L C",
            axial("1 1 0", &half_degrees(), |v| 1000.0 * cosine(v)),
            DVec3::new(2.0, 2.0, 3.0),
            PLACED,
        ),
        (
            "5.3-disc",
            "E = π L C",
            axial("-0.5 -0.5 0", &half_degrees(), |v| 5000.0 * PI * 0.0625 * cosine(v)),
            DVec3::Z * 2.5,
            CORNERS,
        ),
    ];
    for (test, formula, file, place, off) in sources {
        let mut b = Build::new();
        let black = b.paint(0.0, 0.0);
        if test == "5.3" {
            b.room(DVec3::ZERO, DVec3::new(4.0, 4.0, 3.0), [black; 6]);
        } else {
            b.rectangle(DVec3::new(-4.0, -4.0, 0.0), DVec3::X * 8.0, DVec3::Y * 8.0, black);
        }
        let rows = of(rows, test);
        let points = rows.iter().map(|r| Ok((r.point("point_m")?, r.point("normal")?))).collect::<Result<Vec<_>>>()?;
        b.points("points", &points);
        b.hang(file, place);
        let m = b.solve(TOLERANCE)?;
        sheet.topic("illuminance of a source", &format!("CIE 171:2006, {test}: {formula}"), "lx");
        for (row, s) in rows.iter().zip(&m.grids[0].sensors) {
            let reference = row.number("value")?;
            let name = format!("{test} point {}", row.text("point")?);
            sheet.sensor(name, known(reference, DIGITS * reference), s, off);
        }
    }
    Ok(())
}

/// 5.4: the flux of an isotropic source on each surface of a black room.
fn flux_shares(rows: &[Row], sheet: &mut Sheet) -> Result<()> {
    let size = DVec3::new(4.0, 4.0, 3.0);
    let mut b = Build::new();
    let black = b.paint(0.0, 0.0);
    b.room(DVec3::ZERO, size, [black; 6]);
    let places = Build::on_faces(size);
    b.points("points", &places.iter().map(|(_, p, n, _)| (*p, *n)).collect::<Vec<_>>());
    b.hang(axial("0 0 0", &[0.0, 180.0], |_| 1e4 / (4.0 * PI)), DVec3::new(2.0, 2.0, 1.5));
    let m = b.solve(TOLERANCE)?;
    let mut shares = [0.0; 6];
    for (s, (face, _, _, area)) in m.grids[0].sensors.iter().zip(&places) {
        shares[*face] += s.xyz[1] * area / 1e4;
    }
    sheet.topic("share of the flux on a surface of a black room", "CIE 171:2006, 5.4: solid angle", "");
    for (row, share) in of(rows, "5.4").into_iter().zip(shares) {
        let reference = row.number("value")?;
        // Eight points a side integrate the flux to 1e-3.
        sheet.equal(format!("5.4 {}", row.text("point")?), known(reference, 1e-3 * reference), share, PLACED * share);
    }
    sheet.equal("5.4 sum", known(1.0, 1e-3), shares.iter().sum(), PLACED);
    Ok(())
}

/// 5.5: transmittance of a clear pane by angle.
fn glass(rows: &[Row], sheet: &mut Sheet) -> Result<()> {
    sheet.topic("transmittance of a clear pane", "CIE 171:2006, 5.5: Fresnel, both polarisations, n = 1.52", "");
    for test in ["5.5-slab-lossless", "5.5-slab-6mm"] {
        let rows = of(rows, test);
        let Some(normal) = rows.first() else { continue };
        let unit = GlazingUnit::alike(1, normal.number("value")?, 1.52);
        for row in rows {
            let (angle_deg, reference) = (row.number("point")?, row.number("value")?);
            let value = unit.shares(angle_deg.to_radians().cos()).passed;
            sheet.equal(format!("{test} at {angle_deg}°"), known(reference, 1e-9), value, 1e-9);
        }
    }
    Ok(())
}

/// 5.6 and 5.7: light from an even reflector, in the open and behind an obstruction.
fn reflectors(rows: &[Row], sheet: &mut Sheet) -> Result<()> {
    for (test, half) in [("5.6-4x4", 2.0), ("5.6-0.5x0.5", 0.25), ("5.7", 0.0)] {
        let mut b = Build::new();
        let (black, bright) = (b.paint(0.0, 0.0), b.paint(0.0, 100.0));
        if test == "5.7" {
            b.rectangle(DVec3::new(0.0, 4.0, 0.0), DVec3::X * 4.0, DVec3::Z * 3.0, bright);
            b.block(DVec3::new(0.0, 2.5, 0.0), DVec3::new(4.0, 2.7, 1.0), black);
        } else {
            let corner = DVec3::new(2.0 - half, 2.0 - half, 0.0);
            b.rectangle(corner, DVec3::X * 2.0 * half, DVec3::Y * 2.0 * half, bright);
        }
        let rows = of(rows, test);
        let points = rows.iter().map(|r| Ok((r.point("point_m")?, r.point("normal")?))).collect::<Result<Vec<_>>>()?;
        b.points("points", &points);
        let m = b.solve(TOLERANCE)?;
        sheet.topic("illuminance in percent of a reflector's exitance", &format!("CIE 171:2006, {test}: 100 C"), "%");
        for (row, s) in rows.iter().zip(&m.grids[0].sensors) {
            let reference = row.number("value")?;
            let name = format!("{test} point {}", row.text("point")?);
            sheet.sensor(name, known(reference, 1e-7 + DIGITS * reference), s, PLACED);
        }
    }
    Ok(())
}

/// 5.8: an isotropic source of 10,000 lm in the middle of a cube of 4 m.
fn interreflection(sheet: &mut Sheet) -> Result<()> {
    sheet.topic("mean illuminance of all surfaces of a cube", "CIE 171:2006, 5.8: F / (S (1 - rho))", "lx");
    let size = DVec3::splat(4.0);
    let places = Build::on_faces(size);
    for rho in [0.0, 0.1, 0.3, 0.5, 0.7, 0.9] {
        let mut b = Build::new();
        let wall = b.paint(rho, 0.0);
        b.room(DVec3::ZERO, size, [wall; 6]);
        b.points("points", &places.iter().map(|(_, p, n, _)| (*p, *n)).collect::<Vec<_>>());
        b.hang(axial("0 0 0", &[0.0, 180.0], |_| 1e4 / (4.0 * PI)), size * 0.5);
        let m = b.solve(TOLERANCE)?;
        let mean = |of: &dyn Fn(usize) -> f64| places.iter().enumerate().map(|(i, p)| of(i) * p.3).sum::<f64>() / 96.0;
        let sensors = &m.grids[0].sensors;
        let (value, error) = (mean(&|i| sensors[i].xyz[1]), mean(&|i| sensors[i].error_lx));
        let truth = exact(1e4 / (96.0 * (1.0 - rho)));
        sheet.equal(format!("5.8 reflectance {rho}"), truth, value, error + 1e-3 * value);
    }
    Ok(())
}

/// 5.9 to 5.14: openings, panes and masks.
fn daylight(references: &References, sheet: &mut Sheet) -> Result<()> {
    let rows = references.rows("cie171_daylight.csv")?;
    let key = |r: &Row| -> Option<(String, String, String)> {
        Some((r.text("test").ok()?.into(), r.text("configuration").ok()?.into(), r.text("sky").ok()?.into()))
    };
    for group in rows.chunk_by(|a, b| key(a) == key(b)) {
        one_opening(group, sheet)?;
    }
    Ok(())
}

/// Rows of one room under one sky: direct light alone, for the rooms are black.
fn one_opening(rows: &[Row], sheet: &mut Sheet) -> Result<()> {
    let Some(first) = rows.first() else { return Ok(()) };
    let (test, configuration) = (first.text("test")?, first.text("configuration")?);
    let number = first.number("sky")? as u8;
    let mut b = black_room(test, configuration)?;
    let has_ground = rows.iter().any(|r| r.number("ground_percent").is_ok_and(|g| g > 0.0));
    b.sky(number, (60.0, 180.0), if has_ground { 0.3 } else { 0.0 });
    let world = World::with_daylight(&b.0, Daylight::new(&b.0)?);
    let (bands, _) = Bands::plan(&b.0.bands, &[], &[], TOLERANCE)?;
    let optics = Optics::new(&b.0, &world, bands);
    let mut scratch = DirectScratch::for_tolerance(TOLERANCE);
    for row in rows {
        let (point, normal) = (row.point("point_m")?, row.point("normal")?);
        let x = world.lift(world.surfaces.frame.to_local(point), normal);
        // Lifted once more: what the sensor's place above its plane does.
        let [factors, higher] = [x, world.lift(x, normal)].map(|x| {
            let mut factors = vec![0.0; world.groups()];
            direct(&world, x, normal, 1, &mut scratch, &mut factors);
            factors
        });
        for (field, part) in [("sky", LightPart::Sky), ("ground", LightPart::Ground), ("mask", LightPart::Lamps)] {
            let reference = row.number(&format!("{field}_percent"))?;
            if field != "sky" && reference == 0.0 {
                continue;
            }
            sheet.topic(
                &format!("{field} component in percent of the horizontal illuminance outside"),
                &format!("CIE 171:2006, {test}: quadrature by another program"),
                "%",
            );
            // 10,000 lx outside: a lux is 0.01 percent.
            let [value, higher] = [&factors, &higher].map(|f| optics.lux_of_direct(f, &[1.0], part) / 100.0);
            let name = format!("{test} {configuration}, sky {number}, {}, {field}", row.text("point")?);
            let digits = if COARSER.contains(&number) { 1e-5 } else { 1e-7 };
            let reference = known(reference, 1e-6 + digits * reference);
            sheet.equal(name, reference, value, RULES * value + 2.0 * (higher - value).abs());
        }
    }
    Ok(())
}

/// A black room of 4 × 4 × 3 m with an opening in the roof or in the south, glazed or not, and a mask before it.
fn black_room(test: &str, configuration: &str) -> Result<Build> {
    let mut b = Build::new();
    let black = b.paint(0.0, 0.0);
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    b.rectangle(DVec3::ZERO, 4.0 * x, 4.0 * y, black);
    b.rectangle(DVec3::ZERO, 4.0 * y, 3.0 * z, black);
    b.rectangle(4.0 * x, 3.0 * z, 4.0 * y, black);
    b.rectangle(4.0 * y, 4.0 * x, 3.0 * z, black);
    let in_roof = matches!(test, "5.9" | "5.10");
    // The side with the opening: corner, sides, and from where to where it is open.
    let (corner, u, v, size, from, to) = match configuration {
        "roof 1x1" => (3.0 * z, x, y, (4.0, 4.0), (1.5, 1.5), (2.5, 2.5)),
        "roof 4x4" => (3.0 * z, x, y, (4.0, 4.0), (0.0, 0.0), (4.0, 4.0)),
        "facade 4x3" => (DVec3::ZERO, x, z, (4.0, 3.0), (0.0, 0.0), (4.0, 3.0)),
        _ => (DVec3::ZERO, x, z, (4.0, 3.0), (1.0, 1.0), (3.0, 2.0)),
    };
    let frame = [
        ((0.0, 0.0), (size.0, from.1)),
        ((0.0, to.1), (size.0, size.1)),
        ((0.0, from.1), (from.0, to.1)),
        ((to.0, from.1), (size.0, to.1)),
    ];
    for (low, high) in frame.into_iter().filter(|(l, h)| h.0 - l.0 > 1e-9 && h.1 - l.1 > 1e-9) {
        b.rectangle(corner + u * low.0 + v * low.1, u * (high.0 - low.0), v * (high.1 - low.1), black);
    }
    if matches!(test, "5.10" | "5.12") {
        // n = 1.52 and K d = 0.0424: 0.8801 at normal incidence.
        let (r, a) = ((0.52f64 / 2.52).powi(2), (-0.0424f64).exp());
        let pane = b.pane((1.0 - r).powi(2) * a / (1.0 - r * r * a * a));
        b.rectangle(corner + u * from.0 + v * from.1, u * (to.0 - from.0), v * (to.1 - from.1), pane);
    }
    if in_roof {
        b.rectangle(DVec3::ZERO, 4.0 * x, 3.0 * z, black);
    } else {
        b.rectangle(3.0 * z, 4.0 * x, 4.0 * y, black);
    }
    mask(&mut b, configuration)?;
    Ok(b)
}

/// An overhang of some depth or a wall of some height before the opening, which glows with a share of the horizontal
/// illuminance. Endless along x: a point 0.25 m behind the opening sees 1 m aside for every 0.25 m, 25 m at a wall 6 m
/// away and 9 m at the edge of an overhang. Longer masks would lift the sensors more, which is by the scene's size.
fn mask(b: &mut Build, configuration: &str) -> Result<()> {
    let numbers: Vec<f64> = configuration.split_whitespace().filter_map(|w| w.parse().ok()).collect();
    let is_wall = configuration.starts_with("wall ");
    if !is_wall && !configuration.starts_with("overhang ") {
        return Ok(());
    }
    let (Some(&extent), Some(&share)) = (numbers.first(), numbers.last()) else {
        return Err(Error::malformed(format!("no mask in {configuration:?}")).in_file("cie171_daylight.csv"));
    };
    let glowing = b.paint(0.0, share * 1e4);
    if is_wall {
        b.rectangle(DVec3::new(32.0, -6.0, 0.0), DVec3::NEG_X * 60.0, DVec3::Z * extent, glowing);
    } else {
        b.rectangle(DVec3::new(-8.0, -extent, 3.0), DVec3::Y * extent, DVec3::X * 20.0, glowing);
    }
    Ok(())
}
