//! Daylight with answers known on paper: open fields, openings, panes, the sun, and where the light goes.

mod common;

use std::f64::consts::PI;
use std::path::PathBuf;

use clerestory::light::Daylight;
use clerestory::measure::{Measurement, Method, SensorResult, SolveOptions};
use clerestory::scene::{Amount, Daytime, Material, MaterialKind, Placed, SkyName};
use clerestory::spectrum::{BandMode, SpectralValue, Spectrum};
use clerestory::transport::{
    DAYLIGHT_GROUPS, DirectScratch, GlazingUnit, Openings, SUN as SUN_GROUP, World, sun_factor, sun_through,
    visible_directions,
};
use common::{Build, Cover, assert_balanced, at, diffuse, glass, glazed, mirror, only, rgb, solve, within};
use glam::DVec3;

/// A sky of 10,000 lx over a ground of 0.2, sun 45° high in the south if `direct_lx` is not zero.
fn day(model: SkyName, direct_lx: f64) -> Daytime {
    let placed = |lx| Placed { value: Amount::Lux(lx), line: 1 };
    Daytime {
        file: PathBuf::from("test.toml"),
        model: Placed { value: model, line: 1 },
        diffuse: Some(placed(1e4)),
        direct: Some(placed(direct_lx)),
        sun_deg: Some(Placed { value: (45.0, 180.0), line: 1 }),
        site: None,
        spectrum: Spectrum::constant(1.0),
        sun_spectrum: Spectrum::constant(1.0),
        ground_reflectance: 0.2,
        north_deg: 0.0,
    }
}

/// A small black plate far below the points: a scene must hold something.
fn open_field(daytime: Daytime, points: &[(DVec3, DVec3)]) -> Measurement {
    let mut b = Build::new();
    let black = b.material(diffuse("black", 0.0));
    b.rectangle(at(-0.05, -0.05, -5.0), at(0.1, 0.0, 0.0), at(0.0, 0.1, 0.0), black);
    b.points("points", points);
    b.0.daytime = Some(daytime);
    solve(&b.0, &within(0.01))
}

fn near(found: f64, exact: f64, relative: f64, what: &str) {
    assert!((found - exact).abs() <= relative * exact.abs().max(1e-9), "{what}: {found}, exact {exact}");
}

/// Quadrature stops where a finer rule changes nothing beyond 2e-3 and takes the finer value: far below 1e-4.
const QUADRATURE: f64 = 1e-4;

#[test]
fn an_open_field_under_an_overcast_sky_reads_what_it_should() {
    let m = open_field(day(SkyName::Overcast, 0.0), &[(DVec3::ZERO, DVec3::Z), (DVec3::ZERO, DVec3::Y)]);
    let [up, side] = only(&m) else { panic!("two points") };
    near(up.sky_lx, 1e4, QUADRATURE, "horizontal");
    // Vertical over horizontal under (1 + 2 sin γ)/3: (π/2 + 4/3)/3 over 7π/9.
    near(side.sky_lx, 1e4 * (PI / 2.0 + 4.0 / 3.0) / (7.0 * PI / 3.0), QUADRATURE, "vertical");
    // Half of what a wall sees is the ground; the plate hides a millionth of it.
    near(side.external_lx, 1e4 * 0.2 * 0.5, 1e-6, "ground");
    assert_eq!(up.external_lx, 0.0);
}

#[test]
fn the_ground_does_not_shine_through_the_horizon_nor_the_sky_from_below() {
    let m = open_field(day(SkyName::Uniform, 0.0), &[(DVec3::ZERO, DVec3::NEG_Z), (DVec3::ZERO, DVec3::Z)]);
    let [down, up] = only(&m) else { panic!("two points") };
    assert_eq!((down.sky_lx, up.external_lx), (0.0, 0.0));
    // The plate hides 0.01 m² at 5 m: 0.0001273 of the hemisphere, by the projected solid angle.
    near(down.external_lx, 1e4 * 0.2 * (1.0 - 0.01 / (25.0 * PI)), 1e-6, "ground from above");
    near(up.sky_lx, 1e4, 1e-9, "uniform sky");
}

