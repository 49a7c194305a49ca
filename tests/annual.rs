//! A year of daylight: against closed forms, and against the same moments solved one by one.

mod common;

use std::path::Path;

use clerestory::annual::{self, AnnualOptions, Year};
use clerestory::measure::{Silent, Status};
use clerestory::scene::{Amount, Blind, BlindControl, Occupancy, Placed};
use common::bsdf::{lambertian, window};
use common::year::{against_moments, daytime, room, synthetic, year};
use common::{Build, at, diffuse, glass};
use glam::DVec3;

#[test]
fn the_shipped_weather_is_what_its_formula_says() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/weather/synthetic.wea");
    let shipped = std::fs::read_to_string(path).expect("it is shipped");
    assert!(shipped == synthetic::wea().expect("a sun for every hour"), "run the example synthetic-weather");
}

#[test]
fn in_the_open_every_hour_is_sky_and_sun_as_the_weather_has_them() {
    let mut b = Build::new();
    let black = b.material(diffuse("black", 0.0));
    b.rectangle(at(-0.05, -0.05, -5.0), at(0.1, 0.0, 0.0), at(0.0, 0.1, 0.0), black);
    b.points("points", &[(DVec3::ZERO, DVec3::Z), (DVec3::ZERO, -DVec3::Y)]);
    b.0.daytime = Some(daytime());
    let y = year(&b.0, 0.05, 1);
    let s = &y.grids[0].series;
    let (mut whole, mut exact) = (0.0, 0.0);
    for (t, hour) in y.climate.hours.iter().enumerate() {
        let sun = hour.direct_lx * hour.sun.z;
        // The sun's disc is cut by the horizon below half a diameter.
        if hour.sun.z > 0.005 {
            assert!((f64::from(s.sun_of(0)[t]) - sun).abs() <= 1e-3 * sun + 1e-3, "hour {}", hour.index);
            let facing = hour.direct_lx * (-hour.sun.y).max(0.0);
            assert!((f64::from(s.sun_of(1)[t]) - facing).abs() <= 5e-3 * hour.direct_lx, "hour {}", hour.index);
        }
        let up = f64::from(s.of(0)[t]);
        // A patch of 3° about the sun stands for its middle: 2 % of the sky's light at most.
        assert!((up - sun - hour.diffuse_lx).abs() <= 0.02 * hour.diffuse_lx + 1e-2, "hour {}: {up}", hour.index);
        whole += up;
        exact += sun + hour.diffuse_lx;
    }
    assert!((whole / exact - 1.0).abs() < 2e-3, "over the year: {whole} for {exact}");
    // At equinox the sun is up for half of the day everywhere; what faces south sees it all that time, within two steps of
    // 5 minutes, refraction and the disc's half.
    let [_, spring] = [0, 1].map(|i| y.grids[0].metrics.points[i].as_ref().expect("it sees").sunlight_h[1]);
    assert!((spring - 12.0).abs() < 0.5, "{spring} h");
}

#[test]
fn any_hour_of_the_year_is_what_solve_says_of_that_moment() {
    let b = room(glass(0.8));
    let y = year(&b.0, 0.05, 4);
    against_moments(&b.0, &y, (0.02, 8), |hour| hour.diffuse_lx > 5000.0).assert(150, 0.03);
}

#[test]
fn the_same_bits_come_for_any_number_of_threads() {
    let b = room(glass(0.8));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| year(&b.0, 0.1, 1).grids[0].series.clone())
    };
    let (one, three) = (on(1), on(3));
    assert!(one.lux == three.lux && one.error == three.error && one.sun == three.sun);
}

/// The room with blinds of a kind.
fn shaded(control: BlindControl, transmittance: f64) -> Year {
    let mut b = room(glass(0.8));
    b.0.blinds = vec![Blind { panes: vec!["glass".into()], transmittance, control }];
    year(&b.0, 0.1, 1)
}

#[test]
fn closed_blinds_dim_every_hour_and_stop_the_sun() {
    let open = shaded(BlindControl::Fixed(false), 0.1);
    let plain = year(&room(glass(0.8)).0, 0.1, 1);
    let closed = shaded(BlindControl::Fixed(true), 0.1);
    let [open, plain, closed] = [&open, &plain, &closed].map(|y| &y.grids[0].series);
    for k in 0..open.lux.len() {
        let scale = plain.lux[k].max(1.0);
        assert!((open.lux[k] - plain.lux[k]).abs() <= 1e-4 * scale, "open blinds are no blinds");
        let without_sun = open.lux[k] - open.sun[k];
        assert!((closed.lux[k] - 0.1 * without_sun).abs() <= 1e-3 * scale, "{} {without_sun}", closed.lux[k]);
        assert_eq!(open.sun[k], closed.sun[k], "sunlight is counted with blinds open");
    }
}

#[test]
fn blinds_by_lm_83_close_while_the_sun_is_on_too_many_points() {
    let (open, run) = (shaded(BlindControl::Fixed(false), 0.05), shaded(BlindControl::Sun, 0.05));
    let (open, run) = (&open.grids[0].series, &run.grids[0].series);
    let sensors = open.lux.len() / open.hours;
    let mut closed = 0;
    for t in 0..open.hours {
        let sunlit = (0..sensors).filter(|i| open.sun_of(*i)[t] >= 1000.0).count();
        let should = sunlit as f64 > 0.02 * sensors as f64;
        let is = (0..sensors).any(|i| run.of(i)[t] < 0.5 * open.of(i)[t]);
        assert_eq!(should, is, "hour {t}: {sunlit} points in the sun");
        closed += usize::from(is);
    }
    assert!(closed > 10 && closed < open.hours);
}

#[test]
fn blinds_before_a_window_with_a_bsdf_are_refused() {
    let mut b = room(window(lambertian(0.5, 0.3), 1.0));
    b.0.blinds = vec![Blind { panes: vec!["window".into()], transmittance: 0.1, control: BlindControl::Sun }];
    let said = annual::annual(&b.0, &AnnualOptions::default(), &Silent).expect_err("it scatters").to_string();
    assert!(said.contains("[[blinds]] before a window with a BSDF (\"window\")"), "{said}");
}

#[test]
fn a_schedule_of_the_wrong_length_is_refused() {
    let mut b = room(glass(0.8));
    b.0.occupancy = Occupancy::Hourly(vec![true; 8784]);
    let said = annual::annual(&b.0, &AnnualOptions::default(), &Silent).expect_err("hours differ").to_string();
    assert!(said.contains("8784") && said.contains("8760"), "{said}");
}

#[test]
fn lux_of_the_scene_do_not_matter_for_a_year() {
    // The amounts of [sky] are for a moment; the year takes those of its hours.
    let mut b = room(glass(0.8));
    let plain = year(&b.0, 0.1, 1);
    let day = b.0.daytime.as_mut().expect("a sky");
    day.diffuse = Some(Placed { value: Amount::Lux(12_345.0), line: 1 });
    assert!(year(&b.0, 0.1, 1).grids[0].series.lux == plain.grids[0].series.lux);
    assert!(plain.grids[0].status.iter().all(|s| *s == Status::Ok));
}
