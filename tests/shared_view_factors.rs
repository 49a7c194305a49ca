//! Form factors against values computed elsewhere by two methods each, where those lie beside the source.
//!
//! Needs the folder `shared` next to the repository.

mod common;

use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

use clerestory::light::{above_plane, configuration_factor};
use clerestory::mesh::PatchMesh;
use clerestory::scene::{Face, Scene};
use clerestory::transport::World;
use clerestory::transport::form_factor::{Analytic, Work, exchange_area};
use common::{Build, at, diffuse};
use glam::DVec3;
use serde_json::Value;

/// A case: its name, geometry and value.
struct Case {
    id: String,
    geometry: Value,
    value: f64,
}

/// The cases; none, with a note, where the file is not there.
fn cases() -> Vec<Case> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/validation-reference/view_factors.json");
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return Vec::new();
    };
    let file: Value = serde_json::from_str(&text).expect("JSON");
    let list = file["cases"].as_array().expect("cases");
    list.iter()
        .map(|c| Case {
            id: c["id"].as_str().expect("a name").into(),
            geometry: c["geometry"].clone(),
            value: c["value"].as_f64().expect("a number"),
        })
        .collect()
}

/// The case of a name, if the file is there.
fn case(id: &str) -> Option<Case> {
    let all = cases();
    assert!(all.is_empty() || all.iter().any(|c| c.id == id), "{id} is gone");
    all.into_iter().find(|c| c.id == id)
}

fn vector(v: &Value) -> DVec3 {
    let list: Vec<f64> = v.as_array().expect("a point").iter().map(|x| x.as_f64().expect("a number")).collect();
    DVec3::from_slice(&list)
}

fn polygon(v: &Value) -> Vec<DVec3> {
    v.as_array().expect("a polygon").iter().map(vector).collect()
}

fn normal(p: &[DVec3]) -> DVec3 {
    Face::new(p, 0).normal
}

fn area(p: &[DVec3]) -> f64 {
    Face::new(p, 0).area_m2
}

/// `F_12` of two polygons that nothing stands between.
fn factor(a: &[DVec3], b: &[DVec3]) -> f64 {
    exchange_area(a, normal(a), b, normal(b)) / area(a)
}

#[test]
fn unoccluded_polygons_match_to_a_millionth() {
    let mut compared = 0;
    for c in cases().iter().filter(|c| c.geometry["type"] == "polygons") {
        let (a, b) = (polygon(&c.geometry["A"]), polygon(&c.geometry["B"]));
        let value = factor(&a, &b);
        assert!((value - c.value).abs() <= 1e-6 * c.value, "{}: {value} against {}", c.id, c.value);
        let back = factor(&b, &a) * area(&b);
        assert!((back - value * area(&a)).abs() <= 1e-9 * back, "{}: reciprocity", c.id);
        compared += 1;
    }
    assert!(compared == 0 || compared >= 21, "{compared} cases");
}

#[test]
fn points_see_polygons_exactly() {
    for c in cases().iter().filter(|c| c.geometry["type"] == "element-polygon") {
        let value =
            point_factor(vector(&c.geometry["point"]), vector(&c.geometry["normal"]), &polygon(&c.geometry["B"]));
        assert!((value - c.value).abs() <= 1e-11, "{}: {value} against {}", c.id, c.value);
    }
}

/// Factor of a polygon at a point.
fn point_factor(x: DVec3, n: DVec3, polygon: &[DVec3]) -> f64 {
    let seen: Vec<DVec3> = polygon.iter().map(|v| *v - x).collect();
    let mut above = Vec::new();
    above_plane(&seen, n, 0.0, &mut above);
    configuration_factor(&above, n)
}

/// Factor between the first two faces of a scene, the others standing between.
fn blocked(scene: &Scene) -> f64 {
    let world = World::new(scene);
    let mesh = PatchMesh::uniform(&world.surfaces, 10.0, |p| p.front && p.surface < 2);
    let analytic = Analytic::new(&world, &mesh);
    analytic.between(&mesh.list[0], 1, &mut Work::default()) / mesh.list[0].area
}

fn three(polygons: &[Vec<DVec3>]) -> Scene {
    let mut b = Build::new();
    let grey = b.material(diffuse("grey", 0.5));
    for p in polygons {
        b.face(p, grey);
    }
    b.0
}

#[test]
fn blocked_polygons_match_to_two_thousandths() {
    for id in ["blocked-contained", "blocked-unit", "blocked-halfplane"] {
        let Some(c) = case(id) else { return };
        let scene = three(&["A", "B", "blocker"].map(|k| polygon(&c.geometry[k])));
        let value = blocked(&scene);
        assert!((value - c.value).abs() <= 2e-3 * c.value, "{id}: {value} against {}", c.value);
    }
}

