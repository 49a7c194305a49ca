//! How the sky's luminance is spread over the hemisphere.
//!
//! In: a model and, where it matters, the direction to the sun. Out: [`Sky`], which tells the luminance of any
//! direction per unit of horizontal illuminance. The scale comes from an integral over the whole hemisphere, not from a
//! sum over patches. Directions are unit vectors, z up.

mod cie;
mod integral;
mod patches;
mod perez;

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use integral::Rule;

pub use cie::{CIE_TYPES, cie_coefficients};
pub use patches::Patches;
pub use perez::{Perez, PerezInput, USUAL_WATER_CM, irradiance_of, relative_air_mass};

/// The five numbers of a sky: gradation `a, b`, indicatrix `c, d, e`.
///
/// `L ∝ (1 + a exp(b / cos Z)) (1 + c (exp(d χ) − exp(d π/2)) + e cos² χ)`: `Z` angle from the zenith, `χ` from the sun
/// (CIE S 011/E:2003). Perez's model has the same form without the constant `exp(d π/2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Gradation: amount.
    pub a: f64,
    /// Gradation: steepness.
    pub b: f64,
    /// Indicatrix: brightness about the sun.
    pub c: f64,
    /// Indicatrix: its decay, per radian.
    pub d: f64,
    /// Indicatrix: back-scattering.
    pub e: f64,
}

/// A law of luminance over the hemisphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SkyModel {
    /// CIE S 011, by its five numbers.
    Cie(Coefficients),
    /// Perez et al. 1993, by its five numbers.
    Perez(Coefficients),
    /// The traditional overcast sky of Moon and Spencer 1942, `L/Lz = (1 + 2 sin γ)/3`.
    Overcast,
    /// The same in all directions.
    Uniform,
}

/// Perez's gradation explodes at the horizon where `b > 0`: cosine and exponent are held there, else a ring of half a
/// degree would hold all the light.
const LEAST_COSINE: f64 = 0.01;
const MOST_EXPONENT: f64 = 5.0;

impl SkyModel {
    /// Does the luminance depend on where the sun stands?
    #[must_use]
    pub fn needs_sun(&self) -> bool {
        match self {
            Self::Cie(k) | Self::Perez(k) => k.c != 0.0 || k.e != 0.0,
            Self::Overcast | Self::Uniform => false,
        }
    }

    /// Luminance in any unit: `cosine` of the angle from the zenith, `toward` cosine of the angle from the sun.
    fn shape(&self, cosine: f64, toward: f64) -> f64 {
        (self.gradation(cosine) * self.indicatrix(toward)).max(0.0)
    }

    /// What the angle from the sun makes of the luminance.
    fn indicatrix(&self, toward: f64) -> f64 {
        match self {
            Self::Uniform | Self::Overcast => 1.0,
            Self::Cie(k) => indicatrix(k, toward, k.c * (k.d * FRAC_PI_2).exp()),
            Self::Perez(k) => indicatrix(k, toward, 0.0),
        }
    }

    /// What the height above the horizon makes of it. Some combinations of Perez's fit go below zero; light does not, and
    /// whoever multiplies the two ends there.
    fn gradation(&self, cosine: f64) -> f64 {
        match self {
            Self::Uniform => 1.0,
            Self::Overcast => (1.0 + 2.0 * cosine) / 3.0,
            Self::Cie(k) => 1.0 + k.a * (k.b / cosine.max(1e-9)).exp(),
            Self::Perez(k) => 1.0 + k.a * (k.b / cosine.max(LEAST_COSINE)).min(MOST_EXPONENT).exp(),
        }
    }
}

fn indicatrix(k: &Coefficients, toward: f64, offset: f64) -> f64 {
    if k.c == 0.0 && k.e == 0.0 {
        return 1.0;
    }
    let toward = toward.clamp(-1.0, 1.0);
    1.0 + k.c * (k.d * toward.acos()).exp() - offset + k.e * toward * toward
}

/// A sky with its sun, scaled to a horizontal illuminance of one.
#[derive(Clone, Copy, Debug)]
pub struct Sky {
    model: SkyModel,
    sun: DVec3,
    /// `∫ shape cos Z dω`.
    horizontal: f64,
}

impl Sky {
    /// A sky of which the sun stands at the unit vector `sun`; models without a sun do not look at it.
    #[must_use]
    pub fn new(model: SkyModel, sun: DVec3) -> Self {
        Self::by_rule(model, sun, Rule::Fine)
    }

    /// The same at a tenth of the cost, its scale within 1e-4 (3e-3 with the sun below 5°): for the thousands of skies
    /// of a year.
    #[must_use]
    pub fn quick(model: SkyModel, sun: DVec3) -> Self {
        Self::by_rule(model, sun, Rule::Quick)
    }

