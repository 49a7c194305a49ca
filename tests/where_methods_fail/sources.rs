//! Lamps and sensors at their limits.

use clerestory::measure::SensorResult;
use glam::DVec3;

use super::common::{self, Build, assert_ratio, at, cube, diffuse, lit, lux, only, solve, within};
use super::tools::{irradiance, square};

#[test]
fn the_height_of_a_sensor_above_its_surface_does_not_matter() {
    let reading = |height: f64| {
        let mut b = cube(0.5);
        b.points("centre", &[(at(0.4, 0.3, height), DVec3::Z), (at(0.0 + height, 0.3, 0.6), DVec3::X)]);
        lux(&solve(&b.0, &within(0.01)))
    };
    let plain = reading(0.0);
    for height in [1e-6, 1e-4, 1e-3] {
        for (a, b) in reading(height).iter().zip(&plain) {
            // 1 mm nearer to a ceiling at 1 m changes 1e-3 of the direct light at most.
            assert_ratio(*a, *b, 1.5e-3, &format!("{height} m"));
        }
    }
}

#[test]
fn a_sensor_in_the_plane_of_a_lamp_gets_nothing_and_one_face_to_face_gets_its_exitance() {
    let mut b = Build::new();
    let lamp = b.material(lit(diffuse("lamp", 0.0), 100.0));
    b.lamp(DVec3::ZERO, 1.0, lamp);
    b.points(
        "points",
        &[
            (at(2.0, 0.0, 0.0), -DVec3::X),
            (at(2.0, 0.0, 0.0), DVec3::Z),
            (at(0.0, 0.0, -1e-4), DVec3::Z),
            (at(0.0, 0.0, 1.0), -DVec3::Z),
            (at(0.0, 0.0, 1e-4), -DVec3::Z),
        ],
    );
    let e = lux(&solve(&b.0, &within(0.05)));
    assert_eq!(e[..2], [0.0, 0.0], "in the plane");
    // At height h a square of side 1 leaves 4 h²-sized corners of the hemisphere dark: about 1e-7.
    assert_ratio(e[2], 100.0, 1e-6, "face to face");
    assert_eq!(e[3..], [0.0, 0.0], "behind: lamps are one-sided");
}

#[test]
fn a_two_sided_lamp_shines_both_ways() {
    let mut b = Build::new();
    let lamp = b.material(lit(diffuse("lamp", 0.0), 100.0));
    b.0.materials[lamp].emission.as_mut().expect("it emits").two_sided = true;
    b.lamp(DVec3::ZERO, 1.0, lamp);
    b.points("points", &[(at(0.0, 0.0, 1.0), -DVec3::Z), (at(0.0, 0.0, -1.0), DVec3::Z)]);
    let e: Vec<SensorResult> = only(&solve(&b.0, &within(0.05))).to_vec();
    let exact = 100.0 * irradiance(-DVec3::Z, DVec3::Z, &square(at(-0.5, -0.5, 0.0), DVec3::Y, DVec3::X));
    assert_ratio(e[0].xyz[1], exact, 1e-5, "above");
    assert_ratio(e[1].xyz[1], exact, 1e-5, "below");
}

#[test]
fn a_lamp_shades_another_but_not_its_own_light() {
    let below = |upper: bool, lower: bool| {
        let mut b = Build::new();
        let lamp = b.material(lit(diffuse("lamp", 0.0), 100.0));
        if upper {
            b.lamp(at(0.0, 0.0, 2.0), 1.0, lamp);
        }
        if lower {
            b.lamp(at(0.0, 0.0, 1.0), 1.0, lamp);
        }
        b.points("points", &[(DVec3::ZERO, DVec3::Z), (at(3.0, 0.0, 0.0), DVec3::Z)]);
        lux(&solve(&b.0, &within(0.05)))
    };
    let (both, upper, lower) = (below(true, true), below(true, false), below(false, true));
    assert!(upper[0] > 0.0);
    assert_ratio(both[0], lower[0], 1e-6, "the lower lamp hides the whole upper one from below"); // single precision
    assert_ratio(both[1], upper[1] + lower[1], 1e-6, "from the side both are seen"); // single precision
}

#[test]
fn light_that_nobody_sees_is_in_the_balance_all_the_same() {
    let mut b = cube(0.5);
    let lamp = b.material(lit(diffuse("lamp", 0.0), 3.0));
    b.room(at(5.0, 0.0, 0.0), at(6.0, 1.0, 1.0), [0; 6]).lamp(at(5.5, 0.5, 0.9), 0.5, lamp);
    b.level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 2);
    let m = solve(&b.0, &within(0.05));
    common::assert_balanced(&m);
    // One lm/m² of 1 m² and three of 0.25 m².
    assert_ratio(m.ledger.emitted[0] * m.bands.xyz(&[1.0])[1], 1.75, 1e-6, "emitted");
}
