//! States of the lights: light is linear, one run serves all of them, and each has its own error.

mod common;

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use clerestory::measure::{GridResult, Measurement, Method, SolveOptions};
use clerestory::scene::{Amount, Daytime, LightState, Placed, Scene, SkyName};
use clerestory::spectrum::{BandMode, Spectrum, illuminant};
use common::{Build, Cover, assert_near, assert_ratio, at, diffuse, glass, lit, mirror, painted, rgb, solve, within};
use glam::DVec3;

fn state(name: &str, levels: &[(&str, f64)], others: f64, daylight: bool) -> LightState {
    let levels = levels.iter().map(|(group, level)| ((*group).to_owned(), *level)).collect();
    LightState { name: name.into(), levels, others, daylight }
}

fn of<'a>(m: &'a Measurement, name: &str) -> &'a GridResult {
    &m.states.iter().find(|s| s.name == name).expect("the state is there").grids[0]
}

/// A coloured room with a warm lamp on the left and a cool one on the right.
fn two_lamps() -> Build {
    let mut b = Build::new();
    let grey = b.material(painted("grey", rgb([0.7, 0.7, 0.7])));
    let red = b.material(painted("red", rgb([0.65, 0.1, 0.08])));
    let blue = b.material(painted("blue", rgb([0.1, 0.15, 0.6])));
    b.room(DVec3::ZERO, at(4.0, 3.0, 2.5), [red, blue, grey, grey, grey, grey]);
    b.block(at(1.8, 0.8, 0.0), at(2.2, 2.2, 1.6), grey);
    for (name, x, kelvin) in [("warm", 1.0, "A"), ("cool", 3.0, "D65")] {
        let mut lamp = lit(diffuse(name, 0.0), 2000.0);
        let spectrum = illuminant(kelvin).expect("known");
        let emission = lamp.emission.as_mut().expect("it shines");
        emission.radiance = spectrum.scaled(2000.0 / (PI * spectrum.luminous()));
        emission.group = Some(name.into());
        let lamp = b.material(lamp);
        b.lamp(at(x, 1.5, 2.45), 0.6, lamp);
    }
    b.level("level", at(0.2, 0.2, 0.8), at(3.8, 2.8, 0.8), 4);
    b.bands(BandMode::Rgb);
    b
}

fn with_states(mut b: Build) -> Scene {
    b.0.states = vec![
        state("half", &[("warm", 0.5), ("cool", 0.5)], 1.0, true),
        state("left", &[("cool", 0.0)], 1.0, true),
        state("mixed", &[("warm", 0.2), ("cool", 0.7)], 1.0, true),
        state("off", &[], 0.0, false),
    ];
    b.0
}

#[test]
fn a_level_for_all_scales_all_and_nothing_burns_when_all_is_off() {
    let m = solve(&with_states(two_lamps()), &within(0.05));
    for (a, b) in m.grids[0].sensors.iter().zip(&of(&m, "half").sensors) {
        for k in 0..3 {
            assert_ratio(b.xyz[k], 0.5 * a.xyz[k], 1e-9, "half");
        }
        assert_ratio(b.error_lx, 0.5 * a.error_lx, 1e-6, "its error");
    }
    assert!(of(&m, "off").sensors.iter().all(|s| s.xyz == [0.0; 3] && s.error_lx == 0.0));
    let parts = |s: &clerestory::measure::SensorResult| s.direct_lx + s.reflected_lx;
    assert!(of(&m, "mixed").sensors.iter().all(|s| (parts(s) - s.xyz[1]).abs() < 1e-6 * s.xyz[1]));
}

#[test]
fn a_state_is_the_scene_with_its_lamps_dimmed() {
    let one = solve(&with_states(two_lamps()), &within(0.03));
    let mut cover = Cover::default();
    for (name, levels) in [("left", [1.0, 0.0]), ("mixed", [0.2, 0.7])] {
        let mut b = two_lamps();
        let lamps = b.0.materials.iter_mut().filter_map(|m| m.emission.as_mut());
        lamps.zip(levels).for_each(|(e, level)| e.radiance = e.radiance.scaled(level));
        // By another seed: an independent answer.
        let alone = solve(&b.0, &SolveOptions { seed: 7, ..within(0.03) });
        cover.enter_pair(of(&one, name), &alone.grids[0], name);
        for (a, b) in of(&one, name).sensors.iter().zip(&alone.grids[0].sensors) {
            let xy = |s: &clerestory::measure::SensorResult| s.xyz[0] / s.xyz.iter().sum::<f64>();
            // A colour errs by less than the light does.
            assert_near(xy(a), xy(b), 0.01, "chromaticity x");
        }
    }
    cover.assert();
}

