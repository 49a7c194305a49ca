//! The light of every hour: where the sun stands, how bright it is, what the sky looks like.

use glam::DVec3;
use rayon::prelude::*;

use crate::light::sky::{PerezInput, Sky, SkyModel, USUAL_WATER_CM};
use crate::light::sun::{Air, Moment, Place, SunPosition, days_in_month};
use crate::light::weather::{Record, Weather, hour_of_year};
use crate::{Error, Result};

/// The calendar for the sun's place: a weather file is put together from many years, and this one lies in the middle of
/// the four years of a leap cycle.
pub const CALENDAR_YEAR: i32 = 2026;
/// Parts of an hour in which the sun is looked for near the horizon.
const PARTS: usize = 4;
/// Sunlight shorter than this is none, hours.
const SHORTEST_H: f64 = 1e-3;
/// Altitude at the middle of an hour from which it is up all hour: it moves by 7.5 degrees in half an hour.
const ALL_HOUR_DEG: f64 = 7.6;
/// Rough altitude at the middle of an hour below which it is down all hour.
const SURELY_DOWN_DEG: f64 = -ALL_HOUR_DEG - 2.0;

/// Direct irradiance from which the sun shines, W/m² (WMO).
const SUNNY_W_M2: f64 = 120.0;
/// Hours of a year, and of a leap year.
const HOURS: [usize; 2] = [8760, 8784];

/// One hour with the sun above the horizon.
#[derive(Clone, Copy, Debug)]
pub struct Hour {
    /// Number of the hour in the year, from 0.
    pub index: usize,
    /// Month, 1 to 12.
    pub month: u32,
    /// Day of the month.
    pub day: u32,
    /// Hours from midnight, standard time of the file: the middle of the hour.
    pub middle_h: f64,
    /// The moment for which the sun's place is taken, likewise: the middle of the sunlit part of the hour.
    pub sun_h: f64,
    /// Unit vector to the sun, z up.
    pub sun: DVec3,
    /// Does the sun shine as the weather services count it: 120 W/m² or more face on (WMO)?
    pub is_sunny: bool,
    /// Illuminance face on to the sun, lx.
    pub direct_lx: f64,
    /// Diffuse horizontal illuminance, lx.
    pub diffuse_lx: f64,
    /// How the sky's luminance is spread; `None` where it sends nothing.
    pub sky: Option<Sky>,
}

/// The sunlit hours of a weather file.
#[derive(Clone, Debug, Default)]
pub struct Climate {
    /// The hours.
    pub hours: Vec<Hour>,
    /// Number of all hours of the year.
    pub total: usize,
    /// Hours that the file leaves out.
    pub left_out: usize,
    /// Clear sky at equinox, 9 h and 15 h, as LEED v4.1 has it for its option 2; nothing where the file has no such days.
    pub equinox: Option<[Hour; 2]>,
    /// Light that the file gives to hours without sun, against all of it: it is left out.
    pub dark_share: f64,
}

impl Climate {
    /// Works out every hour. `place` is that of the building, `north_deg` true north clockwise from +y.
    ///
    /// # Errors
    /// Hours without irradiance, with their line; a place or time that cannot be.
    pub fn new(weather: &Weather, place: Place, north_deg: f64) -> Result<Self> {
        if let Some(gap) = weather.records.iter().find(|r| lacks(r)) {
            return Err(Error::malformed(format!(
                "{} of {} hours have no direct or no diffuse irradiance, this one first",
                weather.missing(),
                weather.records.len()
            ))
            .mend("take another file, or fill the gaps")
            .at_line(gap.line));
        }
        let is_leap = weather.is_leap();
        let number = |record: &Record| hour_of_year(record, is_leap) as usize;
        if let Some(pair) = weather.records.windows(2).find(|p| number(&p[0]) == number(&p[1])) {
            return Err(Error::unsupported("two records in one hour")
                .mend("give an hourly file")
                .at_line(pair[1].line));
        }
        let of = |record: &Record| {
            let hour = hour(number(record), record, weather.utc_offset_h, place, north_deg);
            hour.map_err(|e| e.at_line(record.line))
        };
        let found: Vec<Option<Hour>> = weather.records.par_iter().with_min_len(64).map(of).collect::<Result<_>>()?;
        let light = |r: &Record| r.direct_normal_w_m2.unwrap_or(0.0) + r.diffuse_horizontal_w_m2.unwrap_or(0.0);
        let all: f64 = weather.records.iter().map(light).sum();
        let dark: f64 = weather.records.iter().zip(&found).filter(|(_, h)| h.is_none()).map(|(r, _)| light(r)).sum();
        let hours: Vec<Hour> = found.into_iter().flatten().collect();
        if hours.is_empty() {
            return Err(Error::impossible("the sun never rises in this file").mend("take a file of a whole year"));
        }
        let total = HOURS[usize::from(is_leap)];
        let dark_share = if all > 0.0 { dark / all } else { 0.0 };
        let equinox = equinox(weather, place, north_deg)?;
        Ok(Self { hours, total, left_out: total.saturating_sub(weather.records.len()), equinox, dark_share })
    }
}

/// Days about an equinox among which the clearest is looked for, and the equinoxes as days of the year.
const NEAR_EQUINOX_DAYS: f64 = 15.0;
const EQUINOXES: [(u32, u32); 2] = [(3, 21), (9, 21)];

