//! Scenes at which radiosity and form-factor programs are known to fail, and what this one does instead.

mod common;

use std::f64::consts::PI;
use std::path::PathBuf;

use clerestory::error::ErrorKind;
use clerestory::light::{above_plane, configuration_factor};
use clerestory::measure::{Measurement, SensorResult, Status};
use clerestory::scene::{self, Material, MaterialKind, Scene};
use clerestory::spectrum::SpectralValue;
use clerestory::transport::{DirectScratch, World, direct};
use common::{
    Build, Cover, assert_near, assert_ratio, at, cube, diffuse, lit, lux, mirror, only, refusal, solve, warned, within,
};
use glam::DVec3;

// ---------------------------------------------------------------------------------------------- form factors

/// Place and weight of `n` points of 0..1 that crowd at both ends, where irradiance has its kinks: midpoints under
/// `x = t³(10 − 15t + 6t²)`, whose first two derivatives vanish there (Sidi 1993).
fn crowded(n: usize) -> Vec<(f64, f64)> {
    let point = |k: usize| {
        let t = (k as f64 + 0.5) / n as f64;
        (t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t), 30.0 * (t * (1.0 - t)).powi(2) / n as f64)
    };
    (0..n).map(point).collect()
}

/// Mean over polygon `a` of a function of the point: triangles from the first vertex, each a collapsed square.
fn mean_over(a: &[DVec3], n: usize, mut f: impl FnMut(DVec3) -> f64) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for k in 1..a.len() - 1 {
        let (p, u, v) = (a[0], a[k] - a[0], a[k + 1] - a[0]);
        let size = u.cross(v).length();
        for (s, ws) in crowded(n) {
            for (t, wt) in crowded(n) {
                let w = size * s * ws * wt;
                sum += w * f(p + (u * (1.0 - t) + v * t) * s);
                area += w;
            }
        }
    }
    sum / area
}

/// Irradiance at a point per unit exitance of a polygon, back faces and horizon counted as they are.
fn irradiance(x: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    if common::face(polygon, 0).normal.dot(x - polygon[0]) <= 0.0 {
        return 0.0;
    }
    let seen: Vec<DVec3> = polygon.iter().map(|p| *p - x).collect();
    let mut above = Vec::new();
    above_plane(&seen, normal, 0.0, &mut above);
    configuration_factor(&above, normal)
}

fn form_factor(a: &[DVec3], b: &[DVec3]) -> f64 {
    let normal = common::face(a, 0).normal;
    mean_over(a, 160, |x| irradiance(x, normal, b))
}

fn square(corner: DVec3, u: DVec3, v: DVec3) -> Vec<DVec3> {
    vec![corner, corner + u, corner + u + v, corner + v]
}

#[test]
fn abutting_and_nearly_touching_squares_match_the_closed_forms() {
    let floor = square(DVec3::ZERO, DVec3::X, DVec3::Y);
    let wall = square(DVec3::ZERO, DVec3::Y, DVec3::Z);
    // Howell C-14 and C-11. The mean over 2 · 160² crowded points is good to 1e-6 with a kink at an edge.
    assert_near(form_factor(&floor, &wall), 0.200_043_776_1, 1e-6, "common edge");
    for (gap, f) in [(0.1, 0.826_994_522_4), (0.01, 0.980_416_602_9), (0.001, 0.998_005_631_9)] {
        let above = square(at(0.0, 0.0, gap), DVec3::Y, DVec3::X);
        assert_near(form_factor(&floor, &above), f, 1e-5, &format!("gap {gap}"));
    }
}

#[test]
fn slivers_keep_their_form_factors() {
    let wall = square(DVec3::ZERO, DVec3::Y, DVec3::Z);
    for (width, f) in [(1e-3, 0.498_592_023), (1e-6, 0.499_997_493)] {
        let strip = square(DVec3::ZERO, DVec3::X * width, DVec3::Y);
        assert_near(form_factor(&strip, &wall), f, 1e-6, &format!("strip of {width}"));
    }
    let needle = [DVec3::ZERO, DVec3::X, at(0.5, 1e-6, 0.0)];
    let above = square(at(0.0, -0.5, 0.5), DVec3::Y, DVec3::X);
    assert_near(form_factor(&needle, &above), 0.516_669_888, 1e-6, "needle");
}

