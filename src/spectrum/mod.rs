//! Spectra, bands, photometry and colour: a leaf that every stage may use.

/// Maximum luminous efficacy of radiation, lm/W (CIE 018:2019).
pub const KM: f64 = 683.002;
