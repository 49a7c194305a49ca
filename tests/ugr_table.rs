//! The glare table against a sum over the whole array and the room's own radiosity solution; the near field against area
//! sources; luminaires in mirrors against their bound.

mod common;

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use clerestory::light::photometry::{PhotometricType, Photometry, Web, to_ies};
use clerestory::light::{UGR_REFLECTANCES, UgrSpacing, ugr_table};
use clerestory::scene::{LuminaireRow, Scene};
use common::{Build, assert_near, assert_ratio, at, diffuse, guth, mirror, solve, within};
use glam::DVec3;

fn panel() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("luminaires/panel.ies")
}

fn hang(scene: &mut Scene, bytes: Vec<u8>, positions: Vec<DVec3>) {
    scene.luminaires.push(LuminaireRow::aimed_down(bytes, positions));
}

#[test]
fn the_glare_table_is_the_sum_over_the_array_against_the_solved_walls() {
    // 4H x 8H at H = 1 m, the luminaires half a millimetre below the ceiling; 3600 lm of 0.6 m x 0.6 m, Lambertian.
    let (x, y, rho) = (4.0, 8.0, UGR_REFLECTANCES[0]);
    let mut b = Build::new();
    let [ceiling, wall, floor] = [0, 1, 2].map(|k| b.material(diffuse("surface", rho[k])));
    b.room(DVec3::ZERO, at(x, y, 1.0), [wall, wall, wall, wall, floor, ceiling]);
    let places: Vec<DVec3> =
        (0..512).map(|k| at(0.125 + 0.25 * f64::from(k % 16), 0.125 + 0.25 * f64::from(k / 16), 0.9995)).collect();
    // As points: the table puts the light into directions as the file has it.
    let file = Photometry::read(&panel()).expect("shipped");
    let point = Photometry { opening: Default::default(), ..file };
    hang(&mut b.0, to_ies(&point).into_bytes(), places.clone());
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for (corner, along, normal) in [
        (DVec3::ZERO, at(0.0, y, 0.0), DVec3::X),
        (at(x, 0.0, 0.0), at(0.0, y, 0.0), DVec3::NEG_X),
        (DVec3::ZERO, at(x, 0.0, 0.0), DVec3::Y),
        (at(0.0, y, 0.0), at(x, 0.0, 0.0), DVec3::NEG_Y),
    ] {
        for i in 0..8 {
            for j in 0..4 {
                let place = |k: i32, n: f64| (f64::from(k) + 0.5) / n;
                points.push((corner + along * place(i, 8.0) + DVec3::Z * place(j, 4.0), normal));
                weights.push(along.length());
            }
        }
    }
    b.points("walls", &points);
    let m = solve(&b.0, &within(0.05));
    let whole: f64 = weights.iter().sum();
    let mean = m.grids[0].sensors.iter().zip(&weights).map(|(s, w)| w * s.reflected_lx).sum::<f64>() / whole;
    // L = 3600 lm/(π 0.36 m²), ω = 0.36 m² cos θ/r².
    let luminance = 3600.0 / (PI * 0.36);
    let sum: f64 = places
        .iter()
        .map(|p| {
            let (aside, ahead, above) = (p.x - 0.5 * x, p.y, 1.0);
            let r2 = aside * aside + ahead * ahead + above * above;
            luminance * luminance * 0.36 * above / r2.powf(1.5) / guth(aside, ahead, above).powi(2)
        })
        .sum();
    let expected = 8.0 * (0.25 / (mean / PI) * sum).log10();
    let table = ugr_table(&Photometry::read(&panel()).expect("shipped"), UgrSpacing::Quarter).expect("it has an area");
    let row = table.iter().find(|r| (r.x, r.y) == (4, 8)).expect("a standard room");
    assert_near(row.along_c0[0], expected, 0.2, "UGR of 4H x 8H");
}

#[test]
fn half_a_metre_below_a_long_panel_its_area_counts() {
    // 1.2 m x 0.3 m, 1000 cd at nadir, Lambertian: the sum over small areas, 1200 x 300 of them.
    let blank = Photometry::read(&panel()).expect("shipped");
    let angles: Vec<f64> = (0..=180).map(|k| 0.5 * f64::from(k)).collect();
    let candela = angles.iter().map(|a| 1000.0 * a.to_radians().cos().max(0.0)).collect();
    let web = Web::new(PhotometricType::C, angles, vec![0.0], candela).expect("sound");
    let opening =
        clerestory::light::photometry::Opening { along_c0_m: 1.2, along_c90_m: 0.3, height_m: 0.0, round: false };
    let bytes = to_ies(&Photometry { web, opening, ..blank }).into_bytes();
    let mut b = Build::new();
    let black = b.material(diffuse("black", 0.0));
    b.rectangle(at(-5.0, -5.0, 0.0), at(10.0, 0.0, 0.0), at(0.0, 10.0, 0.0), black);
    let points = [at(0.0, 0.0, 0.0), at(0.6, 0.1, 0.0), at(1.0, -0.3, 0.0)];
    b.points("points", &points.map(|p| (p, DVec3::Z)));
    hang(&mut b.0, bytes, vec![at(0.0, 0.0, 0.5)]);
    let m = solve(&b.0, &within(0.05));
    for (s, p) in m.grids[0].sensors.iter().zip(points) {
        let mut exact = 0.0;
        for i in 0..1200 {
            for j in 0..300 {
                let d = at(1e-3 * (f64::from(i) + 0.5) - 0.6, 1e-3 * (f64::from(j) + 0.5) - 0.15, 0.5) - p;
                exact += 1000.0 / 0.36 * 1e-6 * 0.25 / d.length_squared().powi(2);
            }
        }
        assert_ratio(s.xyz[1], exact, 2e-3, "near a panel");
        let point = 1000.0 * 0.25 / (at(0.0, 0.0, 0.5) - p).length_squared().powi(2);
        assert!((point / exact - 1.0).abs() > 0.05, "as a point it would be off: {point} {exact}");
    }
}

#[test]
fn the_bound_of_mirrored_luminaires_holds_their_image() {
    // A mirror of reflectance 0.8 upright beside a lamp of 1000 cd to all sides: the image of a point is as far behind it.
    let bytes = b"IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 0\n0 180\n0\n1000 1000\n".to_vec();
    let mut b = Build::new();
    let (black, shiny) = (b.material(diffuse("black", 0.0)), b.material(mirror(0.8)));
    b.rectangle(at(-5.0, -5.0, 0.0), at(10.0, 0.0, 0.0), at(0.0, 10.0, 0.0), black);
    b.rectangle(at(-3.0, 2.0, 0.0), at(6.0, 0.0, 0.0), at(0.0, 0.0, 3.0), shiny);
    b.points("points", &[(at(0.0, 0.0, 0.0), DVec3::Z)]);
    hang(&mut b.0, bytes, vec![at(0.0, 1.0, 2.0)]);
    let m = solve(&b.0, &within(0.05));
    let told = &m.record.left_out.iter().find(|l| l.what.contains("luminaires mirrored")).expect("it is told").bound;
    let bound: f64 = told["at most ".len()..].split(' ').next().expect("a number").parse().expect("a number");
    // The image lies at (0, 3, 2): E = 0.8 I h/d³.
    let exact = 0.8 * 1000.0 * 2.0 / 13.0f64.powf(1.5);
    assert!(bound >= 0.999 * exact && bound < 1.1 * exact, "{told}: {exact}");
}
