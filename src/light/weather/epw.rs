//! EnergyPlus weather: eight lines of header, then 8,760 or 8,784 rows of 35 fields.

use super::{Record, Weather, check_day, check_place, hour_of_year, irradiance, number};
use crate::light::sun::Place;
use crate::{Error, Result};

const HEADER_LINES: usize = 8;
/// Fields of a row; files from before 2008 leave out the last three.
const FEWEST_FIELDS: usize = 32;
const HOURS: usize = 8760;
const LEAP_HOURS: usize = 8784;
/// "Missing" for a dew point, °C.
const NO_DEW_POINT: f64 = 99.0;

pub(super) fn parse(text: &str) -> Result<Weather> {
    let mut lines = text.lines().enumerate().map(|(i, l)| (i + 1, l));
    let header: Vec<(usize, &str)> = lines.by_ref().take(HEADER_LINES).collect();
    let Some((_, location)) = header.first() else { return Err(Error::malformed("an empty file")) };
    let mut weather = self::location(location).map_err(|e| e.at_line(1))?;
    check_periods(&header)?;
    for (line, row) in lines.filter(|(_, l)| !l.trim().is_empty()) {
        let record = record(row, line).map_err(|e| e.at_line(line))?;
        check_order(weather.records.last(), &record).map_err(|e| e.at_line(line))?;
        weather.records.push(record);
    }
    let (count, leap) = (weather.records.len(), weather.records.iter().any(|r| (r.month, r.day) == (2, 29)));
    if count != if leap { LEAP_HOURS } else { HOURS } {
        return Err(Error::malformed(format!("{count} hours, expected {HOURS}, or {LEAP_HOURS} with 29 February"))
            .mend("the file is cut off: fetch it again"));
    }
    Ok(weather)
}

fn location(line: &str) -> Result<Weather> {
    let fields: Vec<&str> = line.split(',').collect();
    let value = |index: usize, name| number(fields.get(index).copied(), name);
    let place = Place { latitude_deg: value(6, "latitude")?, longitude_deg: value(7, "longitude")? };
    let (utc_offset_h, elevation_m) = (value(8, "time zone")?, value(9, "elevation")?);
    check_place(place, utc_offset_h)?;
    let name = fields.get(1).map(|s| s.trim().to_owned()).unwrap_or_default();
    Ok(Weather { name, place, utc_offset_h, elevation_m, records: Vec::new() })
}

/// One record an hour, one period.
fn check_periods(header: &[(usize, &str)]) -> Result<()> {
    let Some((line, text)) = header.iter().find(|(_, l)| l.starts_with("DATA PERIODS")) else {
        return Err(Error::malformed("no line DATA PERIODS among the first eight")
            .mend("the header is cut: fetch the file again")
            .at_line(header.len()));
    };
    let fields: Vec<&str> = text.split(',').collect();
    let an_hour = number(fields.get(2).copied(), "records an hour").map_err(|e| e.at_line(*line))?;
    if an_hour == 1.0 {
        return Ok(());
    }
    Err(Error::unsupported(format!("{an_hour} records an hour")).mend("give an hourly file").at_line(*line))
}

fn record(row: &str, line: usize) -> Result<Record> {
    let fields: Vec<&str> = row.split(',').collect();
    if fields.len() < FEWEST_FIELDS {
        return Err(Error::malformed(format!("{} fields, a row has 35", fields.len())).mend("export the file again"));
    }
    let value = |index: usize, name| number(Some(fields[index]), name);
    let (month, day) = check_day(value(1, "month")?, value(2, "day")?)?;
    let hour = value(3, "hour")?;
    if !(1.0..=24.0).contains(&hour) || hour.fract() != 0.0 {
        return Err(Error::malformed(format!("hour {hour}, expected 1 to 24")).mend("export the file again"));
    }
    Ok(Record {
        month,
        day,
        middle_h: hour - 0.5,
        direct_normal_w_m2: irradiance(Some(fields[14]), "direct normal irradiance")?,
        diffuse_horizontal_w_m2: irradiance(Some(fields[15]), "diffuse horizontal irradiance")?,
        dew_point_c: Some(value(7, "dew point")?).filter(|t| *t < NO_DEW_POINT),
        line,
    })
}

/// Every row is the hour after the one before.
fn check_order(before: Option<&Record>, record: &Record) -> Result<()> {
    let first = Record { month: 1, day: 1, middle_h: 0.5, ..*record };
    let expected = before.map_or(hour_of_year(&first, true), |b| hour_of_year(b, true) + 1.0);
    let found = hour_of_year(record, true);
    let skips_leap_day = expected == 59.0 * 24.0 + 0.5 && found == expected + 24.0;
    if found == expected || skips_leap_day {
        return Ok(());
    }
    let name = |r: &Record| format!("month {}, day {}, hour {}", r.month, r.day, r.middle_h + 0.5);
    let message = match before {
        Some(b) => format!("{} follows {}: rows are missing or out of order", name(record), name(b)),
        None => format!("the file begins at {}, expected the first hour of the year", name(record)),
    };
    Err(Error::malformed(message).mend("fetch the file again, or fill the missing rows"))
}
