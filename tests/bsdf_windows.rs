//! Windows with a BSDF: against sheets that do the same, sums of their own, path tracing, and where the light goes.

mod common;

use std::f64::consts::PI;

use clerestory::light::configuration_factor;
use clerestory::measure::{Measurement, SensorResult};
use clerestory::scene::bsdf::{Bsdf, KlemsBasis, Passage, PatchFinder};
use clerestory::scene::{Material, MaterialKind, Projection, SkyName, View};
use clerestory::spectrum::SpectralValue;
use common::bsdf::{day, lambertian, office, slats, slats_value, window};
use common::{
    Build, Cover, assert_balanced, assert_ratio, at, diffuse, glass, lux, mirror, only, paths, refusal, rgb, solve,
    within,
};
use glam::DVec3;

const PAINT: [f64; 3] = [0.2, 0.5, 0.8];
const BLACK: [f64; 3] = [0.0; 3];
/// Altitude and azimuth of the sun: it shines on the window from the left.
const SUN: (f64, f64) = (40.0, 200.0);

fn desks(b: &mut Build, n: usize) {
    b.level("desks", at(0.25, 0.5, 0.8), at(3.75, 5.5, 0.8), n);
}

fn translucent(tau: f64, rho: f64) -> Material {
    let [rho, tau] = [rho, tau].map(SpectralValue::Grey);
    let kind = MaterialKind::Translucent { front: rho.clone(), back: rho, transmittance: tau, maintenance_factor: 1.0 };
    Material { kind, ..diffuse("sheet", 0.0) }
}

#[test]
fn an_even_bsdf_shines_as_the_configuration_factor_says() {
    // A window under an even sky gets half of its light, and half of the ground's; a Lambertian sheet of it in a black room
    // gives E_w τ F at any point.
    let tau = 0.4;
    let mut b = office(BLACK, window(lambertian(tau, 0.3), 1.0));
    desks(&mut b, 4);
    b.0.daytime = Some(day(SkyName::Uniform, 0.0, SUN));
    let m = solve(&b.0, &within(0.01));
    let arriving = 0.5e4 * (1.0 + 0.2);
    let corners = [at(0.5, 0.0, 1.0), at(3.5, 0.0, 1.0), at(3.5, 0.0, 2.5), at(0.5, 0.0, 2.5)];
    for s in only(&m) {
        let seen = corners.map(|c| c - s.position);
        let exact = tau * arriving * configuration_factor(&seen, DVec3::Z);
        // Solid angles of cones up to 0.2 wide are summed with the cosine of a direction in each, four thousand of them at a
        // cell and thousands of cells.
        assert_ratio(s.xyz[1], exact, 1e-3, "lux");
        assert_ratio(s.sky_lx + s.external_lx, s.xyz[1], 1e-9, "all of it comes straight from sky and ground");
    }
}

#[test]
fn an_even_bsdf_is_a_translucent_sheet() {
    let mut cover = Cover::default();
    let mut means = Vec::new();
    for (sky, sun_lx) in [(SkyName::Overcast, 0.0), (SkyName::Cie(12), 6e4)] {
        let run = |pane: Material| {
            let mut b = office(PAINT, pane);
            desks(&mut b, 5);
            b.0.daytime = Some(day(sky, sun_lx, SUN));
            solve(&b.0, &within(0.03))
        };
        let (bsdf, sheet) = (run(window(lambertian(0.5, 0.3), 1.0)), run(translucent(0.5, 0.3)));
        cover.enter_pair(&bsdf.grids[0], &sheet.grids[0], "even");
        means.push((lux(&bsdf).iter().sum::<f64>(), lux(&sheet).iter().sum::<f64>()));
    }
    cover.assert();
    for (bsdf, sheet) in means {
        // A third of a single point's tolerance for the mean of 25.
        assert_ratio(bsdf, sheet, 0.01, "mean");
    }
}

