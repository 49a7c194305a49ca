//! What light does to the receptors of CIE S 026, read from the bands of a sensor.

use super::result::SensorResult;
use crate::error::{Error, Result};
use crate::spectrum::{Action, Bands, SpectralValue, Spectrum};

/// Turns band values into alpha-opic irradiances with their errors.
#[derive(Clone, Debug)]
pub struct AlphaOpicScale {
    /// W/m² per W/(m² nm) of each band, in the order of [`crate::spectrum::ALPHA_OPIC`].
    weights: Vec<[f64; 5]>,
    /// Largest share that the division into bands may miss.
    pub miss: [f64; 5],
}

/// Alpha-opic readings of a sensor; half-widths of 95 % intervals beside the values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlphaOpic {
    /// Irradiances and errors, W/m², in the order of [`crate::spectrum::ALPHA_OPIC`].
    pub irradiance: [(f64, f64); 5],
    /// Melanopic equivalent daylight (D65) illuminance and its error, lx.
    pub melanopic_edi_lx: (f64, f64),
}

impl AlphaOpicScale {
    /// The scale of a division into bands, for a scene of these materials and lights.
    ///
    /// # Errors
    /// Malformed for red, green and blue; impossible for a light below zero.
    pub(super) fn new(
        bands: &Bands,
        reflectances: &[(&SpectralValue, f64)],
        lights: &[(&Spectrum, f64)],
    ) -> Result<Self> {
        let weights = bands.alpha_opic_weights().ok_or_else(|| {
            Error::malformed("alpha-opic irradiances cannot be told from red, green and blue")
                .mend("set mode = \"auto\" or a step in nm in [bands]")
        })?;
        Ok(Self { weights, miss: bands.alpha_opic_miss(reflectances, lights)? })
    }

    /// Reads a sensor that has its bands. The errors of the bands may all have one sign (the same rays serve them all),
    /// so they are added.
    #[must_use]
    pub fn read(&self, sensor: &SensorResult) -> AlphaOpic {
        let mut irradiance = [(0.0, 0.0); 5];
        for (w, band) in self.weights.iter().zip(&sensor.spectral) {
            for (sum, w) in irradiance.iter_mut().zip(w) {
                *sum = (sum.0 + w * band.irradiance, sum.1 + w * band.error);
            }
        }
        for (value, miss) in irradiance.iter_mut().zip(self.miss) {
            value.1 += miss * value.0;
        }
        let per_lux = Action::Melanopic.d65_w_lm().unwrap_or(f64::NAN);
        let (value, error) = irradiance[4];
        AlphaOpic { irradiance, melanopic_edi_lx: (value / per_lux, error / per_lux) }
    }
}
