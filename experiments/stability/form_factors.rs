//! Form factors of near, far and thin polygons, and of small ones in hemicubes.

use std::f64::consts::{PI, TAU};

use clerestory::mesh::PatchMesh;
use clerestory::scene::Face;
use clerestory::transport::form_factor::{Analytic, Hemicube, Work, exchange_area};
use clerestory::transport::points::Points;
use clerestory::transport::{DirectScratch, World, direct};
use glam::DVec3;

use super::Table;
use super::common::{Build, at, diffuse, lit};
use super::tools::{irradiance, mean_over, square};

const POSES: u32 = 200;

fn opposed(gap: f64) -> [Vec<DVec3>; 2] {
    [square(DVec3::ZERO, DVec3::X, DVec3::Y), square(at(0.0, 0.0, gap), DVec3::Y, DVec3::X)]
}

/// Howell C-11 in double precision.
fn closed_form(gap: f64) -> f64 {
    let x = 1.0 / gap;
    let q = 1.0 + x * x;
    let terms =
        (q * q / (1.0 + 2.0 * x * x)).sqrt().ln() + 2.0 * x * q.sqrt() * (x / q.sqrt()).atan() - 2.0 * x * x.atan();
    2.0 / (PI * x * x) * terms
}

/// The same where it loses no digits; by its series far away.
fn truth(gap: f64) -> f64 {
    let q = gap.powi(-2);
    if gap < 30.0 { closed_form(gap) } else { q / PI * (1.0 - 2.0 / 3.0 * q + 17.0 / 30.0 * q * q) }
}

fn centre(polygon: &[DVec3]) -> DVec3 {
    polygon.iter().sum::<DVec3>() / polygon.len() as f64
}

/// `cos cos A / (π r²)` from middle to middle, and the same with the disc's area added to the denominator.
fn points(a: &[DVec3], b: &[DVec3]) -> [f64; 2] {
    let [fa, fb] = [a, b].map(|p| Face::new(p, 0));
    let d = centre(b) - centre(a);
    let cosines = fa.normal.dot(d).max(0.0) * (-fb.normal.dot(d)).max(0.0) / d.length_squared();
    [0.0, fb.area_m2].map(|disc| cosines * fb.area_m2 / (PI * d.length_squared() + disc))
}

fn contour(a: &[DVec3], b: &[DVec3]) -> f64 {
    let [fa, fb] = [a, b].map(|p| Face::new(p, 0));
    exchange_area(a, fa.normal, b, fb.normal) / fa.area_m2
}

/// What the default takes for the light on `a` from a lamp `b`, in the mean over points of `a`.
fn as_lamp(a: &[DVec3], b: &[DVec3]) -> f64 {
    let mut build = Build::new();
    let (black, lamp) = (build.material(diffuse("black", 0.0)), build.material(lit(diffuse("lamp", 0.0), 1.0)));
    build.face(a, black).face(b, lamp);
    let world = World::new(&build.0);
    let normal = Face::new(a, 0).normal;
    let mut scratch = DirectScratch::default();
    mean_over(a, 60, |x| {
        let mut factors = [0.0];
        direct(&world, world.surfaces.frame.to_local(x), normal, 1, &mut scratch, &mut factors);
        factors[0]
    })
}

pub(super) fn gap(out: &mut Table) {
    out.panel("Parallel unit squares", "gap, in sides");
    for gap in [1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 1e3, 1e4, 1e5] {
        let [a, b] = opposed(gap);
        let exact = truth(gap);
        let [kernel, disc] = points(&a, &b);
        let middle = irradiance(centre(&a), DVec3::Z, &b);
        for (name, f) in [
            ("kernel between the middles", kernel),
            ("disc", disc),
            ("exact at the middle", middle),
            ("closed form (Howell C-11)", closed_form(gap)),
            ("contour integrals (classic methods)", contour(&a, &b)),
            ("exact at points (default)", as_lamp(&a, &b)),
        ] {
            out.draw("gap", gap, name, Some(f / exact - 1.0));
        }
    }
}

