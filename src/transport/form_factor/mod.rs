//! Form factors between the patches of a uniform mesh, by the classic methods, exchangeable.
//!
//! | method | how | source |
//! |---|---|---|
//! | [`Analytic`] | contour integrals; where something stands between, exact clipping inside a quadrature | Lambert 1760; Goral et al. 1984 |
//! | [`Hemicube`] | an item buffer on half a cube | Cohen and Greenberg 1985 |
//! | [`Discs`] | rays to discs that make up the source | Wallace, Elmquist and Haines 1989 |
//!
//! Each fills rows `F_ij`, the share of what patch `i` sends that arrives at patch `j`: geometry alone, good for every
//! band. [`FormFactors`] holds all rows.

mod analytic;
mod contour;
mod discs;
mod hemicube;
mod matrix;
mod pairs;
mod quadrature;
mod shaft;

pub use analytic::Analytic;
pub use contour::exchange_area;
pub use discs::Discs;
pub use hemicube::{Hemicube, askew};
pub use matrix::{FormFactors, is_closed, sees_anything, staying_shares, too_far_off};
pub use pairs::{Pairs, Spread, face_each_other};

use super::direct::DirectScratch;

/// Buffers of one thread, and what was done with them.
#[derive(Debug, Default)]
pub struct Work {
    /// For exact clipping; counts shadow rays and factors.
    pub scratch: DirectScratch,
    /// Factors worked out without clipping.
    pub factors: u64,
    /// Rays cast apart from shadow rays.
    pub rays: u64,
}

impl Work {
    /// Rays of all kinds.
    #[must_use]
    pub fn all_rays(&self) -> u64 {
        self.rays + self.scratch.rays
    }

    /// Factors of all kinds.
    #[must_use]
    pub fn all_factors(&self) -> u64 {
        self.factors + self.scratch.factors
    }
}

/// One way to find the form factors of a mesh.
pub trait Method: Sync {
    /// What it is, for a record.
    fn describe(&self) -> String;

    /// Fills the row `F_ij` of patch `i`, for all `j`; `row` holds zeros when it begins.
    fn row(&self, i: usize, row: &mut [f64], work: &mut Work);

    /// Exchange area `A_i F_ij` of one pair, where that can be had alone and is the same both ways.
    fn exchange(&self, _i: usize, _j: usize, _work: &mut Work) -> Option<f64> {
        None
    }
}
