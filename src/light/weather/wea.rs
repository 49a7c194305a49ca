//! WEA, the weather of Daysim and Radiance: six lines of header, then `month day hour direct diffuse`.
//!
//! Longitude and standard meridian count *west* as positive there; they are turned round here.

use super::{Record, Weather, check_day, check_place, hour_of_year, irradiance, number};
use crate::light::sun::Place;
use crate::{Error, Result};

const KEYS: [&str; 6] = ["place", "latitude", "longitude", "time_zone", "site_elevation", "weather_data_file_units"];

pub(super) fn parse(text: &str) -> Result<Weather> {
    let mut lines = text.lines().enumerate().map(|(i, l)| (i + 1, l)).filter(|(_, l)| !l.trim().is_empty());
    let mut values = [0.0; 6];
    let mut name = String::new();
    for (k, key) in KEYS.iter().enumerate() {
        let (line, text) = lines.next().unwrap_or((k + 1, ""));
        let (word, rest) = text.trim().split_once(char::is_whitespace).unwrap_or((text.trim(), ""));
        if word != *key {
            return Err(Error::malformed(format!("found `{word}`, expected the header line `{key}`"))
                .mend(format!("add `{key} ...` as line {} of the file", k + 1))
                .at_line(line));
        }
        if k == 0 {
            rest.trim().clone_into(&mut name);
        } else {
            values[k] = number(Some(rest), key).map_err(|e| e.at_line(line))?;
        }
        if k == 5 && values[k] != 1.0 {
            return Err(Error::unsupported(format!("weather_data_file_units {}", values[k]))
                .mend("write direct normal and diffuse horizontal irradiance in W/m², units 1")
                .at_line(line));
        }
    }
    let place = Place { latitude_deg: values[1], longitude_deg: -values[2] };
    let utc_offset_h = -values[3] / 15.0;
    check_place(place, utc_offset_h)?;
    let mut records: Vec<Record> = Vec::new();
    for (line, row) in lines {
        let record = record(row, line).map_err(|e| e.at_line(line))?;
        if records.last().is_some_and(|b| hour_of_year(b, true) >= hour_of_year(&record, true)) {
            return Err(Error::malformed("the hour is out of order").mend("sort the rows by time").at_line(line));
        }
        records.push(record);
    }
    Ok(Weather { name, place, utc_offset_h, elevation_m: values[4], records })
}

fn record(row: &str, line: usize) -> Result<Record> {
    let fields: Vec<&str> = row.split_whitespace().collect();
    let [month, day, hour, direct, diffuse] = fields[..] else {
        return Err(Error::malformed(format!("{} fields, a row has 5 numbers", fields.len()))
            .mend("write month, day, hour, direct normal and diffuse horizontal irradiance"));
    };
    let (month, day) = check_day(number(Some(month), "month")?, number(Some(day), "day")?)?;
    let middle_h = number(Some(hour), "hour")?;
    if !(0.0..=24.0).contains(&middle_h) {
        return Err(Error::malformed(format!("hour {middle_h}, expected 0 to 24")).mend("mend the row"));
    }
    Ok(Record {
        month,
        day,
        middle_h,
        direct_normal_w_m2: irradiance(Some(direct), "direct normal irradiance")?,
        diffuse_horizontal_w_m2: irradiance(Some(diffuse), "diffuse horizontal irradiance")?,
        dew_point_c: None,
        line,
    })
}
