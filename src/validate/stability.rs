//! What breaks other programs.

use glam::{DQuat, DVec3};

use super::References;
use super::form_factors::below_corner;
use super::radiosity::furnace;
use super::scenes::Build;
use super::sheet::{Sheet, exact, known};
use crate::Result;
use crate::measure::{Measurement, SolveOptions};
use crate::scene::Face;

/// Rays are in 32 bits: 1e-5 of the 1000 lx of a furnace, twofold.
const ROUNDING_LX: f64 = 0.02;

pub(super) fn run(_: &References, sheet: &mut Sheet) -> Result<()> {
    furnaces(sheet)?;
    near_lamps(sheet)?;
    leaks(sheet)?;
    splits(sheet)?;
    repeats(sheet)
}

fn all(sheet: &mut Sheet, name: &str, m: &Measurement) {
    for (i, s) in m.grids[0].sensors.iter().enumerate() {
        sheet.sensor(format!("{name}, point {i}"), known(1000.0, ROUNDING_LX), s, 0.0);
    }
}

fn furnaces(sheet: &mut Sheet) -> Result<()> {
    let size = DVec3::new(4.0, 3.0, 2.7);
    sheet.topic("a furnace keeps its 1000 lx at any size and place", "closed form: E = M / (1 - rho)", "lx");
    for (name, scale) in [("a millimetre model", 1e-3), ("a kilometre", 250.0)] {
        all(sheet, name, &furnace(size * scale, DVec3::ZERO, [0.6; 6]).solve(0.05)?);
    }
    for far in [1e3, 1e5] {
        let origin = DVec3::new(far, -far, 0.5 * far);
        all(sheet, &format!("{far} m from the origin"), &furnace(size, origin, [0.6; 6]).solve(0.05)?);
    }
    sheet.topic("a furnace of almost perfect reflectors keeps its 1000 lx", "closed form: E = M / (1 - rho)", "lx");
    for rho in [0.98, 0.99] {
        all(sheet, &format!("reflectance {rho}"), &furnace(size, DVec3::ZERO, [rho; 6]).solve(0.05)?);
    }
    sheet.topic("a room of extreme proportions keeps its 1000 lx", "closed form: E = M / (1 - rho)", "lx");
    for (name, size) in [("a duct", DVec3::new(0.05, 0.05, 5.0)), ("a slit", DVec3::new(4.0, 4.0, 0.01))] {
        all(sheet, name, &furnace(size, DVec3::ZERO, [0.6; 6]).solve(0.05)?);
    }
    sheet.topic("a turned furnace keeps its 1000 lx", "closed form: E = M / (1 - rho)", "lx");
    let mut turned = furnace(size, DVec3::ZERO, [0.6; 6]);
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    for f in &mut turned.0.faces {
        *f = Face::new(&f.vertices.iter().map(|v| turn * *v).collect::<Vec<_>>(), f.material);
    }
    for s in turned.0.grids.iter_mut().flat_map(|g| &mut g.sensors) {
        (s.position, s.normal) = (turn * s.position, turn * s.normal);
    }
    all(sheet, "about a skew axis", &turned.solve(0.05)?);
    Ok(())
}

/// A lamp very near or very far.
fn near_lamps(sheet: &mut Sheet) -> Result<()> {
    sheet.topic(
        "a square lamp of 1 m² is exact at any distance",
        "Howell B-3: four times the factor of a quarter",
        "lx",
    );
    for distance in [1e-3, 1e-2, 0.1, 1.0, 10.0, 300.0] {
        let mut b = Build::new();
        let (black, lamp) = (b.paint(0.0, 0.0), b.paint(0.0, 1000.0));
        b.rectangle(DVec3::new(-0.5, -0.5, distance), DVec3::Y, DVec3::X, lamp);
        b.rectangle(DVec3::new(-0.5, -0.5, -0.5), DVec3::X, DVec3::Y, black);
        b.points("points", &[(DVec3::ZERO, DVec3::Z)]);
        let m = b.solve(0.05)?;
        let truth = 4000.0 * below_corner(0.5 / distance, 0.5 / distance);
        // A sensor is lifted by 1e-5 of the scene at most: at 1 mm from the lamp that changes next to nothing.
        sheet.sensor(format!("{distance} m away"), known(truth, 1e-5 * truth), &m.grids[0].sensors[0], 0.0);
    }
    Ok(())
}

