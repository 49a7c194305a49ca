//! Photometric files against lumens and candelas computed elsewhere, where those lie beside the source.

mod common;

use std::f64::consts::PI;
use std::path::PathBuf;

use clerestory::light::photometry::{Photometry, to_eulumdat, to_ies};
use clerestory::measure::SensorResult;
use clerestory::scene::{LuminaireRow, Scene};
use common::{Build, at, diffuse};
use glam::DVec3;

/// The folder of files; `None`, with a note, where it is not there.
fn folder() -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data/luminaires");
    if !path.is_dir() {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}

fn rows(path: &PathBuf) -> Vec<csv::StringRecord> {
    let rows: Vec<_> =
        csv::Reader::from_path(path).expect("the table is sound").into_records().map(Result::unwrap).collect();
    assert!(!rows.is_empty());
    rows
}

/// Vertical and horizontal angle of the last columns of `expected.csv`.
const DIRECTIONS: [(f64, f64); 9] = [
    (0.0, 0.0),
    (20.0, 10.0),
    (33.0, 75.0),
    (45.0, 140.0),
    (60.0, 200.0),
    (61.0, 301.0),
    (85.0, 45.0),
    (100.0, 30.0),
    (135.0, 95.0),
];

#[test]
fn lumens_and_candelas_agree_with_the_expected_values() {
    let Some(folder) = folder() else { return };
    let mut compared = 0;
    for row in rows(&folder.join("expected.csv")) {
        let name = &row[0];
        let path = ["real", "synthetic"].map(|f| folder.join(f).join(name)).into_iter().find(|p| p.exists()).unwrap();
        let p = Photometry::read(&path).unwrap();
        // Six digits are given.
        let agree = |what: &str, found: f64, expected: &str| {
            let expected: f64 = expected.parse().unwrap();
            assert!((found - expected).abs() <= 1e-5 * expected.abs().max(1e-3), "{name} {what}: {found} {expected}");
        };
        agree("peak", p.web.peak().0, &row[5]);
        agree("lumens", p.web.flux_lm(), &row[6]);
        if !row[7].is_empty() {
            agree("rated lumens", p.rated_flux_lm.unwrap(), &row[7]);
        }
        for (k, (vertical, horizontal)) in DIRECTIONS.iter().enumerate().filter(|(k, _)| !row[11 + k].is_empty()) {
            agree(&format!("cd at {vertical}, {horizontal}"), p.web.at(*vertical, *horizontal), &row[11 + k]);
            compared += 1;
        }
        let again = Photometry::parse(to_ies(&p).as_bytes(), &path.with_extension("ies")).unwrap();
        agree("lumens written as IES", again.web.flux_lm(), &row[6]);
        if let Ok(text) = to_eulumdat(&p) {
            let again = Photometry::parse(text.as_bytes(), &path.with_extension("ldt")).unwrap();
            agree("lumens written as EULUMDAT", again.web.flux_lm(), &row[6]);
        }
    }
    assert!(compared >= 100, "{compared}");
}

#[test]
fn malformed_files_are_refused_with_file_line_and_mend() {
    let Some(folder) = folder() else { return };
    let good = std::fs::read(folder.join("synthetic/lambert_1000lm_1986.ies")).unwrap();
    for row in rows(&folder.join("malformed.csv")) {
        let path = folder.join(&row[0]);
        if std::fs::read(&path).unwrap() == good {
            eprintln!("skipped: {} has no defect: its bytes are those of the good file", row[0].to_owned());
            continue;
        }
        let error = Photometry::read(&path).unwrap_err();
        let text = error.to_string();
        let (_, after) = text.split_once(&row[0]).unwrap();
        let line: usize = after[1..].split(':').next().unwrap().parse().unwrap();
        assert!(error.is_input() && line > 0 && text.contains("mend:"), "{text}");
    }
}

