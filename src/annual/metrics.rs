//! What a year comes to: daylight autonomy, useful daylight, sunlight, and the levels of standards.
//!
//! Sources: daylight autonomy (Reinhart and Walkenhorst 2001), its continuous form (Rogers 2006), useful daylight
//! illuminance (Nabil and Mardaljevic 2006, bins of Mardaljevic et al. 2012), sDA and ASE (IES LM-83-12), EN 17037:2018,
//! LEED v4.1 (option 1 of its daylight credit), BREEAM HEA 01.
//!
//! **Errors.** Each figure is worked out again with all illuminances at the lower and at the upper end of their errors: its
//! own error is the larger of the two differences.

use std::f64::consts::PI;

use super::climate::Climate;
use super::series::Series;
use crate::light::sky::{Sky, SkyModel};
use crate::measure::{Coefficients, ESTIMATES, Status};
use crate::scene::{Occupancy, Sensor};

/// Illuminance that daylight autonomy asks for, lx.
const AUTONOMY_LX: f64 = 300.0;
/// Limits of useful daylight, lx.
const USEFUL_LX: [f64; 3] = [100.0, 300.0, 3000.0];
/// Sunlight that is too much, lx, and hours of it, for ASE1000,250.
const SUNLIT_LX: f32 = 1000.0;
const SUNLIT_HOURS: usize = 250;
/// Share of hours for sDA300/50.
const SPATIAL_SHARE: f64 = 0.5;
/// Daylight hours of a year (EN 17037).
const DAYLIGHT_HOURS: usize = 4380;
/// Targets and least targets of EN 17037: minimum, medium, high; lx.
const EN_17037: [(f64, f64); 3] = [(300.0, 100.0), (500.0, 300.0), (750.0, 500.0)];
/// Shares of the area that must meet target and least target.
const EN_17037_SHARES: [f64; 2] = [0.5, 0.95];
/// BREEAM HEA 01, offices: mean and least illuminance, lx, over so many hours.
const BREEAM_MEAN_LX: f64 = 300.0;
const BREEAM_LEAST_LX: f64 = 90.0;
const BREEAM_HOURS: usize = 2000;
/// Area, in shares, from which LEED v4.1 gives one, two and three points: option 1 and option 2.
const LEED: [f64; 3] = [0.40, 0.55, 0.75];
const LEED_EQUINOX: [f64; 3] = [0.55, 0.75, 0.90];

/// A figure with its error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figure {
    /// The figure.
    pub value: f64,
    /// Half-width at 95 %.
    pub error: f64,
}

impl Figure {
    /// From the figure, and those at both ends of the illuminances.
    fn of([value, low, high]: [f64; 3]) -> Self {
        Self { value, error: (low - value).abs().max((high - value).abs()) }
    }
}

/// A level of EN 17037.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Below the minimum.
    None,
    /// Minimum.
    Minimum,
    /// Medium.
    Medium,
    /// High.
    High,
}

impl Level {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["none", "minimum", "medium", "high"][self as usize]
    }
}

/// The figures of one sensor; shares of the hours of presence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointMetrics {
    /// Daylight autonomy at 300 lx.
    pub autonomy: Figure,
    /// Continuous daylight autonomy at 300 lx.
    pub continuous_autonomy: Figure,
    /// Useful daylight: below 100, 100 to 300, 300 to 3,000, above 3,000 lx.
    pub useful: [Figure; 4],
    /// Hours of presence with 1,000 lx or more straight from the sun, blinds open.
    pub sunlit_hours: usize,
    /// Mean over the year of light received, lx h.
    pub annual_lx_h: Figure,
    /// Illuminance held in half of the daylight hours, lx.
    pub half_of_daylight_lx: Figure,
    /// Light of the overcast sky, blinds open.
    pub overcast: Overcast,
    /// Hours in which the sun shines on the sensor, as a share of those in which it shines outdoors: of the year, and from
    /// 21 September to 21 March. Blinds open.
    pub probable_sunlight: [f64; 2],
    /// Hours of possible sunlight on 1 February and on 21 March, blinds open (EN 17037, exposure to sunlight).
    pub sunlight_h: [f64; 2],
}

