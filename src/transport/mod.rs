//! Who sees whom, and how much: rays, direct light, transport rows.
//!
//! In: a scene. Out: [`World`] (geometry behind one ray caster), [`Optics`] (what materials do, band by band),
//! [`Rows`] (the sampled rows of the transport matrix, geometry alone, good for every band).

mod bvh;
pub mod caster;
mod chain;
mod close;
mod daylight;
mod direct;
pub mod form_factor;
mod glass;
mod hung;
mod hung_images;
mod kernel;
mod lamps;
mod lanes;
mod openings;
mod optics;
mod packet;
mod panels;
mod places;
pub mod points;
mod portals;
mod rows;
mod scatterer;
mod specular;
mod spherical;
mod sun_images;
mod sunlight;
mod umbra;
mod visible;
mod window_paths;
mod world;

pub use chain::{Fork, Landing, Tint, follow};
pub use daylight::{DAYLIGHT_GROUPS, GROUND, SKY, SUN, Seen, deposit, pass_out, visible_directions};
pub use direct::{DirectScratch, direct, transmittance_to, visible_factor};
pub use glass::{Glazing, GlazingUnit, Pane, Shares};
pub use hung::{luminaire_in_sight, one_place_lx};
pub use hung_images::most_mirrored_lx;
pub use openings::{Openings, sun_through};
pub use optics::{LightPart, Optics, Scatter};
pub use panels::{PANEL_SETS, PanelColumns, PanelLook, PanelSun, Panels};
pub use places::{direct_at_place, direct_at_vertex};
pub use portals::{chance_weight, through_panes};
pub use rows::{Mirrored, Replica, RowSettings, Rows, Target};
pub use scatterer::Scatterer;
pub use specular::{Specular, Speculars};
pub use sun_images::SunImages;
pub use sunlight::{mirrored_sun, sun_direction, sun_factor};
pub use window_paths::{WindowLook, WindowSight, window_along};
pub use world::{Kind, World, cosine_direction};
