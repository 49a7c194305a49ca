//! Translucent sheets: what arrives on one side leaves both.

mod common;

use std::f64::consts::PI;

use clerestory::light::configuration_factor;
use clerestory::measure::{Measurement, Method, SolveOptions};
use clerestory::scene::{Material, MaterialKind, Projection, View};
use clerestory::spectrum::{BandMode, SpectralValue};
use common::{
    Build, Cover, assert_balanced, assert_ratio, at, diffuse, glass, lit, lux, mirror, only, paths, rgb, solve, white,
    within,
};
use glam::DVec3;

fn sheet(reflectance: SpectralValue, transmittance: SpectralValue) -> Material {
    let kind = MaterialKind::Translucent {
        front: reflectance.clone(),
        back: reflectance,
        transmittance,
        maintenance_factor: 1.0,
    };
    Material { name: "sheet".into(), kind, emission: None, outside: false }
}

fn grey_sheet(reflectance: f64, transmittance: f64) -> Material {
    sheet(SpectralValue::Grey(reflectance), SpectralValue::Grey(transmittance))
}

/// Radiosities of endless parallel plates at heights 0, 1 and 2: the lowest emits `m` and has reflectance `low`, the middle
/// one is a sheet of (reflectance, transmittance), the highest has reflectance `high`. What arrives on the lowest, on the
/// sheet from below and above, on the highest.
fn plates(m: f64, low: f64, (rho, tau): (f64, f64), high: f64) -> [f64; 4] {
    // B1 = m + low·B2; B2 = ρ B1 + τ B4; B3 = ρ B4 + τ B1; B4 = high·B3.
    // From the last two: B4 = high τ B1/(1 − high ρ).
    let up = high * tau / (1.0 - high * rho);
    let b1 = m / (1.0 - low * (rho + tau * up));
    let b4 = up * b1;
    [rho * b1 + tau * b4, b1, b4, rho * b4 + tau * b1]
}

/// The plates between four perfect mirrors: endless.
fn tower(low: f64, middle: Material, high: f64) -> Build {
    let mut b = Build::new();
    let [pane, lamp, sky] = [mirror(1.0), lit(diffuse("lamp", low), 1000.0), diffuse("top", high)];
    let [pane, lamp, top, middle] = [pane, lamp, sky, middle].map(|m| b.material(m));
    b.room(DVec3::ZERO, at(1.0, 1.0, 2.0), [pane, pane, pane, pane, lamp, top]);
    b.rectangle(at(0.0, 0.0, 1.0), DVec3::X, DVec3::Y, middle);
    let place = |z: f64, n: DVec3| (at(0.4, 0.7, z), n);
    b.points("heights", &[place(0.0, DVec3::Z), place(1.0, -DVec3::Z), place(1.0, DVec3::Z), place(2.0, -DVec3::Z)]);
    b
}

#[test]
fn endless_plates_about_a_sheet_match_the_closed_form_by_both_methods() {
    for (low, (rho, tau), high) in [(0.5, (0.3, 0.6), 0.8), (0.0, (0.0, 1.0), 0.9), (0.7, (0.6, 0.2), 0.0)] {
        let b = tower(low, grey_sheet(rho, tau), high);
        let exact = plates(1000.0, low, (rho, tau), high);
        let quick = solve(&b.0, &within(0.02));
        assert_balanced(&quick);
        let judge = solve(&b.0, &paths(1 << 14));
        for (m, what) in [(&quick, "elements"), (&judge, "paths")] {
            let mut cover = Cover::default();
            cover.enter_all(m, &exact, what);
            cover.assert();
            for (found, exact) in lux(m).iter().zip(exact) {
                // Also wide errors must not hide a wrong value.
                assert_ratio(*found, exact, 0.05, what);
            }
        }
    }
}

#[test]
fn bands_pass_each_on_its_own() {
    let (rho, tau) = ([0.1, 0.5, 0.2], [0.8, 0.1, 0.4]);
    let mut b = tower(0.5, sheet(rgb(rho), rgb(tau)), 0.6);
    b.bands(BandMode::Rgb);
    let m = solve(&b.0, &SolveOptions { spectral: true, ..within(0.02) });
    assert_balanced(&m);
    let emitted = m.bands.radiance(&white(1000.0).radiance);
    let mut cover = Cover::default();
    for band in 0..3 {
        let exact = plates(PI * emitted[band], 0.5, (rho[band], tau[band]), 0.6);
        for (s, exact) in only(&m).iter().zip(exact) {
            let found = s.spectral[band];
            cover.enter(found.irradiance, found.error, 0.0, exact, format!("band {band}"));
            assert_ratio(found.irradiance, exact, 0.05, "band");
        }
    }
    cover.assert();
}

/// A room of black walls that give off 1000 lm/m², and a dark black one beyond a sheet of 2 × 2 m at x = 2.
fn two_rooms() -> Build {
    let mut b = Build::new();
    let (bright, dark) = (b.material(lit(diffuse("bright", 0.0), 1000.0)), b.material(diffuse("dark", 0.0)));
    let wall = b.material(grey_sheet(0.4, 0.5));
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    for (from, m) in [(0.0, bright), (2.0, dark)] {
        b.rectangle(at(from, 0.0, 0.0), 2.0 * x, 2.0 * y, m);
        b.rectangle(at(from, 0.0, 2.0), 2.0 * y, 2.0 * x, m);
        b.rectangle(at(from, 0.0, 0.0), 2.0 * z, 2.0 * x, m);
        b.rectangle(at(from, 2.0, 0.0), 2.0 * x, 2.0 * z, m);
    }
    b.rectangle(DVec3::ZERO, 2.0 * y, 2.0 * z, bright);
    b.rectangle(at(4.0, 0.0, 0.0), 2.0 * z, 2.0 * y, dark);
    b.rectangle(at(2.0, 0.0, 0.0), 2.0 * y, 2.0 * z, wall);
    b
}