#[test]
fn the_sun_follows_the_cosine_and_lights_the_ground() {
    let tilted = DVec3::new(0.0, -1.0, 1.0);
    let points = [(DVec3::ZERO, DVec3::Z), (DVec3::ZERO, tilted), (DVec3::ZERO, DVec3::Y), (DVec3::ZERO, DVec3::NEG_Z)];
    let m = open_field(day(SkyName::Uniform, 5e4), &points);
    let [up, facing, away, down] = only(&m) else { panic!("four points") };
    // A disc of half angle α face on loses nothing by definition; tilted by 45° it follows the cosine exactly.
    near(up.sun_lx, 5e4 / 2f64.sqrt(), 1e-6, "horizontal");
    near(facing.sun_lx, 5e4, 1e-6, "face on");
    assert_eq!(away.sun_lx, 0.0);
    let ground = 0.2 * (1e4 + 5e4 / 2f64.sqrt());
    near(down.external_lx, ground, 1e-3, "exitance of the sunlit ground");
}

#[test]
fn the_penumbra_of_a_half_plane_falls_as_a_segment_of_the_disc() {
    // An edge 10 m over the points, running east to west, hides all to the north of it; sun at the zenith.
    let mut b = Build::new();
    let black = b.material(diffuse("black", 0.0));
    b.rectangle(at(-5.0, 0.0, 10.0), at(10.0, 0.0, 0.0), at(0.0, 10.0, 0.0), black);
    let radius = 10.0 * (0.5f64 * 0.533).to_radians().tan();
    let offsets = [-0.9, -0.5, 0.0, 0.5, 0.9];
    let points: Vec<(DVec3, DVec3)> = offsets.iter().map(|t| (at(0.0, t * radius, 0.0), DVec3::Z)).collect();
    b.points("points", &points);
    let mut daytime = day(SkyName::None, 1e5);
    daytime.sun_deg = Some(Placed { value: (90.0, 0.0), line: 1 });
    b.0.daytime = Some(daytime);
    let m = solve(&b.0, &within(0.01));
    for (t, s) in offsets.iter().zip(only(&m)) {
        // Seen from t·r north of the edge, the part of the disc south of it: (acos t − t √(1 − t²))/π.
        let share = (t.acos() - t * (1.0 - t * t).sqrt()) / PI;
        // A polygon of twelve sides stands for the disc: its segments differ by 1 % of the disc at most.
        assert!((s.sun_lx / 1e5 - share).abs() < 0.01, "{t}: {} {share}", s.sun_lx / 1e5);
    }
}

/// A room of 4 x 4 x 3 m of one reflectance, a roof light of 1 x 1 m in its middle, with a pane of grey glass if given.
fn roof_light(rho: f64, pane: Option<f64>) -> Build {
    roof_light_of(rho, pane.map(glass))
}

/// The same with any glazing.
fn roof_light_of(rho: f64, pane: Option<Material>) -> Build {
    let mut b = Build::new();
    let wall = b.material(diffuse("wall", rho));
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    b.rectangle(at(0.0, 0.0, 0.0), 4.0 * x, 4.0 * y, wall);
    b.rectangle(at(0.0, 0.0, 0.0), 4.0 * y, 3.0 * z, wall);
    b.rectangle(at(4.0, 0.0, 0.0), 3.0 * z, 4.0 * y, wall);
    b.rectangle(at(0.0, 4.0, 0.0), 4.0 * x, 3.0 * z, wall);
    b.rectangle(at(0.0, 0.0, 0.0), 3.0 * z, 4.0 * x, wall);
    for (low, u, v) in [((0.0, 0.0), 4.0, 1.5), ((0.0, 2.5), 4.0, 1.5), ((0.0, 1.5), 1.5, 1.0), ((2.5, 1.5), 1.5, 1.0)]
    {
        b.rectangle(at(low.0, low.1, 3.0), v * y, u * x, wall);
    }
    if let Some(pane) = pane {
        let pane = b.material(pane);
        b.rectangle(at(1.5, 1.5, 3.0), x, y, pane);
    }
    b
}