#[test]
fn a_polygon_that_crosses_the_horizon_counts_with_its_upper_part() {
    let floor = square(DVec3::ZERO, DVec3::X, DVec3::Y);
    let crossing = square(at(-0.5, 0.0, -0.5), DVec3::Y, DVec3::Z);
    assert_near(form_factor(&floor, &crossing), 0.033_752_143_4, 1e-7, "half below");
}

#[test]
fn back_faces_and_coplanar_polygons_give_nothing_at_all() {
    let floor = square(DVec3::ZERO, DVec3::X, DVec3::Y);
    let turned_away = square(DVec3::Z, DVec3::X, DVec3::Y);
    let beside = square(DVec3::X, DVec3::X, DVec3::Y);
    assert_eq!(form_factor(&floor, &turned_away), 0.0);
    assert_eq!(form_factor(&floor, &beside), 0.0);
}

#[test]
fn a_millimetre_seen_from_a_kilometre_keeps_its_light() {
    let mut b = Build::new();
    // Luminance 1e9 cd/m² on 1 mm², 1 km away: E = L A / r² = 1e-3 lx.
    let lamp = b.material(lit(diffuse("lamp", 0.0), PI * 1e9));
    b.lamp(at(0.0, 0.0, 1000.0), 1e-3, lamp).points("below", &[(DVec3::ZERO, DVec3::Z)]);
    let m = solve(&b.0, &within(0.05));
    assert_ratio(lux(&m)[0], 1e-3, 1e-3, "far away");
}

/// Mean over `a` of what it receives from `b` past `blocker`, as the program works it out.
fn blocked_factor(a: &[DVec3], b: &[DVec3], blocker: &[DVec3]) -> f64 {
    let mut build = Build::new();
    let (black, lamp) = (build.material(diffuse("black", 0.0)), build.material(lit(diffuse("lamp", 0.0), 1.0)));
    build.face(a, black).face(b, lamp).face(blocker, black);
    let world = World::new(&build.0);
    let frame = world.surfaces.frame;
    let normal = common::face(a, 0).normal;
    let mut scratch = DirectScratch::default();
    let mean = mean_over(a, 60, |x| {
        let mut factors = [0.0];
        direct(&world, frame.to_local(x), normal, 1, &mut scratch, &mut factors);
        factors[0]
    });
    assert_eq!(scratch.rays, 0, "no shadow rays: the clipping is exact");
    mean
}

#[test]
fn blockers_take_exactly_their_share() {
    let a = square(DVec3::ZERO, DVec3::X, DVec3::Y);
    let b = square(DVec3::Z, DVec3::Y, DVec3::X);
    let wide = square(at(-1.0, -1.0, 1.0), DVec3::Y * 3.0, DVec3::X * 3.0);
    let plate = square(at(0.25, 0.25, 0.5), DVec3::X * 0.5, DVec3::Y * 0.5);
    let half = square(at(-5.0, -5.0, 0.5), DVec3::X * 5.5, DVec3::Y * 11.0);
    // Kinks inside of `a` leave the mean over 2 · 60² points good to about 1e-5.
    assert_near(blocked_factor(&a, &wide, &plate), 0.587_923_220_7, 5e-5, "contained");
    assert_near(blocked_factor(&a, &b, &plate), 0.099_506_294_6, 5e-5, "plate");
    assert_near(blocked_factor(&a, &b, &half), 0.099_912_447_8, 5e-5, "half-plane");
}

#[test]
fn form_factors_match_the_reference_file() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/validation-reference/view_factors.json");
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return;
    };
    let file: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let point = |v: &serde_json::Value| {
        let x = |k: usize| v[k].as_f64().expect("a number");
        at(x(0), x(1), x(2))
    };
    let polygon =
        |v: &serde_json::Value| -> Vec<DVec3> { v.as_array().expect("a polygon").iter().map(point).collect() };
    let mut seen = 0;
    for case in file["cases"].as_array().expect("cases") {
        let (g, name, truth) = (&case["geometry"], case["id"].as_str().expect("a name"), case["value"].as_f64());
        let truth = truth.expect("a value");
        match g["type"].as_str() {
            // As above: 1e-5 for means with kinks; the file has 12 digits for points.
            Some("polygons") => assert_near(form_factor(&polygon(&g["A"]), &polygon(&g["B"])), truth, 1e-5, name),
            Some("element-polygon") => {
                let found = irradiance(point(&g["point"]), point(&g["normal"]), &polygon(&g["B"]));
                assert_near(found, truth, 2e-12, name);
            }
            Some("polygons-blocked") => {
                let found = blocked_factor(&polygon(&g["A"]), &polygon(&g["B"]), &polygon(&g["blocker"]));
                assert_near(found, truth, 5e-5, name);
            }
            _ => continue,
        }
        seen += 1;
    }
    assert!(seen >= 20, "{seen} cases");
}

