//! Years of rooms under the synthetic weather, and the same moments solved one by one.

#[path = "../../experiments/weather/synthetic.rs"]
pub mod synthetic;

use std::path::PathBuf;

use clerestory::annual::{self, AnnualOptions, CALENDAR_YEAR, Hour, Year};
use clerestory::measure::{Silent, SolveOptions};
use clerestory::scene::{ClockTime, Daytime, Material, Placed, Scene, Site, SkyName};
use clerestory::spectrum::Spectrum;

use glam::DVec3;

use super::{Build, at, diffuse, solve, within};

/// Every so many days are left out: the laws of a year hold for a part of it.
const EVERY: usize = 12;

/// The synthetic weather, a day in twelve.
fn weather() -> Vec<u8> {
    let text = synthetic::wea().expect("a sun for every hour");
    let head = text.lines().take(6);
    let rows = text.lines().skip(6).enumerate().filter(|(h, _)| (h / 24).is_multiple_of(EVERY)).map(|(_, l)| l);
    head.chain(rows).map(|l| format!("{l}\n")).collect::<String>().into_bytes()
}

/// Perez's sky by that weather, over a ground of 0.2.
pub fn daytime() -> Daytime {
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

/// A room of 3 × 4 × 2.5 m with a window of 2 × 1.2 m to the south, whose front looks out, and 24 points.
pub fn room(pane: Material) -> Build {
    room_of(diffuse("wall", 0.5), diffuse("wall", 0.5), pane)
}

/// The same with a north wall of its own.
pub fn room_of(wall: Material, north: Material, pane: Material) -> Build {
    let mut b = Build::new();
    let [wall, north, pane] = [wall, north, pane].map(|m| b.material(m));
    let (x, y, z) = (at(3.0, 0.0, 0.0), at(0.0, 4.0, 0.0), at(0.0, 0.0, 2.5));
    b.rectangle(DVec3::ZERO, x, y, wall);
    b.rectangle(z, y, x, wall);
    b.rectangle(y, x, z, north);
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

/// The year of a scene, its sky in `parts` of Tregenza's patches a side.
pub fn year(scene: &Scene, tolerance: f64, parts: usize) -> Year {
    let options = AnnualOptions {
        solve: SolveOptions { tolerance, ..SolveOptions::default() },
        parts: Some(parts),
        ..AnnualOptions::default()
    };
    annual::annual(scene, &options, &Silent).expect("the year is computed")
}

/// How hours of a year agree with the same moments solved one by one, at points above 50 lx.
#[derive(Debug, Default)]
pub struct Agreement {
    pub count: usize,
    /// Values inside the stated errors of both.
    pub inside: usize,
    squares: f64,
    differences: f64,
}

impl Agreement {
    /// Both together.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            inside: self.inside + other.inside,
            squares: self.squares + other.squares,
            differences: self.differences + other.differences,
        }
    }

    /// Relative, over all values.
    pub fn rms(&self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }

    pub fn bias(&self) -> f64 {
        self.differences / self.count as f64
    }

    /// At least so many values, as many as may be off by the tolerance, 95 % of them inside their errors.
    pub fn assert(&self, least: usize, rms: f64) {
        let told = format!("{self:?}: RMS {}, bias {}", self.rms(), self.bias());
        assert!(self.count >= least && self.rms() < rms, "{told}");
        assert!(self.inside * 100 >= 95 * self.count, "{told}");
    }
}

/// Solves `count` of the hours that are `wanted` at a tolerance, spread over the year.
pub fn against_moments(
    scene: &Scene,
    y: &Year,
    (tolerance, count): (f64, usize),
    wanted: impl Fn(&Hour) -> bool,
) -> Agreement {
    let hours: Vec<usize> = hours_of(y, wanted);
    assert!(hours.len() >= count, "{} hours", hours.len());
    let chosen = (0..count).map(|k| hours[(2 * k + 1) * hours.len() / (2 * count)]);
    chosen.map(|t| against_moment(scene, y, tolerance, t)).fold(Agreement::default(), Agreement::with)
}

/// The hours that are `wanted`.
pub fn hours_of(y: &Year, wanted: impl Fn(&Hour) -> bool) -> Vec<usize> {
    (0..y.climate.hours.len()).filter(|t| wanted(&y.climate.hours[*t])).collect()
}

/// Solves one hour of a year, of which it is given the number, at a tolerance.
pub fn against_moment(scene: &Scene, y: &Year, tolerance: f64, number: usize) -> Agreement {
    let hour = &y.climate.hours[number];
    let mut scene = scene.clone();
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
    let m = solve(&scene, &within(tolerance));
    let mut agreement = Agreement::default();
    for (year, moment) in y.grids.iter().zip(&m.grids) {
        for (i, sensor) in moment.sensors.iter().enumerate().filter(|(_, s)| s.xyz[1] > 50.0) {
            let [found, stated] = [year.series.of(i), year.series.error_of(i)].map(|row| f64::from(row[number]));
            let off = found / sensor.xyz[1] - 1.0;
            agreement.count += 1;
            agreement.inside += usize::from((found - sensor.xyz[1]).abs() <= stated + sensor.error_lx);
            agreement.squares += off * off;
            agreement.differences += off;
        }
    }
    agreement
}

/// Does the sun give most of the light?
pub fn is_sunny(hour: &Hour) -> bool {
    hour.direct_lx * hour.sun.z > 2.0 * hour.diffuse_lx && hour.sun.z > 0.2
}

/// Is the sun behind clouds?
pub fn is_cloudy(hour: &Hour) -> bool {
    hour.direct_lx * hour.sun.z < 0.05 * hour.diffuse_lx && hour.diffuse_lx > 5000.0
}