#[test]
fn a_hole_that_nobody_declared_lights_the_room_by_its_configuration_factor() {
    let mut b = roof_light(0.0, None);
    b.points("floor", &[(at(2.0, 2.0, 0.0), DVec3::Z)]);
    b.0.daytime = Some(day(SkyName::Uniform, 0.0));
    let m = solve(&b.0, &within(0.01));
    // A point on a surface stands 4e-6 of the scene above it, which brings it 1e-5 nearer.
    // Centre of a unit square at distance 3 (Howell B-4): 4 · 2/(2π) · a/√(1+a²) · atan(a/√(1+a²)), a = 1/6.
    let a = (1.0f64 / 6.0) / (1.0 + 1.0 / 36.0f64).sqrt();
    near(only(&m)[0].sky_lx, 1e4 * 4.0 / PI * a * a.atan(), 3e-5, "hole");
}

#[test]
fn the_interreflected_light_of_a_room_follows_from_its_flux() {
    // The sky sends Φ = E_h A through the hole. In a closed room the mean indirect light would be ρΦ/(S(1−ρ)); here the
    // hole of 1 m² takes part with reflectance 0.
    let rho = 0.6;
    let mut b = roof_light(rho, None);
    b.level("floor", at(0.0, 0.0, 0.0), at(4.0, 4.0, 0.0), 4);
    b.0.daytime = Some(day(SkyName::Overcast, 0.0));
    let m = solve(&b.0, &within(0.02));
    let ledger = &m.ledger;
    // In one band Y is proportional: what enters is E_h times the area of the hole, from above; nothing from below.
    let unit = m.bands.xyz(&[1.0])[1];
    near(ledger.emitted[0] * unit, 1e4, 0.05, "flux that enters through 1 m²");
    let rest = ledger.emitted[0] - ledger.absorbed[0] - ledger.escaped[0] - ledger.unexpanded[0];
    assert!(rest.abs() <= ledger.sampling_error[0].max(1e-3 * ledger.emitted[0]), "{ledger:?}");
    // Absorbed plus escaped is what the exact direct light brought in: tight, where the shot rays are noisy.
    near((ledger.absorbed[0] + ledger.escaped[0]) * unit, 1e4, 0.01, "flux by the elements");
}

#[test]
fn five_parts_sum_to_the_whole_and_paths_agree() {
    let mut b = roof_light(0.5, Some(0.88));
    let facade = b.material(Material { outside: true, ..diffuse("facade", 0.4) });
    b.rectangle(at(0.0, 6.0, 3.0), at(4.0, 0.0, 0.0), at(0.0, 0.0, 4.0), facade);
    b.level("floor", at(0.5, 0.5, 0.1), at(3.5, 3.5, 0.1), 3);
    b.0.daytime = Some(day(SkyName::Cie(12), 3e4));
    let quick = solve(&b.0, &within(0.02));
    let judge = solve(&b.0, &SolveOptions { method: Method::PathTracing, paths: Some(1 << 15), ..within(0.02) });
    let parts = |s: &SensorResult| [s.direct_lx, s.sun_lx, s.sky_lx, s.external_lx, s.reflected_lx];
    let (mut outside, mut sums) = (0, [[0.0; 5]; 2]);
    for (a, b) in only(&quick).iter().zip(only(&judge)) {
        for s in [a, b] {
            near(parts(s).iter().sum(), s.xyz[1], 1e-6, "sum of the parts");
        }
        outside += usize::from((a.xyz[1] - b.xyz[1]).abs() > a.error_lx.hypot(b.error_lx));
        for (sum, s) in sums.iter_mut().zip([a, b]) {
            sum.iter_mut().zip(parts(s)).for_each(|(sum, part)| *sum += part);
        }
    }
    assert!(outside <= 1, "{outside} of 9 outside both errors");
    for (k, name) in ["direct", "sun", "sky", "external", "reflected"].iter().enumerate() {
        let [quick, judge] = [sums[0][k], sums[1][k]];
        // Nine points of 32,768 paths: the rarest part, light from the facade, is known to about 3 %.
        assert!((quick - judge).abs() <= 0.04 * judge + 1.0, "{name}: {quick} {judge}");
    }
}

