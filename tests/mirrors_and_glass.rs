//! Mirrors show the room again; panes pass what they are said to pass.

mod common;

use clerestory::light::configuration_factor;
use common::{
    Build, Cover, assert_balanced, assert_near, assert_ratio, at, diffuse, glass, lit, lux, mirror, only, solve, within,
};
use glam::DVec3;

/// Sensors in the part of the room that both versions have.
fn sensors(b: &mut Build) {
    b.level("floor", at(0.1, 0.1, 0.0), at(1.9, 1.9, 0.0), 3);
    b.points(
        "air",
        &[
            (at(1.9, 1.0, 1.0), DVec3::X),
            (at(1.9, 1.0, 1.0), -DVec3::X),
            (at(0.5, 0.5, 1.2), at(1.0, 1.0, -1.0)),
            (at(0.0, 1.0, 1.0), DVec3::X),
        ],
    );
}

#[test]
fn a_perfect_mirror_doubles_the_room() {
    let mut one = Build::new();
    let (wall, lamp) = (one.material(diffuse("wall", 0.6)), one.material(lit(diffuse("lamp", 0.0), 1000.0)));
    let pane = one.material(mirror(1.0));
    one.room(DVec3::ZERO, at(2.0, 2.0, 2.0), [wall, pane, wall, wall, wall, wall]);
    one.lamp(at(0.7, 1.2, 1.9), 0.5, lamp).block(at(0.3, 0.3, 0.0), at(0.8, 0.7, 0.9), wall);
    sensors(&mut one);
    let mut two = Build::new();
    let (wall, lamp) = (two.material(diffuse("wall", 0.6)), two.material(lit(diffuse("lamp", 0.0), 1000.0)));
    two.room(DVec3::ZERO, at(4.0, 2.0, 2.0), [wall; 6]);
    two.lamp(at(0.7, 1.2, 1.9), 0.5, lamp).block(at(0.3, 0.3, 0.0), at(0.8, 0.7, 0.9), wall);
    two.lamp(at(3.3, 1.2, 1.9), 0.5, lamp).block(at(3.2, 0.3, 0.0), at(3.7, 0.7, 0.9), wall);
    sensors(&mut two);
    let (one, two) = (solve(&one.0, &within(0.03)), solve(&two.0, &within(0.03)));
    assert_balanced(&one);
    let mut cover = Cover::default();
    for (a, b) in one.grids.iter().zip(&two.grids) {
        cover.enter_pair(a, b, &a.name);
    }
    cover.assert();
}

#[test]
fn a_mirror_shows_a_lamp_at_its_reflectance() {
    for rho in [0.5, 0.9] {
        let mut b = Build::new();
        let (pane, lamp) = (b.material(mirror(rho)), b.material(lit(diffuse("lamp", 0.0), 1000.0)));
        // A wide mirror in the plane x = 0; a lamp beside it; nothing else.
        b.rectangle(at(0.0, -3.0, -3.0), DVec3::Y * 6.0, DVec3::Z * 6.0, pane);
        b.lamp(at(1.0, 0.0, 1.0), 0.6, lamp);
        let places = [(0.5, 0.0), (1.0, 0.5), (0.3, -0.4), (1.5, 0.2)].map(|(x, y)| at(x, y, 0.0));
        b.points("below", &places.map(|p| (p, DVec3::Z)));
        let m = solve(&b.0, &within(0.01));
        let from = |x: f64, p: DVec3| {
            let corners = [(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3)];
            configuration_factor(&corners.map(|(u, v)| at(x + u, v, 1.0) - p), DVec3::Z)
        };
        let truth = places.map(|p| 1000.0 * (from(1.0, p) + rho * from(-1.0, p)));
        let mut cover = Cover::default();
        cover.enter_all(&m, &truth, &format!("ρ = {rho}"));
        cover.assert();
        for (s, t) in only(&m).iter().zip(truth) {
            // Ten times the tolerance: also wide errors must not hide a wrong value.
            assert_ratio(s.xyz[1], t, 0.1, "image of the lamp");
        }
    }
}

