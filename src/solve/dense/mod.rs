//! The classic solvers of the dense radiosity system, all bands at once.
//!
//! ```text
//! B_i = M_i + ρ_i H_i,   H_i = Σ_j F_ij B_j
//! ```
//! In: [`FormFactors`], reflectances and emitted exitances. Out: an [`Outcome`] with radiosities `B`, irradiances `H`, and what is known of
//! their error. Every solver gives the same answer; they differ in how soon they come near it.
//!
//! | solver | source |
//! |---|---|
//! | [`Solver::FullMatrix`] | Gaussian elimination: Goral et al. 1984 |
//! | [`Solver::Jacobi`], [`Solver::GaussSeidel`] | gathering: Cohen and Greenberg 1985 |
//! | [`Solver::Southwell`] | shooting: Gortler, Cohen and Slusallek 1993 |
//! | [`Solver::Overshooting`] | shooting what is still to come as well: Feda and Purgathofer 1992 |
//! | [`Solver::ConjugateGradients`] | Hestenes and Stiefel 1952, on the symmetric form |

mod conjugate;
mod full_matrix;
mod gathering;
mod shooting;

/// Excess over one of `ρ_i Σ_j F_ij` that is rounding.
const GAIN: f64 = 1e-6;

pub use shooting::{ExchangeRows, OnDemand, Shooting};

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::transport::form_factor::FormFactors;

/// A way to solve the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// Gaussian elimination, one band after another.
    FullMatrix,
    /// Gathering, every patch from the last sweep.
    Jacobi,
    /// Gathering, every patch from the newest values.
    GaussSeidel,
    /// Shooting from the patch with the most unshot flux.
    Southwell,
    /// Shooting, with the expected return of the room shot in advance.
    Overshooting,
    /// Conjugate gradients on the symmetric form.
    ConjugateGradients,
}

/// What turns radiosities into irradiances: a matrix of form factors, or something that acts as one.
pub trait Operator: Sync {
    /// Irradiance of all patches from their radiosities; `bands` of each, fastest.
    fn irradiance(&self, radiosity: &[f64], bands: usize) -> Vec<f64>;

    /// Does no light leave the scene?
    fn is_closed(&self) -> bool;
}

impl Operator for FormFactors {
    fn irradiance(&self, radiosity: &[f64], bands: usize) -> Vec<f64> {
        let mut out = vec![0.0; radiosity.len()];
        out.par_chunks_mut(bands.max(1)).enumerate().for_each(|(i, h)| gather(self, i, radiosity, h));
        out
    }

    fn is_closed(&self) -> bool {
        self.closed
    }
}

/// Irradiance of one patch, into `h`.
fn gather(factors: &FormFactors, i: usize, radiosity: &[f64], h: &mut [f64]) {
    h.fill(0.0);
    for (x, b) in factors.exchange_row(i).iter().zip(radiosity.chunks_exact(h.len())) {
        h.iter_mut().zip(b).for_each(|(h, b)| *h += x * b);
    }
    h.iter_mut().for_each(|h| *h /= factors.areas[i]);
}

/// The system of a mesh. Fields are stored patch by patch, band fastest.
#[derive(Clone, Debug)]
pub struct System {
    /// Number of bands.
    pub bands: usize,
    /// Areas of the patches.
    pub areas: Vec<f64>,
    /// Reflectance.
    pub rho: Vec<f64>,
    /// Emitted exitance `M`, W/(m² nm).
    pub emitted: Vec<f64>,
}

/// A solution, and what is known of its error.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Radiosity `B`, W/(m² nm).
    pub radiosity: Vec<f64>,
    /// Irradiance `H`, W/(m² nm).
    pub irradiance: Vec<f64>,
    /// Sweeps, shots or products that were needed; eliminations for the full matrix.
    pub iterations: usize,
    /// Largest `|M + ρFB − B|` over the patches, against the largest reflected part `B − M`; over all bands.
    pub residual: f64,
    /// Flux in that residual, against the flux emitted: what is still to be shot. Largest over the bands.
    pub unshot: f64,
    /// Bound on the largest error of `B` against the largest reflected part: residual over `1 − ρ_max`. Largest over the
    /// bands.
    pub bound: f64,
}

impl System {
    /// Number of patches.
    #[must_use]
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// No patches?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Flux emitted in each band.
    #[must_use]
    pub fn emitted_flux(&self) -> Vec<f64> {
        self.flux(&self.emitted)
    }

    /// Mean reflectance by area, in each band.
    #[must_use]
    pub fn mean_rho(&self) -> Vec<f64> {
        let total: f64 = self.areas.iter().sum();
        self.flux(&self.rho).iter().map(|r| r / total.max(1e-300)).collect()
    }

