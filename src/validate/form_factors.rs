//! Form factors: closed forms of Howell's catalogue, stored values for what has none.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::References;
use super::scenes::Build;
use super::sheet::{Sheet, exact, known};
use crate::Result;
use crate::light::{above_plane, configuration_factor};
use crate::mesh::PatchMesh;
use crate::scene::Face;
use crate::transport::World;
use crate::transport::form_factor::{Analytic, Work, exchange_area};

/// Relative error that we claim for pairs of polygons that nothing stands between.
const OPEN: f64 = 1e-6;
/// The same for pairs with something between them: the visible part is found by subdivision.
const BLOCKED: f64 = 2e-3;
/// Error of the factor of a polygon at a point, which is exact.
const AT_POINT: f64 = 1e-11;
/// Share of the area that a round body of fine facets is off by.
const ROUND: f64 = 1e-3;

const HOWELL: &str = "Howell, A Catalog of Radiation Heat Transfer Configuration Factors";

pub(super) fn run(references: &References, sheet: &mut Sheet) -> Result<()> {
    rectangles(sheet);
    points(sheet);
    round_bodies(sheet);
    stored(references, sheet)
}

/// `F_12` of polygons that nothing stands between.
fn between(a: &[DVec3], b: &[DVec3]) -> f64 {
    let (first, second) = (Face::new(a, 0), Face::new(b, 0));
    exchange_area(a, first.normal, b, second.normal) / first.area_m2
}

/// Factor of a polygon at a point.
fn at_point(x: DVec3, n: DVec3, polygon: &[DVec3]) -> f64 {
    let seen: Vec<DVec3> = polygon.iter().map(|v| *v - x).collect();
    let mut above = Vec::new();
    above_plane(&seen, n, 0.0, &mut above);
    configuration_factor(&above, n)
}

/// C-11: equal rectangles opposite each other, sides over distance.
pub(super) fn opposite(x: f64, y: f64) -> f64 {
    let (x2, y2) = (1.0 + x * x, 1.0 + y * y);
    let logarithm = 0.5 * (x2 * y2 / (x2 + y2 - 1.0)).ln();
    let along = |a: f64, b2: f64| a * b2.sqrt() * (a / b2.sqrt()).atan();
    2.0 / (PI * x * y) * (logarithm + along(x, y2) + along(y, x2) - x * x.atan() - y * y.atan())
}

/// C-14: rectangles with a common edge at a right angle; `w` and `h` are their other sides over the edge, the factor is
/// from the one of `w`.
fn adjacent(w: f64, h: f64) -> f64 {
    let (w2, h2) = (w * w, h * h);
    let s = w2 + h2;
    let logarithm = ((1.0 + w2) * (1.0 + h2) / (1.0 + s)).ln()
        + w2 * (w2 * (1.0 + s) / ((1.0 + w2) * s)).ln()
        + h2 * (h2 * (1.0 + s) / ((1.0 + h2) * s)).ln();
    (w * (1.0 / w).atan() + h * (1.0 / h).atan() - s.sqrt() * (1.0 / s.sqrt()).atan() + 0.25 * logarithm) / (PI * w)
}

fn rectangles(sheet: &mut Sheet) {
    let plate =
        |x: f64, y: f64, z: f64| [(0.0, 0.0), (x, 0.0), (x, y), (0.0, y)].map(|(a, b)| DVec3::new(a, b, z)).to_vec();
    sheet.topic("equal rectangles opposite each other", &format!("{HOWELL}, C-11"), "");
    let sides = [0.1, 0.5, 1.0, 3.0, 20.0];
    for (i, &x) in sides.iter().enumerate() {
        for &y in &sides[i..] {
            let value = between(&plate(x, y, 0.0), &flipped(plate(x, y, 1.0)));
            // The closed form takes differences of terms of its sides' size.
            let digits = 1e-14 * (x * y).max(1.0) / (x * y);
            sheet.equal(format!("{x} × {y} over a distance of 1"), known(opposite(x, y), digits), value, OPEN * value);
        }
    }
    sheet.topic("rectangles at a right angle with a common edge", &format!("{HOWELL}, C-14"), "");
    for &w in &sides {
        for &h in &sides {
            let floor = plate(1.0, w, 0.0);
            let wall = [(0.0, 0.0), (0.0, h), (1.0, h), (1.0, 0.0)].map(|(a, b)| DVec3::new(a, 0.0, b)).to_vec();
            let value = between(&floor, &wall);
            let digits = 1e-14 * (1.0 + w * w + h * h) / w;
            sheet.equal(format!("{w} wide, {h} high, edge 1"), known(adjacent(w, h), digits), value, OPEN * value);
        }
    }
}

fn flipped(mut p: Vec<DVec3>) -> Vec<DVec3> {
    p.reverse();
    p
}

/// Factor of a rectangle at a point below its corner and parallel to it; sides over distance.
pub(super) fn below_corner(a: f64, b: f64) -> f64 {
    let part = |u: f64, v: f64| u / (1.0 + u * u).sqrt() * (v / (1.0 + u * u).sqrt()).atan();
    (part(a, b) + part(b, a)) / TAU
}