pub(super) fn sliver(out: &mut Table) {
    out.panel("Strip at the foot of a wall of its length", "length over width");
    let wall = square(DVec3::ZERO, DVec3::Y, DVec3::Z);
    for aspect in [1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6] {
        let strip = square(DVec3::ZERO, DVec3::X / aspect, DVec3::Y);
        // Means of exact factors over 2 · 200² crowded points: good to a few 1e-7 with the kink at the foot.
        let exact = mean_over(&strip, 200, |x| irradiance(x, DVec3::Z, &wall));
        let [kernel, disc] = points(&strip, &wall);
        for (name, f) in [
            ("kernel between the middles", kernel),
            ("disc", disc),
            ("hemicube of 100 in the middle", at_point(&strip, &wall, 100)),
            ("exact at the middle", irradiance(centre(&strip), DVec3::Z, &wall)),
            ("contour integrals (classic methods)", contour(&strip, &wall)),
            ("exact at points (default)", as_lamp(&strip, &wall)),
        ] {
            out.draw("sliver", aspect, name, Some(f / exact - 1.0));
        }
    }
}

/// Hemicube at the middle of `a`, turned so that no row of pixels runs along an edge.
fn at_point(a: &[DVec3], b: &[DVec3], resolution: usize) -> f64 {
    let mut build = Build::new();
    let grey = build.material(diffuse("grey", 0.5));
    build.face(a, grey).face(b, grey);
    let world = World::new(&build.0);
    let mesh = PatchMesh::uniform(&world.surfaces, 10.0, |p| p.front);
    let mut row = vec![0.0; mesh.list.len()];
    let x = world.surfaces.frame.to_local(centre(a));
    let x = world.lift(x, DVec3::Z);
    let turn = at(0.3f64.cos(), 0.3f64.sin(), 0.0);
    Hemicube { world: &world, mesh: &mesh, resolution }.at_point(x, DVec3::Z, turn, &mut row, &mut Work::default());
    row[1]
}

pub(super) fn hemicube(out: &mut Table) {
    out.panel("Square of side s at height 1, anywhere within a pixel", "pixels of the hemicube");
    for resolution in [50, 100, 200, 500] {
        for side in [0.2, 0.05, 0.01] {
            let errors = poses(side, resolution);
            let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
            out.draw("hemicube", resolution as f64, &format!("s = {side}, hemicube"), Some(rms));
            let missed = errors.iter().filter(|e| **e == -1.0).count() as f64 / errors.len() as f64;
            out.enter("hemicube", resolution as f64, &format!("s = {side}, share missed"), Some(missed));
        }
    }
    for resolution in [50.0, 500.0] {
        let (a, b) =
            (square(DVec3::ZERO, DVec3::X * 1e-3, DVec3::Y * 1e-3), square(DVec3::Z, DVec3::Y * 0.01, DVec3::X * 0.01));
        let error = as_lamp(&a, &b) / mean_over(&a, 20, |x| irradiance(x, DVec3::Z, &b)) - 1.0;
        out.draw("hemicube", resolution, "s = 0.01, exact at points (default)", Some(error));
    }
}

/// Relative errors of squares over the element, shifted by parts of a pixel and turned.
fn poses(side: f64, resolution: usize) -> Vec<f64> {
    let draws = Points::new(5);
    (0..POSES)
        .map(|pose| {
            let ((s, t), turn) = (draws.pair(pose, 0), TAU * draws.get(pose, 2));
            let shift = at(s - 0.5, t - 0.5, 0.0) * (4.0 / resolution as f64);
            let corner = DVec3::Z + shift - at(0.5, 0.5, 0.0) * side;
            let mut b = Build::new();
            let grey = b.material(diffuse("grey", 0.5));
            b.rectangle(corner, DVec3::Y * side, DVec3::X * side, grey);
            b.rectangle(at(-2.0, -2.0, -0.1), DVec3::X * 1e-3, DVec3::Y * 1e-3, grey); // gives the scene its size
            let world = World::new(&b.0);
            let mesh = PatchMesh::uniform(&world.surfaces, 10.0, |p| p.front);
            let (mut row, mut work) = (vec![0.0; mesh.list.len()], Work::default());
            let x = world.surfaces.frame.to_local(DVec3::ZERO);
            let turn = at(turn.cos(), turn.sin(), 0.0);
            Hemicube { world: &world, mesh: &mesh, resolution }.at_point(x, DVec3::Z, turn, &mut row, &mut work);
            row[0] / Analytic::new(&world, &mesh).at_point(x, DVec3::Z, 0, &mut work) - 1.0
        })
        .collect()
}