/// Illuminance on a level point in a black room by `E = V T D`, each summed apart: V by small areas of the window, D by small
/// cones of an overcast sky of 10,000 lx over a ground of 0.2.
fn three_phase(point: DVec3) -> f64 {
    let basis = KlemsBasis::Full;
    let (patches, finder, value) = (basis.patches(), PatchFinder::new(basis), slats_value(basis));
    let zenith = 1e4 * 9.0 / (7.0 * PI);
    let ground = 0.2 * 1e4 / PI;
    // The light's way in: y is into the room; seen from there x is to the right, z up.
    let luminance = |way: DVec3| if way.z > 0.0 { ground } else { zenith * (1.0 - 2.0 * way.z) / 3.0 };
    let fine = 24;
    let mut arriving = vec![0.0; patches.len()];
    for (i, p) in patches.iter().enumerate() {
        for a in 0..fine {
            for c in 0..fine {
                let place = |k: usize| (k as f64 + 0.5) / fine as f64;
                let [low, high] = p.theta.map(|t| t.sin().powi(2));
                let squared = low + place(a) * (high - low);
                let phi = p.phi + (place(c) - 0.5) * p.width;
                let way = DVec3::new(squared.sqrt() * phi.cos(), (1.0 - squared).sqrt(), squared.sqrt() * phi.sin());
                arriving[i] += luminance(way) * p.projected_solid_angle() / (fine * fine) as f64;
            }
        }
    }
    let leaving: Vec<f64> =
        (0..patches.len()).map(|o| arriving.iter().enumerate().map(|(i, e)| value(o, i) * e).sum()).collect();
    let (nu, nv) = (600, 300);
    let area = 3.0 * 1.5 / (nu * nv) as f64;
    let mut sum = 0.0;
    for u in 0..nu {
        for v in 0..nv {
            let place = at(0.5 + 3.0 * (f64::from(u) + 0.5) / 600.0, 0.0, 1.0 + 1.5 * (f64::from(v) + 0.5) / 300.0);
            let d = point - place;
            let way = d.normalize();
            let patch = finder.find(way.y, way.x, way.z);
            sum += leaving[patch] * area * way.y * (-way.z).max(0.0) / d.length_squared();
        }
    }
    sum
}

#[test]
fn a_black_room_is_the_three_phase_formula() {
    let mut b = office(BLACK, window(slats(), 1.0));
    let points = [at(2.0, 1.0, 0.8), at(1.0, 2.0, 0.8), at(3.2, 4.0, 0.4)];
    b.points("points", &points.map(|p| (p, DVec3::Z)));
    b.0.daytime = Some(day(SkyName::Overcast, 0.0, SUN));
    let exact = points.map(three_phase);
    let (quick, judge) = (solve(&b.0, &within(0.01)), solve(&b.0, &paths(1 << 19)));
    // Paths to 0.05 %, and then some for bad luck; `solve` to the tolerance asked for.
    for (m, limit, what) in [(&judge, 1e-3, "paths"), (&quick, 0.01, "solve")] {
        let mut cover = Cover::default();
        cover.enter_all(m, &exact, what);
        cover.assert();
        for (lx, exact) in lux(m).into_iter().zip(exact) {
            assert_ratio(lx, exact, limit, what);
        }
    }
}

/// `solve` against path tracing, point by point, and in the mean.
fn agree(b: &Build, tolerance: f64, count: u64, mean_limit: f64, what: &str) {
    let (quick, judge) = (solve(&b.0, &within(tolerance)), solve(&b.0, &paths(count)));
    let mut cover = Cover::default();
    cover.enter_pair(&quick.grids[0], &judge.grids[0], what);
    cover.assert();
    let mean = |m: &Measurement, of: &dyn Fn(&SensorResult) -> f64| only(m).iter().map(of).sum::<f64>();
    assert_ratio(mean(&quick, &|s| s.xyz[1]), mean(&judge, &|s| s.xyz[1]), mean_limit, what);
    // The sky's part is exact but for points spread over the window.
    assert_ratio(mean(&quick, &|s| s.sky_lx), mean(&judge, &|s| s.sky_lx), mean_limit, what);
}

#[test]
fn slats_under_an_overcast_sky_agree_with_path_tracing() {
    let mut b = office(PAINT, window(slats(), 1.0));
    desks(&mut b, 4);
    b.0.daytime = Some(day(SkyName::Overcast, 0.0, SUN));
    agree(&b, 0.03, 1 << 14, 0.01, "overcast");
}

