//! Figures of the CIE, as published.

pub(super) mod cie1931;
pub(super) mod daylight;
pub(super) mod illuminants;
