//! Findings on small scenes.

use super::*;

const HEAD: &str = "[geometry]\nfiles = [\"a.obj\"]\nunit = \"m\"\nup = \"z\"\n[materials.wall]\nreflectance = 0.5\n\
    [materials.lamp]\nemission = { luminance_cd_m2 = 100 }\n";
const GRID: &str = "[[grids]]\nname = \"g\"\nplane = { origin_m = [0.5, 0.5, 0.9], u_m = [1, 0, 0], v_m = [0, 1, 0], nu = 2, nv = 2 }\n";

/// A box, fronts outward or inward.
fn solid(from: usize, lo: [f64; 3], hi: [f64; 3], outward: bool) -> String {
    let mut text = String::new();
    for i in 0..8 {
        let pick = |axis: usize| {
            if i >> axis & 1 == 1 { hi[axis] } else { lo[axis] }
        };
        text += &format!("v {} {} {}\n", pick(0), pick(1), pick(2));
    }
    for ring in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        let mut ring = ring.map(|i: usize| (i + from).to_string());
        if !outward {
            ring.reverse();
        }
        text += &format!("f {}\n", ring.join(" "));
    }
    text
}

fn found(obj: &str, rest: &str) -> Vec<Diagnostic> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.obj"), obj).unwrap();
    let path = folder.path().join("s.toml");
    std::fs::write(&path, format!("{HEAD}{rest}")).unwrap();
    check(&load(&path).unwrap())
}

fn has(found: &[Diagnostic], severity: Severity, words: &str) -> bool {
    found.iter().any(|d| d.severity == severity && d.what.contains(words))
}

/// A room wound inward with a lamp under its ceiling.
fn room(lamp_down: bool) -> String {
    let lamp = if lamp_down { "f 9 12 11 10" } else { "f 9 10 11 12" };
    format!(
        "usemtl wall\no room\n{}usemtl lamp\no panel\nv 0.5 0.5 2.499\nv 1.5 0.5 2.499\nv 1.5 1.5 2.499\nv 0.5 1.5 2.499\n{lamp}\n",
        solid(1, [0.0; 3], [2.0, 2.0, 2.5], false)
    )
}

#[test]
fn a_sound_room_has_only_its_free_lamp_edges_to_tell() {
    let found = found(&room(true), GRID);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(has(&found, Severity::Info, "4 open edges, 4.000 m in all"));
}

#[test]
fn a_lamp_that_shines_into_the_ceiling_is_found() {
    assert!(has(&found(&room(false), GRID), Severity::Warning, "shine into object `room`, 1.000 mm before them"));
}

#[test]
fn a_lamp_in_the_plane_of_the_ceiling_is_found() {
    let found = found(&room(true).replace("2.499", "2.5"), GRID);
    assert!(has(&found, Severity::Warning, "lie in the plane of faces of object `room`"), "{found:?}");
}

#[test]
fn a_room_wound_outward_buries_its_sensors() {
    let obj = format!("usemtl wall\no room\n{}", solid(1, [0.0; 3], [2.0, 2.0, 2.5], true));
    let found = found(&obj, GRID);
    assert!(has(&found, Severity::Error, "4 of 4 points lie inside a solid"), "{found:?}");
    assert!(has(&found, Severity::Warning, "no light"));
}

#[test]
fn a_block_hides_some_sensors_and_rests_on_the_floor() {
    let block = solid(13, [0.6, 0.6, 0.0], [1.0, 1.0, 1.0], true);
    let bottomless = block.lines().filter(|l| *l != "f 13 15 16 14").collect::<Vec<_>>().join("\n");
    let closed = found(&format!("{}usemtl wall\no block\n{block}", room(true)), GRID);
    assert!(has(&closed, Severity::Warning, "1 of 4 points lie inside a solid"), "{closed:?}");
    let open = found(&format!("{}usemtl wall\no block\n{bottomless}\n", room(true)), GRID);
    assert!(has(&open, Severity::Info, "4 open edges, 4.000 m"), "the block's lower edges lie on the floor: {open:?}");
}

#[test]
fn a_twisted_face_and_a_crack_are_found() {
    let twisted = room(true).replacen("f 7 8 6 5", "f 5 6 8 7", 1);
    assert!(has(&found(&twisted, GRID), Severity::Warning, "4 edges join faces that are wound against each other"));
    let cracked = "usemtl wall\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1.00005 0 0\nv 2 0 0\nv 2 1 0\nv 1.00005 1 0\nf 1 2 3 4\nf 5 6 7 8\n";
    assert!(has(&found(cracked, ""), Severity::Warning, "nearly meet"));
}

#[test]
fn a_sensor_that_faces_the_wall_is_found() {
    let grid = "[[grids]]\nname = \"g\"\nplane = { origin_m = [0.5, 0.5, 0.001], u_m = [0, 1, 0], v_m = [1, 0, 0], nu = 2, nv = 2 }\n";
    assert!(has(&found(&room(true), grid), Severity::Warning, "4 of 4 points face a wall at no distance"));
}

#[test]
fn a_scene_that_asks_nothing_is_told() {
    assert!(has(&found(&room(true), ""), Severity::Warning, "nothing is asked"));
}