#[test]
fn endless_strips_match_crossed_strings() {
    // A length of 400 gaps stands for an endless one: what the ends lose is of the order gap/length, and is taken off by
    // comparing two lengths, in which it halves.
    let strip = |half: f64, x: [f64; 2], y: f64, up: bool| {
        let p = [at(x[0], y, -half), at(x[1], y, -half), at(x[1], y, half), at(x[0], y, half)];
        if up { p.into_iter().rev().collect() } else { p.to_vec() }
    };
    let endless = |value: &dyn Fn(f64) -> f64| 2.0 * value(400.0) - value(200.0);
    if let Some(c) = case("2d-strips") {
        let open = |h: f64| factor(&strip(h, [0.0, 1.0], 0.0, true), &strip(h, [0.0, 1.0], 1.0, false));
        let value = endless(&open);
        assert!((value - c.value).abs() <= 1e-6 * c.value, "{value} against {}", c.value);
    }
    if let Some(c) = case("2d-blocked-1-1-0.5-0.3-0.7") {
        // The factor to a receiver of the whole length from a piece of 2 in the middle is that of an endless strip, but
        // for the ends of the far one, seen under 1/400.
        let scene = three(&[
            strip(1.0, [0.0, 1.0], 0.0, true),
            strip(400.0, [0.0, 1.0], 1.0, false),
            strip(400.0, [0.3, 0.7], 0.5, false),
        ]);
        let value = blocked(&scene);
        assert!((value - c.value).abs() <= 2e-3 * c.value, "{value} against {}", c.value);
    }
}

/// A regular polygon of `n` corners with the area of the disc, looking along +z.
fn disc(radius: f64, z: f64, n: usize) -> Vec<DVec3> {
    let corner = TAU / n as f64;
    let r = radius * (corner / corner.sin()).sqrt();
    (0..n).map(|k| at(r * (corner * k as f64).cos(), r * (corner * k as f64).sin(), z)).collect()
}

fn flipped(mut p: Vec<DVec3>) -> Vec<DVec3> {
    p.reverse();
    p
}

#[track_caller]
fn assert_fine(c: &Case, value: f64) {
    assert!((value - c.value).abs() <= 1e-3 * c.value, "{}: {value} against {}", c.id, c.value);
}

fn number(c: &Case, key: &str) -> f64 {
    c.geometry[key].as_f64().expect("a number")
}

#[test]
fn discs_are_fine_polygons() {
    for (id, r1, r2, h) in [("disks-equal", "r1", "r2", "h"), ("disks-0.5-2", "r1", "r2", "h")] {
        let Some(c) = case(id) else { return };
        let (r1, r2, h) = (number(&c, r1), number(&c, r2), number(&c, h));
        assert_fine(&c, factor(&disc(r1, 0.0, 64), &flipped(disc(r2, h, 64))));
    }
    for id in ["el-disk-axis", "el-disk-off"] {
        let Some(c) = case(id) else { return };
        let centre = vector(&c.geometry["disk_centre"]);
        let points: Vec<DVec3> = disc(number(&c, "disk_radius"), 0.0, 128).iter().map(|p| *p + centre).collect();
        let value = point_factor(vector(&c.geometry["point"]), vector(&c.geometry["normal"]), &points);
        assert_fine(&c, value);
    }
}

/// Facets of a sphere's surface, looking out: `n` rings from `z/r = cosines[0]` down to `cosines[1]`, triangles at the
/// poles.
fn sphere(radius: f64, n: usize, polar: [f64; 2]) -> Vec<Vec<DVec3>> {
    let around = 2 * n;
    let point = |i: usize, k: usize| {
        let theta = polar[0] + (polar[1] - polar[0]) * i as f64 / n as f64;
        let phi = TAU * (k % around) as f64 / around as f64;
        at(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()) * radius
    };
    let mut facets = Vec::new();
    for i in 0..n {
        for k in 0..around {
            let mut facet = vec![point(i, k), point(i + 1, k), point(i + 1, k + 1), point(i, k + 1)];
            facet.dedup_by(|a, b| (*a - *b).length() < 1e-9);
            if (facet[0] - facet[facet.len() - 1]).length() < 1e-9 {
                facet.pop();
            }
            facets.push(facet);
        }
    }
    facets
}

