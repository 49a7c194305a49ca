//! Where the sun stands, and how large it is.
//!
//! Positions follow the solar position algorithm of Reda and Andreas (NREL, 2004; crate `solar-positioning`).
//! **Refraction:** the altitude used everywhere is the apparent one, by the rule of that report for the air's pressure
//! and temperature (1010 hPa and 10 °C unless a weather file tells better); far below the horizon there is none. ΔT comes
//! from an estimate by date.

use glam::DVec3;
use solar_positioning::time::JulianDate;
use solar_positioning::{Location, RefractionCorrection, SolarPositions, delta_t};

use crate::{Error, Result};

/// Apparent diameter of the sun's disc, degrees: the mean over the year.
pub const DIAMETER_DEG: f64 = 0.533;

/// Distance from the middle of [`disc`] to its corners, the middle being at distance one: a little more than its radius.
pub const DISC_REACH: f64 = 0.004_759_836_356_3;

/// A moment in universal time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Year.
    pub year: i32,
    /// Month, 1 to 12.
    pub month: u32,
    /// Day of the month, from 1.
    pub day: u32,
    /// Hours of universal time; below 0 and above 24 they reach into the days beside.
    pub hours: f64,
}

impl Moment {
    /// Day of the year, from 1, in universal time.
    #[must_use]
    pub fn day_of_year(&self) -> u32 {
        let before = (1..self.month).map(|m| days_in_month(self.year, m)).sum::<u32>() + self.day;
        let year = if is_leap_year(self.year) { 366 } else { 365 };
        let shifted = i64::from(before) + (self.hours / 24.0).floor() as i64;
        if shifted < 1 { shifted as u32 + year } else { 1 + (shifted as u32 - 1) % year }
    }
}

/// Does the year hold a 29 February (Gregorian calendar)?
#[must_use]
pub fn is_leap_year(year: i32) -> bool {
    year % 4 == 0 && (year % 100 != 0 || year % 400 == 0)
}

/// Days of a month, 1 to 12.
#[must_use]
pub fn days_in_month(year: i32, month: u32) -> u32 {
    match month {
        2 if is_leap_year(year) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// A place on the earth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Degrees, north positive.
    pub latitude_deg: f64,
    /// Degrees, east positive.
    pub longitude_deg: f64,
}

/// The air that bends the sun's light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// Pressure, hPa.
    pub pressure_hpa: f64,
    /// Temperature, °C.
    pub temperature_c: f64,
}

impl Default for Air {
    fn default() -> Self {
        Self { pressure_hpa: 1010.0, temperature_c: 10.0 }
    }
}

/// Where the sun stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPosition {
    /// Altitude of its centre above the horizon, degrees, with refraction.
    pub altitude_deg: f64,
    /// Clockwise from true north, degrees.
    pub azimuth_deg: f64,
}

impl SunPosition {
    /// The sun at a moment over a place.
    ///
    /// # Errors
    /// When place, moment or air are out of range.
    pub fn at(moment: &Moment, place: Place, air: Air) -> Result<Self> {
        let find = || {
            let delta_t = delta_t::estimate_from_date(moment.year, moment.month)?;
            let midnight = JulianDate::from_utc(moment.year, moment.month, moment.day, 0, 0, 0.0, delta_t)?;
            let time = JulianDate::new(midnight.julian_date() + moment.hours / 24.0, delta_t)?;
            let location = Location { latitude: place.latitude_deg, longitude: place.longitude_deg };
            let refraction = RefractionCorrection::new(air.pressure_hpa, air.temperature_c)?;
            SolarPositions::new().at_from_julian(time, location, 0.0, Some(refraction))
        };
        let found = find()
            .map_err(|e: solar_positioning::Error| Error::malformed(format!("no sun for this place and time: {e}")))?;
        Ok(Self { altitude_deg: found.elevation_angle(), azimuth_deg: found.azimuth() })
    }

    /// Altitude within 1.5°, degrees, for a hundredth of the cost: declination and equation of time by Spencer 1971.
    #[must_use]
    pub fn rough_altitude_deg(moment: &Moment, place: Place) -> f64 {
        let day = std::f64::consts::TAU * (f64::from(moment.day_of_year()) - 1.0) / 365.0;
        let ((s1, c1), (s2, c2)) = (day.sin_cos(), (2.0 * day).sin_cos());
        let declination = 0.006918 - 0.399912 * c1 + 0.070257 * s1 - 0.006758 * c2 + 0.000907 * s2;
        let equation = 0.0000075 + 0.001868 * c1 - 0.032077 * s1 - 0.014615 * c2 - 0.040849 * s2;
        let from_noon = (15.0 * (moment.hours - 12.0) + place.longitude_deg).to_radians() + equation;
        let latitude = place.latitude_deg.to_radians();
        let across = latitude.cos() * declination.cos() * from_noon.cos();
        (latitude.sin() * declination.sin() + across).asin().to_degrees()
    }

