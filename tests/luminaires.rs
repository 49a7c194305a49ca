//! Luminaires in scenes: closed forms near and far, shadows, flux, both ways to compute.

mod common;

use std::f64::consts::PI;

use clerestory::light::Luminaires;
use clerestory::light::photometry::{Opening, PhotometricType, Photometry, Web, to_ies};
use clerestory::measure::{self, Measurement, Method, Silent, SolveOptions};
use clerestory::scene::{LuminaireRow, Projection, Scene, View};
use common::{Build, at, diffuse, glass};
use glam::{DMat3, DVec3};

/// A luminaire file of type C by a formula of vertical and horizontal angle, degrees.
fn file(opening: Opening, horizontal: &[f64], vertical: &[f64], candela: impl Fn(f64, f64) -> f64) -> Vec<u8> {
    let values = horizontal.iter().flat_map(|h| vertical.iter().map(|v| candela(*v, *h)).collect::<Vec<_>>()).collect();
    let web = Web::new(PhotometricType::C, vertical.to_vec(), horizontal.to_vec(), values).expect("a sound web");
    let blank = Photometry::parse(b"TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 0\n0 180\n0\n1 1\n", "x.ies".as_ref())
        .expect("a sound file");
    to_ies(&Photometry { web, opening, ..blank }).into_bytes()
}

fn degrees(from: f64, to: f64, step: f64) -> Vec<f64> {
    (0..=((to - from) / step).round() as usize).map(|k| from + step * k as f64).collect()
}

fn square(side_m: f64) -> Opening {
    Opening { along_c0_m: side_m, along_c90_m: side_m, height_m: 0.0, round: false }
}

/// One luminaire that hangs straight down.
fn hang(scene: &mut Scene, bytes: Vec<u8>, position: DVec3) {
    hang_at(scene, bytes, vec![position]);
}

fn hang_at(scene: &mut Scene, bytes: Vec<u8>, positions: Vec<DVec3>) {
    scene.luminaires.push(LuminaireRow::aimed_down(bytes, positions));
}

/// Black floor, large enough to be a plane; sensors look up from just above it unless they say otherwise.
fn floor(points: &[(DVec3, DVec3)]) -> Build {
    let mut b = Build::new();
    let black = b.material(diffuse("black", 0.0));
    b.rectangle(at(-5.0, -5.0, 0.0), at(10.0, 0.0, 0.0), at(0.0, 10.0, 0.0), black);
    b.points("points", points);
    b
}

fn solve(scene: &Scene, tolerance: f64) -> Measurement {
    common::solve(scene, &common::within(tolerance))
}

/// Both ways to compute agree with the expected illuminances: within `share`, and within their stated errors.
fn expect(scene: &Scene, expected: &[f64], share: f64) {
    let m = solve(scene, 0.01);
    for (s, e) in m.grids[0].sensors.iter().zip(expected) {
        let off = (s.xyz[1] - e).abs();
        assert!(off <= share * e, "at {}: {} lx, expected {e}", s.position, s.xyz[1]);
    }
    let traced = common::solve(scene, &common::paths(20_000));
    for (s, e) in traced.grids[0].sensors.iter().zip(expected) {
        let allowed = 2.0 * s.error_lx + share * e;
        assert!(
            (s.xyz[1] - e).abs() <= allowed,
            "paths at {}: {} ± {} lx, expected {e}",
            s.position,
            s.xyz[1],
            s.error_lx
        );
    }
}

#[test]
fn a_point_follows_the_inverse_square_and_the_cosine() {
    // CIE 171 5.2: E = I0 cos γ · cos γ / d² = I0 h²/d⁴. A table each degree is linear in between: 4e-5 off.
    let bytes =
        file(Opening::default(), &[0.0], &degrees(0.0, 90.0, 1.0), |v, _| 1000.0 * v.to_radians().cos().max(0.0));
    let places: Vec<(f64, f64)> = vec![(0.0, 0.0), (0.5, 0.0), (1.5, 0.0), (1.0, 0.5), (1.5, 1.5)];
    let points: Vec<_> = places.iter().map(|(x, y)| (at(*x, *y, 0.0), DVec3::Z)).collect();
    let mut b = floor(&points);
    hang(&mut b.0, bytes, at(0.0, 0.0, 3.0));
    let expected: Vec<f64> = places.iter().map(|(x, y)| 9000.0 / (9.0 + x * x + y * y).powi(2)).collect();
    expect(&b.0, &expected, 1e-4);
}