// ---------------------------------------------------------------------------------------------- geometry

/// Writes the scene as a user would have drawn it, with extra OBJ text at its end, and reads it back.
fn as_files(scene: &Scene, extra: &str) -> Scene {
    let folder = tempfile::tempdir().expect("made");
    let mut obj = String::from("o thing\n");
    for f in &scene.faces {
        for p in &f.vertices {
            obj += &format!("v {} {} {}\n", p.x, p.y, p.z);
        }
        let numbers: String =
            (0..f.vertices.len()).map(|k| format!(" {}", k as i64 - f.vertices.len() as i64)).collect();
        obj += &format!("usemtl {}\nf{numbers}\n", scene.materials[f.material].name);
    }
    let mut toml =
        String::from("[geometry]\nfiles = [\"a.obj\"]\nunit = \"m\"\nup = \"z\"\n[bands]\nmode = \"grey\"\n");
    for m in &scene.materials {
        let MaterialKind::Diffuse { front: SpectralValue::Grey(rho), .. } = m.kind else { panic!("grey paint") };
        toml += &format!("[materials.{}]\nreflectance = {rho}\n", m.name);
        if let Some(e) = &m.emission {
            toml += &format!("emission = {{ exitance_lm_m2 = {} }}\n", PI * e.radiance.luminous());
        }
    }
    std::fs::write(folder.path().join("a.obj"), obj + extra).expect("written");
    std::fs::write(folder.path().join("s.toml"), toml).expect("written");
    let mut read = scene::load(&folder.path().join("s.toml")).expect("a sound scene");
    read.grids.clone_from(&scene.grids);
    read
}

/// A cube with reflectance 0.5 and a few sensors.
fn cube_with_sensors() -> Scene {
    let mut b = cube(0.5);
    b.level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 3);
    b.0
}

const LAST_FACE: &str = "f -4 -3 -2 -1\n";

#[test]
fn faces_without_area_and_duplicates_change_nothing_and_are_told() {
    let scene = cube_with_sensors();
    let plain = lux(&solve(&as_files(&scene, ""), &within(0.05)));
    // The last face drawn is the ceiling: drawn twice, it must not shine twice.
    for (extra, word) in [
        ("usemtl wall\nf -4 -4 -3\n", "fewer than three"),
        ("v 0 0 0\nv 0.5 0 0\nv 1 0 0\nusemtl wall\nf -3 -2 -1\n", "no area"),
        ("usemtl wall\nf 1 2 3 4\n", "duplicate"),
        (&format!("usemtl ceiling\n{LAST_FACE}"), "emitted once"),
    ] {
        let read = as_files(&scene, extra);
        assert!(read.warnings.iter().any(|w| w.contains(word)), "{word}: {:?}", read.warnings);
        for (a, b) in lux(&solve(&read, &within(0.05))).iter().zip(&plain) {
            assert_ratio(*a, *b, 1e-9, word);
        }
    }
}

#[test]
fn a_room_wound_inside_out_is_as_bright() {
    let build = |inward: bool| {
        let mut b = Build::new();
        let (wall, lamp) = (b.material(diffuse("wall", 0.5)), b.material(lit(diffuse("lamp", 0.0), 1000.0)));
        if inward {
            b.room(DVec3::ZERO, at(2.0, 2.0, 2.0), [wall; 6]);
        } else {
            b.block(DVec3::ZERO, at(2.0, 2.0, 2.0), wall);
        }
        b.lamp(at(1.0, 1.0, 1.9), 0.5, lamp).level("floor", at(0.2, 0.2, 0.0), at(1.8, 1.8, 0.0), 3);
        solve(&b.0, &within(0.05))
    };
    let mut cover = Cover::default();
    cover.enter_pair(&build(false).grids[0], &build(true).grids[0], "inside out");
    cover.assert();
}