#[test]
fn spheres_are_fine_polyhedra() {
    for id in ["el-sphere-full", "el-sphere-clip"] {
        let Some(c) = case(id) else { return };
        let (d, theta) = (number(&c, "distance"), number(&c, "theta_deg").to_radians());
        let n = at(theta.sin(), 0.0, theta.cos());
        // From a point outside, a convex polyhedron shows the facets that face it, each once.
        let facets = sphere(number(&c, "sphere_radius"), 48, [0.0, PI]);
        let value: f64 = facets
            .iter()
            .map(|f| f.iter().map(|p| *p + at(0.0, 0.0, d)).collect::<Vec<DVec3>>())
            .filter(|f| normal(f).dot(f[0]) < 0.0)
            .map(|f| point_factor(DVec3::ZERO, n, &f))
            .sum();
        assert_fine(&c, value);
    }
    if let Some(c) = case("sphere-disk") {
        // F from sphere to disc by reciprocity; small facets each see the disc whole or cut by their horizon.
        let (r, d) = (0.5, number(&c, "centre_distance"));
        let target = flipped(disc(number(&c, "disk_radius"), d, 48));
        let facets = sphere(r, 24, [0.0, PI]);
        let sum: f64 = facets.iter().map(|f| exchange_area(f, normal(f), &target, normal(&target))).sum();
        assert_fine(&c, sum / facets.iter().map(|f| area(f)).sum::<f64>());
    }
    if let Some(c) = case("sphere-cap") {
        let half = number(&c, "cap_half_angle_deg").to_radians();
        let cap: Vec<Vec<DVec3>> = sphere(1.0, 40, [0.0, half]).into_iter().map(flipped).collect();
        let rest: Vec<Vec<DVec3>> = sphere(1.0, 40, [half, PI]).into_iter().map(flipped).collect();
        for patch in [&rest[30 * 80 + 5], &rest[2 * 80]] {
            let sum: f64 = cap.iter().map(|f| exchange_area(patch, normal(patch), f, normal(f))).sum();
            assert_fine(&c, sum / area(patch));
        }
    }
}

#[test]
fn a_hemisphere_sees_half_of_itself() {
    let Some(c) = case("hemi-self") else { return };
    let facets: Vec<Vec<DVec3>> = sphere(1.0, 24, [0.0, PI / 2.0]).into_iter().map(flipped).collect();
    // By symmetry one meridian of facets stands for all.
    let (mut sum, mut all) = (0.0, 0.0);
    for i in 0..24 {
        let f = &facets[i * 48];
        all += area(f);
        sum += facets.iter().map(|g| exchange_area(f, normal(f), g, normal(g))).sum::<f64>();
    }
    assert_fine(&c, sum / all);
}

/// Strips of a cylinder's wall with the area of the cylinder, looking out or in.
fn cylinder(radius: f64, length: f64, n: usize, inward: bool) -> Vec<Vec<DVec3>> {
    let corner = TAU / n as f64;
    let r = radius * 0.5 * corner / (0.5 * corner).sin();
    let p = |k: usize, z: f64| at(r * (corner * k as f64).cos(), r * (corner * k as f64).sin(), z);
    (0..n)
        .map(|k| vec![p(k, 0.0), p(k + 1, 0.0), p(k + 1, length), p(k, length)])
        .map(|f| if inward { flipped(f) } else { f })
        .collect()
}

#[test]
fn cylinders_are_fine_prisms() {
    if let Some(c) = case("cyl-in-self-1-2") {
        let wall = cylinder(number(&c, "radius"), number(&c, "length"), 96, true);
        let sum: f64 = wall.iter().map(|f| exchange_area(&wall[0], normal(&wall[0]), f, normal(f))).sum();
        assert_fine(&c, sum / area(&wall[0]));
    }
    for (id, to_inner) in [("cyl-outer-inner-2-1-2", true), ("cyl-outer-self-2-1-2", false)] {
        let Some(c) = case(id) else { return };
        let (inner, outer, length) = (number(&c, "r_inner"), number(&c, "r_outer"), number(&c, "length"));
        let n = 96;
        let inner = cylinder(inner, length, n, false);
        let outer = cylinder(outer, length, n, true);
        let all: Vec<Vec<DVec3>> = outer.into_iter().chain(inner).collect();
        let scene = three(&all);
        let world = World::new(&scene);
        let mesh = PatchMesh::uniform(&world.surfaces, 10.0, |p| p.front);
        let analytic = Analytic::new(&world, &mesh);
        let mut work = Work::default();
        let range = if to_inner { n..2 * n } else { 0..n };
        let sum: f64 = range.map(|j| analytic.between(&mesh.list[0], j, &mut work)).sum();
        assert_fine(&c, sum / mesh.list[0].area);
    }
}