#[test]
fn planes_lie_where_the_scene_turns_them() {
    // 100 cd towards C0, 200 to C90, 300 to C180, 400 to C270, at 45 degrees.
    let bytes = file(Opening::default(), &[0.0, 90.0, 180.0, 270.0], &degrees(0.0, 90.0, 45.0), |_, h| 100.0 + h / 0.9);
    let places = [at(2.0, 0.0, 0.0), at(0.0, 2.0, 0.0), at(-2.0, 0.0, 0.0), at(0.0, -2.0, 0.0)];
    let mut b = floor(&places.map(|p| (p, DVec3::Z)));
    hang(&mut b.0, bytes, at(0.0, 0.0, 2.0));
    let lx = |candela: f64| candela * 0.5f64.sqrt() / 8.0;
    let read = |scene: &Scene| solve(scene, 0.01).grids[0].sensors.iter().map(|s| s.xyz[1]).collect::<Vec<_>>();
    for (found, candela) in read(&b.0).iter().zip([100.0, 200.0, 300.0, 400.0]) {
        // A sensor on a floor stands 4e-6 of the scene's size above it: 3e-5 of the light.
        assert!((found / lx(candela) - 1.0).abs() < 1e-4, "{found} {}", lx(candela));
    }
    // A quarter turn takes C0 to +y.
    b.0.luminaires[0].axes = DMat3::from_axis_angle(DVec3::Z, 0.5 * PI);
    for (found, candela) in read(&b.0).iter().zip([400.0, 100.0, 200.0, 300.0]) {
        // A sensor on a floor stands 4e-6 of the scene's size above it: 3e-5 of the light.
        assert!((found / lx(candela) - 1.0).abs() < 1e-4, "{found} {}", lx(candela));
    }
}

/// Illuminance of a Lambertian rectangle of unit luminance in the plane z = h at a point of the plane z = 0 that looks up,
/// by the sum over many small areas.
fn by_small_areas(side: f64, p: DVec3, normal: DVec3, luminance: impl Fn(DVec3) -> f64) -> f64 {
    let n = 1500;
    let step = side / f64::from(n);
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            let place = |k: i32| (f64::from(k) + 0.5) * step - 0.5 * side;
            let d = DVec3::new(place(i), place(j), 0.0) - p;
            let r2 = d.length_squared();
            sum += luminance(-d) * normal.dot(d).max(0.0) * d.z.max(0.0) / (r2 * r2) * step * step;
        }
    }
    sum
}

#[test]
fn near_a_panel_its_shape_counts() {
    // A square of 1 m that hangs at z = 2, once Lambertian, once narrow (I = cos³ γ, so L = cos² γ times 1/A). Points from
    // far to 5 cm below it, and one that looks sideways. The sum over small areas is good to 1e-4 at 5 cm (75 steps).
    let points = [
        (at(0.0, 0.0, 0.0), DVec3::Z),
        (at(1.5, 0.3, 0.0), DVec3::Z),
        (at(0.2, 0.1, 1.7), DVec3::Z),
        (at(0.45, 0.45, 1.95), DVec3::Z),
        (at(1.5, 0.3, 1.5), DVec3::NEG_X),
    ];
    for power in [1.0, 3.0] {
        let bytes = file(square(1.0), &[0.0], &degrees(0.0, 90.0, 0.5), |v, _| {
            1000.0 * v.to_radians().cos().max(0.0).powf(power)
        });
        let mut b = floor(&points);
        hang(&mut b.0, bytes, at(0.0, 0.0, 2.0));
        let luminance = |d: DVec3| 1000.0 * (-d.z / d.length()).powf(power - 1.0);
        let expected: Vec<f64> =
            points.iter().map(|(p, n)| by_small_areas(1.0, *p - at(0.0, 0.0, 2.0), *n, luminance)).collect();
        expect(&b.0, &expected, 2e-3);
    }
}

