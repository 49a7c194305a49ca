//! Requirements, watts, surfaces of the room: what a lighting engineer reads.

mod common;

use std::f64::consts::PI;
use std::path::Path;

use assert_cmd::Command;
use clerestory::measure::RoomSurface;
use clerestory::scene::Scene;
use common::{assert_near, assert_ratio, cube, furnished, solve, within};

#[test]
fn surfaces_absorb_what_the_lamp_gives() {
    // A closed cube of reflectance 0.6 whose ceiling gives 1 lm/m² on 1 m²: Σ A E (1 − ρ) = 1 lm. The lamp reflects too.
    let mut b = cube(0.6);
    b.level("level", common::at(0.1, 0.1, 0.4), common::at(0.9, 0.9, 0.4), 4);
    let m = solve(&b.0, &within(0.02));
    let (mut absorbed, mut error) = (0.0, 0.0);
    let all = |s: &&&RoomSurface| s.object.is_none();
    for s in m.appraisal.surfaces.iter().filter(|s| all(&s)) {
        assert!(s.front && s.modelled_share > 0.999, "{s:?}");
        let [lux, off] = s.illuminance_lx.expect("all reflect");
        absorbed += 0.4 * s.area_m2 * lux;
        error += 0.4 * s.area_m2 * off;
        let own = if s.material == "ceiling" { 1.0 / PI } else { 0.0 };
        assert_ratio(s.luminance_cd_m2[0], 0.6 * lux / PI + own, 1e-6, "L = (ρ E + M)/π");
    }
    assert_near(absorbed, 1.0, error, "flux");
    assert!(error < 0.05, "{error}");
}

#[test]
fn the_objects_of_a_material_make_up_its_surfaces() {
    // The block stands in a grey room as an object of its own: flux and area add up.
    let mut b = furnished();
    let block = b.0.objects.len();
    b.0.objects.push("block".into());
    for face in &mut b.0.faces {
        if face.vertices.iter().all(|v| (2.3..3.2).contains(&v.x) && v.z < 1.3) {
            face.object = block;
        }
    }
    b.level("level", common::at(0.1, 0.1, 0.4), common::at(0.9, 0.9, 0.4), 4);
    let m = solve(&b.0, &within(0.05));
    let (wholes, parts): (Vec<_>, Vec<_>) = m.appraisal.surfaces.iter().partition(|s| s.object.is_none());
    assert!(parts.len() > wholes.len(), "some material is on several objects: {parts:?}");
    for whole in wholes {
        let of: Vec<_> = parts.iter().filter(|p| p.material == whole.material && p.front == whole.front).collect();
        let sum = |value: &dyn Fn(&RoomSurface) -> f64| of.iter().map(|p| value(p)).sum::<f64>();
        // Means are over what was modelled.
        let flux = |s: &RoomSurface| s.luminance_cd_m2[0] * s.area_m2 * s.modelled_share;
        assert_ratio(sum(&flux), flux(whole), 1e-9, &whole.material);
        assert_ratio(sum(&|s| s.area_m2 * s.modelled_share), whole.area_m2 * whole.modelled_share, 1e-9, "area");
        assert!(of.iter().all(|p| scene_has(&b.0, p.object.as_deref())), "{of:?}");
    }
}

fn scene_has(scene: &Scene, object: Option<&str>) -> bool {
    object.is_some_and(|name| scene.objects.iter().any(|o| o == name))
}

#[test]
fn the_mean_of_a_wall_is_that_of_sensors_on_it() {
    let mut b = furnished();
    let points: Vec<_> = (0..144)
        .map(|k| (f64::from(k % 12), f64::from(k / 12)))
        .map(|(i, j)| (common::at(0.0, 3.0 * (i + 0.5) / 12.0, 2.5 * (j + 0.5) / 12.0), glam::DVec3::X))
        .collect();
    b.points("wall", &points);
    let m = solve(&b.0, &within(0.03));
    let grid = &m.grids[0].sensors;
    let mean = grid.iter().map(|s| s.xyz[1]).sum::<f64>() / grid.len() as f64;
    let mean_error = grid.iter().map(|s| s.error_lx).sum::<f64>() / grid.len() as f64;
    let wall = m.appraisal.surfaces.iter().find(|s| s.material == "red" && s.front).expect("it is lit");
    let [lux, error] = wall.illuminance_lx.expect("red reflects in all bands");
    // The midpoint rule over the wall, whose light changes over a metre or so: (0.25 m)²/24 of the second derivative.
    assert_near(lux, mean, error + mean_error + 0.003 * mean, "red wall");
}

