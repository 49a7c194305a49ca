//! Hourly weather: EPW and WEA files in, direct and diffuse irradiance by the hour out.
//!
//! **Hours.** A record stands for the hour about its middle, in the file's own standard time (no summer time). An EPW
//! file numbers hours 1 to 24 by their *end*, so hour 12 is 11:00 to 12:00 with its middle at 11.5; a WEA file states
//! the middle itself. **Missing values** stay missing: asking for such an hour is an error that names its line.

mod epw;
mod wea;

use std::path::Path;

use super::sun::{Moment, Place, days_in_month};
use crate::{Error, Result};

/// A weather file.
#[derive(Clone, Debug, PartialEq)]
pub struct Weather {
    /// Name of the place.
    pub name: String,
    /// Where it is.
    pub place: Place,
    /// Standard time of the file against universal time, hours, east positive.
    pub utc_offset_h: f64,
    /// Height above the sea, m.
    pub elevation_m: f64,
    /// The hours, in the order of the file.
    pub records: Vec<Record>,
}

/// One hour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// Month, 1 to 12.
    pub month: u32,
    /// Day of the month.
    pub day: u32,
    /// Middle of the hour in the file's standard time, hours from midnight.
    pub middle_h: f64,
    /// Mean direct irradiance on a plane that faces the sun, W/m²; `None` where the file has no value.
    pub direct_normal_w_m2: Option<f64>,
    /// Mean diffuse irradiance of a horizontal plane, W/m²; `None` where the file has no value.
    pub diffuse_horizontal_w_m2: Option<f64>,
    /// Dew point, °C, where it is known.
    pub dew_point_c: Option<f64>,
    /// Line in the file.
    pub line: usize,
}

impl Record {
    /// Water above the ground, cm, from the dew point (Wright et al. 1989, as Perez et al. 1990 take it).
    #[must_use]
    pub fn precipitable_water_cm(&self) -> Option<f64> {
        self.dew_point_c.map(|t| (0.07 * t - 0.075).exp())
    }
}

/// More than the sun sends, W/m².
const MOST_W_M2: f64 = 1500.0;
/// Values from here on mean "missing" in both formats.
const MISSING: f64 = 9990.0;
/// Standard times lie between these, hours.
const ZONES_H: std::ops::RangeInclusive<f64> = -14.0..=14.0;
/// Standard time and longitude never lie further apart, hours.
const MOST_ZONE_H: f64 = 4.0;

impl Weather {
    /// Reads an EPW or WEA file; its first line tells which it is.
    ///
    /// # Errors
    /// Malformed lines, rows out of order or left out, values that no weather has: with line and mend.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        // Names of places come in many encodings; all numbers are ASCII.
        let text = String::from_utf8_lossy(bytes);
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let first = text.lines().next().unwrap_or_default().trim_start();
        let weather = if first.starts_with("LOCATION") {
            epw::parse(text)?
        } else if first.starts_with("place") {
            wea::parse(text)?
        } else {
            return Err(Error::malformed("neither an EPW file (LOCATION,...) nor a WEA file (place ...)")
                .mend("give a weather file in one of the two formats")
                .at_line(1));
        };
        if weather.records.is_empty() {
            return Err(Error::malformed("the file holds no hour").mend("export it again"));
        }
        Ok(weather)
    }

    /// Reads a file from the disk.
    ///
    /// # Errors
    /// As [`Weather::parse`], and where the file cannot be read.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, &e))?;
        Self::parse(&bytes).map_err(|e| e.in_file(path))
    }

    /// The hour that holds a moment; typical years stand for any year.
    ///
    /// # Errors
    /// When the file does not hold that hour.
    pub fn at(&self, moment: &Moment) -> Result<&Record> {
        let (month, day, hour) = local(moment, self.utc_offset_h);
        let holds = |r: &&Record| r.month == month && r.day == day && (-0.5..0.5).contains(&(hour - r.middle_h));
        self.records.iter().find(holds).ok_or_else(|| {
            Error::malformed(format!("the weather file holds no hour about {month}-{day} {hour:.2} h of its own time"))
                .mend("choose a time inside the file, or another file")
        })
    }

    /// Does it hold a 29 February?
    #[must_use]
    pub fn is_leap(&self) -> bool {
        self.records.iter().any(|r| (r.month, r.day) == (2, 29))
    }

    /// Number of hours without direct or diffuse irradiance.
    #[must_use]
    pub fn missing(&self) -> usize {
        let lacks = |r: &&Record| r.direct_normal_w_m2.is_none() || r.diffuse_horizontal_w_m2.is_none();
        self.records.iter().filter(lacks).count()
    }
}