#[test]
fn a_disc_is_round() {
    // Howell C-22 by way of coaxial disc: E = π L r²/(r² + h²) on the axis; off it by CIE 171 5.3's disc of 5000 cd/m².
    let bytes = file(Opening { round: true, ..square(0.5) }, &[0.0], &degrees(0.0, 90.0, 0.5), |v, _| {
        5000.0 * PI * 0.0625 * v.to_radians().cos().max(0.0)
    });
    let points = [(0.0, 0.0), (1.0, 0.0), (3.0, 0.0), (0.2, 2.3), (0.3, 2.45)].map(|(x, z)| (at(x, 0.0, z), DVec3::Z));
    let mut b = floor(&points);
    hang(&mut b.0, bytes, at(0.0, 0.0, 2.5));
    let disc = |x: f64, z: f64| {
        let (h, l) = (2.5 - z, 5000.0);
        let (hh, rr) = (h / x, 0.25 / x);
        let big = 1.0 + hh * hh + rr * rr;
        // Configuration factor of a disc for a parallel element (Howell B-14 with Z = 1 + H² + R²).
        0.5 * PI * l * (1.0 - (1.0 + hh * hh - rr * rr) / (big * big - 4.0 * rr * rr).sqrt())
    };
    let axis = PI * 5000.0 * 0.0625 / (0.0625 + 6.25);
    expect(&b.0, &[axis, disc(1.0, 0.0), disc(3.0, 0.0), disc(0.2, 2.3), disc(0.3, 2.45)], 5e-3);
}

#[test]
fn a_line_lights_as_the_sum_of_its_points() {
    let line = Opening { along_c0_m: 2.0, ..Opening::default() };
    let bytes = file(line, &[0.0], &[0.0, 180.0], |_, _| 100.0);
    let points = [(at(0.0, 0.5, 0.0), DVec3::Z), (at(1.0, 0.0, 1.5), DVec3::Z)];
    let mut b = floor(&points);
    hang(&mut b.0, bytes, at(0.0, 0.0, 2.0));
    // ∫ I/l · h/(ρ² + t²)^{3/2} dt = I h/(l ρ²) [t/√(ρ² + t²)], ρ the distance of the point from the line.
    let exact = |x: f64, rho2: f64, h: f64| {
        let end = |t: f64| t / (rho2 + t * t).sqrt();
        100.0 * h / (2.0 * rho2) * (end(1.0 - x) + end(1.0 + x))
    };
    expect(&b.0, &[exact(0.0, 4.25, 2.0), exact(1.0, 0.25, 0.5)], 5e-3);
}

#[test]
fn a_board_shades_exactly_what_it_hides() {
    // A board at half height hides half of a square panel from the point below its edge; a point lamp wholly or not at all.
    let cosine = |v: f64| 1000.0 * v.to_radians().cos().max(0.0);
    for (opening, shares) in [(square(1.0), [0.5, 0.0]), (Opening::default(), [1.0, 0.0])] {
        let points = [(at(0.0, 0.0, 0.0), DVec3::Z), (at(-2.0, 0.0, 0.0), DVec3::Z)];
        let mut free = floor(&points);
        let mut shaded = floor(&points);
        // Its edge stands at x = 1e-6, just beside the line from the middle of the lamp to the first point.
        let black = shaded.material(diffuse("board", 0.0));
        shaded.rectangle(at(-3.0, -3.0, 1.0), at(3.0 - 1e-6, 0.0, 0.0), at(0.0, 6.0, 0.0), black);
        for b in [&mut free, &mut shaded] {
            hang(&mut b.0, file(opening, &[0.0], &degrees(0.0, 90.0, 1.0), |v, _| cosine(v)), at(0.0, 0.0, 2.0));
        }
        let (free, shaded) = (solve(&free.0, 0.01), solve(&shaded.0, 0.01));
        for (k, share) in shares.iter().enumerate() {
            let (a, b) = (free.grids[0].sensors[k].xyz[1], shaded.grids[0].sensors[k].xyz[1]);
            assert!((b - share * a).abs() < 1e-4 * a, "{opening:?} {k}: {b} of {a}");
        }
    }
}