#[test]
fn the_error_of_a_state_is_its_own() {
    // Path tracing solves each state by itself, without channels.
    let scene = with_states(two_lamps());
    let fast = solve(&scene, &within(0.05));
    let paths = SolveOptions { method: Method::PathTracing, paths: Some(30_000), ..within(0.05) };
    let traced = solve(&scene, &paths);
    let mut cover = Cover::default();
    for name in ["half", "left", "mixed"] {
        cover.enter_pair(of(&fast, name), of(&traced, name), name);
    }
    cover.assert();
    assert_eq!(of(&traced, "off").sensors[0].xyz, [0.0; 3]);
}

/// A room with a window, a mirror and a lamp, under a sky with a sun.
fn by_day() -> Build {
    let mut b = Build::new();
    let grey = b.material(diffuse("grey", 0.6));
    let (pane, shiny, lamp) =
        (b.material(glass(0.8)), b.material(mirror(0.9)), b.material(lit(diffuse("lamp", 0.0), 3000.0)));
    b.room(DVec3::ZERO, at(4.0, 4.0, 3.0), [grey; 6]);
    b.0.faces.remove(2);
    b.rectangle(DVec3::ZERO, at(4.0, 0.0, 0.0), at(0.0, 0.0, 3.0), pane);
    b.rectangle(at(1.0, 3.9, 0.5), at(2.0, 0.0, 0.0), at(0.0, 0.0, 2.0), shiny);
    b.lamp(at(2.0, 3.0, 2.9), 0.8, lamp);
    b.level("level", at(0.3, 0.3, 0.8), at(3.7, 3.7, 0.8), 4);
    let lux = |lx| Some(Placed { value: Amount::Lux(lx), line: 1 });
    b.0.daytime = Some(Daytime {
        file: PathBuf::from("test.toml"),
        model: Placed { value: SkyName::Cie(12), line: 1 },
        diffuse: lux(1e4),
        direct: lux(3e4),
        sun_deg: Some(Placed { value: (45.0, 180.0), line: 1 }),
        site: None,
        spectrum: Spectrum::constant(1.0),
        sun_spectrum: Spectrum::constant(1.0),
        ground_reflectance: 0.2,
        north_deg: 0.0,
    });
    b
}

#[test]
fn daylight_and_electric_light_are_told_apart_and_sum_to_all() {
    let mut b = by_day();
    b.0.states = vec![state("evening", &[], 0.5, false)];
    let m = solve(&b.0, &within(0.1));
    let names: Vec<&str> = m.states.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["evening", "daylight", "electric"]);
    for (k, all) in m.grids[0].sensors.iter().enumerate() {
        let (day, lamps, evening) =
            (&of(&m, "daylight").sensors[k], &of(&m, "electric").sensors[k], &of(&m, "evening").sensors[k]);
        assert_ratio(day.xyz[1] + lamps.xyz[1], all.xyz[1], 1e-6, "sum");
        assert_ratio(evening.xyz[1], 0.5 * lamps.xyz[1], 1e-6, "half of the lamps");
        assert_eq!((day.direct_lx, lamps.sun_lx, lamps.sky_lx), (0.0, 0.0, 0.0));
        assert_ratio(day.sky_lx + day.sun_lx, all.sky_lx + all.sun_lx, 1e-9, "sky and sun are daylight");
        assert_ratio(lamps.direct_lx, all.direct_lx, 1e-9, "lamps are electric");
        // Errors of parts that come by the same rays may help or hinder each other.
        assert!(
            all.error_lx <= 1.5 * (day.error_lx + lamps.error_lx),
            "{} {} {}",
            all.error_lx,
            day.error_lx,
            lamps.error_lx
        );
    }
    // Each part alone is what the scene gives without the other.
    let mut night = by_day();
    night.0.daytime = None;
    let mut day = by_day();
    day.0.materials.iter_mut().for_each(|m| m.emission = None);
    let mut cover = Cover::default();
    for (name, scene) in [("electric", night.0), ("daylight", day.0)] {
        let alone = solve(&scene, &SolveOptions { seed: 5, ..within(0.1) });
        cover.enter_pair(of(&m, name), &alone.grids[0], name);
    }
    cover.assert();
}

