//! All that emits, behind one idea: polygons with an exitance per group.
//!
//! In: the scene and its surfaces. Out: [`Emitters`]. Surfaces of one material form a *group*: they share a
//! spectrum, so that geometry is worked out once for all bands, and groups can be dimmed without a new solve.

mod emitters;
mod lambert;

pub use emitters::{Emitter, Emitters};
pub use lambert::{above_plane, configuration_factor};