/// Shares of the horizontal illuminance outdoors under the traditional overcast sky.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overcast {
    /// All light: the daylight factor.
    pub daylight_factor: f64,
    /// What comes from the sky straight: on a facade the vertical sky component. Nothing behind the no-sky line.
    pub sky_component: f64,
}

/// The figures of a grid; shares of its area.
#[derive(Clone, Debug, PartialEq)]
pub struct GridMetrics {
    /// sDA300/50.
    pub spatial_autonomy: Figure,
    /// ASE1000,250: more than 250 hours, and at least 250 hours.
    pub sunlight_exposure: [f64; 2],
    /// Means of the figures of the points.
    pub mean: PointMetrics,
    /// LEED v4.1 option 1 by this grid's sDA alone: points, at both ends of its error too.
    pub leed_points: [usize; 3],
    /// EN 17037 by hourly illuminances: level, and at both ends of the errors.
    pub en17037_hourly: [Level; 3],
    /// EN 17037 by the daylight factor.
    pub en17037_factor: Level,
    /// BREEAM HEA 01 for offices: hours with a mean of 300 lx, hours with 90 lx at the worst point.
    pub breeam_hours: [usize; 2],
    /// Both reach 2,000 hours.
    pub breeam: bool,
    /// Clear sky at equinox, where the weather has such days.
    pub equinox: Option<Equinox>,
    /// Area that sees no sky.
    pub no_sky: f64,
    /// Hours of presence.
    pub present_hours: usize,
    /// Median diffuse illuminance outdoors over the daylight hours, lx.
    pub outdoor_median_lx: f64,
}

/// LEED v4.1 option 2: clear sky at equinox, 9 h and 15 h, blinds open.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Equinox {
    /// Area with 300 to 3,000 lx at both times.
    pub useful: Figure,
    /// Mean illuminance at each time, lx.
    pub mean_lx: [f64; 2],
    /// Points.
    pub leed_points: usize,
}

/// Metrics of a grid and its points.
#[derive(Clone, Debug, PartialEq)]
pub struct Metrics {
    /// By sensor; what sees nothing has no figures.
    pub points: Vec<Option<PointMetrics>>,
    /// Of the grid; nothing where no point sees.
    pub grid: Option<GridMetrics>,
}

impl Metrics {
    /// Works out all figures; `overcast` is the light of the overcast sky and `sunlight_h` the hours of possible sunlight, by
    /// sensor.
    #[must_use]
    pub fn new(
        sensors: &[Sensor],
        status: &[Status],
        series: &Series,
        (overcast, sunlight_h): (&[Overcast], &[[f64; 2]]),
        climate: &Climate,
        occupancy: &Occupancy,
    ) -> Self {
        let present: Vec<usize> = (0..climate.hours.len())
            .filter(|t| occupancy.holds(climate.hours[*t].index, climate.hours[*t].middle_h))
            .collect();
        let present_hours = (0..climate.total).filter(|h| occupancy.holds(*h, (*h % 24) as f64 + 0.5)).count();
        let daylight = daylight_hours(climate);
        let hours = Hours { present: &present, present_hours, daylight: &daylight };
        let points: Vec<Option<PointMetrics>> = (0..sensors.len())
            .map(|i| (status[i] == Status::Ok).then(|| point(series, i, &hours, climate, (overcast[i], sunlight_h[i]))))
            .collect();
        let area = |i: usize| sensors[i].area_m2.unwrap_or(1.0);
        let lit: Vec<(usize, PointMetrics, f64)> =
            points.iter().enumerate().filter_map(|(i, p)| p.map(|p| (i, p, area(i)))).collect();
        let grid = (!lit.is_empty()).then(|| grid(series, &lit, &hours, climate));
        Self { points, grid }
    }
}

/// Hours that count.
struct Hours<'a> {
    /// With sun and presence.
    present: &'a [usize],
    /// With presence, sun or not.
    present_hours: usize,
    /// The brightest half of the year.
    daylight: &'a [usize],
}

/// The 4,380 hours with the most light outdoors.
fn daylight_hours(climate: &Climate) -> Vec<usize> {
    let light = |t: &usize| {
        let h = &climate.hours[*t];
        h.diffuse_lx + h.direct_lx * h.sun.z
    };
    let mut all: Vec<usize> = (0..climate.hours.len()).collect();
    all.sort_by(|a, b| light(b).total_cmp(&light(a)));
    all.truncate(DAYLIGHT_HOURS);
    all.sort_unstable();
    all
}

