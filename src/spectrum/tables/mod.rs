//! Figures of the CIE, as published.

pub(super) mod cie1931;
pub(super) mod daylight;
#[expect(clippy::approx_constant, reason = "a lamp's spectrum has 3.14 by chance")]
pub(super) mod illuminants;
