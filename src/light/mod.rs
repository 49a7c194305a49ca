//! All that emits: surfaces, the sky, the sun.
//!
//! In: the scene and its surfaces. Out: [`Emitters`]. Surfaces of one material form a *group*: they share a
//! spectrum, so that geometry is worked out once for all bands, and groups can be dimmed without a new solve.

mod daylight;
mod emitters;
mod lambert;
pub mod sky;
pub mod sun;
pub mod weather;

pub use daylight::Daylight;
pub(crate) use daylight::site_of;
pub use emitters::{Emitter, Emitters};
pub use lambert::{above_plane, configuration_factor};
