//! What no sensor feels costs nothing.

mod common;

use clerestory::measure::{Measurement, SolveOptions};
use common::{Build, Cover, at, diffuse, lit, paths, solve, within};
use glam::DVec3;

/// Rooms of 5 × 4 × 3 m in a row under one ceiling, joined by doors of 0.9 × 2.1 m, each with a lamp and a cupboard;
/// sensors in the first.
fn rooms(count: usize) -> Build {
    let mut b = Build::new();
    let (grey, white) = (b.material(diffuse("grey", 0.3)), b.material(diffuse("white", 0.7)));
    let lamp = b.material(lit(diffuse("lamp", 0.0), 3000.0));
    b.room(DVec3::ZERO, at(5.0 * count as f64, 4.0, 3.0), [white, white, white, white, grey, white]);
    for k in 0..count {
        let x = 5.0 * k as f64;
        if k > 0 {
            b.block(at(x - 0.05, 0.0, 0.0), at(x + 0.05, 1.5, 3.0), white);
            b.block(at(x - 0.05, 2.4, 0.0), at(x + 0.05, 4.0, 3.0), white);
            b.block(at(x - 0.05, 1.5, 2.1), at(x + 0.05, 2.4, 3.0), white);
        }
        b.lamp(at(x + 2.5, 2.0, 2.95), 1.0, lamp);
        b.block(at(x + 2.0, 3.2, 0.0), at(x + 3.0, 3.8, 1.8), grey);
    }
    b.level("first room", at(0.3, 0.3, 0.8), at(4.7, 3.0, 0.8), 6);
    b
}

fn count(m: &Measurement, name: &str) -> f64 {
    m.record.counts.iter().find(|c| c.0 == name).map_or(f64::NAN, |c| c.1 as f64)
}

#[test]
fn nine_rooms_that_no_sensor_sees_into_add_little_work_and_no_error() {
    let truth = solve(&rooms(10).0, &paths(32_768));
    let mut cover = Cover::default();
    for seed in 1..=2 {
        let options = SolveOptions { seed, ..within(0.05) };
        let (one, ten) = (solve(&rooms(1).0, &options), solve(&rooms(10).0, &options));
        cover.enter_pair(&ten.grids[0], &truth.grids[0], "point");
        let work = count(&ten, "rays") / count(&one, "rays");
        assert!(work <= 2.0, "{work} times the rays of one room");
        let share = count(&ten, "elements") / count(&ten, "elements_possible");
        assert!(share <= 0.2, "{share} of all elements");
    }
    cover.assert();
}