const OBJ: &str = "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nusemtl floor\nf 1 2 3 4\n";

fn run(toml: &str) -> (std::process::Output, tempfile::TempDir) {
    let dir = tempfile::tempdir().expect("made");
    std::fs::write(dir.path().join("a.obj"), OBJ).expect("written");
    let panel = Path::new(env!("CARGO_MANIFEST_DIR")).join("luminaires/panel.ies");
    let start = "[geometry]\nfiles = [\"a.obj\"]\nunit = \"m\"\nup = \"z\"\n[materials.floor]\nreflectance = 0.2\n\
         [[grids]]\nname = \"floor\"\non = \"floor\"\nspacing_m = 1.0\n";
    let lamp = |x: f64, group: &str| {
        format!("[[luminaires]]\nfile = {panel:?}\nposition_m = [{x}, 1.5, 2.5]\ngroup = \"{group}\"\n")
    };
    let text = format!("{start}{}{}{toml}", lamp(1.0, "left"), lamp(3.0, "right"));
    std::fs::write(dir.path().join("s.toml"), text).expect("written");
    let output = Command::cargo_bin("clerestory")
        .expect("the program is built")
        .current_dir(dir.path())
        .args(["solve", "s.toml", "-o", "out", "--quiet"])
        .output()
        .expect("it runs");
    (output, dir)
}

#[test]
fn states_of_luminaires_are_written() {
    let (output, dir) = run("[[states]]\nname = \"left\"\nlevels = { left = 1, right = 0 }\n\
         [[states]]\nname = \"right\"\nlevels = { left = 0 }\n");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(dir.path().join("out").join(name)).expect("written");
    let means: Vec<(String, f64)> = read("summary.csv")
        .lines()
        .skip(1)
        .map(|l| l.split(',').collect::<Vec<_>>())
        .map(|f| (f[14].to_owned(), f[5].parse().expect("a number")))
        .collect();
    let [all, left, right] = &means[..] else { panic!("three lines: {means:?}") };
    assert_eq!((all.0.as_str(), left.0.as_str(), right.0.as_str()), ("", "left", "right"));
    assert_ratio(left.1 + right.1, all.1, 1e-9, "sum of the states");
    assert!(read("states.csv").starts_with("state,grid,point,x_m,"));
    assert_eq!(read("states.csv").lines().count(), 1 + 2 * 12);
    let json: serde_json::Value = serde_json::from_str(&read("run.json")).expect("JSON");
    assert_ratio(json["states"][1]["grids"][0]["mean_lx"].as_f64().expect("a number"), right.1, 1e-12, "run.json");
}

#[test]
fn cylinders_stand_at_the_points_of_a_grid_that_asks_for_them() {
    let (output, dir) = run("[[grids]]\nname = \"faces\"\non = \"floor\"\nspacing_m = 1.0\nheight_m = 1.2\n\
         cylindrical = true\nsemicylindrical = [0, -1, 0]\n");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(dir.path().join("out").join(name)).expect("written");
    let names: Vec<String> =
        read("summary.csv").lines().skip(1).map(|l| l.split(',').next().expect("a name").to_owned()).collect();
    assert_eq!(names, ["floor", "faces", "faces_cylindrical", "faces_semicylindrical"]);
    let text = read("modelling.csv");
    let lines: Vec<Vec<&str>> = text.lines().skip(1).map(|l| l.split(',').collect()).collect();
    assert_eq!(lines.len(), 12);
    for l in lines {
        let v: Vec<f64> = l[2..].iter().map(|x| x.parse().expect("a number")).collect();
        assert_ratio(v[4], v[2] / v[0], 1e-12, "modelling ratio");
        assert!(v[5] > 0.0 && v[5] < 0.1 * v[4]);
    }
}

#[test]
fn states_that_cannot_be_are_named() {
    for (toml, words) in [
        ("[[states]]\nname = \"a\"\nlevels = { lefd = 1 }\n", ["s.toml:", "did you mean `left`?"]),
        ("[[states]]\nname = \"a\"\nlevels = { left = 1.5 }\n", ["left = 1.5 is no level", "0 (off) to 1"]),
        ("[[states]]\nname = \"daylight\"\n", ["\"daylight\"", "each state its own name"]),
        ("[[states]]\nname = \"a\"\n[[states]]\nname = \"a\"\n", ["taken", "each state its own name"]),
    ] {
        let (output, _dir) = run(toml);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(words.iter().all(|w| text.contains(w)), "{text}");
    }
}