#[test]
fn a_translucent_roof_light_shines_as_an_emitter_of_what_it_gets() {
    let sheet = MaterialKind::Translucent {
        front: SpectralValue::Grey(0.3),
        back: SpectralValue::Grey(0.3),
        transmittance: SpectralValue::Grey(0.5),
        maintenance_factor: 1.0,
    };
    let sheet = Material { kind: sheet, ..diffuse("sheet", 0.3) };
    let mut b = roof_light_of(0.0, Some(sheet));
    b.points("floor", &[(at(2.0, 2.0, 0.0), DVec3::Z)]);
    b.0.daytime = Some(day(SkyName::Uniform, 2e4));
    // Sky and sun at 45° upon a flat roof; below, the centre of a unit square at distance 3 (Howell B-4), a = 1/6.
    let a = (1.0f64 / 6.0) / (1.0 + 1.0 / 36.0f64).sqrt();
    let exact = 0.5 * (1e4 + 2e4 / 2f64.sqrt()) * 4.0 / PI * a * a.atan();
    for method in [Method::Auto, Method::PathTracing] {
        let m = solve(&b.0, &SolveOptions { method, paths: Some(1 << 16), ..within(0.02) });
        let s = &only(&m)[0];
        assert!((s.xyz[1] - exact).abs() <= s.error_lx, "{method:?}: {} ± {}, exact {exact}", s.xyz[1], s.error_lx);
        near(s.xyz[1], exact, 0.05, "also wide errors must not hide a wrong value");
        assert!(s.sun_lx + s.sky_lx < 1e-9, "it comes by the sheet");
    }
}

/// Transmittances of a coloured pane in the three bands.
const STAINED: [f64; 3] = [0.8, 0.5, 0.1];

/// A room below a pane, solved in three bands, each reported.
fn below(rho: f64, pane: SpectralValue, daytime: Daytime, method: Method) -> Measurement {
    let mut b = roof_light_of(rho, Some(glazed(2, pane)));
    b.bands(BandMode::Rgb);
    b.level("floor", at(0.5, 0.5, 0.1), at(3.5, 3.5, 0.1), 3);
    b.0.daytime = Some(daytime);
    solve(&b.0, &SolveOptions { method, paths: Some(1 << 14), spectral: true, ..within(0.03) })
}

#[test]
fn coloured_panes_let_sun_and_sky_through_as_grey_ones_do_in_each_band() {
    let daytime = || {
        let mut daytime = day(SkyName::Cie(12), 3e4);
        daytime.sun_deg = Some(Placed { value: (75.0, 170.0), line: 1 });
        daytime
    };
    // Without reflection all is exact but the places where triangles are divided.
    let coloured = below(0.0, rgb(STAINED), daytime(), Method::Auto);
    for (band, t) in STAINED.into_iter().enumerate() {
        let grey = below(0.0, SpectralValue::Grey(t), daytime(), Method::Auto);
        for (c, g) in only(&coloured).iter().zip(only(&grey)) {
            near(c.spectral[band].irradiance, g.spectral[band].irradiance, 5e-3, "band by band");
        }
        let sunlit = only(&grey).iter().filter(|s| s.sun_lx > 1000.0).count();
        assert!(sunlit > 0, "the sun reaches some of the points");
    }
    for s in only(&coloured) {
        near(s.sun_lx + s.sky_lx, s.xyz[1], 1e-6, "nothing else shines");
    }
    // With reflection, within the stated errors.
    let coloured = below(0.5, rgb(STAINED), daytime(), Method::Auto);
    assert_balanced(&coloured);
    let mut cover = Cover::default();
    for (band, t) in STAINED.into_iter().enumerate() {
        let grey = below(0.5, SpectralValue::Grey(t), daytime(), Method::Auto);
        for (c, g) in only(&coloured).iter().zip(only(&grey)) {
            let (c, g) = (c.spectral[band], g.spectral[band]);
            cover.enter(c.irradiance, c.error.hypot(g.error), 0.0, g.irradiance, format!("band {band}"));
        }
    }
    let judge = below(0.5, rgb(STAINED), daytime(), Method::PathTracing);
    cover.enter_pair(&coloured.grids[0], &judge.grids[0], "paths");
    cover.assert();
    let sums = |m: &Measurement| only(m).iter().fold((0.0, 0.0), |sum, s| (sum.0 + s.sun_lx, sum.1 + s.sky_lx));
    let ((sun, sky), (judged_sun, judged_sky)) = (sums(&coloured), sums(&judge));
    // Nine points of 16,384 paths.
    near(judged_sun, sun, 0.03, "sun");
    near(judged_sky, sky, 0.03, "sky");
}