/// The cases of CIE 171 for electric light, by name.
fn cases() -> Option<Vec<serde_json::Value>> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/validation-reference/cie171_electric.json");
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    };
    let all: serde_json::Value = serde_json::from_str(&text).expect("the table is sound");
    Some(all["cases"].as_array().expect("the table is sound").clone())
}

fn case<'a>(cases: &'a [serde_json::Value], name: &str) -> &'a serde_json::Value {
    cases.iter().find(|c| c["test"] == name).expect("the table is sound")
}

fn vector(v: &serde_json::Value) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|k| v[k].as_f64().expect("the table is sound")))
}

/// A luminaire file of one plane: sizes as LM-63 has them (width, length, height, m).
fn axial(sizes: &str, vertical: &[f64], candela: impl Fn(f64) -> f64) -> Vec<u8> {
    let join = |list: Vec<f64>| list.iter().map(f64::to_string).collect::<Vec<_>>().join("\n");
    format!(
        "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {} 1 1 2 {sizes}\n1 1 0\n{}\n0\n{}\n",
        vertical.len(),
        join(vertical.to_vec()),
        join(vertical.iter().map(|v| candela(*v)).collect())
    )
    .into_bytes()
}

fn hung(bytes: Vec<u8>, position: DVec3) -> LuminaireRow {
    LuminaireRow::aimed_down(bytes, vec![position])
}

/// Every point within 1 %, and within its stated error by both methods (a stated error of zero is that of exact light:
/// then what the table and the place of a sensor above its floor leave, `exact`, counts).
fn compare(name: &str, scene: &Scene, expected: &[f64], exact: f64) {
    for options in [common::within(0.01), common::paths(50_000)] {
        let m = common::solve(scene, &options);
        let mut worst: f64 = 0.0;
        for (s, e) in common::only(&m).iter().zip(expected) {
            let off = (s.xyz[1] - e).abs();
            worst = worst.max(off / e);
            let stated = if options.paths.is_some() { 1.7 * s.error_lx } else { s.error_lx };
            assert!(off <= 0.01 * e, "{name} at {}: {} ± {} lx, expected {e}", s.position, s.xyz[1], s.error_lx);
            assert!(
                off <= stated + exact * e,
                "{name} at {}: {} ± {} lx, expected {e}",
                s.position,
                s.xyz[1],
                s.error_lx
            );
        }
        println!("{name} {:?}: worst {:.4} %", options.method, 100.0 * worst);
    }
}

fn half_degrees() -> Vec<f64> {
    (0..=180).map(|k| 0.5 * f64::from(k)).collect()
}

fn cosine(v: f64) -> f64 {
    v.to_radians().cos().max(0.0)
}

#[test]
fn point_area_and_disc_sources_of_cie_171_are_met() {
    let Some(cases) = cases() else { return };
    let sources: [(&str, Vec<u8>); 5] = [
        ("5.2a", axial("0 0 0", &half_degrees(), |v| 1000.0 * cosine(v))),
        ("5.2-isotropic", axial("0 0 0", &[0.0, 180.0], |_| 10_000.0 / (4.0 * PI))),
        ("5.2-table", axial("0 0 0", &[0.0, 30.0, 60.0, 90.0], |v| [1000.0, 800.0, 250.0, 0.0][(v / 30.0) as usize])),
        ("5.3", axial("1 1 0", &half_degrees(), |v| 1000.0 * cosine(v))),
        ("5.3-disc", axial("-0.5 -0.5 0", &half_degrees(), |v| 5000.0 * PI * 0.0625 * cosine(v))),
    ];
    for (name, bytes) in sources {
        let case = case(&cases, name);
        let inputs = &case["inputs"];
        let place = if name == "5.3" {
            DVec3::new(2.0, 2.0, 3.0)
        } else {
            vector(if name == "5.3-disc" { &inputs["centre"] } else { &inputs["source"] })
        };
        let mut b = Build::new();
        let black = b.material(diffuse("black", 0.0));
        if name == "5.3" {
            b.room(DVec3::ZERO, at(4.0, 4.0, 3.0), [black; 6]);
        } else {
            b.rectangle(at(-4.0, -4.0, 0.0), at(8.0, 0.0, 0.0), at(0.0, 8.0, 0.0), black);
        }
        let points = case["points"].as_array().unwrap();
        let sensors: Vec<_> = points.iter().map(|p| (vector(&p["p"]), vector(&p["n"]))).collect();
        let expected: Vec<f64> = points.iter().map(|p| p["E"].as_f64().unwrap()).collect();
        b.points("points", &sensors);
        b.0.luminaires.push(hung(bytes, place));
        // Half a degree of table: 1e-5; a sensor 4e-6 of the scene above its floor: 4e-5 at 2.4 m. The disc has 48 corners:
        // 2e-3 of its radius, at 5 cm from its edge 3e-3 of the light.
        compare(name, &b.0, &expected, if name == "5.3-disc" { 4e-3 } else { 1e-4 });
    }
}

