//! Sensors and pixels, each with its error.
//!
//! In: a [`Scene`](crate::scene::Scene) and a tolerance. Out: a [`Measurement`]. The tolerance is asked at the sensors, so the work starts there
//! and goes only as far as it matters: [`solve()`] chooses mesh, rays and bands, judges every sensor by its stated
//! error, and refines what the statement blames.

mod adaptive;
mod alpha_opic;
mod appraisal;
mod bsdf;
mod camera;
mod classic;
mod coefficients;
mod demand;
mod gather;
mod glare;
mod ledger;
mod memory;
mod options;
mod path_tracing;
mod picture;
mod probe;
mod receiver;
mod remarks;
mod result;
mod room_surfaces;
mod run;
mod sensor_state;
mod solved;
mod statement;
mod states;

pub use alpha_opic::{AlphaOpic, AlphaOpicScale};
pub use appraisal::{Appraisal, Judged, Power, RoomSurface, Verdict};
pub use coefficients::{Coefficients, ESTIMATES, GridCoefficients, SunScratch};
pub use memory::parse_size;
pub use options::{Display, Method, Progress, Silent, SolveOptions};
pub use remarks::remarks;
pub use result::*;
pub use run::{coefficients, solve};
pub(crate) use statement::student;