#[test]
fn slats_in_the_sun_agree_with_path_tracing() {
    let mut b = office(PAINT, window(slats(), 1.0));
    desks(&mut b, 3);
    b.0.daytime = Some(day(SkyName::Cie(12), 6e4, SUN));
    // Paths find the bright patches by chance: 14 % at 2^13 paths, 3.5 % at 2^17, 1.2 % for the mean of nine.
    agree(&b, 0.03, 1 << 17, 0.025, "sunny");
}

/// The office with slats, a house 8 m before it and a slab over the window.
fn obstructed() -> Build {
    let mut b = office(PAINT, window(slats(), 1.0));
    let stone = b.material(Material { outside: true, ..diffuse("stone", 0.4) });
    b.block(at(-6.0, -14.0, -3.0), at(3.0, -8.0, 6.0), stone);
    b.block(at(0.0, -1.2, 2.6), at(4.0, 0.0, 2.75), stone);
    b
}

#[test]
fn slats_behind_a_slab_and_before_a_house_agree_with_path_tracing() {
    let mut b = obstructed();
    desks(&mut b, 4);
    b.0.daytime = Some(day(SkyName::Overcast, 0.0, SUN));
    agree(&b, 0.05, 1 << 15, 0.02, "obstructed");
}

#[test]
fn lamps_inside_are_reflected_and_leave_by_the_window_as_path_tracing_says() {
    let mut b = office(PAINT, window(slats(), 1.0));
    let lamp = b.material(common::lit(diffuse("lamp", 0.0), 3000.0));
    b.lamp(at(2.0, 3.0, 2.9), 1.0, lamp);
    desks(&mut b, 4);
    let (quick, judge) = (solve(&b.0, &within(0.03)), solve(&b.0, &paths(1 << 13)));
    assert_balanced(&quick);
    assert!(quick.ledger.escaped[0] > 0.01 * quick.ledger.emitted[0], "light leaves by the window");
    let mut cover = Cover::default();
    cover.enter_pair(&quick.grids[0], &judge.grids[0], "lamp");
    cover.assert();
}

#[test]
fn sky_and_sun_add_up() {
    let run = |sky: SkyName, sun_lx: f64| {
        let mut b = office(PAINT, window(slats(), 1.0));
        desks(&mut b, 4);
        let mut daytime = day(sky, sun_lx, SUN);
        if sky == SkyName::None {
            daytime.diffuse = None;
        }
        b.0.daytime = Some(daytime);
        solve(&b.0, &within(0.03))
    };
    let (both, sky, sun) = (run(SkyName::Cie(12), 6e4), run(SkyName::Cie(12), 0.0), run(SkyName::None, 6e4));
    let mut cover = Cover::default();
    for ((both, sky), sun) in only(&both).iter().zip(only(&sky)).zip(only(&sun)) {
        assert_ratio(both.sky_lx, sky.sky_lx, 1e-6, "the same windows, the same points");
        assert_ratio(both.sun_lx, sun.sun_lx, 1e-6, "the same windows, the same points");
        let error = both.error_lx.hypot(sky.error_lx).hypot(sun.error_lx);
        cover.enter(both.xyz[1], error, 0.0, sky.xyz[1] + sun.xyz[1], "sum");
    }
    cover.assert();
}

#[test]
fn what_comes_in_is_absorbed_or_leaves() {
    for (sky, sun_lx) in [(SkyName::Overcast, 0.0), (SkyName::Cie(12), 6e4)] {
        let mut b = office(PAINT, window(slats(), 1.0));
        desks(&mut b, 3);
        b.0.daytime = Some(day(sky, sun_lx, SUN));
        let m = solve(&b.0, &within(0.01));
        assert_balanced(&m);
        let l = &m.ledger;
        assert!(l.escaped[0] > 0.0 && l.sampling_error[0] < 0.2 * l.emitted[0], "the balance says something: {l:?}");
    }
}