/// Illuminance of a sensor in an hour: as it is, and at the ends of its error.
fn ends(series: &Series, i: usize, t: usize) -> [f64; 3] {
    let (lux, error) = (f64::from(series.of(i)[t]), f64::from(series.error_of(i)[t]));
    [lux, (lux - error).max(0.0), lux + error]
}

/// A figure that is a mean over hours of something of the illuminance; hours without sun give that of darkness.
fn mean_of(series: &Series, i: usize, hours: &Hours<'_>, of: impl Fn(f64) -> f64) -> Figure {
    let n = hours.present_hours.max(1) as f64;
    let dark = (hours.present_hours - hours.present.len()) as f64 * of(0.0);
    let mut sums = [dark; 3];
    for t in hours.present {
        for (sum, lux) in sums.iter_mut().zip(ends(series, i, *t)) {
            *sum += of(lux);
        }
    }
    Figure::of(sums.map(|s| s / n))
}

fn point(
    series: &Series,
    i: usize,
    hours: &Hours<'_>,
    climate: &Climate,
    (overcast, sunlight_h): (Overcast, [f64; 2]),
) -> PointMetrics {
    let share = |holds: &dyn Fn(f64) -> bool| mean_of(series, i, hours, |e| f64::from(u8::from(holds(e))));
    let [low, middle, high] = USEFUL_LX;
    let sunlit = |t: &&usize| series.sun_of(i)[**t] >= SUNLIT_LX;
    let mut sums = [0.0; 3];
    for t in 0..series.hours {
        for (sum, lux) in sums.iter_mut().zip(ends(series, i, t)) {
            *sum += lux;
        }
    }
    PointMetrics {
        autonomy: share(&|e| e >= AUTONOMY_LX),
        continuous_autonomy: mean_of(series, i, hours, |e| (e / AUTONOMY_LX).min(1.0)),
        useful: [
            share(&|e| e < low),
            share(&|e| (low..middle).contains(&e)),
            share(&|e| (middle..=high).contains(&e)),
            share(&|e| e > high),
        ],
        sunlit_hours: hours.present.iter().filter(sunlit).count(),
        annual_lx_h: Figure::of(sums),
        half_of_daylight_lx: Figure::of(half_of_daylight(series, i, hours.daylight)),
        overcast,
        probable_sunlight: probable_sunlight(series, i, climate),
        sunlight_h,
    }
}

/// Share of the sunny hours in which the sun reaches a sensor: of the year, and from 21 September to 21 March (Littlefair
/// 2011, BRE 209).
fn probable_sunlight(series: &Series, i: usize, climate: &Climate) -> [f64; 2] {
    let is_winter = |t: usize| {
        let day = (climate.hours[t].month, climate.hours[t].day);
        day >= (9, 21) || day <= (3, 21)
    };
    [false, true].map(|winter_alone| {
        let counts = |t: &usize| climate.hours[*t].is_sunny && (!winter_alone || is_winter(*t));
        let sunny: Vec<usize> = (0..series.hours).filter(counts).collect();
        let reached = sunny.iter().filter(|t| series.sun_of(i)[**t] > 0.0).count();
        reached as f64 / sunny.len().max(1) as f64
    })
}

/// Illuminance that is held in half of the daylight hours of a year.
fn half_of_daylight(series: &Series, i: usize, hours: &[usize]) -> [f64; 3] {
    std::array::from_fn(|end| {
        let mut values: Vec<f64> = hours.iter().map(|t| ends(series, i, *t)[end]).collect();
        values.resize(DAYLIGHT_HOURS, 0.0);
        *values.select_nth_unstable_by(DAYLIGHT_HOURS / 2, f64::total_cmp).1
    })
}