    /// Unit vector to the sun in the program's axes (z up), true north being `north_deg` clockwise from +y.
    #[must_use]
    pub fn direction(&self, north_deg: f64) -> DVec3 {
        let (h, a) = (self.altitude_deg.to_radians(), (self.azimuth_deg + north_deg).to_radians());
        DVec3::new(h.cos() * a.sin(), h.cos() * a.cos(), h.sin())
    }
}

/// The disc as a regular polygon of its own solid angle, as seen from the origin: vertices at distance one.
#[must_use]
pub fn disc(direction: DVec3) -> [DVec3; 12] {
    let (u, v) = direction.any_orthonormal_pair();
    const COSINES: [f64; 12] = {
        const ROOT: f64 = 0.866_025_403_784_438_6;
        [1.0, ROOT, 0.5, 0.0, -0.5, -ROOT, -1.0, -ROOT, -0.5, 0.0, 0.5, ROOT]
    };
    std::array::from_fn(|k| direction + (u * COSINES[k] + v * COSINES[(k + 9) % 12]) * DISC_REACH)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disc_has_its_solid_angle() {
        // A regular polygon of n sides whose corners are at r has the area n r² sin(2π/n) / 2; here 3 r².
        let radius = (0.5 * DIAMETER_DEG).to_radians().tan();
        assert!((DISC_REACH - radius * (std::f64::consts::PI / 3.0).sqrt()).abs() < 1e-12, "{DISC_REACH}");
    }

    #[test]
    fn the_worked_example_of_the_report_is_met() {
        // Reda and Andreas, NREL/TP-560-34302, appendix A.5: zenith 50.11162, azimuth 194.34024 at 820 hPa, 11 °C.
        let moment = Moment { year: 2003, month: 10, day: 17, hours: 19.0 + 30.0 / 60.0 + 30.0 / 3600.0 };
        let place = Place { latitude_deg: 39.742_476, longitude_deg: -105.1786 };
        let sun = SunPosition::at(&moment, place, Air { pressure_hpa: 820.0, temperature_c: 11.0 }).unwrap();
        // The example stands 1,830 m high and takes its own ΔT, 67 s.
        assert!((90.0 - sun.altitude_deg - 50.11162).abs() < 1e-4, "{sun:?}");
        assert!((sun.azimuth_deg - 194.34024).abs() < 1e-4, "{sun:?}");
    }

    #[test]
    fn the_rough_altitude_is_within_its_bound() {
        for (latitude_deg, longitude_deg) in [(0.0, 0.0), (48.1, 11.6), (-33.9, 151.2), (69.6, 18.9), (90.0, 0.0)] {
            let place = Place { latitude_deg, longitude_deg };
            for year in [2024, 2026] {
                for month in 1..=12 {
                    for hours in [-9.0, -2.5, 0.0, 5.5, 12.0, 17.25, 23.9, 30.0] {
                        let moment = Moment { year, month, day: 3 + month * 2, hours };
                        let exact = SunPosition::at(&moment, place, Air::default()).unwrap().altitude_deg;
                        let rough = SunPosition::rough_altitude_deg(&moment, place);
                        assert!((rough - exact).abs() < 1.5, "{place:?} {moment:?}: {rough} {exact}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_sun_stands_in_the_south_of_a_northern_noon_and_north_turns_it() {
        let sun = SunPosition { altitude_deg: 30.0, azimuth_deg: 180.0 };
        let d = sun.direction(0.0);
        assert!((d - DVec3::new(0.0, -(30f64.to_radians().cos()), 0.5)).length() < 1e-12);
        // True north 90° clockwise from +y is +x: the south lies at −x.
        let turned = sun.direction(90.0);
        assert!((turned - DVec3::new(-(30f64.to_radians().cos()), 0.0, 0.5)).length() < 1e-12, "{turned}");
    }

    #[test]
    fn days_are_counted_through_new_year_and_leap_days() {
        let day = |year, month, day, hours| Moment { year, month, day, hours }.day_of_year();
        assert_eq!(day(2026, 1, 1, 0.0), 1);
        assert_eq!(day(2024, 3, 1, 12.0), 61);
        assert_eq!(day(2026, 12, 31, 23.0), 365);
        assert_eq!(day(2026, 12, 31, 25.0), 1);
        assert_eq!(day(2026, 1, 1, -1.0), 365);
    }

    #[test]
    fn the_disc_has_the_solid_angle_of_the_sun() {
        let d = SunPosition { altitude_deg: 40.0, azimuth_deg: 222.0 }.direction(0.0);
        let vertices = disc(d);
        // Seen face on, the configuration factor is sin² of the half angle.
        let exact = (0.5 * DIAMETER_DEG).to_radians().sin().powi(2);
        let found = crate::light::configuration_factor(&vertices, d);
        assert!((found / exact - 1.0).abs() < 1e-4, "{found} {exact}");
    }
}