#[test]
fn dirt_takes_its_share_of_what_comes_in() {
    let panes: [&dyn Fn(f64) -> Material; 3] = [
        &|dirt| window(slats(), dirt),
        &|dirt| {
            let mut pane = glass(0.8);
            let MaterialKind::Glass { maintenance_factor, .. } = &mut pane.kind else { unreachable!() };
            *maintenance_factor = dirt;
            pane
        },
        &|dirt| {
            let mut sheet = translucent(0.5, 0.3);
            let MaterialKind::Translucent { maintenance_factor, .. } = &mut sheet.kind else { unreachable!() };
            *maintenance_factor = dirt;
            sheet
        },
    ];
    for (k, pane) in panes.iter().enumerate() {
        let run = |dirt: f64| {
            let mut b = office(BLACK, pane(dirt));
            desks(&mut b, 3);
            b.0.daytime = Some(day(SkyName::Cie(12), 6e4, SUN));
            lux(&solve(&b.0, &within(0.05)))
        };
        for (clean, dirty) in run(1.0).into_iter().zip(run(0.75)) {
            assert!(clean > 0.0);
            // Tables and radiosities are in single precision.
            assert_ratio(dirty, 0.75 * clean, 2e-6, ["bsdf", "glass", "translucent"][k]);
        }
    }
}

#[test]
fn a_picture_shows_the_window_as_a_meter_before_it_reads() {
    // An even window of τ E_w/π: every pixel that looks at it shows that, whatever the direction.
    let mut b = office(BLACK, window(lambertian(0.4, 0.0), 1.0));
    b.0.views.push(View {
        name: "window".into(),
        position: at(2.0, 3.0, 1.75),
        direction: DVec3::NEG_Y,
        up: DVec3::Z,
        projection: Projection::Perspective { horizontal: 0.6, vertical: 0.3 },
        width: 8,
        height: 4,
    });
    b.0.daytime = Some(day(SkyName::Uniform, 0.0, SUN));
    let exact = 0.4 * 0.5e4 * 1.2 / PI;
    for options in [within(0.02), paths(64)] {
        let m = solve(&b.0, &options);
        for xyz in &m.views[0].xyz {
            assert_ratio(f64::from(xyz[1]), exact, 5e-3, "cd/m²");
        }
    }
}

#[test]
fn a_blind_seen_in_a_mirror_is_the_blind() {
    // The back wall is a mirror: a point that looks at it sees the window's room once more.
    let mut b = Build::new();
    let black = b.material(diffuse("black", 0.0));
    let (wall, pane) = (b.material(mirror(1.0)), b.material(window(slats(), 1.0)));
    b.room(DVec3::ZERO, at(4.0, 3.0, 3.0), [black, black, black, wall, black, black]);
    b.0.faces.retain(|f| f.vertices.iter().any(|v| v.y > 1e-9));
    b.rectangle(DVec3::ZERO, at(4.0, 0.0, 0.0), at(0.0, 0.0, 3.0), pane);
    b.points("facing the mirror", &[(at(2.0, 1.0, 1.0), DVec3::Y), (at(1.0, 2.0, 2.0), DVec3::Y)]);
    b.0.daytime = Some(day(SkyName::Overcast, 0.0, SUN));
    let (quick, judge) = (solve(&b.0, &within(0.02)), solve(&b.0, &paths(1 << 15)));
    let mut cover = Cover::default();
    cover.enter_pair(&quick.grids[0], &judge.grids[0], "mirror");
    cover.assert();
    assert!(lux(&quick).iter().all(|lx| *lx > 10.0));
}

#[test]
fn the_shipped_slats_are_their_formula() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/office/slats.xml");
    let bsdf = Bsdf::from_xml(&std::fs::read_to_string(path).expect("it is shipped")).expect("it is sound");
    let scattering = bsdf.scattering(Passage::TransmissionFront).expect("it passes light");
    let value = slats_value(KlemsBasis::Quarter);
    for o in 0..41 {
        for i in 0..41 {
            // The file has six digits.
            assert_ratio(scattering.value(o, i), value(o, i), 1e-5, "sr⁻¹");
        }
    }
}

#[test]
fn what_is_not_followed_is_refused() {
    // A coloured pane right before the blind.
    let mut b = office(PAINT, window(slats(), 1.0));
    let stained = b.material(common::glazed(1, rgb([0.8, 0.5, 0.3])));
    b.rectangle(at(0.5, -0.1, 1.0), at(3.0, 0.0, 0.0), at(0.0, 0.0, 1.5), stained);
    desks(&mut b, 2);
    b.0.daytime = Some(day(SkyName::Overcast, 0.0, SUN));
    let text = refusal(&b.0).to_string();
    assert!(text.contains("a coloured pane before a window with a BSDF"), "{text}");
}