#[test]
fn in_a_single_band_a_coloured_pane_lets_by_what_the_eye_has_left() {
    let under = |bands: BandMode, pane: SpectralValue| {
        let mut b = roof_light_of(0.0, Some(glazed(1, pane)));
        b.bands(bands);
        b.level("floor", at(0.5, 0.5, 0.1), at(3.5, 3.5, 0.1), 3);
        b.0.daytime =
            Some(Daytime { sun_deg: Some(Placed { value: (75.0, 170.0), line: 1 }), ..day(SkyName::Cie(12), 3e4) });
        solve(&b.0, &within(0.03))
    };
    // The light of `day` has equal energy.
    let luminous = rgb(STAINED).to_spectrum().luminous() / Spectrum::constant(1.0).luminous();
    let as_grey = [(BandMode::Grey, rgb(STAINED), luminous), (BandMode::Rgb, rgb([0.5; 3]), 0.5)];
    for (bands, pane, t) in as_grey {
        let (coloured, grey) = (under(bands.clone(), pane), under(bands, SpectralValue::Grey(t)));
        for (c, g) in only(&coloured).iter().zip(only(&grey)) {
            near(c.sky_lx, g.sky_lx, 1e-3, "sky");
            near(c.sun_lx, g.sun_lx, 1e-3, "sun");
            assert!(c.sky_lx > 50.0, "the sky is seen: {} lx", c.sky_lx);
        }
    }
}

#[test]
fn a_room_far_from_the_origin_reads_the_same() {
    let run = |offset: DVec3| {
        let mut b = roof_light(0.5, Some(0.88));
        b.level("floor", at(0.5, 0.5, 0.8), at(3.5, 3.5, 0.8), 3);
        b.0.faces.iter_mut().flat_map(|f| &mut f.vertices).for_each(|v| *v += offset);
        b.0.grids.iter_mut().flat_map(|g| &mut g.sensors).for_each(|s| s.position += offset);
        b.0.daytime = Some(day(SkyName::Cie(9), 3e4));
        only(&solve(&b.0, &within(0.05))).iter().map(|s| s.xyz[1]).collect::<Vec<f64>>()
    };
    let (here, far) = (run(DVec3::ZERO), run(at(500_000.0, 5_400_000.0, 100.0)));
    for (a, b) in here.iter().zip(&far) {
        near(*b, *a, 1e-6, "UTM coordinates");
    }
}

/// Angular radius of the sun, radians.
const SUN: f64 = 0.5 * 0.533 * PI / 180.0;

/// The sun alone, at an altitude and azimuth in degrees, 100,000 lx.
fn sun_at(altitude_deg: f64, azimuth_deg: f64) -> Daytime {
    let mut daytime = day(SkyName::None, 1e5);
    daytime.sun_deg = Some(Placed { value: (altitude_deg, azimuth_deg), line: 1 });
    daytime
}

#[test]
fn a_low_sun_lights_the_ground_by_its_sine_and_sets_bit_by_bit() {
    let points = [(DVec3::ZERO, DVec3::Z), (DVec3::ZERO, DVec3::NEG_Z), (DVec3::ZERO, DVec3::NEG_Y)];
    for (altitude, exact) in [(0.5, 872.65), (1.0, 1745.2), (5.0, 8715.6), (0.1, f64::NAN), (0.01, f64::NAN)] {
        let m = open_field(sun_at(altitude, 180.0), &points);
        let [up, down, wall] = only(&m) else { panic!("three points") };
        assert_eq!(down.sun_lx, 0.0, "no beam through the ground");
        let t = (altitude.to_radians() / SUN).min(1.0);
        // The share of the disc above the horizon, and its mean height times that share, in radii.
        let share = 1.0 - (t.acos() - t * (1.0 - t * t).sqrt()) / PI;
        let height = t * share + 2.0 / (3.0 * PI) * (1.0 - t * t).powf(1.5);
        if exact.is_nan() {
            // A polygon of twelve sides stands for the disc: its segments differ by 1 % of the disc at most.
            assert!((up.sun_lx - 1e5 * SUN * height).abs() < 0.01 * 1e5 * SUN, "{altitude}: {}", up.sun_lx);
        } else {
            near(up.sun_lx, exact, 1e-4, "all of the disc is up");
        }
        assert!((wall.sun_lx / 1e5 - share).abs() < 0.01, "{altitude}: a wall gets {}", wall.sun_lx);
    }
}

