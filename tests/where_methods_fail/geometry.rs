//! Geometry as it is drawn: doubles, slivers, leaks, contacts, solids in solids.

use clerestory::error::ErrorKind;
use clerestory::measure::{self, Measurement, Status};
use clerestory::mesh::PatchMesh;
use clerestory::scene::{Face, Material, Scene};
use clerestory::transport::World;
use glam::DVec3;

use super::common::{
    self, Build, Cover, assert_near, assert_ratio, at, cube, diffuse, lit, lux, only, refusal, solve, warned, within,
};
use super::tools::{as_files, irradiance};

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
        b.0
    };
    let told = |from: f64| as_files(&build(from), "").warnings.iter().any(|w| w.contains("run into each other"));
    assert!(told(1.5) && !told(2.0), "those that cross are told, those that touch are not");
    let [crossing, touching] = [1.5, 2.0].map(|from| solve(&build(from), &within(0.03)));
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
    let remarks = measure::remarks(&b.0, &m).join("; ");
    assert!(remarks.contains("grid \"inside\": 2 of 2 points lie inside a solid"), "{remarks}");
    assert!(remarks.contains("grid \"floor\" gets no light at all"), "{remarks}");
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

#[test]
fn faces_that_share_a_place_are_told() {
    let mut scene = cube_with_sensors();
    scene.materials.push(diffuse("red", 0.2));
    let plain = solve(&as_files(&scene, ""), &within(0.05));
    // The second vertex of each file is the floor's: a red floor on the floor, and a red rug that covers a part of it.
    let floor = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf -4 -3 -2 -1\n";
    let rug = "v 0.2 0.2 0\nv 0.7 0.2 0\nv 0.7 0.7 0\nv 0.2 0.7 0\nusemtl red\nf -4 -3 -2 -1\n";
    for (extra, word) in [(floor, "kept material `wall`, not `red`"), (rug, "overlaps in one plane")] {
        let read = as_files(&scene, extra);
        assert!(read.warnings.iter().any(|w| w.contains(word)), "{word}: {:?}", read.warnings);
        let m = solve(&read, &within(0.05));
        assert_ratio(m.ledger.emitted[0], plain.ledger.emitted[0], 1e-9, "light is emitted once");
    }
}

#[test]
fn slivers_in_a_floor_change_nothing_beyond_the_errors() {
    let plain = solve(&cube_with_sensors(), &within(0.03));
    for width in [1e-3, 1e-6] {
        let mut b = cube(0.5);
        b.0.faces.retain(|f| f.normal.z < 0.5);
        let (x, y) = (DVec3::X, DVec3::Y);
        b.rectangle(DVec3::ZERO, x * 0.4, y, 0).rectangle(x * 0.4, x * width, y, 0);
        b.rectangle(x * (0.4 + width), x * (0.6 - width), y, 0);
        b.level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 3);
        let world = World::new(&b.0);
        let mesh = PatchMesh::uniform(&world.surfaces, 0.1, |p| p.front);
        let area: f64 = mesh.list.iter().map(|p| p.area).sum::<f64>() * world.surfaces.frame.area_m2();
        assert_near(area, 6.0, 1e-12, "no area is lost");
        let m = solve(&b.0, &within(0.03));
        common::assert_balanced(&m);
        let mut cover = Cover::default();
        cover.enter_pair(&m.grids[0], &plain.grids[0], &format!("sliver of {width}"));
        cover.assert();
    }
}

#[test]
fn a_lamp_that_looks_out_of_the_room_is_no_silent_night() {
    let mut b = cube(0.5);
    let ceiling = b.0.faces.iter_mut().find(|f| f.material == 1).expect("a ceiling");
    ceiling.vertices.reverse();
    *ceiling = Face::new(&ceiling.vertices, 1);
    b.level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 3);
    let m = solve(&b.0, &within(0.05));
    assert!(lux(&m).iter().all(|e| *e == 0.0), "it shines outward");
    let remarks = measure::remarks(&b.0, &m).join("; ");
    assert!(remarks.contains("grid \"floor\" gets no light at all") && remarks.contains("wrong way"), "{remarks}");
}

#[test]
fn a_gap_of_a_millimetre_passes_what_crossed_strings_say() {
    // Two slabs, 10 mm thick, 1 mm apart, a lamp before them: a black slot ten times as deep as wide passes √101 − 10.
    let mut b = Build::new();
    let (black, lamp) = (b.material(diffuse("black", 0.0)), b.material(lit(diffuse("lamp", 0.0), 1000.0)));
    let (depth, gap, side) = (0.01, 0.001, 2.0);
    b.room(at(-1.0, -1.0, -1.0), at(1.0, 1.0, 1.0), [black; 6]);
    b.block(at(0.0, -1.0, -1.0), at(depth, 1.0, -0.5 * gap), black);
    b.block(at(0.0, -1.0, 0.5 * gap), at(depth, 1.0, 1.0), black);
    b.rectangle(at(0.0, -1.0, -1.0), DVec3::Y * side, DVec3::Z * side, lamp);
    let points: Vec<(DVec3, DVec3)> =
        (0..16).map(|k| (at(depth, 0.0, gap * ((f64::from(k) + 0.5) / 16.0 - 0.5)), -DVec3::X)).collect();
    b.points("exit", &points);
    b.points("behind", &[(at(0.5, 0.0, 0.8), DVec3::X)]);
    let m = solve(&b.0, &within(0.05));
    let mean = m.grids[0].sensors.iter().map(|s| s.direct_lx).sum::<f64>() / 16.0;
    // The slot is 2 m long, not endless: what lies beyond is seen under 10/1000 and takes its square. The midpoint rule
    // over the width is good to 1e-4 here.
    assert_ratio(mean, 1000.0 * (101f64.sqrt() - 10.0), 3e-4, "through the gap");
    assert_eq!(m.grids[1].sensors[0].direct_lx, 0.0, "looking away");
}
