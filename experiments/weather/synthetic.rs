//! Weather by formula: clear, hazy and overcast days over 50° north.

use std::fmt::Write as _;

use clerestory::annual::CALENDAR_YEAR;
use clerestory::light::sun::{Air, Moment, Place, SunPosition, days_in_month};

const PLACE: Place = Place { latitude_deg: 50.0, longitude_deg: 10.0 };
const UTC_OFFSET_H: f64 = 1.0;
/// Light over its power, lm/W: of the sky and of the sun, about their means.
const SKY_LM_W: f64 = 120.0;
const SUN_LM_W: f64 = 100.0;

/// A kind of day, by the curves of IES RP-21 (1984): the sky gives `a + b sin(h)^c` klx, the sun `127.5 exp(−k / sin h)`.
struct Kind {
    /// Days up to this share of the sequence are of this kind.
    upto: f64,
    sky: [f64; 3],
    extinction: Option<f64>,
}

const KINDS: [Kind; 3] = [
    Kind { upto: 0.4, sky: [0.8, 15.5, 0.5], extinction: Some(0.21) },
    Kind { upto: 0.65, sky: [0.3, 45.0, 1.0], extinction: Some(0.80) },
    Kind { upto: 1.0, sky: [0.3, 21.0, 1.0], extinction: None },
];

/// Direct normal and diffuse horizontal irradiance of an hour, W/m², for a sun at an altitude.
fn irradiances(kind: &Kind, altitude_deg: f64) -> (f64, f64) {
    if altitude_deg <= 0.0 {
        return (0.0, 0.0);
    }
    let sine = altitude_deg.to_radians().sin();
    let [a, b, c] = kind.sky;
    let direct = kind.extinction.map_or(0.0, |k| 127.5e3 * (-k / sine).exp() / SUN_LM_W);
    (direct.round(), (1e3 * (a + b * sine.powf(c)) / SKY_LM_W).round())
}

/// The whole year as a WEA file.
pub(crate) fn wea() -> clerestory::Result<String> {
    let mut text = format!(
        "place Synthetic_clear_hazy_and_overcast_days\nlatitude {:.2}\nlongitude {:.2}\ntime_zone {:.0}\nsite_elevation 0.0\nweather_data_file_units 1\n",
        PLACE.latitude_deg,
        -PLACE.longitude_deg,
        -15.0 * UTC_OFFSET_H
    );
    let mut number = 0.0f64;
    for month in 1..=12 {
        for day in 1..=days_in_month(CALENDAR_YEAR, month) {
            number += 1.0;
            // The golden ratio spreads the kinds evenly and without a period.
            let share = (number * 0.618_033_988_75).fract();
            let kind = KINDS.iter().find(|k| share < k.upto).unwrap_or(&KINDS[2]);
            for hour in 0..24 {
                let middle_h = f64::from(hour) + 0.5;
                let moment = Moment { year: CALENDAR_YEAR, month, day, hours: middle_h - UTC_OFFSET_H };
                let altitude_deg = SunPosition::at(&moment, PLACE, Air::default())?.altitude_deg;
                let (direct, diffuse) = irradiances(kind, altitude_deg);
                // Writing to a string cannot fail.
                let _ = writeln!(text, "{month} {day} {middle_h:.3} {direct:.0} {diffuse:.0}");
            }
        }
    }
    Ok(text)
}