#[test]
fn kept_openings_cut_the_sun_as_the_scene_does() {
    // A hole three quarters of which are glazed, with a bar below: the sun's way leads across every border.
    let mut b = roof_light(0.5, None);
    let (pane, bar) = (b.material(glass(0.8)), b.material(diffuse("bar", 0.5)));
    b.rectangle(at(1.5, 1.5, 3.0), 0.75 * DVec3::X, DVec3::Y, pane);
    b.rectangle(at(1.9, 1.0, 2.5), 0.1 * DVec3::X, 2.0 * DVec3::Y, bar);
    b.0.daytime = Some(sun_at(60.0, 180.0));
    let world = World::new(&b.0);
    let frame = &world.surfaces.frame;
    let mut scratch = DirectScratch::default();
    let (mut partly, mut lit) = (0, 0);
    for (k, normal) in [DVec3::Z, DVec3::new(0.3, -0.2, 0.9).normalize()].into_iter().enumerate() {
        let x = frame.to_local(at(2.0 + 0.1 * k as f64, 1.9, 0.9));
        let mut openings = Openings::default();
        let _ = visible_directions(&world, (x, normal), 7, (0.1, Some(&mut openings)), &mut scratch, &mut |_| {});
        let openings = openings.whole().expect("few blockers");
        for step in 0..4000 {
            let (along, across) = (f64::from(step % 400) / 400.0 - 0.5, f64::from(step / 400) / 14.0 - 0.32);
            let sun = DVec3::new(along, across, 1.0).normalize();
            let mut found = [[0.0; DAYLIGHT_GROUPS]; 2];
            let _ = sun_factor(&world, (x, normal), sun, 3, &mut scratch, &mut found[0]);
            let panes = scratch.panes().len();
            sun_through(&world, (x, normal), &openings, sun, &mut scratch, &mut found[1]);
            let [looked, kept] = found.map(|f| f[SUN_GROUP]);
            assert!((looked - kept).abs() < 1e-9, "{sun}: {looked} by a look, {kept} by what was kept");
            assert_eq!(panes > 0, !scratch.panes().is_empty(), "{sun}");
            lit += usize::from(kept > 0.0);
            partly += usize::from(kept > 0.0 && kept < 0.5 * normal.dot(sun));
        }
    }
    assert!(lit > 500 && partly > 10, "{lit} lit, {partly} partly");
}

#[test]
fn at_the_zenith_there_is_no_azimuth() {
    let points = [(DVec3::ZERO, DVec3::Z), (DVec3::ZERO, at(1.0, 2.0, 2.0))];
    let read = |azimuth| {
        let m = open_field(sun_at(90.0, azimuth), &points);
        only(&m).iter().map(|s| s.sun_lx).collect::<Vec<f64>>()
    };
    let north = read(0.0);
    near(north[1], 1e5 * 2.0 / 3.0, 1e-6, "cosine");
    for azimuth in [90.0, 200.0] {
        for (a, b) in read(azimuth).iter().zip(&north) {
            near(*a, *b, 1e-9, "zenith");
        }
    }
}

#[test]
fn a_wall_that_points_at_the_sun_gets_half_the_disc_on_each_side() {
    let m = open_field(sun_at(45.0, 180.0), &[(DVec3::ZERO, DVec3::X), (DVec3::ZERO, DVec3::NEG_X)]);
    for s in only(&m) {
        // A point sun would give nothing. Half a disc of radius a stands 4a/(3π) over the plane in the mean.
        near(s.sun_lx, 1e5 * SUN * 2.0 / (3.0 * PI), 0.03, "grazed");
    }
}