#[test]
fn faces_that_meet_without_common_vertices_change_nothing_beyond_the_errors() {
    let mut b = cube(0.5);
    b.0.faces.retain(|f| f.normal.z < 0.5 && f.normal.x < 0.5);
    for k in 0..4 {
        let (x, y) = (0.5 * f64::from(k % 2), 0.5 * f64::from(k / 2));
        b.rectangle(at(x, y, 0.0), DVec3::X * 0.5, DVec3::Y * 0.5, 0);
    }
    for k in 0..9 {
        let (y, z) = (f64::from(k % 3) / 3.0, f64::from(k / 3) / 3.0);
        b.rectangle(at(0.0, y, z), DVec3::Y / 3.0, DVec3::Z / 3.0, 0);
    }
    b.level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 3);
    assert_eq!(b.0.faces.len(), 4 + 4 + 9);
    let mut cover = Cover::default();
    let plain = solve(&cube_with_sensors(), &within(0.03));
    cover.enter_pair(&solve(&b.0, &within(0.03)).grids[0], &plain.grids[0], "split");
    cover.assert();
}

/// The room 0–`x1` × 0–2 × 0–2 with a lamp in its left part.
fn left_box(x1: f64) -> (Build, usize) {
    let mut b = Build::new();
    let (wall, lamp) = (b.material(diffuse("wall", 0.7)), b.material(lit(diffuse("lamp", 0.0), 1000.0)));
    b.room(DVec3::ZERO, at(x1, 2.0, 2.0), [wall; 6]);
    b.lamp(at(0.8, 1.0, 1.9), 0.5, lamp);
    (b, wall)
}

fn left_sensors(b: &mut Build) -> &mut Build {
    b.level("left", at(0.02, 0.05, 0.0), at(1.68, 1.95, 0.0), 4)
}

#[test]
fn a_partition_on_an_undivided_floor_lets_no_light_through() {
    let (mut alone, _) = left_box(1.7);
    left_sensors(&mut alone);
    let alone = solve(&alone.0, &within(0.03));
    for thickness in [0.0, 0.1] {
        let (mut b, wall) = left_box(4.0);
        if thickness == 0.0 {
            b.rectangle(at(1.7, 0.0, 0.0), DVec3::Y * 2.0, DVec3::Z * 2.0, wall);
        } else {
            b.block(at(1.7, 0.0, 0.0), at(1.7 + thickness, 2.0, 2.0), wall);
        }
        left_sensors(&mut b);
        let near = 1.7 + thickness + 1e-3;
        b.level("right", at(1.7 + thickness, 0.0, 0.0), at(4.0, 2.0, 0.0), 4);
        b.points(
            "close to the wall",
            &[(at(near, 1.0, 0.0), DVec3::Z), (at(near, 1.0, 1.0), DVec3::X), (at(near, 0.01, 0.01), DVec3::Z)],
        );
        let m = solve(&b.0, &within(0.03));
        for s in m.grids[1..].iter().flat_map(|g| &g.sensors) {
            assert_eq!((s.status, s.xyz[1]), (Status::Ok, 0.0), "thickness {thickness}: {:?}", s.position);
        }
        let mut cover = Cover::default();
        cover.enter_pair(&m.grids[0], &alone.grids[0], &format!("left of {thickness} m"));
        cover.assert();
    }
}

/// A room with a block whose bottom lies at `bottom`; sensors round its foot and in a row under it.
fn room_with_block(bottom: f64) -> Measurement {
    let mut b = Build::new();
    let (wall, lamp) = (b.material(diffuse("wall", 0.6)), b.material(lit(diffuse("lamp", 0.0), 1000.0)));
    b.room(at(0.0, 0.0, 0.0), at(3.0, 3.0, 2.5), [wall; 6]);
    b.block(at(1.03, 1.07, bottom), at(1.98, 1.91, 0.8), wall);
    b.lamp(at(1.0, 1.2, 2.4), 0.5, lamp);
    let foot = [(1.0, 1.5), (2.0, 1.5), (1.5, 1.05), (1.5, 1.93), (0.5, 0.5), (2.6, 2.5), (0.98, 1.02)];
    b.points("foot", &foot.map(|(x, y)| (at(x, y, 0.0), DVec3::Z)));
    b.level("under", at(1.05, 1.1, 0.0), at(1.95, 1.9, 0.0), 3);
    solve(&b.0, &within(0.03))
}

#[test]
fn a_block_on_the_floor_or_sunk_into_it_hides_the_same_floor() {
    let (standing, sunk) = (room_with_block(0.0), room_with_block(-0.1));
    let mut cover = Cover::default();
    cover.enter_pair(&standing.grids[0], &sunk.grids[0], "foot");
    cover.assert();
    for s in standing.grids[1].sensors.iter().chain(&sunk.grids[1].sensors) {
        assert_eq!((s.status, s.xyz[1]), (Status::Covered, 0.0), "{:?}", s.position);
    }
}

