//! The program as a user meets it; hardly any light is traced.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

fn clerestory(args: &[&str]) -> Output {
    Command::cargo_bin("clerestory").expect("the program is built").args(args).output().expect("it runs")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

const OBJ: &str = "o slab\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nusemtl wall\nf 1 2 3 4\n";
const TOML: &str = "[geometry]\nfiles = [\"a.obj\"]\nunit = \"m\"\nup = \"z\"\n[materials.wall]\nreflectance = 0.5\n";

/// Writes a scene and answers its path.
fn scene(folder: &Path, obj: &str, toml: &str) -> String {
    std::fs::write(folder.join("a.obj"), obj).expect("written");
    std::fs::write(folder.join("s.toml"), toml).expect("written");
    folder.join("s.toml").display().to_string()
}

/// Both commands must refuse the scene with exit code 2 and these words.
fn refused(obj: &str, toml: &str, words: &[&str]) {
    let folder = tempfile::tempdir().expect("made");
    let path = scene(folder.path(), obj, toml);
    let out = folder.path().join("out").display().to_string();
    for args in [vec!["check", path.as_str()], vec!["solve", path.as_str(), "-o", out.as_str()]] {
        let output = clerestory(&args);
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {text}");
        for word in words {
            assert!(text.contains(word), "{args:?}: {word:?} is not in {text}");
        }
        assert!(output.stdout.is_empty(), "results only on standard output");
    }
    assert!(!Path::new(&out).exists(), "nothing is written for a scene that cannot be read");
}

#[test]
fn help_teaches_the_commands_and_exit_codes() {
    let output = clerestory(&["--help"]);
    let text = stdout(&output);
    assert!(output.status.success());
    for word in ["solve", "check", "schema", "Exit codes:", "clerestory solve room.toml"] {
        assert!(text.contains(word), "{word}");
    }
    let text = stdout(&clerestory(&["solve", "--help"]));
    for word in
        ["--tolerance", "--method", "path-tracing", "--spectral", "--threads", "--seed", "--json", "--quiet", "95 %"]
    {
        assert!(text.contains(word), "{word}");
    }
}

#[test]
fn wrong_usage_is_exit_code_2() {
    for args in
        [&["solve"][..], &["slove", "x"], &["solve", "x", "--tolerance", "5"], &["solve", "x", "--threads", "0"]]
    {
        assert_eq!(clerestory(args).status.code(), Some(2), "{args:?}");
    }
    assert!(stderr(&clerestory(&["solve", "x", "--tolerance", "5"])).contains("write 5% or 0.05"));
    assert!(stderr(&clerestory(&["solve", "x", "--paths", "5"])).contains("--method path-tracing"));
}

#[test]
fn a_scene_that_is_not_there_is_named() {
    let output = clerestory(&["solve", "nowhere.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("error: nowhere.toml: no such file"));
}

#[test]
fn an_unknown_key_is_answered_with_the_nearest() {
    let toml = TOML.replace("reflectance", "reflectence");
    refused(OBJ, &toml, &["s.toml:6: unknown key `reflectence`", "did you mean `reflectance`?"]);
}

#[test]
fn an_impossible_reflectance_names_line_and_mend() {
    refused(
        OBJ,
        &TOML.replace("0.5", "1.07"),
        &["s.toml:6: material \"wall\": reflectance 1.07 exceeds 1", "mend:", "percent"],
    );
}

#[test]
fn a_broken_obj_names_line_and_mend() {
    refused(&OBJ.replace("f 1 2 3 4", "f 1 2 3 9"), TOML, &["a.obj:7: vertex 9 is out of range", "mend:"]);
    refused(&OBJ.replace("v 2 1 0", "v 2 nan 0"), TOML, &["a.obj:4: coordinate nan"]);
    refused(&OBJ.replace("v 2 1 0", "v 2 inf 0"), TOML, &["a.obj:4: coordinate inf"]);
    refused(&OBJ.replace("f 1 2 3 4", "f"), TOML, &["a.obj:7:"]);
    refused(&OBJ.replace("f 1 2 3 4", "f 0 2 3 4"), TOML, &["a.obj:7:"]);
}

#[test]
fn a_sun_that_cannot_shine_is_refused_with_its_line() {
    let sky = "[sky]\nmodel = \"cie-clear\"\nhorizontal_illuminance_lx = 1e4\n";
    let site = |longitude: &str, time: &str| {
        format!("{TOML}{sky}[site]\nlatitude_deg = 52.5\nlongitude_deg = {longitude}\ntime = \"{time}\"\n")
    };
    refused(OBJ, &format!("{TOML}{sky}"), &["s.toml:8:", "where the sun stands", "[site]"]);
    let night = site("13.4", "2026-03-21T23:00:00+01:00");
    refused(OBJ, &night, &["s.toml:13:", "not above the horizon", "between sunrise and sunset"]);
    // Berlin with the sign of its longitude wrong, on its own clock.
    let wrong_sign = site("-73.9", "2026-03-21T12:00:00+01:00");
    refused(OBJ, &wrong_sign, &["s.toml:12:", "hours apart", "wrong sign"]);
    let nowhere = format!("{TOML}{sky}[site]\ntime = \"2026-03-21T12:00:00+01:00\"\n");
    refused(OBJ, &nowhere, &["s.toml:10:", "no place", "latitude_deg"]);
    let set_twice = format!(
        "{TOML}{sky}sun_altitude_deg = 30\nsun_azimuth_deg = 180\n[site]\nlatitude_deg = 52.5\nlongitude_deg = 13.4\ntime = \"2026-03-21T12:00:00Z\"\n"
    );
    refused(OBJ, &set_twice, &["s.toml:10:", "placed twice"]);
    let perez = format!("{TOML}[sky]\nmodel = \"perez\"\nsun_altitude_deg = 30\nsun_azimuth_deg = 180\n");
    refused(OBJ, &perez, &["s.toml:8:", "wants direct and diffuse light", "weather file"]);
    let dark = format!("{TOML}[sky]\nmodel = \"cie-overcast\"\n");
    refused(OBJ, &dark, &["s.toml:8:", "horizontal_illuminance_lx"]);
}

#[test]
fn check_tells_findings_in_words_and_in_json() {
    let folder = tempfile::tempdir().expect("made");
    let path = scene(folder.path(), OBJ, TOML);
    let output = clerestory(&["check", &path]);
    assert!(output.status.success());
    assert!(stdout(&output).contains("warning: no light"), "{}", stdout(&output));
    let json: serde_json::Value =
        serde_json::from_slice(&clerestory(&["check", &path, "--json"]).stdout).expect("JSON");
    assert_eq!(json["faces"], 1);
    assert!(json["findings"].as_array().is_some_and(|f| f.iter().any(|d| d["severity"] == "warning")));
}

#[test]
fn the_schema_is_json_schema() {
    let json: serde_json::Value = serde_json::from_slice(&clerestory(&["schema"]).stdout).expect("JSON");
    assert_eq!(json["title"], "clerestory scene");
    assert!(json["properties"]["geometry"].is_object());
}

#[test]
fn a_reader_who_goes_away_is_no_error() {
    let program = assert_cmd::cargo::cargo_bin("clerestory");
    let mut child = std::process::Command::new(program)
        .arg("schema")
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("it runs");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    assert!(output.status.success());
    assert!(output.stderr.is_empty(), "{}", stderr(&output));
}

/// A box of 4 x 3 x 2.5 m seen from inside, with a lamp below its ceiling.
const ROOM: &str = "o room\nv 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 2.5\nv 4 0 2.5\nv 4 3 2.5\nv 0 3 2.5\n\
    v 1.5 1 2.4\nv 2.5 1 2.4\nv 2.5 2 2.4\nv 1.5 2 2.4\nusemtl wall\nf 1 2 3 4\nf 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\n\
    f 3 7 8 4\nf 4 8 5 1\nusemtl lamp\nf 12 11 10 9\n";
const LAMP: &str = "[materials.lamp]\nemission = { exitance_lm_m2 = 1000 }\n";
const VIEW: &str = "[[views]]\nname = \"camera\"\nposition_m = [0.5, 0.5, 1.5]\ndirection = [1, 1, -0.1]\nfov_deg = 80\npixels = [24, 16]\n";

#[test]
fn progressive_pictures_are_refused_where_there_are_none() {
    let folder = tempfile::tempdir().expect("made");
    let path = scene(folder.path(), ROOM, &format!("{TOML}{LAMP}"));
    let to = folder.path().join("p").display().to_string();
    let out = folder.path().join("out").display().to_string();
    let run = |method: &str| clerestory(&["solve", &path, "-o", &out, "--method", method, "--progressive", &to]);
    let (other, viewless) = (run("gathering"), run("progressive"));
    assert_eq!((other.status.code(), viewless.status.code()), (Some(2), Some(2)));
    assert!(stderr(&other).contains("--progressive goes with --method progressive"), "{}", stderr(&other));
    let text = stderr(&viewless);
    assert!(text.contains("s.toml:") && text.contains("no view") && text.contains("[[views]]"), "{text}");
    assert!(!Path::new(&to).exists() && !Path::new(&out).exists());
}

#[test]
fn progressive_pictures_show_the_lights_come_on() {
    let folder = tempfile::tempdir().expect("made");
    let path = scene(folder.path(), ROOM, &format!("{TOML}{LAMP}{VIEW}"));
    let [to, out] = ["p", "out"].map(|n| folder.path().join(n).display().to_string());
    let output =
        clerestory(&["solve", &path, "-o", &out, "--method", "progressive", "--patches", "4", "--progressive", &to]);
    assert!(output.status.success(), "{}", stderr(&output));
    let mut names: Vec<String> = std::fs::read_dir(&to)
        .expect("made")
        .map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    // One lamp: there is no second light.
    let expected = [
        "camera_1_ambient-only.png",
        "camera_2_one-light.png",
        "camera_3_24-shots.png",
        "camera_4_full-solution.png",
        "camera_strip.png",
        "progressive.csv",
    ];
    assert_eq!(names, expected);
    let table = std::fs::read_to_string(Path::new(&to).join("progressive.csv")).expect("text");
    let unshot: Vec<f64> =
        table.lines().skip(1).map(|l| l.rsplit(',').next().expect("a cell").parse().expect("a number")).collect();
    assert!((unshot[0] - 1.0).abs() < 1e-14, "nothing is shot yet: {}", unshot[0]);
    assert!((unshot[1] - 0.5).abs() < 1e-9, "the walls hold half of what the lamp gave: {}", unshot[1]);
    assert!(unshot.is_sorted_by(|a, b| a > b) && unshot[3] <= 1e-3, "{unshot:?}");
    // One exposure: the walls of the first picture are as grey as one value can make them, the last ones are not.
    let grey = |name: &str| {
        let picture = image::open(Path::new(&to).join(name)).expect("a picture").to_rgb8();
        picture.pixels().map(|p| p.0[1]).filter(|g| *g < 250).collect::<std::collections::BTreeSet<u8>>().len()
    };
    assert_eq!(grey(expected[0]), 1, "one ambient term");
    assert!(grey(expected[3]) > 20, "{}", grey(expected[3]));
}

#[test]
fn an_interrupted_run_leaves_whole_files_or_none() {
    let folder = tempfile::tempdir().expect("made");
    let grid = "[[grids]]\nname = \"g\"\nplane = { origin_m = [0, 0, 0.8], u_m = [4, 0, 0], v_m = [0, 3, 0], nu = 40, nv = 30 }\nnormal = [0, 0, 1]\n";
    let path = scene(folder.path(), ROOM, &format!("{TOML}{LAMP}{grid}{VIEW}"));
    let program = assert_cmd::cargo::cargo_bin("clerestory");
    let out = folder.path().join("out");
    let start = || {
        let _ = std::fs::remove_dir_all(&out);
        std::process::Command::new(&program)
            .args(["solve", &path, "--tolerance", "30%", "-q", "-o"])
            .arg(&out)
            .stdout(std::process::Stdio::null())
            .spawn()
            .expect("it runs")
    };
    let whole = |name: &str| -> bool {
        let Ok(text) = std::fs::read_to_string(out.join(name)) else { return false };
        match name {
            "illuminance.csv" => assert_eq!(text.lines().count(), 1 + 1200),
            _ => assert!(serde_json::from_str::<serde_json::Value>(&text).is_ok(), "run.json is cut off"),
        }
        true
    };
    let clock = std::time::Instant::now();
    assert!(start().wait().expect("it ends").success());
    let takes = clock.elapsed();
    assert!(whole("illuminance.csv") && whole("run.json"));
    // Killed early, in the middle, and while it writes.
    for share in [0.2, 0.6, 0.85, 0.9, 0.94, 0.97, 0.99, 1.0] {
        let mut child = start();
        std::thread::sleep(takes.mul_f64(share));
        let _ = child.kill();
        let _ = child.wait();
        let _ = (whole("illuminance.csv"), whole("run.json"));
    }
}

/// A room with a window, and the synthetic weather.
fn office_year(folder: &Path, replace: (&str, &str)) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments");
    for (name, from) in [("office.obj", "office/office.obj"), ("synthetic.wea", "weather/synthetic.wea")] {
        std::fs::copy(root.join(from), folder.join(name)).expect("copied");
    }
    let text = std::fs::read_to_string(root.join("office/blinds.toml")).expect("it is shipped");
    let text =
        text.replace("../weather/", "").replace("nu = 16, nv = 24", "nu = 4, nv = 6").replace(replace.0, replace.1);
    std::fs::write(folder.join("year.toml"), text).expect("written");
    folder.join("year.toml").display().to_string()
}

#[test]
fn a_year_is_written_as_matrices_tables_and_pictures() {
    let folder = tempfile::tempdir().expect("made");
    let scene = office_year(folder.path(), ("", ""));
    let out = folder.path().join("out");
    let output =
        clerestory(&["annual", &scene, "-o", &out.display().to_string(), "--tolerance", "10%", "--json", "-q"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    for name in ["metrics.csv", "grid_metrics.csv", "annual_error.npy", "sun-up-hours.txt", "run.json"] {
        assert!(out.join(name).is_file(), "{name}");
    }
    for ending in ["autonomy", "useful", "sunlight", "year", "months"] {
        assert!(out.join(format!("workplane_{ending}.png")).is_file(), "{ending}");
    }
    let npy = std::fs::read(out.join("annual.npy")).expect("written");
    let header = 10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    assert_eq!((&npy[..8], header % 64, npy[header - 1]), (b"\x93NUMPY\x01\x00".as_slice(), 0, b'\n'));
    assert_eq!(npy.len(), header + 4 * 24 * 8760);
    // The matrix in text has one line a sensor and one column an hour with sun.
    let hours = std::fs::read_to_string(out.join("sun-up-hours.txt")).expect("written").lines().count();
    let ill = std::fs::read_to_string(out.join("annual.ill")).expect("written");
    assert!(ill.lines().count() == 24 && ill.lines().all(|l| l.split(' ').count() == hours));
    // The record and the table tell the same.
    let record: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    let table = std::fs::read_to_string(out.join("grid_metrics.csv")).expect("written");
    let mut lines = table.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let (names, values) = (lines.next().expect("a header"), lines.next().expect("a grid"));
    let mut compared = 0;
    for (name, value) in names.iter().zip(values) {
        if let (Some(told), Ok(value)) = (record["grids"][0][name].as_f64(), value.parse::<f64>()) {
            assert!((told - value).abs() <= 1e-12 * told.abs(), "{name}: {told} {value}");
            compared += 1;
        }
    }
    assert!(compared > 25, "{compared}");
}

#[test]
fn a_year_refuses_what_it_cannot_use() {
    let folder = tempfile::tempdir().expect("made");
    let said = |replace: (&str, &str)| {
        let scene = office_year(folder.path(), replace);
        let output = clerestory(&["annual", &scene, "-o", &folder.path().join("out").display().to_string(), "-q"]);
        assert_eq!(output.status.code(), Some(2), "{replace:?}");
        stderr(&output)
    };
    let no_weather = said(("weather = \"synthetic.wea\"", "latitude_deg = 50\nlongitude_deg = 10"));
    assert!(no_weather.contains("weather"), "{no_weather}");
    let no_pane = said(("panes = [\"glazing\"]", "panes = [\"glasing\"]"));
    assert!(no_pane.contains("year.toml:") && no_pane.contains("glazing"), "{no_pane}");
    let no_control = said(("control = \"lm-83\"", "control = \"lm83\""));
    assert!(no_control.contains("year.toml:") && no_control.contains("lm-83"), "{no_control}");
    let no_day = said(("hours = [8, 18]", "hours = [18, 8]"));
    assert!(no_day.contains("year.toml:"), "{no_day}");
    // A value that is missing, in line 7 + 8 of the file.
    let text = std::fs::read_to_string(folder.path().join("synthetic.wea")).expect("copied");
    let gap: String = text
        .lines()
        .enumerate()
        .map(|(i, l)| if i == 14 { "1 1 8.500 9999 10\n".into() } else { format!("{l}\n") })
        .collect();
    let scene = office_year(folder.path(), ("synthetic.wea", "gap.wea"));
    std::fs::write(folder.path().join("gap.wea"), gap).expect("written");
    let output = clerestory(&["annual", &scene, "-o", &folder.path().join("out").display().to_string(), "-q"]);
    assert!(output.status.code() == Some(2) && stderr(&output).contains("gap.wea:15"), "{}", stderr(&output));
}