/// Configuration factor of the sheet of [`two_rooms`].
fn of_sheet(p: DVec3, n: DVec3) -> f64 {
    let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)];
    configuration_factor(&corners.map(|(y, z)| at(2.0, y, z) - p), n)
}

#[test]
fn two_rooms_joined_by_a_sheet_share_the_light_of_one() {
    let mut b = two_rooms();
    // The sheet sees nothing but 1000 lm/m² on one side, nothing on the other: exitance 400 and 500 lm/m².
    let beyond = [at(2.05, 1.0, 1.0), at(2.5, 0.5, 1.0), at(3.0, 1.0, 0.8), at(3.9, 1.5, 0.4)].map(|p| (p, -DVec3::X));
    let before = [at(1.95, 1.0, 1.0), at(1.0, 0.5, 1.2)].map(|p| (p, DVec3::X));
    b.points("both", &[beyond.as_slice(), before.as_slice()].concat());
    let exact: Vec<f64> = beyond
        .iter()
        .map(|(p, n)| 500.0 * of_sheet(*p, *n))
        .chain(before.iter().map(|(p, n)| {
            let f = of_sheet(*p, *n);
            400.0 * f + 1000.0 * (1.0 - f)
        }))
        .collect();
    for options in [within(0.02), paths(1 << 14)] {
        let m = solve(&b.0, &options);
        let mut cover = Cover::default();
        cover.enter_all(&m, &exact, &m.record.method);
        cover.assert();
        for (found, exact) in lux(&m).iter().zip(&exact) {
            assert_ratio(*found, *exact, 0.05, &m.record.method);
        }
    }
}

#[test]
fn a_picture_shows_the_light_that_comes_through() {
    let mut b = two_rooms();
    b.0.views.push(View {
        name: "sheet".into(),
        position: at(3.5, 1.0, 1.0),
        direction: -DVec3::X,
        up: DVec3::Z,
        projection: Projection::Perspective { horizontal: 0.5, vertical: 0.5 },
        width: 4,
        height: 4,
    });
    for options in [within(0.05), paths(4096)] {
        let m = solve(&b.0, &options);
        for pixel in &m.views[0].xyz {
            // Four sets of rays upon emitters all around: the noise is that of the elements, 5 %.
            assert_ratio(f64::from(pixel[1]), 500.0 / PI, 0.05, &m.record.method);
        }
    }
}

#[test]
fn a_furnace_does_not_notice_a_sheet_that_absorbs_nothing() {
    let mut b = Build::new();
    let wall = b.material(lit(diffuse("wall", 0.5), 500.0));
    b.room(DVec3::ZERO, at(3.0, 2.0, 2.0), [wall; 6]);
    let thing = b.material(grey_sheet(0.3, 0.7));
    b.rectangle(at(1.6, 0.2, 0.3), DVec3::Y * 1.5, DVec3::Z * 1.4, thing);
    let points = [(0.5, 1.0, 1.0), (1.5, 1.0, 1.0), (1.7, 1.0, 1.0), (2.8, 0.3, 0.2)].map(|(x, y, z)| at(x, y, z));
    b.points("air", &points.map(|p| (p, DVec3::X)));
    let m = solve(&b.0, &within(0.02));
    assert_balanced(&m);
    let mut cover = Cover::default();
    cover.enter_all(&m, &[1000.0; 4], "furnace");
    cover.assert();
}

/// A lamp in a closed box of one material, read from outside.
fn boxed(case: Material) -> Measurement {
    let mut b = Build::new();
    let (case, lamp, plate) =
        (b.material(case), b.material(lit(diffuse("lamp", 0.0), 1000.0)), b.material(diffuse("plate", 0.0)));
    b.block(at(0.0, 0.0, 1.0), at(1.0, 1.0, 2.0), case);
    b.lamp(at(0.5, 0.5, 1.5), 0.4, lamp);
    b.rectangle(at(-2.0, -2.0, 0.0), DVec3::X * 5.0, DVec3::Y * 5.0, plate);
    b.points("below", &[(at(0.5, 0.5, 0.0), DVec3::Z)]);
    solve(&b.0, &within(0.05))
}

#[test]
fn a_closed_case_that_lets_light_through_is_not_taken_for_a_solid() {
    assert_eq!(lux(&boxed(diffuse("case", 0.5)))[0], 0.0);
    for case in [grey_sheet(0.3, 0.6), glass(0.8)] {
        let name = case.name.clone();
        let m = boxed(case);
        assert_balanced(&m);
        assert!(lux(&m)[0] > 1.0, "{name}: {}", lux(&m)[0]);
    }
}

#[test]
fn classic_methods_refuse_sheets() {
    let b = tower(0.5, grey_sheet(0.4, 0.5), 0.5);
    let options = SolveOptions { method: Method::FullMatrix, ..within(0.05) };
    let error = clerestory::measure::solve(&b.0, &options, &clerestory::measure::Silent).unwrap_err().to_string();
    assert!(error.contains("opaque diffuse surfaces alone"), "{error}");
}
