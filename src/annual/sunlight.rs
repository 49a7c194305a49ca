//! Hours of possible sunlight on single days, as EN 17037 asks for its exposure to sunlight: a cloudless day between
//! 1 February and 21 March, the sun counted from a least altitude on that each country names.

use glam::DVec3;
use rayon::prelude::*;

use super::climate::CALENDAR_YEAR;
use crate::error::Result;
use crate::light::sun::{Air, Moment, Place, SunPosition};
use crate::measure::{Coefficients, Status};

/// The ends of the standard's season: month and day.
pub const DAYS: [(u32, u32); 2] = [(2, 1), (3, 21)];
/// Step in which the sun is followed, hours. A line of sight that opens or shuts is found to half of it.
const STEP_H: f64 = 1.0 / 12.0;

/// Where the sun stands, step by step, on the days.
pub(super) struct SunPaths([Vec<DVec3>; 2]);

impl SunPaths {
    /// From the altitude `least_deg` on. Steps are those of universal time: a day here is from midnight to midnight by the
    /// mean sun of the place.
    pub(super) fn new(place: Place, north_deg: f64, least_deg: f64) -> Result<Self> {
        let noon_utc_h = 12.0 - place.longitude_deg / 15.0;
        let path = |(month, day): (u32, u32)| -> Result<Vec<DVec3>> {
            let mut path = Vec::new();
            let steps = (12.0 / STEP_H) as i32;
            for k in -steps..steps {
                let hours = noon_utc_h + (f64::from(k) + 0.5) * STEP_H;
                let sun = SunPosition::at(&Moment { year: CALENDAR_YEAR, month, day, hours }, place, Air::default())?;
                if sun.altitude_deg > least_deg {
                    path.push(sun.direction(north_deg));
                }
            }
            Ok(path)
        };
        Ok(Self([path(DAYS[0])?, path(DAYS[1])?]))
    }

    /// Hours in which the sun's disc is seen from each sensor of a grid, at least in part, blinds open.
    pub(super) fn hours(&self, coefficients: &Coefficients, grid: usize, status: &[Status]) -> Vec<[f64; 2]> {
        let patch = |sun: &DVec3| (*sun, coefficients.seen_patches.of(*sun));
        let paths = [0, 1].map(|d| self.0[d].iter().map(patch).collect::<Vec<_>>());
        let of = |scratch: &mut _, (i, status): (usize, &Status)| {
            let is_lit = *status == Status::Ok;
            let sunny = if is_lit { coefficients.sunny_patches(grid, i) } else { Vec::new() };
            let mut seen =
                |(sun, home): &&(DVec3, usize)| sunny[*home] && coefficients.sun(grid, i, *sun, scratch).0 > 0.0;
            [0, 1].map(|d| if is_lit { STEP_H * paths[d].iter().filter(&mut seen).count() as f64 } else { 0.0 })
        };
        status.par_iter().enumerate().with_max_len(8).map_init(|| coefficients.scratch(), of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_is_up_for_half_of_the_day_at_equinox_on_the_equator() {
        let place = Place { latitude_deg: 0.0, longitude_deg: -122.0 };
        let paths = SunPaths::new(place, 0.0, 0.0).unwrap();
        // Refraction and the disc are small against a step; every step counts for its middle.
        assert!((STEP_H * paths.0[1].len() as f64 - 12.0).abs() <= 2.0 * STEP_H, "{}", paths.0[1].len());
        let higher = SunPaths::new(place, 0.0, 15.0).unwrap();
        // The sun climbs 15 degrees an hour there.
        assert!((STEP_H * higher.0[1].len() as f64 - 10.0).abs() <= 2.0 * STEP_H, "{}", higher.0[1].len());
    }
}
