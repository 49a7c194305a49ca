//! Skies and sun against reference values that lie beside the project; skipped, and said so, where they do not.

use std::f64::consts::PI;
use std::path::PathBuf;

use clerestory::light::sky::{PerezInput, Sky, SkyModel, cie_coefficients};
use clerestory::light::sun::{Air, Moment, Place, SunPosition};
use glam::DVec3;

/// The rows of a table, by column name; `None` where the file is not there.
fn table(name: &str) -> Option<Vec<std::collections::BTreeMap<String, String>>> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared").join(name);
    if !path.exists() {
        eprintln!("skipped: no {}", path.display());
        return None;
    }
    let mut reader = csv::Reader::from_path(&path).expect("readable");
    let heads = reader.headers().expect("a header").clone();
    let rows = reader.records().map(|r| {
        let r = r.expect("a row");
        heads.iter().zip(r.iter()).map(|(h, v)| (h.to_owned(), v.to_owned())).collect()
    });
    Some(rows.collect())
}

type Row = std::collections::BTreeMap<String, String>;

fn number(row: &Row, key: &str) -> f64 {
    row[key].parse().unwrap_or_else(|_| panic!("{key} = {:?}", row[key]))
}

fn direction(altitude_deg: f64, azimuth_deg: f64) -> DVec3 {
    SunPosition { altitude_deg, azimuth_deg }.direction(0.0)
}

fn sky_of(number: u8, sun: DVec3) -> Sky {
    let model =
        if number == 16 { SkyModel::Overcast } else { SkyModel::Cie(cie_coefficients(number).expect("a type")) };
    Sky::new(model, sun)
}

#[test]
fn cie_skies_match_to_a_millionth() {
    let Some(rows) = table("data/sky/golden_cie_sky.csv") else { return };
    for row in &rows {
        let sky = sky_of(row["sky_type"].parse().unwrap(), direction(number(row, "sun_altitude_deg"), 180.0));
        let found = if row["point_altitude_deg"] == "diffuse_horizontal_over_zenith" {
            sky.horizontal_over_zenith()
        } else {
            let azimuth = 180.0 + number(row, "azimuth_from_sun_deg");
            sky.luminance(direction(number(row, "point_altitude_deg"), azimuth)) * sky.horizontal_over_zenith()
        };
        let wanted = number(row, "value");
        assert!((found / wanted - 1.0).abs() < 1e-6, "{row:?}: {found}");
    }
    assert!(rows.len() > 400);
}

#[test]
fn perez_skies_match_to_a_hundred_thousandth() {
    let Some(rows) = table("data/sky/golden_perez.csv") else { return };
    for row in &rows {
        let moment = PerezInput {
            direct_normal_w_m2: number(row, "dni_W_m2"),
            diffuse_horizontal_w_m2: number(row, "dhi_W_m2"),
            sun_zenith_deg: 90.0 - number(row, "sun_altitude_deg"),
            day_of_year: row["day_of_year"].parse().unwrap(),
            precipitable_water_cm: number(row, "precipitable_water_cm"),
        };
        let perez = moment.sky();
        let near = |found: f64, key: &str, limit: f64| {
            let wanted = number(row, key);
            assert!((found - wanted).abs() <= limit * wanted.abs().max(1e-3), "{} {key}: {found} {wanted}", row["row"]);
        };
        near(perez.clearness, "epsilon", 1e-6);
        near(perez.brightness, "delta", 1e-6);
        for (value, key) in [
            (perez.coefficients.a, "a"),
            (perez.coefficients.b, "b"),
            (perez.coefficients.c, "c"),
            (perez.coefficients.d, "d"),
            (perez.coefficients.e, "e"),
            (perez.diffuse_lm_w, "diffuse_efficacy_lm_W"),
            (perez.direct_lm_w, "direct_efficacy_lm_W"),
        ] {
            near(value, key, 1e-6);
        }
        let azimuth = number(row, "sun_azimuth_deg");
        let sky = Sky::new(SkyModel::Perez(perez.coefficients), direction(number(row, "sun_altitude_deg"), azimuth));
        let diffuse_lx = moment.diffuse_horizontal_w_m2 * perez.diffuse_lm_w;
        near(diffuse_lx, "diffuse_horizontal_lux", 1e-6);
        let mut points = 0;
        for key in row.keys() {
            let Some((altitude, offset)) = key.strip_prefix("L_alt").and_then(|k| k.split_once("_daz")) else {
                continue;
            };
            let toward = direction(altitude.parse().unwrap(), azimuth + offset.parse::<f64>().unwrap());
            near(diffuse_lx * sky.luminance(toward), key, 1e-5);
            points += 1;
        }
        assert_eq!(points, 12);
    }
    assert!(rows.len() >= 7);
}