fn grid(series: &Series, lit: &[(usize, PointMetrics, f64)], hours: &Hours<'_>, climate: &Climate) -> GridMetrics {
    let area: f64 = lit.iter().map(|l| l.2).sum();
    let share = |holds: &dyn Fn(&PointMetrics) -> bool| -> f64 {
        // An empty sum is minus zero.
        (lit.iter().filter(|l| holds(&l.1)).map(|l| l.2).sum::<f64>() + 0.0) / area
    };
    let at = |f: Figure, end: usize| f.value + [0.0, -f.error, f.error][end];
    let spatial: [f64; 3] = std::array::from_fn(|end| share(&|p| at(p.autonomy, end) >= SPATIAL_SHARE));
    let hourly =
        std::array::from_fn(|end| level(&|lux, least| share(&|p| at(p.half_of_daylight_lx, end) >= lux) >= least));
    let outdoor_median_lx = outdoor_median(climate);
    let by_factor = |lux: f64, least: f64| share(&|p| p.overcast.daylight_factor * outdoor_median_lx >= lux) >= least;
    let breeam_hours = breeam(series, lit, hours, area);
    GridMetrics {
        spatial_autonomy: Figure::of(spatial),
        sunlight_exposure: [share(&|p| p.sunlit_hours > SUNLIT_HOURS), share(&|p| p.sunlit_hours >= SUNLIT_HOURS)],
        mean: mean_point(lit, area),
        leed_points: spatial.map(|s| LEED.iter().filter(|l| s >= **l).count()),
        en17037_hourly: hourly,
        en17037_factor: level(&by_factor),
        breeam_hours,
        breeam: breeam_hours.iter().all(|h| *h >= BREEAM_HOURS),
        equinox: None,
        no_sky: share(&|p| p.overcast.sky_component <= 0.0),
        present_hours: hours.present_hours,
        outdoor_median_lx,
    }
}

/// The highest level of which both targets hold: `holds(lux, share of the area)`.
fn level(holds: &dyn Fn(f64, f64) -> bool) -> Level {
    let [of_target, of_least] = EN_17037_SHARES;
    let reached = EN_17037.iter().take_while(|(target, least)| holds(*target, of_target) && holds(*least, of_least));
    [Level::None, Level::Minimum, Level::Medium, Level::High][reached.count()]
}

/// Hours with 300 lx in the mean, and with 90 lx at the worst point.
fn breeam(series: &Series, lit: &[(usize, PointMetrics, f64)], hours: &Hours<'_>, area: f64) -> [usize; 2] {
    let lux = |i: usize, t: usize| f64::from(series.of(i)[t]);
    let mean = |t: usize| lit.iter().map(|(i, _, a)| lux(*i, t) * a).sum::<f64>() / area;
    let least = |t: usize| lit.iter().map(|(i, _, _)| lux(*i, t)).fold(f64::INFINITY, f64::min);
    let count = |holds: &dyn Fn(usize) -> bool| hours.present.iter().filter(|t| holds(**t)).count();
    [count(&|t| mean(t) >= BREEAM_MEAN_LX), count(&|t| least(t) >= BREEAM_LEAST_LX)]
}

fn mean_point(lit: &[(usize, PointMetrics, f64)], area: f64) -> PointMetrics {
    let mean = |of: &dyn Fn(&PointMetrics) -> f64| lit.iter().map(|(_, p, a)| of(p) * a).sum::<f64>() / area;
    let figure =
        |of: &dyn Fn(&PointMetrics) -> Figure| Figure { value: mean(&|p| of(p).value), error: mean(&|p| of(p).error) };
    PointMetrics {
        autonomy: figure(&|p| p.autonomy),
        continuous_autonomy: figure(&|p| p.continuous_autonomy),
        useful: std::array::from_fn(|k| figure(&|p| p.useful[k])),
        sunlit_hours: mean(&|p| p.sunlit_hours as f64).round() as usize,
        annual_lx_h: figure(&|p| p.annual_lx_h),
        half_of_daylight_lx: figure(&|p| p.half_of_daylight_lx),
        overcast: Overcast {
            daylight_factor: mean(&|p| p.overcast.daylight_factor),
            sky_component: mean(&|p| p.overcast.sky_component),
        },
        probable_sunlight: std::array::from_fn(|k| mean(&|p| p.probable_sunlight[k])),
        sunlight_h: std::array::from_fn(|k| mean(&|p| p.sunlight_h[k])),
    }
}

