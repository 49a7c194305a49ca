//! Memory is planned before it is taken.

#[path = "common/mod.rs"]
mod common;

use assert_cmd::Command;
use clerestory::measure::{GridResult, SolveOptions, parse_size};
use clerestory::scene::Scene;
use common::{diffuse, lit, solve, within};
use glam::DVec3;

/// A room with a lamp and boxes in it, and bands enough for two blocks.
fn room() -> Scene {
    let mut b = clerestory::scene::Build::new();
    let wall = b.material(diffuse("wall", 0.5));
    let lamp = b.material(lit(diffuse("lamp", 0.5), 3000.0));
    b.room(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.7), [wall; 6]);
    b.lamp(DVec3::new(2.0, 1.5, 2.6), 0.6, lamp);
    for k in 0..4 {
        let low = DVec3::new(0.4 + 0.9 * f64::from(k), 1.0, 0.0);
        b.block(low, low + DVec3::new(0.4, 0.5, 0.6), wall);
    }
    b.level("floor", DVec3::new(0.2, 0.2, 0.0), DVec3::new(3.8, 0.9, 0.0), 6);
    b.bands(clerestory::spectrum::BandMode::Edges((0..=12).map(|k| 400.0 + 25.0 * f64::from(k)).collect()));
    b.0
}

fn readings(grids: &[GridResult]) -> Vec<[f64; 2]> {
    grids.iter().flat_map(|g| &g.sensors).map(|s| [s.xyz[1], s.error_lx]).collect()
}

#[test]
fn a_limit_that_is_kept_changes_no_reading() {
    let scene = room();
    let free = solve(&scene, &within(0.1));
    let planned = free.record.planned_bytes.expect("a plan");
    // Less than the fastest way takes: one block of bands after the other.
    let narrow = SolveOptions { max_memory: Some(planned - 1), ..within(0.1) };
    let kept = solve(&scene, &narrow);
    assert!(kept.record.planned_bytes.is_some_and(|p| p < planned));
    assert_eq!(readings(&kept.grids), readings(&free.grids));
}

#[test]
fn too_small_a_limit_says_what_needs_how_much() {
    let tight = SolveOptions { max_memory: Some(57_000_000), ..within(0.01) };
    let error = clerestory::measure::solve(&room(), &tight, &clerestory::measure::Silent).expect_err("too little");
    let told = error.to_string();
    assert!(error.is_input(), "{told}");
    for part in ["elements in 12 bands need", "--max-memory allows 57.0MB", "mend: allow more (--max-memory "] {
        assert!(told.contains(part), "{told}");
    }
    let tighter = SolveOptions { max_memory: Some(1000), ..within(0.01) };
    let error = clerestory::measure::solve(&room(), &tighter, &clerestory::measure::Silent).expect_err("too little");
    assert!(error.to_string().contains("scene, sensors and pictures alone need"));
}

/// The plan is of the most: it may tell up to this much more than is taken, here where a third of it is the program.
const MOST_OVER: f64 = 2.5;

#[test]
fn the_peak_is_not_above_the_plan_nor_far_below_it() {
    if !cfg!(target_os = "linux") {
        return; // other systems do not tell
    }
    let dir = tempfile::tempdir().expect("a folder");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/validation/cornell/scene.toml");
    let out = dir.path().join("out");
    let mut command = Command::cargo_bin("clerestory").expect("the program");
    command.args(["solve", scene, "--tolerance", "5%", "--quiet", "--max-memory", "2GB", "-o"]).arg(&out);
    command.assert().success();
    let text = std::fs::read_to_string(out.join("run.json")).expect("a record");
    let record: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let memory = |key: &str| record["memory"][key].as_f64().expect("a number");
    let (planned, peak) = (memory("planned_bytes"), memory("peak_bytes"));
    assert_eq!(memory("max_bytes"), 2e9);
    assert!(peak <= planned && planned <= MOST_OVER * peak, "planned {planned}, taken {peak}");
}

#[test]
fn a_size_without_sense_is_refused() {
    assert!(parse_size("many").is_err());
}
