//! Sensors and pixels, each with its error.

pub mod result;

pub use result::*;