/// Month, day and hours from midnight in a time zone.
fn local(moment: &Moment, utc_offset_h: f64) -> (u32, u32, f64) {
    let mut hour = moment.hours + utc_offset_h;
    let (mut year, mut month, mut day) = (moment.year, moment.month, moment.day);
    while hour < 0.0 {
        hour += 24.0;
        if day > 1 {
            day -= 1;
            continue;
        }
        (year, month) = if month > 1 { (year, month - 1) } else { (year - 1, 12) };
        day = days_in_month(year, month);
    }
    while hour >= 24.0 {
        hour -= 24.0;
        day += 1;
        if day > days_in_month(year, month) {
            (year, month, day) = if month < 12 { (year, month + 1, 1) } else { (year + 1, 1, 1) };
        }
    }
    (month, day, hour)
}

/// A finite number in a field, by name.
fn number(field: Option<&str>, name: &str) -> Result<f64> {
    let text = field.map(str::trim).unwrap_or_default();
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ => Err(Error::malformed(format!("{name}: `{text}` is no number")).mend("export the file again")),
    }
}

/// An irradiance; `None` where the format's code for "missing" stands.
fn irradiance(field: Option<&str>, name: &str) -> Result<Option<f64>> {
    let value = number(field, name)?;
    if value >= MISSING {
        return Ok(None);
    }
    if !(0.0..=MOST_W_M2).contains(&value) {
        return Err(Error::impossible(format!("{name} is {value} W/m², expected 0 to {MOST_W_M2}"))
            .mend("mend the value, or write 9999 where it is missing"));
    }
    Ok(Some(value))
}

/// Place and zone must be on the earth and fit each other.
fn check_place(place: Place, utc_offset_h: f64) -> Result<()> {
    if !(-90.0..=90.0).contains(&place.latitude_deg) || !(-180.0..=180.0).contains(&place.longitude_deg) {
        return Err(Error::impossible(format!(
            "latitude {} and longitude {} are no place on the earth",
            place.latitude_deg, place.longitude_deg
        ))
        .mend("mend the header"));
    }
    check_zone(place.longitude_deg, utc_offset_h)
}

/// A longitude with the wrong sign puts noon at night: it must fit its time zone.
pub(crate) fn check_zone(longitude_deg: f64, utc_offset_h: f64) -> Result<()> {
    if !ZONES_H.contains(&utc_offset_h) {
        return Err(Error::impossible(format!("no place keeps the time UTC{utc_offset_h:+}"))
            .mend("a time zone is at most 14 hours from UTC; a meridian at most 210 degrees"));
    }
    let apart = (longitude_deg / 15.0 - utc_offset_h + 12.0).rem_euclid(24.0) - 12.0;
    if apart.abs() <= MOST_ZONE_H {
        return Ok(());
    }
    Err(Error::impossible(format!(
        "longitude {longitude_deg} (east positive) and time zone UTC{utc_offset_h:+} lie {:.1} hours apart",
        apart.abs()
    ))
    .mend("one of the two has the wrong sign: east of Greenwich both are positive"))
}

/// A calendar day; the year is typical, so that 29 February may stand in any.
fn check_day(month: f64, day: f64) -> Result<(u32, u32)> {
    let whole = month.fract() == 0.0 && day.fract() == 0.0;
    if whole && (1.0..=12.0).contains(&month) {
        let month = month as u32;
        if (1.0..=f64::from(days_in_month(2000, month))).contains(&day) {
            return Ok((month, day as u32));
        }
    }
    Err(Error::malformed(format!("month {month}, day {day} is no date")).mend("export the file again"))
}