/// Median of the diffuse horizontal illuminance over the daylight hours (EN 17037).
fn outdoor_median(climate: &Climate) -> f64 {
    let mut values: Vec<f64> = climate.hours.iter().map(|h| h.diffuse_lx).collect();
    values.sort_by(|a, b| b.total_cmp(a));
    values.resize(DAYLIGHT_HOURS, 0.0);
    values[DAYLIGHT_HOURS / 2]
}

/// What the two moments of a clear equinox come to.
pub(super) fn equinox(sensors: &[Sensor], status: &[Status], moments: &Series) -> Equinox {
    let area = |i: &usize| sensors[*i].area_m2.unwrap_or(1.0);
    let lit: Vec<usize> = (0..sensors.len()).filter(|i| status[*i] == Status::Ok).collect();
    let whole: f64 = lit.iter().map(area).sum();
    let range = USEFUL_LX[1]..=USEFUL_LX[2];
    let useful = Figure::of(std::array::from_fn(|end| {
        let both = |i: &&usize| (0..2).all(|t| range.contains(&ends(moments, **i, t)[end]));
        lit.iter().filter(both).map(area).sum::<f64>() / whole
    }));
    Equinox {
        useful,
        mean_lx: [0, 1].map(|t| lit.iter().map(|i| f64::from(moments.of(*i)[t]) * area(i)).sum::<f64>() / whole),
        leed_points: LEED_EQUINOX.iter().filter(|l| useful.value >= **l).count(),
    }
}

