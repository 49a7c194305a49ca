//! Surfaces in the program's own frame, and the elements they are divided into on demand.
//!
//! In: a [`Scene`](crate::scene::Scene). Out: [`Surfaces`] (polygons about a local origin, scaled to size one,
//! with the lines along which other surfaces touch them) and [`Elements`] (cells of a surface's grid, cut
//! along those lines, made when a ray asks for them; larger where [`Importance`] is thin). [`PatchMesh`] makes them all
//! at once, for the classic methods, [`PatchTree`] in all sizes.

mod contact;
mod elements;
mod importance;
mod linear;
mod polygon;
mod solid;
mod surfaces;
mod tree;
mod uniform;

pub use elements::{Element, ElementKey, Elements, NO_ELEMENT};
pub use importance::Importance;
pub use linear::Linear;
pub use polygon::{clip_halfplane, clip_line, polygon_area, sample_polygon};
pub use surfaces::{Frame, Surface, Surfaces};
pub use tree::{Node, PatchTree};
pub use uniform::{Patch, PatchMesh, Patches};
