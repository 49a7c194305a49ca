//! What must not change a result, or must change it in a known way.

mod common;

use clerestory::measure::{GridResult, Measurement};
use clerestory::scene::{Face, Scene};
use clerestory::spectrum::BandMode;
use common::{
    Build, Cover, assert_near, assert_ratio, at, cube, diffuse, furnished, lit, lux, only, painted, rgb, solve, within,
};
use glam::{DMat3, DVec3};

/// The furnished room with some sensors on its floor and in the air.
fn room() -> Build {
    let mut b = furnished();
    b.level("floor", at(0.3, 0.3, 0.0), at(3.7, 2.7, 0.0), 4);
    b.points(
        "air",
        &[(at(2.0, 1.0, 1.3), DVec3::Z), (at(0.5, 2.5, 2.0), DVec3::X), (at(3.5, 0.4, 0.9), at(1.0, 1.0, 1.0))],
    );
    b
}

/// Moves every point of a scene and turns every direction.
fn moved(scene: &Scene, point: impl Fn(DVec3) -> DVec3, direction: impl Fn(DVec3) -> DVec3) -> Scene {
    let mut scene = scene.clone();
    for f in &mut scene.faces {
        let vertices: Vec<DVec3> = f.vertices.iter().map(|p| point(*p)).collect();
        *f = Face::new(&vertices, f.material);
    }
    for s in scene.grids.iter_mut().flat_map(|g| &mut g.sensors) {
        (s.position, s.normal) = (point(s.position), direction(s.normal));
    }
    scene
}

fn all(m: &Measurement) -> Vec<f64> {
    m.grids.iter().flat_map(|g| &g.sensors).map(|s| s.xyz[1]).collect()
}

/// Largest difference of two runs, relative to the reading.
fn largest_change(a: &Measurement, b: &Measurement) -> f64 {
    let (a, b) = (all(a), all(b));
    assert_eq!(a.len(), b.len());
    let change = |(a, b): (&f64, &f64)| {
        assert!(a.is_finite() && b.is_finite(), "{a} {b}");
        (a - b).abs() / b.abs().max(1e-300)
    };
    a.iter().zip(&b).map(change).fold(0.0, f64::max)
}

fn agree(a: &Measurement, b: &Measurement, what: &str) {
    let mut cover = Cover::default();
    for (x, y) in a.grids.iter().zip(&b.grids) {
        cover.enter_pair(x, y, what);
    }
    cover.assert();
}

#[test]
fn the_unit_of_length_does_not_matter() {
    let scene = room().0;
    let plain = solve(&scene, &within(0.05));
    for scale in [1e-3, 1e3] {
        let scaled = solve(&moved(&scene, |p| p * scale, |n| n), &within(0.05));
        // Everything is brought to size one in double precision: rounding alone is left.
        let change = largest_change(&scaled, &plain);
        assert!(change <= 1e-9, "× {scale}: {change:e}");
    }
}

#[test]
fn world_coordinates_of_surveyors_do_not_matter() {
    let scene = room().0;
    let plain = solve(&scene, &within(0.05));
    let offset = at(500_000.0, 5_400_000.0, 100.0);
    let change = largest_change(&solve(&moved(&scene, |p| p + offset, |n| n), &within(0.05)), &plain);
    // Doubles near 5.4e6 m are 1e-9 m apart, 2e-10 of the room: some rays round to another single.
    assert!(change <= 1e-6, "{change:e}");
}

#[test]
fn turning_the_scene_changes_nothing_beyond_the_errors() {
    let scene = room().0;
    let turn = DMat3::from_axis_angle(at(0.3, -0.5, 0.8).normalize(), 0.7);
    let turned = moved(&scene, |p| turn * p, |n| turn * n);
    agree(&solve(&turned, &within(0.05)), &solve(&scene, &within(0.05)), "turned");
}