#[test]
fn a_ceiling_does_not_shade_what_lies_in_its_plane() {
    // In a corridor of 20 m, at walls near by: grazing rays to a lamp in the ceiling must not end at the ceiling.
    for opening in [Opening::default(), square(0.1)] {
        let mut b = Build::new();
        let black = b.material(diffuse("black", 0.0));
        b.room(at(0.0, 0.0, 0.0), at(20.0, 2.0, 2.6), [black; 6]);
        let lamp = at(14.0, 1.4, 2.6);
        let points = [at(14.72, 2.0, 2.18), at(14.1, 2.0, 2.4), at(15.5, 2.0, 2.3), at(14.0, 2.0, 1.0)];
        b.points("wall", &points.map(|p| (p, DVec3::NEG_Y)));
        hang(
            &mut b.0,
            file(opening, &[0.0], &degrees(0.0, 90.0, 0.5), |v, _| 1000.0 * v.to_radians().cos().max(0.0)),
            lamp,
        );
        let side = opening.along_c0_m.max(1e-6);
        let expected = points.map(|p| by_small_areas(side, p - lamp, DVec3::NEG_Y, |_| 1000.0 / (side * side)));
        expect(&b.0, &expected, 1e-3);
    }
}

#[test]
fn a_pane_takes_what_its_transmittance_says() {
    // Straight below a pane of 0.88 at normal incidence.
    for opening in [Opening::default(), square(0.02)] {
        let points = [(at(0.0, 0.0, 0.0), DVec3::Z)];
        let mut b = floor(&points);
        let pane = b.material(glass(0.88));
        b.rectangle(at(-1.0, -1.0, 1.0), at(2.0, 0.0, 0.0), at(0.0, 2.0, 0.0), pane);
        hang(&mut b.0, file(opening, &[0.0], &[0.0, 90.0], |_, _| 1000.0), at(0.0, 0.0, 2.0));
        let lx = solve(&b.0, 0.01).grids[0].sensors[0].direct_lx;
        assert!((lx / (0.88 * 250.0) - 1.0).abs() < 1e-3, "{lx}");
    }
}

/// A closed cube of 4 m with a grid of points; reflectance `rho`.
fn cube(rho: f64) -> Build {
    let mut b = Build::new();
    let wall = b.material(diffuse("wall", rho));
    b.room(at(0.0, 0.0, 0.0), at(4.0, 4.0, 4.0), [wall; 6]);
    b
}