fn points(sheet: &mut Sheet) {
    sheet.topic("a point below the corner of a rectangle, parallel to it", &format!("{HOWELL}, B-3"), "");
    for a in [0.1, 1.0, 5.0] {
        for b in [0.2, 1.0, 30.0] {
            let polygon = [(0.0, 0.0), (0.0, b), (a, b), (a, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
            let value = at_point(DVec3::ZERO, DVec3::Z, &polygon);
            sheet.equal(format!("{a} × {b} at a distance of 1"), exact(below_corner(a, b)), value, AT_POINT);
        }
    }
    sheet.topic("a point before a corner of a rectangle at a right angle", &format!("{HOWELL}, B-4"), "");
    for height in [0.2, 1.0, 10.0] {
        for width in [0.5, 2.0] {
            // The rectangle stands at y = 1 on the plane of the point, its lower corner straight ahead.
            let polygon =
                [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)].map(|(x, z)| DVec3::new(x, 1.0, z));
            let root = (1.0 + height * height).sqrt();
            let closed = ((width).atan() - (width / root).atan() / root) / TAU;
            let value = at_point(DVec3::ZERO, DVec3::Z, &polygon);
            sheet.equal(format!("{width} wide, {height} high, 1 away"), exact(closed), value, AT_POINT);
        }
    }
}

/// A regular polygon of `n` corners with the area of the disc, looking along +z.
fn disc(radius: f64, z: f64, n: usize) -> Vec<DVec3> {
    let corner = TAU / n as f64;
    let r = radius * (corner / corner.sin()).sqrt();
    (0..n).map(|k| DVec3::new(r * (corner * k as f64).cos(), r * (corner * k as f64).sin(), z)).collect()
}

fn round_bodies(sheet: &mut Sheet) {
    sheet.topic("coaxial parallel discs, as polygons of 64 corners and equal area", &format!("{HOWELL}, C-41"), "");
    for (r1, r2, h) in [(1.0, 1.0, 1.0), (0.5, 2.0, 1.0), (1.0, 0.3, 2.0), (3.0, 3.0, 0.5)] {
        let (x1, x2): (f64, f64) = (r1 / h, r2 / h);
        let x = 1.0 + (1.0 + x2 * x2) / (x1 * x1);
        let closed = 0.5 * (x - (x * x - 4.0 * (x2 / x1).powi(2)).sqrt());
        let value = between(&disc(r1, 0.0, 64), &flipped(disc(r2, h, 64)));
        sheet.equal(format!("radii {r1} and {r2}, distance {h}"), exact(closed), value, ROUND * value);
    }
    sheet.topic("a point below the middle of a disc", &format!("{HOWELL}, B-12"), "");
    for (radius, h) in [(0.5, 1.0), (1.0, 1.0), (2.0, 0.5)] {
        let closed = radius * radius / (radius * radius + h * h);
        let value = at_point(DVec3::ZERO, DVec3::Z, &flipped(disc(radius, h, 128)));
        sheet.equal(format!("radius {radius}, distance {h}"), exact(closed), value, ROUND * value);
    }
    sheet.topic("endless strips, by lengths of 400 and 200 gaps extrapolated", "Hottel, crossed strings", "");
    for gap in [0.5f64, 1.0, 2.0] {
        let strip = |half: f64, z: f64| {
            [(0.0, -half), (1.0, -half), (1.0, half), (0.0, half)].map(|(x, y)| DVec3::new(x, y, z)).to_vec()
        };
        let of_length = |half: f64| between(&strip(half, 0.0), &flipped(strip(half, gap)));
        let closed = (1.0 + gap * gap).sqrt() - gap;
        let value = 2.0 * of_length(400.0 * gap) - of_length(200.0 * gap);
        // What the extrapolation leaves is of second order in gap/length.
        sheet.equal(format!("width 1, gap {gap}"), known(closed, 5e-6 * closed), value, OPEN * value);
    }
}

/// Factor between the first two polygons, the others standing between.
fn blocked(polygons: &[Vec<DVec3>]) -> f64 {
    let mut b = Build::new();
    let grey = b.paint(0.5, 0.0);
    for p in polygons {
        b.face(p, grey);
    }
    let world = World::new(&b.0);
    let mesh = PatchMesh::uniform(&world.surfaces, 10.0, |p| p.front && p.surface < 2);
    Analytic::new(&world, &mesh).between(&mesh.list[0], 1, &mut Work::default()) / mesh.list[0].area
}

fn stored(references: &References, sheet: &mut Sheet) -> Result<()> {
    for row in references.rows("form_factors.csv")? {
        let reference = known(row.number("factor")?, row.number("uncertainty")?);
        let (from, to) = (row.points("from")?, row.points("to")?);
        sheet.topic(row.text("what")?, row.text("source")?, "");
        let (value, error) = match row.text("kind")? {
            "point" => (at_point(from[0], from[1], &to), AT_POINT),
            "blocked" => {
                let value = blocked(&[from, to, row.points("blocker")?]);
                (value, BLOCKED * value)
            }
            _ => {
                let value = between(&from, &to);
                (value, OPEN * value)
            }
        };
        sheet.equal(row.text("case")?, reference, value, error);
    }
    Ok(())
}
