//! Halls with many lamps: far ones are judged in clusters and drawn, small ones are asked by a ray.

#[path = "common/mod.rs"]
mod common;
#[path = "../experiments/steel-mill/files.rs"]
#[allow(dead_code, unreachable_pub, reason = "a test takes what it needs")]
mod files;
#[path = "../experiments/steel-mill/hall.rs"]
#[allow(dead_code, unreachable_pub, reason = "a test takes what it needs")]
mod hall;
#[path = "../experiments/steel-mill/parts.rs"]
#[allow(dead_code, unreachable_pub, reason = "a test takes what it needs")]
mod parts;

use clerestory::measure::{Measurement, Method, SolveOptions};
use clerestory::scene::{Build, Scene, load};
use common::{at, diffuse, lit, solve, within};

/// A hall of 24 by 24 by 4 m under 15 by 15 lamps of 0.1 m, with blocks on its floor.
fn hall_of_225_lamps() -> Scene {
    let mut b = Build::new();
    let wall = b.material(diffuse("wall", 0.5));
    let lamp = b.material(lit(diffuse("lamp", 0.5), 2e5));
    b.room(at(0.0, 0.0, 0.0), at(24.0, 24.0, 4.0), [wall; 6]);
    let place = |k: u32| 0.8 + 1.6 * f64::from(k);
    for k in 0..225 {
        b.lamp(at(place(k % 15), place(k / 15), 3.9), 0.1, lamp);
    }
    for k in 0..9 {
        let low = at(3.0 + 7.0 * f64::from(k % 3), 3.0 + 7.0 * f64::from(k / 3), 0.0);
        b.block(low, low + at(2.0, 1.0, 1.8), wall);
    }
    b.level("floor", at(0.5, 0.5, 0.0), at(23.5, 23.5, 0.0), 6);
    b.0
}

#[test]
fn lamps_drawn_from_clusters_give_the_light_that_path_tracing_finds() {
    let scene = hall_of_225_lamps();
    let found = solve(&scene, &within(0.05));
    let judge = SolveOptions { method: Method::PathTracing, paths: Some(1 << 15), ..within(0.01) };
    let judge = solve(&scene, &judge);
    let pairs: Vec<_> = found.grids[0].sensors.iter().zip(&judge.grids[0].sensors).collect();
    let inside = pairs.iter().filter(|(a, b)| (a.xyz[1] - b.xyz[1]).abs() <= a.error_lx.hypot(b.error_lx)).count();
    // Of 36 points at 95 %, 30 or fewer inside have a chance of 1e-3.
    assert!(inside > 30, "{inside} of {} points within the stated errors", pairs.len());
    let mean = |m: &Measurement| {
        let sensors = &m.grids[0].sensors;
        sensors.iter().map(|s| s.reflected_lx).sum::<f64>() / sensors.len() as f64
    };
    let (reflected, judged) = (mean(&found), mean(&judge));
    // The points share elements, so their errors are alike: the median stated error bounds that of their mean.
    let mut errors: Vec<f64> = pairs.iter().map(|(a, _)| a.error_lx).collect();
    errors.sort_by(f64::total_cmp);
    assert!((reflected - judged).abs() < errors[errors.len() / 2], "{reflected} lx against {judged} lx");
}

#[test]
fn a_bay_of_the_mill_takes_no_more_work_than_it_did() {
    let dir = tempfile::tempdir().expect("a folder");
    let size = hall::Size { aisles: 1, bays: 1 };
    let (polygons, text) = files::obj(size);
    assert_eq!(polygons, 1628);
    std::fs::write(dir.path().join("hall.obj"), text).expect("a file");
    std::fs::write(dir.path().join("scene.toml"), files::scene(size, None)).expect("a file");
    let scene = load(&dir.path().join("scene.toml")).expect("a sound scene");
    let m = solve(&scene, &within(0.05));
    let count = |name: &str| m.record.counts.iter().find(|(k, _)| k == name).map_or(0, |(_, n)| *n);
    // A tenth above what they were for 11,315 elements, their twins and 240 points.
    assert!(count("rays") < 1_220_000 && count("form_factors") < 8_000, "{:?}", m.record.counts);
}