#[test]
fn a_closed_box_conserves_the_flux_of_every_shape() {
    // CIE 171 5.4 and 5.8: emitted = absorbed, within 0.1 % or the ledger's own sampling error (99 %).
    let even = |_: f64, _: f64| 10_000.0 / (4.0 * PI);
    let sided = |v: f64, h: f64| (500.0 + h) * (v.to_radians().cos().abs() + 0.1);
    let boxed = Opening { along_c0_m: 0.6, along_c90_m: 0.3, height_m: 0.2, round: false };
    let quarter = degrees(0.0, 180.0, 45.0);
    let cases = [
        file(Opening::default(), &[0.0], &[0.0, 180.0], even),
        file(boxed, &quarter, &degrees(0.0, 180.0, 10.0), sided),
        file(Opening { height_m: 0.0, ..boxed }, &quarter, &degrees(0.0, 90.0, 10.0), sided),
    ];
    for (k, bytes) in cases.into_iter().enumerate() {
        let mut b = cube(0.5);
        b.level("level", at(0.2, 0.2, 1.0), at(3.8, 3.8, 1.0), 4);
        hang(&mut b.0, bytes, at(2.0, 1.5, 2.5));
        let flux_lm = Luminaires::new(&b.0).unwrap().list[0].flux_lm;
        let m = solve(&b.0, 0.02);
        let ledger = &m.ledger;
        let lumens = ledger.emitted[0] * m.bands.xyz(&[1.0])[1];
        assert!((lumens / flux_lm - 1.0).abs() < 1e-6, "case {k}: {lumens} of {flux_lm} lm");
        let rest = ledger.emitted[0] - ledger.absorbed[0] - ledger.escaped[0] - ledger.unexpanded[0];
        let allowed = (1e-3 * ledger.emitted[0]).max(ledger.sampling_error[0]);
        eprintln!(
            "case {k}: open by {:.5} %, sampling error {:.5} %",
            100.0 * rest / ledger.emitted[0],
            100.0 * ledger.sampling_error[0] / ledger.emitted[0]
        );
        assert!(rest.abs() <= allowed, "case {k}: open by {} of {}", rest, ledger.emitted[0]);
    }
}

#[test]
fn interreflection_of_a_luminaire_has_its_closed_form() {
    // Closed cube, uniform ρ: mean reflected illuminance over all faces = ρ Φ/(S (1 − ρ)) (CIE 171 5.8).
    for rho in [0.2, 0.8] {
        let mut b = cube(rho);
        // Gauss's rule of five points on each axis of each face.
        let (outer, inner, middle) = (0.118_463_4, 0.239_314_3, 0.284_444_4);
        let rule =
            [(0.187_640_4, outer), (0.923_061_4, inner), (2.0, middle), (3.076_938_6, inner), (3.812_359_6, outer)];
        let mut points = Vec::new();
        let mut weights = Vec::new();
        for (u, wu) in &rule {
            for (v, wv) in &rule {
                points.extend([
                    (at(*u, *v, 0.0), DVec3::Z),
                    (at(*u, *v, 4.0), DVec3::NEG_Z),
                    (at(0.0, *u, *v), DVec3::X),
                    (at(4.0, *u, *v), DVec3::NEG_X),
                    (at(*u, 0.0, *v), DVec3::Y),
                    (at(*u, 4.0, *v), DVec3::NEG_Y),
                ]);
                weights.extend([wu * wv / 6.0; 6]);
            }
        }
        b.points("faces", &points);
        hang(
            &mut b.0,
            file(Opening::default(), &[0.0], &[0.0, 180.0], |_, _| 10_000.0 / (4.0 * PI)),
            at(2.0, 2.0, 2.0),
        );
        let m = solve(&b.0, 0.02);
        let mean = m.grids[0].sensors.iter().zip(&weights).map(|(s, w)| w * s.reflected_lx).sum::<f64>();
        let exact = rho * 10_000.0 / (96.0 * (1.0 - rho));
        // The rule errs by 0.1 % (computed for the first bounce); the noise of 150 sensors averages out.
        assert!((mean / exact - 1.0).abs() < 3e-3, "rho {rho}: {mean} lx, exact {exact}");
    }
}