/// The mean of the clearest days about both equinoxes, the sun as on 21 September.
fn equinox(weather: &Weather, place: Place, north_deg: f64) -> Result<Option<[Hour; 2]>> {
    let day = |r: &Record| (hour_of_year(r, true) / 24.0).floor();
    let clearest = |(month, of_month): (u32, u32)| -> Option<f64> {
        let middle = day(weather.records.iter().find(|r| (r.month, r.day) == (month, of_month))?);
        let near = weather.records.iter().filter(|r| (day(r) - middle).abs() <= NEAR_EQUINOX_DAYS);
        let mut sums: Vec<(f64, f64)> = Vec::new();
        for r in near {
            let direct = r.direct_normal_w_m2.unwrap_or(0.0);
            match sums.last_mut() {
                Some((d, sum)) if *d == day(r) => *sum += direct,
                _ => sums.push((day(r), direct)),
            }
        }
        sums.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(d, _)| d)
    };
    let [Some(spring), Some(autumn)] = EQUINOXES.map(clearest) else { return Ok(None) };
    let at = |day_wanted: f64, clock: f64| {
        weather.records.iter().find(|r| day(r) == day_wanted && (-0.5..0.5).contains(&(clock - r.middle_h)))
    };
    let mut found = Vec::new();
    for clock in [9.0, 15.0] {
        let (Some(a), Some(b)) = (at(spring, clock), at(autumn, clock)) else { return Ok(None) };
        let mean = |x: Option<f64>, y: Option<f64>| x.zip(y).map(|(x, y)| 0.5 * (x + y));
        let (month, of_month) = EQUINOXES[1];
        let record = Record {
            month,
            day: of_month,
            middle_h: clock,
            direct_normal_w_m2: mean(a.direct_normal_w_m2, b.direct_normal_w_m2),
            diffuse_horizontal_w_m2: mean(a.diffuse_horizontal_w_m2, b.diffuse_horizontal_w_m2),
            dew_point_c: mean(a.dew_point_c, b.dew_point_c),
            line: b.line,
        };
        found.extend(hour(0, &record, weather.utc_offset_h, place, north_deg)?);
    }
    Ok(found.try_into().ok())
}

fn lacks(record: &Record) -> bool {
    record.direct_normal_w_m2.is_none() || record.diffuse_horizontal_w_m2.is_none()
}

fn hour(index: usize, record: &Record, utc_offset_h: f64, place: Place, north_deg: f64) -> Result<Option<Hour>> {
    // 29 February is a day of files that follow one year; the sun of 28 February serves it.
    let day = record.day.min(days_in_month(CALENDAR_YEAR, record.month));
    let moment = |hours| Moment { year: CALENDAR_YEAR, month: record.month, day, hours: hours - utc_offset_h };
    if SunPosition::rough_altitude_deg(&moment(record.middle_h), place) < SURELY_DOWN_DEG {
        return Ok(None);
    }
    let position = |hours| SunPosition::at(&moment(hours), place, Air::default());
    let Some((sun_h, position)) = sunlit(record.middle_h, &position)? else { return Ok(None) };
    let sun = position.direction(north_deg);
    let input = PerezInput {
        direct_normal_w_m2: record.direct_normal_w_m2.unwrap_or(0.0),
        diffuse_horizontal_w_m2: record.diffuse_horizontal_w_m2.unwrap_or(0.0),
        sun_zenith_deg: 90.0 - position.altitude_deg,
        day_of_year: moment(sun_h).day_of_year(),
        precipitable_water_cm: record.precipitable_water_cm().unwrap_or(USUAL_WATER_CM),
    };
    let (mut sky, mut diffuse_lx, mut direct_lx) = (None, 0.0, 0.0);
    if input.diffuse_horizontal_w_m2 > 0.0 {
        let perez = input.sky();
        sky = Some(Sky::quick(SkyModel::Perez(perez.coefficients), sun)).filter(|s| s.luminance(DVec3::Z).is_finite());
        diffuse_lx = if sky.is_some() { input.diffuse_horizontal_w_m2 * perez.diffuse_lm_w } else { 0.0 };
        direct_lx = input.direct_normal_w_m2 * perez.direct_lm_w;
    }
    let (month, day, middle_h) = (record.month, record.day, record.middle_h);
    let is_sunny = input.direct_normal_w_m2 >= SUNNY_W_M2;
    Ok(Some(Hour { index, month, day, middle_h, sun_h, sun, is_sunny, direct_lx, diffuse_lx, sky }))
}

/// Middle of the part of an hour in which the sun is above the horizon, and where it stands then.
fn sunlit(middle_h: f64, position: &impl Fn(f64) -> Result<SunPosition>) -> Result<Option<(f64, SunPosition)>> {
    let middle = position(middle_h)?;
    if middle.altitude_deg >= ALL_HOUR_DEG {
        return Ok(Some((middle_h, middle)));
    }
    // Between these times the sun's altitude is as good as straight.
    let times: [f64; PARTS + 1] = std::array::from_fn(|k| middle_h - 0.5 + k as f64 / PARTS as f64);
    let mut altitudes = [0.0; PARTS + 1];
    for (a, t) in altitudes.iter_mut().zip(&times) {
        *a = position(*t)?.altitude_deg;
    }
    let (mut moment, mut length) = (0.0, 0.0);
    for k in 0..PARTS {
        let ((a, b), (from, to)) = ((altitudes[k], altitudes[k + 1]), (times[k], times[k + 1]));
        let rise = from + (to - from) * (a / (a - b)).clamp(0.0, 1.0);
        let (from, to) = match (a > 0.0, b > 0.0) {
            (true, true) => (from, to),
            (false, true) => (rise, to),
            (true, false) => (from, rise),
            (false, false) => continue,
        };
        moment += 0.5 * (to + from) * (to - from);
        length += to - from;
    }
    if length <= SHORTEST_H {
        return Ok(None);
    }
    Ok(Some((moment / length, position(moment / length)?)))
}