#[test]
fn blocks_with_a_common_face_close_a_room() {
    let mut b = Build::new();
    let (wall, lamp) = (b.material(diffuse("wall", 0.7)), b.material(lit(diffuse("lamp", 0.0), 1000.0)));
    b.room(DVec3::ZERO, at(4.0, 2.0, 1.0), [wall; 6]);
    b.block(at(1.5, 0.0, 0.0), at(2.5, 1.0, 1.0), wall).block(at(1.5, 1.0, 0.0), at(2.5, 2.0, 1.0), wall);
    b.lamp(at(0.7, 1.0, 0.95), 0.4, lamp);
    b.level("right", at(2.5, 0.0, 0.0), at(4.0, 2.0, 0.0), 4);
    b.points(
        "at the joint",
        &[(at(2.501, 1.0, 0.5), DVec3::X), (at(2.501, 1.0, 0.0), DVec3::Z), (at(2.6, 1.0, 0.5), -DVec3::X)],
    );
    b.level("left", at(0.1, 0.1, 0.0), at(1.4, 1.9, 0.0), 2);
    let m = solve(&b.0, &within(0.05));
    for s in m.grids[..2].iter().flat_map(|g| &g.sensors) {
        assert_eq!((s.status, s.xyz[1]), (Status::Ok, 0.0), "{:?}", s.position);
    }
    assert!(m.grids[2].sensors.iter().all(|s| s.xyz[1] > 1.0));
}

#[test]
fn blocks_that_penetrate_each_other_are_as_bright_as_their_union() {
    let build = |from: f64| {
        let mut b = Build::new();
        let (wall, lamp) = (b.material(diffuse("wall", 0.6)), b.material(lit(diffuse("lamp", 0.0), 1000.0)));
        b.room(DVec3::ZERO, at(4.0, 3.0, 2.5), [wall; 6]);
        b.block(at(1.0, 1.0, 0.0), at(2.0, 2.0, 1.0), wall).block(at(from, 1.2, 0.0), at(2.8, 1.8, 0.6), wall);
        b.lamp(at(2.0, 0.8, 2.4), 0.5, lamp);
        b.points(
            "round about",
            &[
                (at(2.0, 1.1, 0.3), DVec3::X),
                (at(2.4, 1.5, 0.6), DVec3::Z),
                (at(2.05, 1.5, 0.6), DVec3::Z),
                (at(2.0, 1.5, 0.8), DVec3::X),
                (at(1.5, 1.5, 1.0), DVec3::Z),
                (at(2.3, 1.0, 0.0), DVec3::Z),
            ],
        );
        b.points("inside", &[(at(1.7, 1.5, 0.3), DVec3::Z), (at(2.5, 1.5, 0.3), DVec3::X)]);
        solve(&b.0, &within(0.03))
    };
    let (crossing, touching) = (build(1.5), build(2.0));
    let mut cover = Cover::default();
    cover.enter_pair(&crossing.grids[0], &touching.grids[0], "union");
    cover.assert();
    for s in crossing.grids[1].sensors.iter().chain(&touching.grids[1].sensors) {
        assert_eq!((s.status, s.xyz[1]), (Status::Inside, 0.0), "{:?}", s.position);
    }
}

#[test]
fn a_lamp_in_a_closed_solid_lights_nothing_outside() {
    let mut b = Build::new();
    let (wall, lamp) = (b.material(diffuse("wall", 0.6)), b.material(lit(diffuse("lamp", 0.0), 1000.0)));
    b.room(DVec3::ZERO, at(2.0, 2.0, 2.0), [wall; 6]).block(at(0.5, 0.5, 0.5), at(1.5, 1.5, 1.5), wall);
    b.lamp(at(1.0, 1.0, 1.4), 0.2, lamp);
    b.level("floor", DVec3::ZERO, at(2.0, 2.0, 0.0), 3);
    b.points("inside", &[(at(1.0, 1.0, 1.0), DVec3::Z), (at(1.0, 1.0, 1.0), DVec3::X)]);
    let m = solve(&b.0, &within(0.05));
    assert!(m.grids[0].sensors.iter().all(|s| s.status == Status::Ok && s.xyz[1] == 0.0), "outside is dark");
    assert!(m.grids[1].sensors.iter().all(|s| s.status == Status::Inside), "a sensor in a solid has no reading");
    assert!(warned(&m, &["1 emitting face", "inside closed solids"]), "{:?}", m.record.warnings);
}