#[test]
fn a_grazed_floor_of_many_faces_has_no_stripes() {
    let mut b = Build::new();
    let black = b.material(diffuse("black", 0.0));
    let side = 0.5;
    for k in 0..400 {
        let corner = at(f64::from(k % 20), f64::from(k / 20), 0.0) * side;
        b.rectangle(corner, DVec3::X * side, DVec3::Y * side, black);
    }
    b.level("floor", DVec3::ZERO, at(10.0, 10.0, 0.0), 13);
    b.0.daytime = Some(sun_at(0.6, 160.0));
    for s in only(&solve(&b.0, &within(0.05))) {
        near(s.sun_lx, 1e5 * 0.6f64.to_radians().sin(), 1e-4, "floor");
    }
}

#[test]
fn a_sun_that_has_set_is_refused() {
    for altitude in [0.0, -0.1, -30.0] {
        for model in [SkyName::None, SkyName::Cie(12), SkyName::Perez] {
            let mut b = Build::new();
            let black = b.material(diffuse("black", 0.0));
            b.rectangle(DVec3::ZERO, DVec3::X, DVec3::Y, black).points("p", &[(DVec3::Z, DVec3::Z)]);
            let mut daytime = day(model, 1e4);
            daytime.sun_deg = Some(Placed { value: (altitude, 180.0), line: 7 });
            b.0.daytime = Some(daytime);
            let error = common::refusal(&b.0).to_string();
            assert!(error.starts_with("test.toml:7:") && error.contains("not above the horizon"), "{error}");
        }
    }
}

#[test]
fn a_uniform_sky_gives_a_wall_exactly_half() {
    let m = open_field(day(SkyName::Uniform, 0.0), &[(DVec3::ZERO, DVec3::X), (DVec3::ZERO, at(1.0, -1.0, 0.0))]);
    for s in only(&m) {
        near(s.sky_lx, 5e3, 1e-6, "vertical"); // single precision of the frame
    }
}

/// An upright mirror or pane that looks south, 0.5 to 1.5 m above the ground, with points before it; the sun is 45° high in
/// the south.
fn facade(thing: Material) -> (Build, [f64; 6]) {
    let mut b = Build::new();
    let thing = b.material(thing);
    b.rectangle(at(-3.0, 0.0, 0.5), DVec3::X * 6.0, DVec3::Z, thing);
    // A ray from y south of the mirror meets it at z = y tan(45° + α) = y (1 + 2α): at y = 0.5 + δ it is on the edge for α = −δ.
    let south = [1.0, 0.5 + 0.5 * SUN, 0.5, 0.5 - 0.5 * SUN, 0.3, 2.0];
    let mut points: Vec<(DVec3, DVec3)> = south.iter().map(|y| (at(0.0, -y, 0.0), DVec3::Z)).collect();
    points.push((at(0.0, -1.0, 0.0), DVec3::Y));
    b.points("ground", &points);
    b.0.daytime = Some(sun_at(45.0, 180.0));
    // Share of the disc that the mirror shows: all, a segment on either side of its lower edge, none.
    let t: f64 = 0.5;
    let segment = (t.acos() - t * (1.0 - t * t).sqrt()) / PI;
    (b, [1.0, 1.0 - segment, 0.5, segment, 0.0, 0.0])
}

#[test]
fn a_mirror_throws_the_sun_where_its_image_is_seen() {
    let pane = GlazingUnit::alike(2, 0.78, 1.52).shares(0.5f64.sqrt()).reflected[1];
    for (thing, rho) in [(mirror(0.8), 0.8), (glazed(2, SpectralValue::Grey(0.78)), pane)] {
        let name = thing.name.clone();
        let (b, shares) = facade(thing);
        let direct = 1e5 * 0.5f64.sqrt();
        let m = solve(&b.0, &within(0.01));
        for (s, share) in only(&m).iter().zip(shares) {
            // 64 well-spread rays count an edge across the disc to a few in a hundred; eight places tell its cosine.
            let slack = if share == 0.0 || share == 1.0 { 1e-3 } else { 0.03 };
            near(s.sun_lx, direct * (1.0 + rho * share), slack, &format!("{name}, {share} of the disc"));
        }
        // Eight places of the disc, over which the cosine has a standard deviation of 0.2 %.
        near(only(&m)[6].sun_lx, direct * rho, 1e-3, "a wall that looks at the mirror sees the image alone");
        let judge = solve(&b.0, &SolveOptions { method: Method::PathTracing, paths: Some(1 << 14), ..within(0.01) });
        for (s, share) in only(&judge).iter().zip(shares) {
            near(s.sun_lx, direct * (1.0 + rho * share), 0.01, "by paths");
        }
        assert!(m.record.left_out.iter().all(|l| !l.what.contains("reflections at mirrors")), "one mirror, one image");
    }
}