/// Irradiance of a plane from a sky, by midpoints in the azimuth and in the square of the sine of the altitude.
fn irradiance(sky: &Sky, normal: DVec3) -> f64 {
    let (n, m) = (500, 720);
    let mut sum = 0.0;
    for i in 0..n {
        let sine = ((f64::from(i) + 0.5) / f64::from(n)).powi(2);
        let (r, weight) = ((1.0 - sine * sine).sqrt(), 2.0 * (f64::from(i) + 0.5) / f64::from(n));
        for j in 0..m {
            let azimuth = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(m);
            let d = DVec3::new(r * azimuth.sin(), r * azimuth.cos(), sine);
            sum += weight * d.dot(normal).max(0.0) * sky.luminance(d);
        }
    }
    sum * 2.0 * PI / f64::from(n * m)
}

#[test]
fn integrals_over_sixteen_skies_match_to_a_ten_thousandth() {
    let Some(rows) = table("validation-reference/sky_integrals.csv") else { return };
    for row in &rows {
        let sun = direction(number(row, "sun_elevation"), number(row, "sun_azimuth"));
        let sky = sky_of(row["sky"].parse().unwrap(), sun);
        assert!((sky.horizontal_over_zenith() / number(row, "Eh_over_Lz") - 1.0).abs() < 1e-7, "{row:?}");
        for (key, normal) in [
            ("Ev_N_over_Eh", DVec3::Y),
            ("Ev_E_over_Eh", DVec3::X),
            ("Ev_S_over_Eh", DVec3::NEG_Y),
            ("Ev_W_over_Eh", DVec3::NEG_X),
        ] {
            let found = irradiance(&sky, normal);
            assert!((found / number(row, key) - 1.0).abs() < 1e-4, "{row:?} {key}: {found}");
        }
    }
    assert_eq!(rows.len(), 32);
}

#[test]
fn the_sun_stands_where_it_should_to_a_hundredth_of_a_degree() {
    let Some(rows) = table("data/sky/golden_solar.csv") else { return };
    let mut checked = 0;
    for row in &rows {
        let utc = &row["utc"];
        let part = |from: usize, to: usize| utc[from..to].parse::<f64>().unwrap();
        let moment = Moment {
            year: part(0, 4) as i32,
            month: part(5, 7) as u32,
            day: part(8, 10) as u32,
            hours: part(11, 13)
                + part(14, 16) / 60.0
                + utc[17..].trim_end_matches('Z').parse::<f64>().unwrap() / 3600.0,
        };
        let place =
            Place { latitude_deg: number(row, "latitude_deg"), longitude_deg: number(row, "longitude_east_deg") };
        let air = Air { pressure_hpa: number(row, "pressure_hPa"), temperature_c: number(row, "temperature_C") };
        let sun = SunPosition::at(&moment, place, air).unwrap();
        // Where the sun is high the azimuth means little: directions are compared.
        let wanted = direction(number(row, "apparent_elevation_deg"), number(row, "azimuth_from_north_east_deg"));
        let off = sun.direction(0.0).angle_between(wanted).to_degrees();
        assert!(off < 0.01, "{} {utc}: {off} degrees off", row["place"]);
        checked += 1;
    }
    assert!(checked >= 60 - 1);
}