#[test]
fn doubling_every_lamp_doubles_every_reading() {
    let scene = room().0;
    let plain = solve(&scene, &within(0.05));
    let mut brighter = scene.clone();
    for m in &mut brighter.materials {
        if let Some(e) = &mut m.emission {
            e.radiance = e.radiance.scaled(2.0);
        }
    }
    let double = solve(&brighter, &within(0.05));
    for (two, one) in all(&double).iter().zip(all(&plain)) {
        // Two is a power of two: every product and sum doubles exactly.
        assert_ratio(*two, 2.0 * one, 1e-12, "doubled");
    }
}

/// A grey room with two lamps, either of which may be dark.
fn two_lamps(exitances: [f64; 2]) -> Scene {
    let mut b = Build::new();
    let wall = b.material(diffuse("wall", 0.6));
    b.room(DVec3::ZERO, at(4.0, 3.0, 2.5), [wall; 6]);
    for (x, exitance) in [0.9, 3.1].into_iter().zip(exitances) {
        let lamp = b.material(lit(diffuse("lamp", 0.0), exitance));
        b.lamp(at(x, 1.5, 2.4), 0.6, lamp);
    }
    b.level("floor", at(0.3, 0.3, 0.0), at(3.7, 2.7, 0.0), 4);
    b.0
}

#[test]
fn two_lamps_give_the_sum_of_each() {
    let run = |e| solve(&two_lamps(e), &within(0.03));
    let (both, first, second) = (run([2000.0, 500.0]), run([2000.0, 0.0]), run([0.0, 500.0]));
    let mut cover = Cover::default();
    for ((s, a), b) in only(&both).iter().zip(only(&first)).zip(only(&second)) {
        let error = (s.error_lx.powi(2) + a.error_lx.powi(2) + b.error_lx.powi(2)).sqrt();
        cover.enter(s.xyz[1], error, 0.0, a.xyz[1] + b.xyz[1], "both lamps");
    }
    cover.assert();
}

#[test]
fn the_order_of_faces_changes_nothing_beyond_the_errors() {
    let scene = room().0;
    let mut other = scene.clone();
    other.faces.reverse();
    other.faces.rotate_left(5);
    agree(&solve(&other, &within(0.05)), &solve(&scene, &within(0.05)), "reordered");
}

#[test]
fn another_seed_moves_numbers_by_less_than_the_stated_errors() {
    let scene = room().0;
    let run = |seed| {
        let mut options = within(0.05);
        options.seed = seed;
        solve(&scene, &options)
    };
    let (mut seen, mut inside) = (0, 0);
    let runs: Vec<Measurement> = (1..=3).map(run).collect();
    for (a, b) in [(0, 1), (1, 2), (0, 2)] {
        let sensors = |m: &Measurement| m.grids.iter().flat_map(|g: &GridResult| g.sensors.clone()).collect::<Vec<_>>();
        for (a, b) in sensors(&runs[a]).iter().zip(sensors(&runs[b])) {
            seen += 1;
            inside += usize::from((a.xyz[1] - b.xyz[1]).abs() <= a.error_lx + b.error_lx);
        }
    }
    // The sum of two 95 % half-widths is 1.4 times the half-width of the difference.
    assert!(inside * 20 >= seen * 19, "{inside} of {seen}");
    assert!(all(&runs[0]) != all(&runs[1]), "another seed is another run");
}

#[test]
fn threads_and_repetition_change_no_bit() {
    let scene = room().0;
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let m = pool.install(|| solve(&scene, &within(0.08)));
        let bits: Vec<[u64; 4]> = m
            .grids
            .iter()
            .flat_map(|g| &g.sensors)
            .map(|s| [s.xyz[0], s.xyz[1], s.xyz[2], s.error_lx].map(f64::to_bits))
            .collect();
        let ledger: Vec<u64> = m.ledger.absorbed.iter().chain(&m.ledger.escaped).map(|x| x.to_bits()).collect();
        (bits, ledger)
    };
    let one = run(1);
    assert!(one == run(2), "two threads");
    assert!(one == run(2), "two threads again");
    assert!(one == run(5), "five threads");
}