    fn by_rule(model: SkyModel, sun: DVec3, rule: Rule) -> Self {
        let horizontal = match model {
            SkyModel::Uniform => PI,
            SkyModel::Overcast => 7.0 * PI / 9.0,
            _ => integral::horizontal(|t| model.indicatrix(t), |c, i| (model.gradation(c) * i).max(0.0), sun.z, rule),
        };
        Self { model, sun, horizontal }
    }

    /// Luminance of a direction per unit of horizontal illuminance, 1/sr; zero below the horizon.
    #[must_use]
    #[inline]
    pub fn luminance(&self, direction: DVec3) -> f64 {
        if direction.z < 0.0 {
            return 0.0;
        }
        self.model.shape(direction.z, direction.dot(self.sun)) / self.horizontal
    }

    /// What the luminances of all directions of one height share, for [`Sky::luminance_at`].
    #[must_use]
    pub fn gradation(&self, height: f64) -> f64 {
        self.model.gradation(height) / self.horizontal
    }

    /// [`Sky::luminance`] of a direction of the sky from the gradation at its height.
    #[must_use]
    #[inline]
    pub fn luminance_at(&self, gradation: f64, direction: DVec3) -> f64 {
        (gradation * self.model.indicatrix(direction.dot(self.sun))).max(0.0)
    }

    /// Horizontal illuminance over the luminance of the zenith, sr.
    #[must_use]
    pub fn horizontal_over_zenith(&self) -> f64 {
        1.0 / self.luminance(DVec3::Z)
    }

    /// Is the luminance the same everywhere?
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        self.model == SkyModel::Uniform
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(altitude_deg: f64, azimuth_deg: f64) -> DVec3 {
        let (h, a) = (altitude_deg.to_radians(), azimuth_deg.to_radians());
        DVec3::new(h.cos() * a.sin(), h.cos() * a.cos(), h.sin())
    }

    fn cie(number: u8, altitude_deg: f64) -> Sky {
        Sky::new(SkyModel::Cie(cie_coefficients(number).unwrap()), at(altitude_deg, 180.0))
    }

    #[test]
    fn uniform_sky_gives_pi_times_its_luminance() {
        // Type 5 goes through the quadrature, `Uniform` does not.
        for sky in [cie(5, 35.0), Sky::new(SkyModel::Uniform, DVec3::Z)] {
            assert!((sky.horizontal_over_zenith() - PI).abs() < 1e-12);
        }
    }

    #[test]
    fn overcast_sky_gives_seven_ninths_of_pi() {
        let integral = integral::horizontal(|_| 1.0, |c, i| SkyModel::Overcast.gradation(c) * i, 0.3, Rule::Fine);
        assert!((integral - 7.0 * PI / 9.0).abs() < 1e-12, "{integral}");
    }

    #[test]
    fn the_quick_rule_is_near_the_fine_one_in_all_weather() {
        for altitude in [0.5, 3.0, 10.0, 25.0, 50.0, 80.0] {
            for (direct, diffuse) in [(0.0, 60.0), (50.0, 100.0), (200.0, 150.0), (500.0, 120.0), (850.0, 60.0)] {
                let input = PerezInput {
                    direct_normal_w_m2: direct,
                    diffuse_horizontal_w_m2: diffuse,
                    sun_zenith_deg: 90.0 - altitude,
                    day_of_year: 80,
                    precipitable_water_cm: USUAL_WATER_CM,
                };
                let (model, sun) = (SkyModel::Perez(input.sky().coefficients), at(altitude, 200.0));
                let ratio = Sky::quick(model, sun).horizontal / Sky::new(model, sun).horizontal;
                let limit = if altitude < 5.0 { 3e-3 } else { 1e-4 };
                assert!((ratio - 1.0).abs() < limit, "{altitude} {direct}: {ratio}");
            }
        }
    }

    #[test]
    fn gradation_alone_does_not_know_the_sun() {
        let values: Vec<f64> = [5.0, 40.0, 90.0].iter().map(|h| cie(1, *h).horizontal_over_zenith()).collect();
        assert!((values[0] - values[1]).abs() < 1e-9 && (values[0] - values[2]).abs() < 1e-9, "{values:?}");
        assert!(!SkyModel::Cie(cie_coefficients(3).unwrap()).needs_sun());
    }

    #[test]
    fn luminance_at_the_horizon_is_the_limit_and_below_it_nothing() {
        for number in 1..=15 {
            let sky = cie(number, 30.0);
            let level = sky.luminance(DVec3::Y);
            assert!(level.is_finite() && (sky.luminance(at(1e-7, 0.0)) - level).abs() < 1e-6 * level, "{number}");
            assert_eq!(sky.luminance(at(-1e-3, 0.0)), 0.0);
        }
    }

    #[test]
    fn a_mirrored_pair_of_directions_is_equally_bright() {
        let sky = cie(12, 30.0); // sun in the south
        for h in [3.0, 30.0, 70.0] {
            assert!((sky.luminance(at(h, 100.0)) - sky.luminance(at(h, 260.0))).abs() < 1e-12);
        }
    }
}