/// Hours since the year began, by a calendar with 29 February if `leap`.
pub(crate) fn hour_of_year(record: &Record, leap: bool) -> f64 {
    let year = if leap { 2000 } else { 2001 };
    let days: u32 = (1..record.month).map(|m| days_in_month(year, m)).sum::<u32>() + record.day - 1;
    f64::from(days) * 24.0 + record.middle_h
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A whole year of made-up hours.
    pub(super) fn epw(rows: impl Fn(u32, u32, u32) -> Option<String>) -> String {
        let mut text = String::from("LOCATION,Nowhere,-,-,synthetic,000000,52.5,13.4,1.0,34.0\n");
        for head in ["DESIGN CONDITIONS,0", "TYPICAL/EXTREME PERIODS,0", "GROUND TEMPERATURES,0"] {
            text += &format!("{head}\n");
        }
        text += "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,none\nCOMMENTS 2,none\n";
        text += "DATA PERIODS,1,1,Data,Sunday, 1/ 1,12/31\n";
        for month in 1..=12 {
            for day in 1..=days_in_month(2001, month) {
                for hour in 1..=24 {
                    text += &rows(month, day, hour).unwrap_or_default();
                }
            }
        }
        text
    }

    pub(super) fn row(month: u32, day: u32, hour: u32, direct: &str, diffuse: &str) -> String {
        let rest = "0,".repeat(18) + "0";
        format!("2001,{month},{day},{hour},0,?,10.0,5.0,70,101325,0,0,300,0,{direct},{diffuse},{rest}\n")
    }

    fn whole() -> String {
        epw(|m, d, h| Some(row(m, d, h, &h.to_string(), "50")))
    }

    const WEA: &str = "place Nowhere\nlatitude 52.50\nlongitude -13.40\ntime_zone -15\nsite_elevation 34.0\n\
                       weather_data_file_units 1\n1 1 11.5 300 90\n1 1 12.5 320 95\n";

    #[test]
    fn an_epw_hour_is_named_by_its_end() {
        let weather = Weather::parse(whole().as_bytes()).unwrap();
        assert_eq!(weather.records.len(), 8760);
        assert_eq!(weather.records[11].middle_h, 11.5);
        // 11:20 in UTC+1 is 10:20 in universal time and lies in hour 12.
        let at = |hours| weather.at(&Moment { year: 2026, month: 3, day: 21, hours }).unwrap().direct_normal_w_m2;
        assert_eq!(at(10.0 + 20.0 / 60.0), Some(12.0));
        assert_eq!(at(11.0), Some(13.0), "noon begins hour 13");
        assert_eq!(at(-0.5), Some(1.0), "half past midnight at UTC+1 is the evening before in universal time");
    }

    #[test]
    fn a_wea_file_counts_west_and_says_the_middle() {
        let weather = Weather::parse(WEA.as_bytes()).unwrap();
        assert_eq!((weather.place.longitude_deg, weather.utc_offset_h), (13.4, 1.0));
        assert_eq!(weather.records[0].middle_h, 11.5);
        let at = weather.at(&Moment { year: 2026, month: 1, day: 1, hours: 11.25 }).unwrap();
        assert_eq!(at.direct_normal_w_m2, Some(320.0), "12:15 lies in the hour about 12.5");
    }

    #[test]
    fn broken_files_name_line_and_mend() {
        let cases = [
            (epw(|m, d, h| (h != 7 || d != 2).then(|| row(m, d, h, "0", "0"))), "follows", 39),
            (epw(|m, d, h| Some(row(m, d, h, if h == 3 { "-4" } else { "0" }, "0"))), "-4", 11),
            (epw(|m, d, h| Some(row(m, d, h, "0", if h == 3 { "x" } else { "0" }))), "`x`", 11),
            (epw(|m, d, h| (m < 12).then(|| row(m, d, h, "0", "0"))), "8016", 0),
            (whole().replace(",13.4,1.0,", ",-13.4,8.0,"), "wrong sign", 1),
            (whole().replace("LOCATION,", "PLACE,"), "neither", 1),
            (whole().replace("DATA PERIODS,1,1", "DATA PERIODS,1,4"), "4 records an hour", 8),
            (WEA.replace("units 1", "units 2"), "units", 6),
            (WEA.replace("time_zone -15", "time_zone 120"), "wrong sign", 0),
            (WEA.replace("12.5 320", "10.5 320"), "order", 8),
            (WEA.replace("320 95", "320"), "5 numbers", 8),
            (WEA.replace("latitude 52.50", "latitude 152"), "no place", 0),
        ];
        for (text, word, line) in cases {
            let e = Weather::parse(text.as_bytes()).unwrap_err().in_file("w").to_string();
            assert!(e.contains(word) && e.contains("mend:"), "{word}: {e}");
            assert!(line == 0 || e.starts_with(&format!("w:{line}:")), "{word}, line {line}: {e}");
        }
    }

    #[test]
    fn missing_values_stay_missing() {
        let weather = Weather::parse(epw(|m, d, h| Some(row(m, d, h, "9999", "50"))).as_bytes()).unwrap();
        assert_eq!(weather.missing(), 8760);
        assert_eq!(weather.records[0].direct_normal_w_m2, None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn no_file_breaks_the_reader(bytes in proptest::collection::vec(any::<u8>(), 0..400), head in 0usize..3) {
            let head = ["", "LOCATION,a,b,c,d,e,52.5,13.4,1.0,34\n", "place x\nlatitude 1\n"][head];
            let mut all = head.as_bytes().to_vec();
            all.extend(bytes);
            let _ = Weather::parse(&all);
        }

        #[test]
        fn a_file_with_one_line_spoilt_is_read_or_named(line in 0usize..300, at in 0usize..60, with in any::<u8>()) {
            let mut lines: Vec<Vec<u8>> = whole().lines().map(|l| l.as_bytes().to_vec()).collect();
            let target = &mut lines[line];
            let place = at % target.len();
            target[place] = with;
            match Weather::parse(&lines.join(&b'\n')) {
                Ok(w) => prop_assert!(w.records.len() == 8760),
                Err(e) => prop_assert!(e.is_input()),
            }
        }
    }
}