    /// `Σ A |x|`, band by band.
    fn flux(&self, x: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.bands];
        for (a, x) in self.areas.iter().zip(x.chunks_exact(self.bands)) {
            sums.iter_mut().zip(x).for_each(|(s, x)| *s += a * x.abs());
        }
        sums
    }

    /// Irradiance of all patches from their radiosities.
    #[must_use]
    pub fn irradiance(&self, factors: &dyn Operator, radiosity: &[f64]) -> Vec<f64> {
        factors.irradiance(radiosity, self.bands)
    }

    /// Solves until the residual of every band is at most `accuracy` of its largest reflected radiosity.
    ///
    /// # Errors
    ///
    /// When there is no finite solution: the scene is closed and nothing absorbs, or the form factors of a patch sum to so
    /// much that it would reflect more than all light that leaves it.
    pub fn solve(&self, factors: &FormFactors, solver: Solver, accuracy: f64) -> Result<Outcome> {
        self.check_finite(factors)?;
        self.check_growth(factors)?;
        let (radiosity, iterations) = match solver {
            Solver::FullMatrix => (full_matrix::solve(self, factors)?, self.bands),
            Solver::Jacobi => gathering::jacobi(self, factors, accuracy),
            Solver::GaussSeidel => gathering::gauss_seidel(self, factors, accuracy),
            Solver::Southwell => shooting::to_the_end(self, factors, accuracy, false),
            Solver::Overshooting => shooting::to_the_end(self, factors, accuracy, true),
            Solver::ConjugateGradients => return self.solve_by_products(factors, accuracy),
        };
        Ok(self.judge(factors, radiosity, iterations))
    }

    /// The same by conjugate gradients, which ask for nothing but products.
    ///
    /// # Errors
    ///
    /// When there is no finite solution: the scene is closed and nothing absorbs.
    pub fn solve_by_products(&self, factors: &dyn Operator, accuracy: f64) -> Result<Outcome> {
        self.check_finite(factors)?;
        let (radiosity, iterations) = conjugate::solve(self, factors, accuracy);
        Ok(self.judge(factors, radiosity, iterations))
    }

    /// What is known of a radiosity, however it was come by.
    #[must_use]
    pub fn judge(&self, factors: &dyn Operator, radiosity: Vec<f64>, iterations: usize) -> Outcome {
        let irradiance = self.irradiance(factors, &radiosity);
        let rest: Vec<f64> =
            (0..radiosity.len()).map(|k| self.emitted[k] + self.rho[k] * irradiance[k] - radiosity[k]).collect();
        let largest =
            |x: &[f64], band: usize| x.iter().skip(band).step_by(self.bands).fold(0.0f64, |m, x| m.max(x.abs()));
        let reflected: Vec<f64> = radiosity.iter().zip(&self.emitted).map(|(b, m)| b - m).collect();
        let (emitted, open) = (self.emitted_flux(), self.flux(&rest));
        let mut outcome = Outcome { radiosity, irradiance, iterations, residual: 0.0, unshot: 0.0, bound: 0.0 };
        for band in 0..self.bands {
            let scale = largest(&reflected, band);
            if scale > 0.0 {
                let residual = largest(&rest, band) / scale;
                outcome.residual = outcome.residual.max(residual);
                outcome.bound = outcome.bound.max(residual / (1.0 - largest(&self.rho, band)).max(1e-12));
                outcome.unshot = outcome.unshot.max(open[band] / emitted[band].max(1e-300));
            }
        }
        outcome
    }

    fn check_finite(&self, factors: &dyn Operator) -> Result<()> {
        let absorbs = |band: usize| self.rho.iter().skip(band).step_by(self.bands).any(|r| *r < 1.0);
        if factors.is_closed() && !self.is_empty() && (0..self.bands).any(|band| !absorbs(band)) {
            return Err(Error::impossible(
                "the room is closed and every surface in it reflects everything: the light never goes away",
            )
            .mend("give at least one surface a reflectance below 1, or open the room"));
        }
        Ok(())
    }

    /// Refuses factors that make any patch reflect more than all that is sent.
    fn check_growth(&self, factors: &FormFactors) -> Result<()> {
        let rho = |i: usize| self.rho[i * self.bands..(i + 1) * self.bands].iter().copied().fold(0.0, f64::max);
        // What patches receive that all see exitance one.
        let sums = factors.irradiance(&vec![1.0; self.len()], 1);
        match (0..self.len()).find(|i| rho(*i) * sums[*i] > 1.0 + GAIN) {
            Some(i) => Err(Error::impossible(format!(
                "the form factors of patch {i} sum to {:.6} and it reflects {:.6}: the light would grow at every reflection",
                sums[i],
                rho(i)
            ))
            .mend("balance the form factors, or work them out more exactly")),
            None => Ok(()),
        }
    }
}
