//! A year of daylight: against closed forms, and against the same moments solved one by one.

mod common;
#[path = "../experiments/weather/synthetic.rs"]
mod synthetic;

use std::path::{Path, PathBuf};

use clerestory::annual::{self, AnnualOptions, CALENDAR_YEAR, Year};
use clerestory::measure::{Silent, SolveOptions, Status};
use clerestory::scene::{Amount, Blind, BlindControl, ClockTime, Daytime, Occupancy, Placed, Scene, Site, SkyName};
use clerestory::spectrum::Spectrum;
use common::{Build, at, diffuse, glass, solve, within};
use glam::DVec3;

/// Every so many days are left out: the laws of a year hold for a part of it.
const EVERY: usize = 12;

/// The synthetic weather, a day in twelve.
fn weather() -> Vec<u8> {
    let text = synthetic::wea().expect("a sun for every hour");
    let head = text.lines().take(6);
    let rows = text.lines().skip(6).enumerate().filter(|(h, _)| (h / 24).is_multiple_of(EVERY)).map(|(_, l)| l);
    head.chain(rows).map(|l| format!("{l}\n")).collect::<String>().into_bytes()
}

fn daytime() -> Daytime {
    Daytime {
        file: PathBuf::from("test.toml"),
        model: Placed { value: SkyName::Perez, line: 1 },
        diffuse: None,
        direct: None,
        sun_deg: None,
        site: Some(Site {
            line: 1,
            latitude_deg: None,
            longitude_deg: None,
            time: None,
            weather: Some((PathBuf::from("test.wea"), weather())),
            least_sun_deg: 0.0,
        }),
        spectrum: Spectrum::constant(1.0),
        sun_spectrum: Spectrum::constant(1.0),
        ground_reflectance: 0.2,
        north_deg: 0.0,
    }
}

fn year(scene: &Scene, tolerance: f64, parts: usize) -> Year {
    let options = AnnualOptions {
        solve: SolveOptions { tolerance, ..SolveOptions::default() },
        parts: Some(parts),
        ..AnnualOptions::default()
    };
    annual::annual(scene, &options, &Silent).expect("the year is computed")
}

/// A room of 3 × 4 × 2.5 m with a window of 2 × 1.2 m to the south, and a point in its middle and one at the window.
fn room() -> Build {
    let mut b = Build::new();
    let (wall, pane) = (b.material(diffuse("wall", 0.5)), b.material(glass(0.8)));
    let (x, y, z) = (at(3.0, 0.0, 0.0), at(0.0, 4.0, 0.0), at(0.0, 0.0, 2.5));
    b.rectangle(DVec3::ZERO, x, y, wall);
    b.rectangle(z, y, x, wall);
    b.rectangle(y, x, z, wall);
    b.rectangle(DVec3::ZERO, y, z, wall);
    b.rectangle(x, z, y, wall);
    // The south wall about its window.
    b.rectangle(DVec3::ZERO, at(0.0, 0.0, 2.5), at(0.5, 0.0, 0.0), wall);
    b.rectangle(at(2.5, 0.0, 0.0), at(0.0, 0.0, 2.5), at(0.5, 0.0, 0.0), wall);
    b.rectangle(at(0.5, 0.0, 0.0), at(0.0, 0.0, 0.9), at(2.0, 0.0, 0.0), wall);
    b.rectangle(at(0.5, 0.0, 2.1), at(0.0, 0.0, 0.4), at(2.0, 0.0, 0.0), wall);
    b.rectangle(at(0.5, 0.0, 0.9), at(0.0, 0.0, 1.2), at(2.0, 0.0, 0.0), pane);
    let points: Vec<(DVec3, DVec3)> =
        (0..24).map(|k| (at(0.25 + 0.5 * f64::from(k % 6), 0.5 + f64::from(k / 6), 0.8), DVec3::Z)).collect();
    b.points("points", &points);
    b.0.daytime = Some(daytime());
    b
}

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
    let b = room();
    let y = year(&b.0, 0.05, 4);
    let grid = &y.grids[0];
    let bright: Vec<usize> = (0..grid.series.hours).filter(|t| y.climate.hours[*t].diffuse_lx > 5000.0).collect();
    let (mut inside, mut all, mut square) = (0, 0, 0.0);
    for t in bright.iter().step_by(bright.len() / 8) {
        let hour = &y.climate.hours[*t];
        let mut scene = b.0.clone();
        let clock = ClockTime {
            year: CALENDAR_YEAR,
            month: hour.month,
            day: hour.day,
            hours: hour.sun_h,
            utc_offset_h: y.utc_offset_h,
            is_utc: false,
        };
        let site = scene.daytime.as_mut().and_then(|d| d.site.as_mut()).expect("a site");
        site.time = Some(Placed { value: clock, line: 1 });
        let m = solve(&scene, &within(0.02));
        for (i, sensor) in m.grids[0].sensors.iter().enumerate().filter(|(_, s)| s.xyz[1] > 50.0) {
            let (found, stated) = (f64::from(grid.series.of(i)[*t]), f64::from(grid.series.error_of(i)[*t]));
            all += 1;
            inside += usize::from((found - sensor.xyz[1]).abs() <= stated + sensor.error_lx);
            square += (found / sensor.xyz[1] - 1.0).powi(2);
        }
    }
    let rms = (square / f64::from(all as u32)).sqrt();
    assert!(all > 150 && rms < 0.03, "{all} values, RMS {rms}");
    assert!(inside * 100 >= 95 * all, "{inside} of {all} inside their errors");
}

#[test]
fn the_same_bits_come_for_any_number_of_threads() {
    let b = room();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| year(&b.0, 0.1, 1).grids[0].series.clone())
    };
    let (one, three) = (on(1), on(3));
    assert!(one.lux == three.lux && one.error == three.error && one.sun == three.sun);
}

/// The room with blinds of a kind.
fn shaded(control: BlindControl, transmittance: f64) -> Year {
    let mut b = room();
    b.0.blinds = vec![Blind { panes: vec!["glass".into()], transmittance, control }];
    year(&b.0, 0.1, 1)
}

#[test]
fn closed_blinds_dim_every_hour_and_stop_the_sun() {
    let open = shaded(BlindControl::Fixed(false), 0.1);
    let plain = year(&room().0, 0.1, 1);
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
fn a_schedule_of_the_wrong_length_is_refused() {
    let mut b = room();
    b.0.occupancy = Occupancy::Hourly(vec![true; 8784]);
    let said = annual::annual(&b.0, &AnnualOptions::default(), &Silent).expect_err("hours differ").to_string();
    assert!(said.contains("8784") && said.contains("8760"), "{said}");
}

#[test]
fn lux_of_the_scene_do_not_matter_for_a_year() {
    // The amounts of [sky] are for a moment; the year takes those of its hours.
    let mut b = room();
    let plain = year(&b.0, 0.1, 1);
    let day = b.0.daytime.as_mut().expect("a sky");
    day.diffuse = Some(Placed { value: Amount::Lux(12_345.0), line: 1 });
    assert!(year(&b.0, 0.1, 1).grids[0].series.lux == plain.grids[0].series.lux);
    assert!(plain.grids[0].status.iter().all(|s| *s == Status::Ok));
}
