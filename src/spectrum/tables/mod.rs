//! Figures of the CIE, as published.

pub(super) mod action;
pub(super) mod cie1931;
pub(super) mod cie1964;
pub(super) mod daylight;
#[expect(clippy::approx_constant, reason = "a lamp's spectrum has 3.14 by chance")]
pub(super) mod illuminants;
#[expect(clippy::approx_constant, reason = "a reflectance is 0.318 by chance")]
pub(super) mod test_colours;