#[test]
fn a_pane_passes_its_transmittance_at_normal_incidence() {
    let reading = |pane: Option<f64>| {
        let mut b = Build::new();
        let lamp = b.material(lit(diffuse("lamp", 0.0), 1e6));
        b.lamp(at(0.0, 0.0, 3.0), 0.05, lamp);
        let other = b.material(glass(pane.unwrap_or(0.5)));
        if pane.is_some() {
            b.rectangle(at(-1.0, -1.0, 1.5), DVec3::X * 2.0, DVec3::Y * 2.0, other);
        }
        b.points("below", &[(DVec3::ZERO, DVec3::Z)]);
        lux(&solve(&b.0, &within(0.01)))[0]
    };
    let open = reading(None);
    for t in [0.88, 0.5, 0.1] {
        // Within 0.7° of the normal the transmittance changes by less than 1e-5.
        assert_ratio(reading(Some(t)), t * open, 1e-4, &format!("pane of {t}"));
    }
}

#[test]
fn two_panes_pass_the_product_and_what_goes_to_and_fro() {
    let mut b = Build::new();
    let (lamp, pane) = (b.material(lit(diffuse("lamp", 0.0), 1000.0)), b.material(glass(0.8)));
    b.lamp(at(0.0, 0.0, 1.0), 20.0, lamp);
    for z in [0.3, 0.6] {
        b.rectangle(at(-9.0, -9.0, z), DVec3::X * 18.0, DVec3::Y * 18.0, pane);
    }
    b.points("below", &[(DVec3::ZERO, DVec3::Z)]);
    let m = solve(&b.0, &within(0.02));
    let s = &only(&m)[0];
    // Direct light through two panes has at most the square of the normal transmittance, and light that goes to and
    // fro between them adds to it; both together stay below one pane.
    assert!(s.direct_lx <= 0.64 * 1000.0 + s.error_lx, "{}", s.direct_lx);
    assert!(s.xyz[1] > s.direct_lx && s.xyz[1] < 0.8 * 1000.0, "{} {}", s.xyz[1], s.direct_lx);
}

/// A closed room in which 1000 lm/m² leave every wall (reflectance ρ, exitance 1 − ρ), with something in its middle.
fn furnace_with(rho: f64, thing: clerestory::scene::Material) -> Build {
    let mut b = Build::new();
    let wall = b.material(lit(diffuse("wall", rho), 1000.0 * (1.0 - rho)));
    b.room(DVec3::ZERO, at(3.0, 2.0, 2.0), [wall; 6]);
    let thing = b.material(thing);
    b.rectangle(at(1.6, 0.2, 0.3), DVec3::Y * 1.5, DVec3::Z * 1.4, thing);
    let points = [(0.5, 1.0, 1.0), (1.5, 1.0, 1.0), (1.7, 1.0, 1.0), (2.8, 0.3, 0.2)].map(|(x, y, z)| at(x, y, z));
    let ways = [DVec3::X, -DVec3::X, DVec3::Z];
    let all: Vec<(DVec3, DVec3)> = points.iter().flat_map(|p| ways.map(|n| (*p, n))).collect();
    b.points("air", &all);
    b
}

#[test]
fn a_furnace_does_not_notice_what_absorbs_nothing() {
    // A pane that absorbs nothing passes (1 − r)/(1 + r) at normal incidence, r = ((n − 1)/(n + 1))².
    let r: f64 = (0.52f64 / 2.52).powi(2);
    for thing in [mirror(1.0), glass((1.0 - r) / (1.0 + r))] {
        let name = thing.name.clone();
        let b = furnace_with(0.5, thing);
        let m = solve(&b.0, &within(0.02));
        assert_balanced(&m);
        let mut cover = Cover::default();
        cover.enter_all(&m, &[1000.0; 12], &name);
        cover.assert();
        let mean = lux(&m).iter().sum::<f64>() / 12.0;
        // A dozen readings that each hold 2 %.
        assert_near(mean, 1000.0, 20.0 / 12f64.sqrt(), &name);
    }
}

#[test]
fn a_furnace_loses_light_in_a_pane_that_absorbs() {
    let m = solve(&furnace_with(0.5, glass(0.5)).0, &within(0.05));
    assert_balanced(&m);
    assert!(lux(&m).iter().all(|e| *e < 1000.0), "{:?}", lux(&m));
}