#[test]
fn many_luminaires_are_the_sum_of_each_and_agree_with_paths() {
    // 25 small downlights in a furnished room: most are drawn for most elements, and the light is that of the paths.
    let bytes =
        file(square(0.1), &[0.0], &degrees(0.0, 90.0, 5.0), |v, _| 400.0 * v.to_radians().cos().max(0.0).powi(3));
    let mut b = Build::new();
    let (wall, wood) = (b.material(diffuse("wall", 0.6)), b.material(diffuse("wood", 0.3)));
    b.room(at(0.0, 0.0, 0.0), at(10.0, 10.0, 3.0), [wall; 6]);
    b.block(at(3.0, 3.0, 0.0), at(5.0, 4.0, 1.5), wood);
    b.level("level", at(0.5, 0.5, 0.8), at(9.5, 9.5, 0.8), 4);
    let positions = (0..25).map(|k| at(1.0 + 2.0 * f64::from(k % 5), 1.0 + 2.0 * f64::from(k / 5), 2.95)).collect();
    hang_at(&mut b.0, bytes, positions);
    let m = solve(&b.0, 0.03);
    let reference = common::solve(&b.0, &common::paths(60_000));
    let mut covered = 0;
    for (a, r) in m.grids[0].sensors.iter().zip(&reference.grids[0].sensors) {
        let off = (a.xyz[1] - r.xyz[1]).abs();
        covered += usize::from(off <= a.error_lx.hypot(r.error_lx));
        assert!(
            off <= 3.0 * a.error_lx.hypot(r.error_lx),
            "{} ± {} lx, paths {} ± {}",
            a.xyz[1],
            a.error_lx,
            r.xyz[1],
            r.error_lx
        );
    }
    assert!(covered >= 14, "{covered} of 16");
}

#[test]
fn pictures_show_a_panel_with_its_luminance() {
    // A Lambertian panel of 1 m² and 1000 cd has 1000 cd/m² from everywhere; the black room has none.
    let mut b = cube(0.0);
    b.0.views.push(View {
        name: "up".into(),
        position: at(2.0, 2.0, 1.0),
        direction: DVec3::Z,
        up: DVec3::Y,
        projection: Projection::Perspective { horizontal: 1.5, vertical: 1.5 },
        width: 9,
        height: 9,
    });
    let bytes = file(square(1.0), &[0.0], &degrees(0.0, 90.0, 1.0), |v, _| 1000.0 * v.to_radians().cos().max(0.0));
    hang(&mut b.0, bytes, at(2.0, 2.0, 4.0));
    for options in [common::within(0.05), common::paths(32)] {
        let m = common::solve(&b.0, &options);
        let luminance = |pixel: usize| f64::from(m.views[0].xyz[pixel][1]);
        assert!((luminance(40) / 1000.0 - 1.0).abs() < 1e-3, "{}", luminance(40));
        assert_eq!(luminance(0), 0.0);
    }
}

#[test]
fn glare_follows_the_formula_of_cie_117() {
    // A panel of 0.6 m straight before the eye and 1.6 m above it: τ = 0, σ = atan(1.6/2).
    let mut b = cube(0.5);
    let eye = at(2.0, 0.5, 1.2);
    b.points("eye", &[(eye, DVec3::Y), (eye, DVec3::NEG_Y)]);
    b.0.observers = vec![0];
    let candela = |v: f64, _: f64| 1000.0 * v.to_radians().cos().max(0.0);
    hang(&mut b.0, file(square(0.6), &[0.0], &degrees(0.0, 90.0, 0.5), candela), at(2.0, 2.5, 2.8));
    let m = solve(&b.0, 0.01);
    let (g, s) = (&m.glare[0], &m.grids[0].sensors[0]);
    let sigma = (1.6f64 / 2.0).atan().to_degrees();
    let index = ((35.2 - 1.22) * 1e-3 * sigma + 21e-5 * sigma * sigma).exp();
    let luminance = 1000.0 / 0.36;
    // The solid angle by small areas: A cos θ/r² with the height over the eye the same everywhere.
    let n = 200;
    let place = |k: i32| (f64::from(k) + 0.5) * 0.6 / f64::from(n) - 0.3;
    let solid_angle: f64 = (0..n * n)
        .map(|k| at(2.0 + place(k % n), 2.5 + place(k / n), 2.8) - eye)
        .map(|d| 1.6 / d.length().powi(3) * 0.36 / f64::from(n * n))
        .sum();
    let ugr = 8.0 * (0.25 * PI / s.reflected_lx * luminance * luminance * solid_angle / (index * index)).log10();
    // 64 places give the solid angle to 1 %: 0.03.
    assert!((g.ugr.unwrap_or(0.0) - ugr).abs() < 0.03, "{g:?} {ugr}");
    assert!((g.background_cd_m2 - s.reflected_lx / PI).abs() < 1e-9);
    assert_eq!(m.glare[1].ugr, None, "no luminaire before the eye");
}

