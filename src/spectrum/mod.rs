//! Spectra, bands, photometry and colour: a leaf that every stage may use.
//!
//! A [`Spectrum`] is a piecewise linear curve over the wavelength in nanometres. [`Bands`] divides the
//! spectrum for the solver, turns reflectances and emissions into band values and band values back into
//! CIE XYZ. All integrals are exact for the piecewise linear curves (see [`cie`]), so that a sum over bands
//! equals the whole.

mod action;
mod bands;
pub mod cie;
pub mod colour;
mod curve;
mod illuminant;
mod planner;
mod tables;
mod upsample;

pub use action::{ALPHA_OPIC, Action, KM_SCOTOPIC, daylight_efficacy_ratio, scotopic_over_photopic};
pub use bands::{BandMode, Bands};
pub use curve::{Beyond, Spectrum};
pub use illuminant::{daylight_factors, daylight_xy, from_cct, illuminant, illuminant_names};
pub use upsample::SpectralValue;

/// Maximum luminous efficacy of radiation, lm/W (CIE 018:2019).
pub const KM: f64 = 683.002;