fn closed_box(size: DVec3, rho: f64, position: DVec3) -> (Build, Vec<(usize, DVec3, DVec3, f64)>) {
    let mut b = Build::new();
    let wall = b.material(diffuse("wall", rho));
    b.room(DVec3::ZERO, size, [wall; 6]);
    let places = Build::on_faces(size);
    b.points("faces", &places.iter().map(|(_, p, n, _)| (*p, *n)).collect::<Vec<_>>());
    b.0.luminaires.push(hung(axial("0 0 0", &[0.0, 180.0], |_| 10_000.0 / (4.0 * PI)), position));
    (b, places)
}

#[test]
fn flux_on_every_surface_of_cie_171_5_4_is_met() {
    let Some(cases) = cases() else { return };
    let (b, places) = closed_box(at(4.0, 4.0, 3.0), 0.0, at(2.0, 2.0, 1.5));
    let m = common::solve(&b.0, &common::within(0.01));
    let mut shares = [0.0; 6];
    for (s, (face, _, _, area)) in common::only(&m).iter().zip(&places) {
        shares[*face] += s.xyz[1] * area / 10_000.0;
    }
    let expected = case(&cases, "5.4")["points"].as_array().unwrap();
    for (share, e) in shares.iter().zip(expected) {
        let e = e["flux_fraction"].as_f64().unwrap();
        assert!((share / e - 1.0).abs() < 1e-3, "{}: {share}", e);
    }
    let sum: f64 = shares.iter().sum();
    println!("5.4: sum {sum:.6}");
    assert!((sum - 1.0).abs() < 1e-3, "{sum}");
}

#[test]
fn interreflection_of_cie_171_5_8_is_met() {
    let Some(cases) = cases() else { return };
    for point in case(&cases, "5.8")["points"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|p| [0.0, 0.3, 0.7, 0.9].map(Some).contains(&p["rho"].as_f64()))
    {
        let (b, places) = closed_box(DVec3::splat(4.0), point["rho"].as_f64().unwrap(), DVec3::splat(2.0));
        let m = common::solve(&b.0, &common::within(0.01));
        let mean = |f: &dyn Fn(&SensorResult) -> f64| {
            common::only(&m).iter().zip(&places).map(|(s, p)| f(s) * p.3).sum::<f64>() / 96.0
        };
        let (total, error) = (mean(&|s| s.xyz[1]), mean(&|s| s.error_lx));
        let expected = point["mean_total"].as_f64().unwrap();
        println!(
            "5.8 rho {}: {total:.3} ± {error:.3} lx, expected {expected:.3}: {:.4} %",
            point["rho"],
            100.0 * (total / expected - 1.0)
        );
        assert!(
            (total / expected - 1.0).abs() < 0.01 && (total - expected).abs() < error + 1e-3 * expected,
            "{total} {expected}"
        );
    }
}