#[test]
fn a_coloured_mirror_throws_coloured_sun() {
    let kind = MaterialKind::Mirror { reflectance: rgb(STAINED) };
    let (mut b, _) = facade(Material { kind, ..mirror(1.0) });
    b.bands(BandMode::Rgb);
    let m = solve(&b.0, &SolveOptions { spectral: true, ..within(0.01) });
    let light = Daylight::new(&b.0).expect("a sun").expect("a sky");
    let face_on = m.bands.radiance(&light.sun_irradiance);
    for (band, rho) in STAINED.into_iter().enumerate() {
        let exact = face_on[band] * 0.5f64.sqrt() * (1.0 + rho);
        near(only(&m)[0].spectral[band].irradiance, exact, 1e-4, "band by band");
    }
    // In a single band by what the eye has left.
    b.bands(BandMode::Grey);
    let luminous = rgb(STAINED).to_spectrum().luminous() / Spectrum::constant(1.0).luminous();
    let m = solve(&b.0, &within(0.01));
    near(only(&m)[0].sun_lx, 1e5 * 0.5f64.sqrt() * (1.0 + luminous), 1e-3, "one band");
}

#[test]
fn sun_from_a_mirror_on_the_floor_lights_the_room_and_is_accounted_for() {
    let mut b = roof_light(0.6, Some(0.8));
    let pool = b.material(mirror(0.9));
    b.rectangle(at(1.0, 1.6, 0.02), DVec3::X * 2.0, DVec3::Y * 2.4, pool);
    b.points("ceiling", &[0.3, 0.9, 3.4, 3.8].map(|y| (at(2.0, y, 2.9), DVec3::NEG_Z)));
    b.0.daytime =
        Some(Daytime { sun_deg: Some(Placed { value: (75.0, 180.0), line: 1 }), ..day(SkyName::Uniform, 5e4) });
    let quick = solve(&b.0, &within(0.03));
    assert_balanced(&quick);
    let judge = solve(&b.0, &SolveOptions { method: Method::PathTracing, paths: Some(1 << 15), ..within(0.03) });
    let mut cover = Cover::default();
    cover.enter_pair(&quick.grids[0], &judge.grids[0], "ceiling");
    cover.assert();
    // 75°: the image stands 3 m below; a spot on the ceiling lies 2 · 3/tan 75° = 1.6 m north of the roof light.
    let spot = &only(&quick)[2];
    let sun = 5e4 * 75f64.to_radians().sin();
    assert!(spot.sun_lx > 0.5 * sun && spot.sun_lx < 0.9 * 0.8 * sun, "{}", spot.sun_lx);
    let told = quick.record.left_out.iter().find(|l| l.what.contains("reflections at mirrors"));
    assert!(told.is_some_and(|l| l.bound.contains("lx")), "pane and pool see each other");
}

#[test]
fn a_sealed_room_under_a_bright_sky_is_dark() {
    let mut b = Build::new();
    let wall = b.material(diffuse("wall", 0.5));
    b.room(DVec3::ZERO, at(4.0, 3.0, 2.7), [wall; 6]);
    b.level("floor", at(0.0, 0.0, 0.85), at(4.0, 3.0, 0.85), 3);
    b.0.daytime = Some(day(SkyName::Overcast, 1e5));
    let m = solve(&b.0, &within(0.05));
    for s in only(&m) {
        assert_eq!((s.xyz[1], s.error_lx), (0.0, 0.0));
    }
    assert_eq!(m.grids[0].holding, 9);
}
