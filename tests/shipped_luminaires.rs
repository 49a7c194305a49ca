//! The luminaires of `luminaires/`: what their files hold is what their formulas say.

#[allow(dead_code, unreachable_pub, reason = "shared with the program that writes the files")]
#[path = "../luminaires/catalogue.rs"]
mod catalogue;

use std::path::Path;

use assert_cmd::Command;
use clerestory::light::photometry::{Photometry, to_eulumdat, to_ies};

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("luminaires")
}

#[test]
fn files_hold_the_flux_of_the_closed_form_in_both_formats() {
    for shipped in catalogue::catalogue() {
        for ending in ["ies", "ldt"] {
            let p = Photometry::read(&folder().join(format!("{}.{ending}", shipped.stem))).unwrap();
            // Linear between angles: cos^n about its axis is off by Δ² (n + 1)/12, 2.6e-4 for the spot.
            let off = p.web.flux_lm() / shipped.flux_lm - 1.0;
            assert!(off.abs() < 3e-4, "{}.{ending}: {} lm, {off:e}", shipped.stem, p.web.flux_lm());
            assert!(p.warnings.is_empty(), "{:?}", p.warnings);
            for (gamma, c) in [(0.0, 0.0), (30.0, 40.0), (35.0, 30.0), (60.0, 150.0), (120.0, 90.0)] {
                // All of these are angles of every web, or planes of no light or of an axial one.
                let (found, formula) = (p.web.at(gamma, c), shipped.candela(gamma, c));
                assert!((found - formula).abs() < 1e-3, "{} {gamma} {c}: {found} {formula}", shipped.stem);
            }
        }
    }
}

#[test]
fn files_are_what_the_formulas_write() {
    for shipped in catalogue::catalogue() {
        let photometry = shipped.photometry();
        for (ending, text) in [("ies", to_ies(&photometry)), ("ldt", to_eulumdat(&photometry).unwrap())] {
            let there = std::fs::read_to_string(folder().join(format!("{}.{ending}", shipped.stem))).unwrap();
            assert_eq!(there, text, "run `cargo run --release --example luminaires`");
        }
    }
}

#[test]
fn the_command_tells_draws_and_converts_a_luminaire() {
    let dir = tempfile::tempdir().unwrap();
    let run =
        |args: &[&str]| Command::cargo_bin("clerestory").unwrap().current_dir(dir.path()).args(args).output().unwrap();
    let file = folder().join("wall_washer.ies");
    let out = run(&["luminaire", file.to_str().unwrap(), "--json", "-o", "told", "--to", "ldt"]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let found: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!((found["integrated_flux_lm"].as_f64().unwrap() / 2000.0 - 1.0).abs() < 2e-4);
    assert_eq!(found["rated_flux_lm"], 2000.0);
    assert_eq!(found["photometric_type"], "C");
    assert_eq!(found["symmetry"], "bilateral 0-180");
    assert!((found["downward_flux_share"].as_f64().unwrap() - 1.0).abs() < 1e-9);
    for name in ["wall_washer.ldt", "wall_washer_polar.png", "wall_washer_polar.svg"] {
        assert!(dir.path().join("told").join(name).exists(), "{name}");
    }
    let again = run(&["luminaire", "told/wall_washer.ldt"]);
    let text = String::from_utf8_lossy(&again.stdout).into_owned();
    assert!(text.contains("EULUMDAT") && text.contains("2000.0 lm"), "{text}");
    assert_eq!(run(&["luminaire", "none.ies"]).status.code(), Some(2));
}