#[test]
fn a_tiny_lamp_is_as_good_as_a_large_one_from_afar() {
    let build = |side: f64| {
        let mut b = Build::new();
        let wall = b.material(diffuse("wall", 0.5));
        let lamp = b.material(lit(diffuse("lamp", 0.0), 1000.0 / (side * side)));
        b.room(DVec3::ZERO, at(10.0, 10.0, 10.0), [wall; 6]);
        b.lamp(at(5.0, 5.0, 9.99), side, lamp).level("floor", DVec3::ZERO, at(10.0, 10.0, 0.0), 3);
        solve(&b.0, &within(0.02))
    };
    let (tiny, large) = (build(1e-3), build(1.0));
    for (a, b) in only(&tiny).iter().zip(only(&large)) {
        // Ten sides away a square differs from a point by 1/3 · 10⁻² of its direct light.
        let allowed = 0.01 * b.xyz[1] + a.error_lx.hypot(b.error_lx);
        assert_near(a.xyz[1], b.xyz[1], allowed, "1 mm against 1 m");
        assert_ratio(a.direct_lx, b.direct_lx, 0.01, "direct light of 1 mm against 1 m");
    }
    let elements = |m: &Measurement| m.record.counts.iter().find(|c| c.0 == "elements").expect("counted").1;
    assert!(elements(&tiny) <= 2 * elements(&large), "{} {}", elements(&tiny), elements(&large));
}

#[test]
fn a_scene_without_light_is_dark_and_says_so() {
    let unlit = |m: Material| {
        let mut b = Build::new();
        let m = b.material(m);
        b.room(DVec3::ZERO, DVec3::ONE, [m; 6]).level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 2);
        solve(&b.0, &within(0.05))
    };
    for m in [unlit(diffuse("wall", 0.5)), unlit(lit(diffuse("dark lamp", 0.5), 0.0))] {
        assert!(warned(&m, &["emits"]), "{:?}", m.record.warnings);
        assert!(only(&m).iter().all(|s| s.xyz == [0.0; 3] && s.error_lx == 0.0), "zeros, not NaN");
        assert_eq!(m.grids[0].holding, 4, "zero is exact");
    }
}

#[test]
fn a_scene_without_sensors_has_an_energy_balance_all_the_same() {
    let m = solve(&cube(0.5).0, &within(0.05));
    assert!(m.grids.is_empty());
    common::assert_balanced(&m);
}

#[test]
fn one_triangle_is_a_scene() {
    let mut b = Build::new();
    let lamp = b.material(lit(diffuse("lamp", 0.5), 1.0));
    b.face(&[DVec3::ZERO, DVec3::X, DVec3::Y], lamp);
    let x = at(0.2, 0.2, 1.0);
    b.points("above", &[(x, -DVec3::Z), (x, DVec3::Z), (at(0.2, 0.2, -1.0), DVec3::Z)]);
    let m = solve(&b.0, &within(0.05));
    let exact = irradiance(x, -DVec3::Z, &[DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_ratio(lux(&m)[0], exact, 1e-5, "front"); // exact but for single precision
    assert_eq!(lux(&m)[1..], [0.0, 0.0], "looking away, and behind the lamp's back");
}

#[test]
fn a_scene_without_faces_is_refused() {
    let mut b = Build::new();
    b.points("somewhere", &[(DVec3::ZERO, DVec3::Z)]);
    let error = refusal(&b.0);
    assert_eq!(error.kind(), ErrorKind::Impossible, "{error}");
}

#[test]
fn a_room_with_a_missing_wall_reads_less_and_the_rest_escapes() {
    let build = |open: bool| {
        let mut b = cube(0.5);
        if open {
            b.0.faces.remove(0);
        }
        b.level("floor", at(0.2, 0.0, 0.0), at(1.0, 1.0, 0.0), 3);
        solve(&b.0, &within(0.05))
    };
    let (open, closed) = (build(true), build(false));
    common::assert_balanced(&open);
    assert!(open.ledger.escaped[0] > 0.1 * open.ledger.emitted[0], "about a fifth and more");
    assert_eq!(closed.ledger.escaped[0], 0.0, "a closed room leaks nothing");
    assert!(lux(&open).iter().zip(lux(&closed)).all(|(o, c)| *o < c));
}

// ---------------------------------------------------------------------------------------------- materials, solver

#[test]
fn black_surfaces_need_no_iteration() {
    let mut b = cube(0.0);
    b.level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 3);
    let m = solve(&b.0, &within(0.05));
    let ceiling = square(at(0.0, 0.0, 1.0), DVec3::Y, DVec3::X);
    for s in only(&m) {
        assert_eq!(s.reflected_lx, 0.0);
        assert_ratio(s.xyz[1], irradiance(s.position, DVec3::Z, &ceiling), 2e-5, "direct light"); // the skin of the floor
    }
    let products = m.record.counts.iter().find(|c| c.0 == "products").expect("counted").1;
    assert!(products <= 1, "{products} products");
}

#[test]
fn a_closed_room_that_reflects_everything_is_refused() {
    let mut b = cube(1.0);
    b.level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 2);
    let error = refusal(&b.0);
    assert_eq!(error.kind(), ErrorKind::Impossible);
    assert!(error.to_string().contains("reflects everything"), "{error}");
}

