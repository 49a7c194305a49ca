//! The boards of `experiments/ferren`: the files are those of the design, and the fronts see no light.

#[allow(dead_code, unreachable_pub, reason = "shared with the program that writes the files")]
#[path = "../experiments/ferren/main.rs"]
mod generator;

use std::path::PathBuf;

use clerestory::measure::{self, Silent, SolveOptions};
use clerestory::scene;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("experiments/ferren")
}

#[test]
fn the_files_are_those_of_the_design() {
    for design in [generator::design::louvre(), generator::design::backing()] {
        assert_eq!(design.points().len(), 60, "{}", design.name);
        for (ending, text) in generator::files(&design) {
            let there = std::fs::read_to_string(folder().join(format!("{}{ending}", design.name))).unwrap();
            assert_eq!(there, text, "run `cargo run --release --example ferren`");
        }
    }
}

#[test]
fn fronts_of_the_louvre_get_exactly_no_direct_light() {
    let mut scene = scene::load(&folder().join("louvre.toml")).unwrap();
    scene.views.clear();
    let m = measure::solve(&scene, &SolveOptions::default(), &Silent).unwrap();
    assert_eq!((m.grids[0].sensors.len(), m.bands.len()), (60, 41));
    for (i, s) in m.grids[0].sensors.iter().enumerate() {
        assert_eq!(s.direct_lx, 0.0, "point {i}");
        assert!(s.xyz[1] > 5.0, "point {i}: the colour that has bled there is light");
    }
}