#[test]
fn classic_methods_refuse_luminaires_by_name() {
    let mut b = cube(0.5);
    b.level("level", at(0.2, 0.2, 1.0), at(3.8, 3.8, 1.0), 2);
    hang(&mut b.0, file(Opening::default(), &[0.0], &[0.0, 180.0], |_, _| 100.0), at(2.0, 2.0, 2.0));
    let error = measure::solve(&b.0, &SolveOptions { method: Method::Gathering, ..common::within(0.05) }, &Silent)
        .unwrap_err()
        .to_string();
    assert!(error.contains("[[luminaires]]") && error.contains("mend:"), "{error}");
}

#[test]
fn a_luminaire_behind_the_ceiling_is_told() {
    let mut b = cube(0.5);
    b.level("level", at(0.2, 0.2, 1.0), at(3.8, 3.8, 1.0), 2);
    hang(&mut b.0, file(square(0.6), &[0.0], &[0.0, 90.0], |v, _| 100.0 - v), at(2.0, 2.0, 4.02));
    let m = solve(&b.0, 0.05);
    assert!(
        m.record.warnings.iter().any(|w| w.contains("lamp.ies") && w.contains("20.0 mm away")),
        "{:?}",
        m.record.warnings
    );
    // In the plane of the ceiling it shines.
    b.0.luminaires[0].positions[0].z = 4.0;
    let m = solve(&b.0, 0.05);
    assert!(m.grids[0].sensors[0].direct_lx > 1.0 && m.record.warnings.is_empty(), "{:?}", m.record.warnings);
}

#[test]
fn a_point_close_to_a_floor_gives_it_no_more_than_its_flux() {
    // A candle of 100 cd at height h over the middle of the floor of a closed cube of 1 m: E = I / h² at its foot, however
    // near, and the cube takes in what is emitted: 400 π lm.
    for height in [0.1, 0.01, 0.001] {
        // Sensors stand on the skin of the floor, a micrometre up.
        let share = 1e-5 + 2e-6 / height;
        let mut b = Build::new();
        let wall = b.material(diffuse("wall", 0.5));
        b.room(DVec3::ZERO, DVec3::ONE, [wall; 6]);
        b.points(
            "points",
            &[(at(0.5, 0.5, 0.0), DVec3::Z), (at(0.9, 0.5, 0.0), DVec3::Z), (at(0.2, 0.3, 1.0), -DVec3::Z)],
        );
        hang(&mut b.0, file(Opening::default(), &[0.0], &[0.0, 180.0], |_, _| 100.0), at(0.5, 0.5, height));
        let m = solve(&b.0, 0.02);
        let direct: Vec<f64> = m.grids[0].sensors.iter().map(|s| s.direct_lx).collect();
        let ratio =
            |lux: f64, exact: f64| assert!((lux / exact - 1.0).abs() < share, "{height} m: {lux} lx, exact {exact}");
        ratio(direct[0], 100.0 / (height * height));
        ratio(direct[1], 100.0 * height / (0.16 + height * height).powf(1.5));
        let up = 1.0 - height;
        ratio(direct[2], 100.0 * up / (0.13 + up * up).powf(1.5));
        let ledger = &m.ledger;
        let rest = ledger.emitted[0] - ledger.absorbed[0] - ledger.escaped[0] - ledger.unexpanded[0];
        let allowed = (1e-3 * ledger.emitted[0]).max(ledger.sampling_error[0]);
        assert!(rest.abs() <= allowed, "{height} m: open by {rest} of {}", ledger.emitted[0]);
        for s in &m.grids[0].sensors {
            assert!(s.error_lx < 0.2 * s.xyz[1], "{height} m: {} ± {} lx", s.xyz[1], s.error_lx);
        }
    }
}
