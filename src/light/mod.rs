//! All that emits: surfaces, luminaires, the sky, the sun.
//!
//! In: the scene and its surfaces. Out: [`Emitters`]. Surfaces of one material form a *group*: they share a
//! spectrum, so that geometry is worked out once for all bands, and groups can be dimmed without a new solve.

mod daylight;
mod emitters;
mod guth;
mod lambert;
mod luminaires;
mod near_field;
pub mod photometry;
pub mod sky;
pub mod sun;
mod ugr_table;
pub mod weather;

pub use daylight::Daylight;
pub(crate) use daylight::site_of;
pub use emitters::{Emitter, Emitters};
pub use guth::position_index;
pub use lambert::{above_plane, configuration_factor, divide_by_plane};
pub use luminaires::{Luminaire, Luminaires, LuminousFace, Shape};
pub use near_field::point_distance_m;
pub use ugr_table::{UGR_REFLECTANCES, UgrRow, UgrSpacing, ugr_table};