/// Share of the light entering one end of a slot of gap 1 and length `length` between endless walls that leaves at
/// the other end. Mirrors at both sides make the walls endless; the entrance is a black lamp.
fn slot(length: f64, rho: f64, tolerance: f64) -> (Measurement, f64) {
    let mut b = Build::new();
    let wall = b.material(diffuse("wall", rho));
    let lamp = b.material(lit(diffuse("entry", 0.0), 1.0));
    let side = b.material(mirror(1.0));
    let wide = 4.0;
    let (x, y, z) = (DVec3::X * length, DVec3::Y * wide, DVec3::Z);
    b.rectangle(DVec3::ZERO, x, y, wall).rectangle(z, y, x, wall);
    b.rectangle(DVec3::ZERO, z, x, side).rectangle(y, x, z, side);
    b.rectangle(DVec3::ZERO, y, z, lamp);
    let points: Vec<(DVec3, DVec3)> =
        (0..8).map(|k| (at(length, wide * 0.5, (f64::from(k) + 0.5) / 8.0), -DVec3::X)).collect();
    b.points("exit", &points);
    let m = solve(&b.0, &within(tolerance));
    let share = m.ledger.escaped[0] / m.ledger.emitted[0];
    (m, share)
}

#[test]
fn open_slots_pass_their_known_share_of_light_even_with_perfect_walls() {
    // Integral equation of the slot by product integration; ρ = 1 is Clausing's problem of 1932.
    for (length, rho, share) in
        [(2.0, 0.5, 0.310_425_1), (2.0, 0.8, 0.410_533_9), (2.0, 1.0, 0.542_057_8), (10.0, 0.5, 0.055_591_1)]
    {
        let (m, found) = slot(length, rho, 0.02);
        common::assert_balanced(&m);
        // The exit's mean over eight points, and the flux in the balance: two ways to the same number. A midpoint
        // rule of eight is good to 1e-3 here.
        let mean = lux(&m).iter().sum::<f64>() / 8.0;
        let error = only(&m).iter().map(|s| s.error_lx).sum::<f64>() / 8.0;
        assert_near(mean, share, error + 1e-3 * share, &format!("length {length}, ρ {rho}: at the exit"));
        let sampling = m.ledger.sampling_error[0] / m.ledger.emitted[0];
        assert_near(found, share, sampling.max(0.02 * share), &format!("length {length}, ρ {rho}: in the balance"));
    }
}