const OBJ: &str = "v 0 0 0\nv 6 0 0\nv 6 4 0\nv 0 4 0\nv 0 0 3\nv 6 0 3\nv 6 4 3\nv 0 4 3\nusemtl floor\nf 1 2 3 4\n\
     usemtl wall\nf 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";

/// Solves a room of 6 x 4 m with six panels of 29 W, and answers the folder of results and the terminal's words.
fn room(extra: &str, grid: &str, flags: &[&str]) -> (tempfile::TempDir, String, Option<i32>) {
    let dir = tempfile::tempdir().expect("made");
    std::fs::write(dir.path().join("a.obj"), OBJ).expect("written");
    let panel = Path::new(env!("CARGO_MANIFEST_DIR")).join("luminaires/panel.ies");
    let text = format!(
        "[geometry]\nfiles = [\"a.obj\"]\nunit = \"m\"\nup = \"z\"\n[materials.floor]\nreflectance = 0.2\n\
         [materials.wall]\nreflectance = 0.6\n[[luminaires]]\nfile = {panel:?}\nposition_m = [1, 1, 3]\ncolumns = 3\n\
         column_spacing_m = [2, 0, 0]\nrows = 2\nrow_spacing_m = [0, 2, 0]\nflux_lm = 3600\npower_W = 30\nra = 83\n\
         group = \"all\"\n[[states]]\nname = \"blackout\"\nlevels = {{ all = 0.002 }}\n{extra}\n\
         [[grids]]\nname = \"task\"\n\
         plane = {{ origin_m = [0.5, 0.5, 0.75], u_m = [5, 0, 0], v_m = [0, 3, 0], nu = 5, nv = 3 }}\n{grid}\n"
    );
    std::fs::write(dir.path().join("s.toml"), text).expect("written");
    let mut command = Command::cargo_bin("clerestory").expect("the program is built");
    let output = command
        .current_dir(dir.path())
        .args(["solve", "s.toml", "-o", "out", "--quiet"])
        .args(flags)
        .output()
        .expect("it runs");
    let words = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (dir, words, output.status.code())
}

fn read(dir: &tempfile::TempDir, name: &str) -> String {
    std::fs::read_to_string(dir.path().join("out").join(name)).expect("written")
}

#[test]
fn requirements_are_judged_with_their_error() {
    let (dir, words, code) = room(
        "[power]\nfloor = \"floor\"\ngrid = \"task\"",
        "requirement = { mean_lx = 300, uniformity = 0.99, ra = 80 }\nemergency = { state = \"blackout\" }",
        &[],
    );
    assert_eq!(code, Some(0), "{words}");
    let text = read(&dir, "requirements.csv");
    let verdicts: Vec<Vec<&str>> = text.lines().skip(1).map(|l| l.split(',').collect()).collect();
    let found: Vec<(&str, &str, &str)> = verdicts.iter().map(|v| (v[1], v[2], v[7])).collect();
    let expected = [
        ("", "mean_lx", "met"),
        ("", "uniformity_U0", "not met"),
        ("", "ra", "met"),
        ("blackout", "direct_min_lx", "met"),
        ("blackout", "direct_max_over_min", "met"),
    ];
    assert_eq!(found, expected);
    // Six of 30 W over 24 m²: 7.5 W/m².
    let json: serde_json::Value = serde_json::from_str(&read(&dir, "run.json")).expect("JSON");
    assert_eq!(json["power"]["luminaires_W"], 180.0);
    assert_eq!(json["power"]["density_W_m2"], 7.5);
    let mean_lx = json["grids"][0]["mean_lx"].as_f64().expect("a number");
    let per_100 = json["power"]["density_W_m2_per_100_lx"].as_f64().expect("a number");
    assert_ratio(per_100, 750.0 / mean_lx, 1e-12, "W/(m² 100 lx)");
    assert!(words.contains("luminaires: 180 W, 7.50 W/m²"), "{words}");
    // A limit at the mean itself cannot be decided.
    let exact = format!("requirement = {{ mean_lx = {mean_lx} }}");
    let (dir, _, _) = room("", &exact, &[]);
    assert!(read(&dir, "requirements.csv").contains("undecided"));
}

