//! Where the light goes: the balance of a run, and flux that must arrive.

use std::f64::consts::PI;

use glam::DVec3;

use super::References;
use super::scenes::{Build, axial};
use super::sheet::{Sheet, exact, known};
use crate::Result;
use crate::measure::{Measurement, SolveOptions};

pub(super) fn run(_: &References, sheet: &mut Sheet) -> Result<()> {
    balances(sheet)?;
    absorbed(sheet)?;
    received(sheet)
}

fn corner() -> DVec3 {
    DVec3::new(5.0, 4.0, 3.0)
}

/// A room with a lamp of 1 m² below its ceiling.
fn room(rho: f64, closed: bool) -> Build {
    let mut b = Build::new();
    let (wall, lamp) = (b.paint(rho, 0.0), b.paint(0.0, 3000.0));
    b.room(DVec3::ZERO, corner(), [wall; 6]);
    if !closed {
        b.0.faces.pop();
    }
    b.rectangle(DVec3::new(2.0, 1.5, 2.9), DVec3::Y, DVec3::X, lamp);
    b.points("points", &[(DVec3::new(2.5, 2.0, 0.8), DVec3::Z), (DVec3::new(1.0, 1.0, 0.8), DVec3::Z)]);
    b
}

fn furnished() -> Build {
    let mut b = room(0.6, true);
    let box_paint = b.paint(0.3, 0.0);
    b.block(DVec3::new(0.5, 0.5, 0.0), DVec3::new(1.5, 1.3, 0.9), box_paint);
    b.block(DVec3::new(3.2, 2.4, 0.0), DVec3::new(4.5, 3.6, 1.8), box_paint);
    b
}

fn parted() -> Build {
    let mut b = room(0.6, true);
    let pane = b.pane(0.85);
    b.rectangle(DVec3::new(3.5, 0.0, 0.0), DVec3::Y * 4.0, DVec3::Z * 3.0, pane);
    b
}

/// A balance closes within this share of the flux, or its stated sampling error, which holds in so many of the runs.
const CLOSES: f64 = 1e-3;
const STATED: f64 = 0.99;
/// Seeds of every room.
const SEEDS: u64 = 16;

/// The ledger of a run is by rays: over seeds its mean must close, and each balance within what it states for itself.
fn balances(sheet: &mut Sheet) -> Result<()> {
    let mut rooms: Vec<(String, Build)> =
        [0.1, 0.5, 0.8, 0.95].map(|rho| (format!("closed room, reflectance {rho}"), room(rho, true))).into();
    rooms.push(("room without a ceiling".into(), room(0.5, false)));
    rooms.push(("furnished room".into(), furnished()));
    rooms.push(("room parted by a pane".into(), parted()));
    let (mut closed, mut all) = (0, 0);
    for (name, b) in rooms {
        let (mut mean, mut stated) = (0.0, 0.0);
        let seeds = SEEDS as f64;
        for seed in 1..=SEEDS {
            let m = b.solve_by(&SolveOptions { seed, ..SolveOptions::default() })?;
            let l = &m.ledger;
            let share = (l.absorbed[0] + l.escaped[0] + l.unexpanded[0]) / l.emitted[0];
            let within = l.sampling_error[0] / l.emitted[0];
            closed += usize::from((share - 1.0).abs() <= within.max(CLOSES));
            all += 1;
            (mean, stated) = (mean + share / seeds, stated + within / seeds);
        }
        // The noise of a mean of independent runs is that of one over the root of their number; the rest is bias.
        sheet.topic(
            "absorbed, escaped and unexpanded over emitted flux, mean of 16 seeds",
            "conservation of energy",
            "",
        );
        sheet.equal(name, exact(1.0), mean, stated / seeds.sqrt() + CLOSES);
    }
    sheet.topic("balances that close within 0.1 % or their stated sampling error", "conservation of energy", "");
    sheet.in_share("seven rooms, 16 seeds", STATED, closed, all);
    Ok(())
}

/// In a closed room everything that is emitted is absorbed, in watts, by rays as by the lamp's own figure.
fn absorbed(sheet: &mut Sheet) -> Result<()> {
    sheet.topic("emitted flux is exitance times area", "definition", "lm");
    for exitance in [500.0, 3000.0] {
        let mut b = Build::new();
        let (wall, lamp) = (b.paint(0.5, 0.0), b.paint(0.0, exitance));
        b.room(DVec3::ZERO, corner(), [wall; 6]);
        b.rectangle(DVec3::new(1.0, 1.0, 2.9), DVec3::Y * 0.5, DVec3::X * 1.5, lamp);
        b.points("points", &[(DVec3::new(2.5, 2.0, 0.8), DVec3::Z)]);
        let m = b.solve(0.05)?;
        let value = m.bands.xyz(&m.ledger.emitted)[1];
        sheet.equal(format!("{exitance} lm/m² on 0.75 m²"), exact(0.75 * exitance), value, 1e-6 * value);
    }
    Ok(())
}

/// Mean over the faces of a box, by Gauss's rule.
fn mean(m: &Measurement, places: &[(usize, DVec3, DVec3, f64)], of: impl Fn(usize) -> f64) -> f64 {
    let area: f64 = places.iter().map(|p| p.3).sum();
    (0..m.grids[0].sensors.len()).map(|i| of(i) * places[i].3).sum::<f64>() / area
}

/// Sumpner 1892: the mean illuminance of a closed room is its flux over (1 - rho) times its surface, wherever the lamp is.
fn received(sheet: &mut Sheet) -> Result<()> {
    sheet.topic("mean illuminance of all surfaces of a closed room", "Sumpner 1892: E = F / (S (1 - rho))", "lx");
    let size = corner();
    for (rho, place) in [(0.0, [2.5, 2.0, 1.5]), (0.4, [1.5, 1.0, 2.0]), (0.8, [4.0, 2.0, 1.0])] {
        let mut b = Build::new();
        let wall = b.paint(rho, 0.0);
        b.room(DVec3::ZERO, size, [wall; 6]);
        let places = Build::on_faces(size);
        b.points("points", &places.iter().map(|(_, p, n, _)| (*p, *n)).collect::<Vec<_>>());
        b.hang(axial("0 0 0", &[0.0, 180.0], |_| 3000.0 / (4.0 * PI)), DVec3::from(place));
        let m = b.solve(0.02)?;
        let sensors = &m.grids[0].sensors;
        let (value, error) = (mean(&m, &places, |i| sensors[i].xyz[1]), mean(&m, &places, |i| sensors[i].error_lx));
        let truth = 3000.0 / (94.0 * (1.0 - rho));
        // Eight points a side integrate what a source 1 m away gives to 1e-3.
        sheet.equal(format!("reflectance {rho}, lamp at {place:?} m"), known(truth, 1e-3 * truth), value, error);
    }
    Ok(())
}