/// Nothing passes a wall of no thickness that rooms share, nor one of a millimetre.
fn leaks(sheet: &mut Sheet) -> Result<()> {
    sheet.topic("no light leaks into a closed dark room", "geometry: nothing is seen", "lx");
    for gap in [0.0, 1e-3] {
        let mut b = Build::new();
        let (wall, lamp) = (b.paint(0.8, 0.0), b.paint(0.0, 1e4));
        b.room(DVec3::ZERO, DVec3::new(3.0, 3.0, 3.0), [wall; 6]);
        b.room(DVec3::new(3.0 + gap, 0.0, 0.0), DVec3::new(6.0 + gap, 3.0, 3.0), [wall; 6]);
        b.rectangle(DVec3::new(1.0, 1.0, 2.9), DVec3::Y, DVec3::X, lamp);
        b.points(
            "points",
            &[
                (DVec3::new(3.02 + gap, 1.5, 0.02), DVec3::Z),
                (DVec3::new(4.5, 1.5, 0.8), DVec3::NEG_X),
                (DVec3::new(3.01 + gap, 0.01, 2.99), DVec3::NEG_X),
            ],
        );
        let m = b.solve(0.05)?;
        for (i, s) in m.grids[0].sensors.iter().enumerate() {
            sheet.sensor(format!("rooms {gap} m apart, point {i}"), exact(0.0), s, 0.0);
        }
    }
    Ok(())
}

/// How a wall is cut into faces does not matter.
fn splits(sheet: &mut Sheet) -> Result<()> {
    sheet.topic("a floor cut into slivers reads as an uncut one", "the same room, solved uncut", "lx");
    let with_floor = |cuts: &[f64]| {
        let mut b = Build::new();
        let (wall, lamp) = (b.paint(0.5, 0.0), b.paint(0.0, 3000.0));
        let size = DVec3::new(4.0, 3.0, 2.7);
        b.room(DVec3::ZERO, size, [wall; 6]);
        b.0.faces.remove(4);
        for w in cuts.windows(2) {
            b.rectangle(DVec3::new(w[0], 0.0, 0.0), DVec3::X * (w[1] - w[0]), DVec3::Y * size.y, wall);
        }
        b.rectangle(DVec3::new(1.5, 1.0, 2.6), DVec3::Y, DVec3::X, lamp);
        b.points("points", &[(DVec3::new(2.0, 1.5, 0.8), DVec3::Z), (DVec3::new(0.3, 0.3, 1.5), DVec3::X)]);
        b.solve(0.02)
    };
    let whole = with_floor(&[0.0, 4.0])?;
    let cut = with_floor(&[0.0, 1e-4, 0.7, 0.7003, 2.0, 3.999, 4.0])?;
    for (i, (s, truth)) in cut.grids[0].sensors.iter().zip(&whole.grids[0].sensors).enumerate() {
        sheet.sensor(format!("point {i}"), known(truth.xyz[1], truth.error_lx), s, 0.0);
    }
    Ok(())
}

/// The same bits for any number of threads, and twice the light for twice the lamp.
fn repeats(sheet: &mut Sheet) -> Result<()> {
    let room = |exitance: f64| {
        let mut b = Build::new();
        let (wall, lamp) = (b.paint(0.7, 0.0), b.paint(0.0, exitance));
        b.room(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.7), [wall; 6]);
        b.rectangle(DVec3::new(1.5, 1.0, 2.6), DVec3::Y, DVec3::X, lamp);
        b.points("points", &[(DVec3::new(2.0, 1.5, 0.8), DVec3::Z), (DVec3::new(0.0, 0.3, 1.5), DVec3::X)]);
        b
    };
    let first = room(3000.0).solve_by(&SolveOptions::default())?;
    sheet.topic("one thread gives the same bits", "a run in all threads", "lx");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.map_err(|e| crate::Error::new(crate::error::ErrorKind::Internal, format!("no thread: {e}")))?;
    let again = pool.install(|| room(3000.0).solve_by(&SolveOptions::default()))?;
    for (i, (a, b)) in first.grids[0].sensors.iter().zip(&again.grids[0].sensors).enumerate() {
        sheet.equal(format!("point {i}"), known(a.xyz[1], 0.0), b.xyz[1], 0.0);
    }
    sheet.topic("twice the lamp gives twice the light", "linearity", "lx");
    let twice = room(6000.0).solve_by(&SolveOptions::default())?;
    for (i, (a, b)) in first.grids[0].sensors.iter().zip(&twice.grids[0].sensors).enumerate() {
        // Factors and rays are the same: rounding alone differs.
        sheet.equal(format!("point {i}"), known(2.0 * a.xyz[1], 0.0), b.xyz[1], 1e-6 * b.xyz[1]);
    }
    Ok(())
}