/// Light of the traditional overcast sky on a grid's sensors, blinds open.
pub(super) fn overcast(coefficients: &Coefficients, g: usize, ground_reflectance: f64) -> Vec<Overcast> {
    let sky = Sky::new(SkyModel::Overcast, glam::DVec3::Z);
    let grid = &coefficients.grids[g];
    let (fine, coarse) = (&coefficients.seen_patches, &coefficients.patches);
    let luminance = |patches: &crate::light::sky::Patches, column: usize| {
        let p = column % patches.all();
        if p == patches.sky() { ground_reflectance / PI } else { sky.luminance(patches.middle(p)) }
    };
    let width = coefficients.sheets * coarse.all();
    let of_columns: Vec<f64> = (0..width).map(|c| luminance(coarse, c)).collect();
    (0..grid.seen.len())
        .map(|i| {
            let part = |of_ground: bool| -> f64 {
                let columns = grid.seen[i].iter().map(|(c, v)| (*c as usize, f64::from(*v)));
                let wanted = columns.filter(|(c, _)| (c % fine.all() == fine.sky()) == of_ground);
                wanted.map(|(c, v)| v * luminance(fine, c)).sum()
            };
            let sky_component = part(false);
            let row = |estimate: usize| -> f64 {
                let values = grid.of_sky(estimate, i, width);
                values.iter().zip(&of_columns).map(|(v, l)| f64::from(*v) * l).sum()
            };
            let reflected = (0..ESTIMATES / 2).map(row).sum::<f64>() / (ESTIMATES / 2) as f64;
            Overcast { daylight_factor: sky_component + part(true) + reflected, sky_component }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::annual::climate::Hour;

    /// A year in which every hour from 6 to 18 has sun, and a sensor with given illuminances by the hour of the day.
    fn year(lux: impl Fn(usize) -> f32, error: f32) -> (Climate, Series) {
        let hours: Vec<Hour> = (0..8760)
            .filter(|h| (6..18).contains(&(h % 24)))
            .map(|index| Hour {
                index,
                month: 1,
                day: 1,
                middle_h: (index % 24) as f64 + 0.5,
                sun_h: (index % 24) as f64 + 0.5,
                sun: DVec3::Z,
                is_sunny: index % 24 < 12,
                direct_lx: 0.0,
                diffuse_lx: 10_000.0 + (index % 24) as f64,
                sky: None,
            })
            .collect();
        let values: Vec<f32> = hours.iter().map(|h| lux(h.index % 24)).collect();
        let n = hours.len();
        let series = Series { error: vec![error; n], sun: values.clone(), lux: values, hours: n };
        (Climate { hours, total: 8760, ..Climate::default() }, series)
    }

    fn metrics(lux: impl Fn(usize) -> f32, error: f32) -> Metrics {
        let (climate, series) = year(lux, error);
        let sensor = Sensor { position: DVec3::ZERO, normal: DVec3::Z, area_m2: Some(1.0) };
        Metrics::new(
            &[sensor],
            &[Status::Ok],
            &series,
            (&[Overcast { daylight_factor: 0.03, sky_component: 0.02 }], &[[0.0; 2]]),
            &climate,
            &Occupancy::Daily(8.0, 18.0),
        )
    }

    #[test]
    fn shares_are_of_the_hours_of_presence() {
        // 8 to 13 h at 400 lx, 13 to 18 h at 150 lx.
        let m = metrics(|h| if h < 13 { 400.0 } else { 150.0 }, 0.0);
        let p = m.points[0].unwrap();
        assert_eq!(p.autonomy.value, 0.5);
        assert_eq!(p.continuous_autonomy.value, 0.75);
        assert_eq!(p.useful.map(|u| u.value), [0.0, 0.5, 0.5, 0.0]);
        assert_eq!(p.sunlit_hours, 0);
        assert_eq!(p.annual_lx_h.value, 365.0 * (7.0 * 400.0 + 5.0 * 150.0));
        let g = m.grid.unwrap();
        assert_eq!((g.present_hours, g.spatial_autonomy.value), (3650, 1.0));
        assert_eq!(g.leed_points, [3; 3]);
        assert_eq!(g.breeam_hours, [1825, 3650]);
        assert!(!g.breeam);
    }

    #[test]
    fn errors_of_illuminance_become_errors_of_shares() {
        // 310 ± 20 lx in half of the hours: autonomy could be nothing.
        let p = metrics(|h| if h < 13 { 310.0 } else { 150.0 }, 20.0).points[0].unwrap();
        assert_eq!((p.autonomy.value, p.autonomy.error), (0.5, 0.5));
        assert_eq!(p.annual_lx_h.error, 20.0 * 12.0 * 365.0);
    }

    #[test]
    fn levels_of_en_17037_ask_for_target_and_least_target() {
        let level = |lux: f32| metrics(|_| lux, 0.0).grid.unwrap().en17037_hourly[0];
        assert_eq!(level(99.0), Level::None);
        assert_eq!(level(300.0), Level::Minimum);
        assert_eq!(level(600.0), Level::Medium);
        assert_eq!(level(750.0), Level::High);
        // Half of 4,380 daylight hours: light in 6 of 12 hours is enough, in 5 is not.
        let part = |until: usize| metrics(move |h| if h < until { 800.0 } else { 0.0 }, 0.0);
        assert_eq!(part(12).grid.unwrap().en17037_hourly[0], Level::High);
        assert_eq!(part(11).grid.unwrap().en17037_hourly[0], Level::None);
        // 3 % of a median of 10,011.5 lx outdoors.
        assert_eq!(metrics(|_| 0.0, 0.0).grid.unwrap().en17037_factor, Level::Minimum);
    }

    #[test]
    fn a_clear_equinox_counts_what_is_useful_at_both_times() {
        let sensor = Sensor { position: DVec3::ZERO, normal: DVec3::Z, area_m2: Some(1.0) };
        // 9 h and 15 h of four sensors; the last is blind.
        let lux = vec![400.0, 500.0, 400.0, 3500.0, 310.0, 2000.0, 0.0, 0.0];
        let series = Series { error: vec![20.0; 8], sun: vec![0.0; 8], lux, hours: 2 };
        let status = [Status::Ok, Status::Ok, Status::Ok, Status::Inside];
        let e = equinox(&[sensor; 4], &status, &series);
        assert!((e.useful.value - 2.0 / 3.0).abs() < 1e-12 && e.leed_points == 1);
        assert!((e.useful.error - 1.0 / 3.0).abs() < 1e-12, "310 ± 20 lx may be too little");
        assert_eq!(e.mean_lx[0], 370.0);
    }

    #[test]
    fn sunlight_counts_from_a_thousand_lux_in_more_than_250_hours() {
        let g = metrics(|h| if h == 9 { 1000.0 } else { 0.0 }, 0.0).grid.unwrap();
        assert_eq!(g.sunlight_exposure, [1.0, 1.0]);
        // One of the six sunny hours from 6 to 12.
        assert!(g.mean.probable_sunlight.iter().all(|p| (p - 1.0 / 6.0).abs() < 1e-12));
    }
}