#[test]
fn a_room_behind_a_small_hole_is_judged_honestly() {
    let (rho, side) = (0.9, 0.1);
    let mut b = Build::new();
    let (wall, ceiling) = (b.material(diffuse("wall", rho)), b.material(lit(diffuse("ceiling", rho), 1.0)));
    b.room(DVec3::ZERO, DVec3::ONE, [wall, wall, wall, wall, wall, ceiling]);
    b.room(DVec3::X, at(2.0, 1.0, 1.0), [wall; 6]);
    // The wall between the rooms is a frame about a hole of 10 × 10 cm.
    b.0.faces.retain(|f| f.vertices.iter().any(|v| (v.x - 1.0).abs() > 1e-9));
    let (lo, hi) = (0.5 - 0.5 * side, 0.5 + 0.5 * side);
    for (y0, y1, z0, z1) in [(0.0, lo, 0.0, 1.0), (hi, 1.0, 0.0, 1.0), (lo, hi, 0.0, lo), (lo, hi, hi, 1.0)] {
        b.rectangle(at(1.0, y0, z0), DVec3::Y * (y1 - y0), DVec3::Z * (z1 - z0), wall);
    }
    b.level("behind", at(1.0, 0.0, 0.0), at(2.0, 1.0, 0.0), 3);
    b.points("hole", &[(at(1.0, 0.5, 0.5), -DVec3::X), (at(1.0, 0.5, 0.5), DVec3::X)]);
    let m = solve(&b.0, &within(0.05));
    let [into, back] = [0, 1].map(|k| &m.grids[1].sensors[k]);
    // What enters, minus what goes back, is absorbed behind the hole: (1 − ρ) of the mean there times the wall.
    let area = side * side;
    let entering = area * (into.xyz[1] - back.xyz[1]) / ((1.0 - rho) * (6.0 - area));
    let slack = area * (into.error_lx + back.error_lx) / ((1.0 - rho) * (6.0 - area));
    let behind = &m.grids[0].sensors;
    let mean = behind.iter().map(|s| s.xyz[1]).sum::<f64>() / behind.len() as f64;
    let error = behind.iter().map(|s| s.error_lx).sum::<f64>() / behind.len() as f64;
    // The floor's mean against that of all walls: the hole's beam crosses the room to the far wall, so the floor is a
    // little darker than the mean at ρ = 0.9.
    assert_near(mean, entering, error + slack + 0.1 * entering, "mean behind the hole");
}

// ---------------------------------------------------------------------------------------------- sources, sensors

#[test]
fn the_height_of_a_sensor_above_its_surface_does_not_matter() {
    let reading = |height: f64| {
        let mut b = cube(0.5);
        b.points("centre", &[(at(0.4, 0.3, height), DVec3::Z), (at(0.0 + height, 0.3, 0.6), DVec3::X)]);
        lux(&solve(&b.0, &within(0.01)))
    };
    let plain = reading(0.0);
    for height in [1e-6, 1e-4, 1e-3] {
        for (a, b) in reading(height).iter().zip(&plain) {
            // 1 mm nearer to a ceiling at 1 m changes 1e-3 of the direct light at most.
            assert_ratio(*a, *b, 1.5e-3, &format!("{height} m"));
        }
    }
}

#[test]
fn a_sensor_in_the_plane_of_a_lamp_gets_nothing_and_one_face_to_face_gets_its_exitance() {
    let mut b = Build::new();
    let lamp = b.material(lit(diffuse("lamp", 0.0), 100.0));
    b.lamp(DVec3::ZERO, 1.0, lamp);
    b.points(
        "points",
        &[
            (at(2.0, 0.0, 0.0), -DVec3::X),
            (at(2.0, 0.0, 0.0), DVec3::Z),
            (at(0.0, 0.0, -1e-4), DVec3::Z),
            (at(0.0, 0.0, 1.0), -DVec3::Z),
            (at(0.0, 0.0, 1e-4), -DVec3::Z),
        ],
    );
    let e = lux(&solve(&b.0, &within(0.05)));
    assert_eq!(e[..2], [0.0, 0.0], "in the plane");
    // At height h a square of side 1 leaves 4 h²-sized corners of the hemisphere dark: about 1e-7.
    assert_ratio(e[2], 100.0, 1e-6, "face to face");
    assert_eq!(e[3..], [0.0, 0.0], "behind: lamps are one-sided");
}

#[test]
fn a_two_sided_lamp_shines_both_ways() {
    let mut b = Build::new();
    let lamp = b.material(lit(diffuse("lamp", 0.0), 100.0));
    b.0.materials[lamp].emission.as_mut().expect("it emits").two_sided = true;
    b.lamp(DVec3::ZERO, 1.0, lamp);
    b.points("points", &[(at(0.0, 0.0, 1.0), -DVec3::Z), (at(0.0, 0.0, -1.0), DVec3::Z)]);
    let e: Vec<SensorResult> = only(&solve(&b.0, &within(0.05))).to_vec();
    let exact = 100.0 * irradiance(-DVec3::Z, DVec3::Z, &square(at(-0.5, -0.5, 0.0), DVec3::Y, DVec3::X));
    assert_ratio(e[0].xyz[1], exact, 1e-5, "above");
    assert_ratio(e[1].xyz[1], exact, 1e-5, "below");
}