#[test]
fn footcandles_are_lux_over_ten_and_three_quarters() {
    let (lux, _, _) = room("", "", &[]);
    let (feet, words, _) = room("", "", &["--units", "fc"]);
    let mean = |dir: &tempfile::TempDir, column: &str| -> f64 {
        let text = read(dir, "summary.csv");
        let mut lines = text.lines();
        let at = lines.next().expect("a header").split(',').position(|c| c == column).expect("the column");
        lines.next().expect("a grid").split(',').nth(at).expect("a field").parse().expect("a number")
    };
    assert_ratio(mean(&feet, "mean_fc"), mean(&lux, "mean_lx") * 0.3048 * 0.3048, 1e-12, "1 fc = 1 lm/ft²");
    assert!(words.contains("mean fc"), "{words}");
}

#[test]
fn footcandles_stand_in_the_record_too() {
    let (lux, _, _) = room("", "requirement = { mean_lx = 300 }", &[]);
    let (feet, _, _) = room("", "requirement = { mean_lx = 300 }", &["--units", "fc"]);
    let [lux, feet] =
        [lux, feet].map(|d| serde_json::from_str::<serde_json::Value>(&read(&d, "run.json")).expect("JSON"));
    let number = |v: &serde_json::Value| v.as_f64().expect("a number");
    assert_ratio(
        number(&feet["grids"][0]["mean_fc"]),
        number(&lux["grids"][0]["mean_lx"]) * 0.3048 * 0.3048,
        1e-12,
        "mean",
    );
    assert_ratio(number(&feet["requirements"][0]["limit"]), 300.0 * 0.3048 * 0.3048, 1e-12, "limit");
    assert_eq!(feet["requirements"][0]["quantity"], "mean_fc");
    assert!(feet["grids"][0].get("mean_lx").is_none());
}

#[test]
fn dimmed_lamps_dazzle_by_the_law_of_the_rating() {
    // L² goes with the square of the level, the background with the level: 8 lg 0.002 less.
    let eyes = "normal = [1, 0, 0]\nugr = true\nrequirement = { ugr = 1, state = \"blackout\" }";
    let (dir, words, _) = room("", eyes, &[]);
    let text = read(&dir, "glare.csv");
    let lines: Vec<Vec<&str>> = text.lines().skip(1).map(|l| l.split(',').collect()).collect();
    let rated = |state: &str| -> Vec<f64> {
        lines.iter().filter(|l| l[5] == state).filter_map(|l| l[3].parse().ok()).collect()
    };
    let (full, dark) = (rated(""), rated("blackout"));
    assert!(full.len() == dark.len() && full.len() >= 10, "{text}{words}");
    for (full, dark) in full.iter().zip(&dark) {
        assert_near(dark - full, 8.0 * 0.002f64.log10(), 1e-4, "a dimmed lamp's rating");
    }
    let requirements = read(&dir, "requirements.csv");
    assert!(requirements.contains("task,blackout,ugr,1,") && requirements.contains(",met"), "{requirements}");
}

#[test]
fn colour_rendering_comes_from_the_file_where_the_scene_says_nothing() {
    let required = "requirement = { ra = 80 }";
    let verdict = |extra: &str| read(&room(extra, required, &[]).0, "requirements.csv");
    assert!(verdict("").contains("ra,80,83"), "the scene's own");
    let second = |cri: &str| {
        let ldt = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("luminaires/panel.ldt"))
            .expect("shipped");
        // Line 31: the colour rendering of the first lamp set.
        let lines: Vec<&str> = ldt.lines().enumerate().map(|(k, l)| if k == 30 { cri } else { l }).collect();
        let dir = tempfile::tempdir().expect("made");
        let file = dir.path().join("p.ldt");
        std::fs::write(&file, lines.join("\r\n")).expect("written");
        let told = verdict(&format!("[[luminaires]]\nfile = {file:?}\nposition_m = [3, 2, 2.9]"));
        told.lines().nth(1).expect("a requirement").to_owned()
    };
    assert!(second("1B").contains("ra,80,80,80,80,met"), "{}", second("1B"));
    assert!(second("72").contains("ra,80,72,72,72,not met"), "{}", second("72"));
    assert!(second("warm").contains("unknown"), "{}", second("warm"));
}

#[test]
fn requirements_that_nothing_measures_are_named() {
    for (grid, word) in [
        ("requirement = { ugr = 19 }", "add ugr = true"),
        ("requirement = { cylindrical_lx = 150 }", "add cylindrical = true"),
        ("requirement = { mean_lx = 500, state = \"blackot\" }", "did you mean `blackout`?"),
        ("requirement = { mean_lx = -1 }", "asks for nothing"),
    ] {
        let (_dir, words, code) = room("", grid, &[]);
        assert_eq!(code, Some(2), "{words}");
        assert!(words.contains(word), "{words}");
    }
}