/// The unit cube with reflectance 0.5, its ceiling emitting `exitance`.
fn cube_of(exitance: f64) -> Scene {
    let mut b = cube(0.5);
    b.0.materials[1].emission = Some(common::white(exitance));
    b.level("floor", at(0.0, 0.0, 0.0), at(1.0, 1.0, 0.0), 3);
    b.0
}

#[test]
fn faint_and_fierce_light_give_the_same_picture() {
    let plain = lux(&solve(&cube_of(1.0), &within(0.05)));
    for exitance in [1e-30, 1e30] {
        let m = solve(&cube_of(exitance), &within(0.05));
        for ((s, one), i) in only(&m).iter().zip(&plain).zip(0..) {
            // Single precision keeps 24 bits at any magnitude between its limits.
            assert_ratio(s.xyz[1] / exitance, *one, 1e-6, &format!("{exitance:e}, sensor {i}"));
            assert!(s.error_lx > 0.0 && s.error_lx < 0.2 * s.xyz[1], "{exitance:e}: error {}", s.error_lx);
        }
    }
}

#[test]
fn faint_and_fierce_light_give_the_same_spectra() {
    let mut options = within(0.05);
    options.spectral = true;
    let run = |exitance| solve(&cube_of(exitance), &options);
    let plain = run(1.0);
    for exitance in [1e-30, 1e30] {
        let m = run(exitance);
        for (s, one) in only(&m).iter().zip(only(&plain)) {
            let (a, b) = (s.spectral[0], one.spectral[0]);
            // As for illuminance; the error's sum of squares must neither vanish nor overflow.
            assert_ratio(a.irradiance / exitance, b.irradiance, 1e-6, &format!("{exitance:e}"));
            assert_ratio(a.error / exitance, b.error, 1e-3, &format!("{exitance:e}, error"));
        }
    }
}

#[test]
fn unlike_bands_read_as_each_would_alone() {
    let rho = [0.95, 0.5, 0.0];
    let scene = |rho: [f64; 3]| {
        let mut b = Build::new();
        let wall = b.material(painted("wall", rgb(rho)));
        let mut ceiling = painted("ceiling", rgb(rho));
        ceiling.emission = Some(common::white(1.0));
        let ceiling = b.material(ceiling);
        b.room(DVec3::ZERO, DVec3::ONE, [wall, wall, wall, wall, wall, ceiling]);
        b.bands(BandMode::Rgb).level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 3);
        b.0
    };
    let mut options = within(0.05);
    options.spectral = true;
    let together = solve(&scene(rho), &options);
    for (band, r) in rho.into_iter().enumerate() {
        let alone = solve(&scene([r; 3]), &options);
        let mut cover = Cover::default();
        for (a, b) in only(&together).iter().zip(only(&alone)) {
            let (a, b) = (a.spectral[band], b.spectral[band]);
            cover.enter(a.irradiance, a.error.hypot(b.error), 0.0, b.irradiance, format!("band {band}"));
        }
        cover.assert();
    }
}

#[test]
fn a_grey_scene_reads_the_same_in_one_band_and_in_sixteen() {
    let scene = |bands| {
        let mut b = cube(0.7);
        b.bands(bands).level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 3);
        b.0
    };
    let one = solve(&scene(BandMode::Grey), &within(0.05));
    let sixteen = solve(&scene(BandMode::Step { step_nm: 20.0, lo_nm: 400.0, hi_nm: 720.0 }), &within(0.05));
    assert_eq!(sixteen.bands.len(), 16);
    // Equal energy in 400 to 720 nm carries this share of the luminance; the rays are the same, so what is left is
    // rounding of 16 single-precision sums.
    let share = sixteen.bands.xyz(&[1.0; 16])[1] / one.bands.xyz(&[1.0])[1];
    for (a, b) in lux(&sixteen).iter().zip(lux(&one)) {
        assert_ratio(*a, share * b, 1e-5, "sixteen bands");
    }
    assert_near(share, 1.0, 1e-3, "nearly all of the light is between 400 and 720 nm");
}
