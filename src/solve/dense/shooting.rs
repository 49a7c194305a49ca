//! Shooting: the patch with the most unshot flux gives it to all others (Southwell's relaxation).
//!
//! Source: Cohen, Chen, Wallace and Greenberg 1988, with their ambient term; Gortler, Cohen and Slusallek 1993 for the
//! proof of convergence; Feda and Purgathofer 1992 for overshooting. A shot needs one row of form factors, so a picture
//! can be had long before the matrix is known ([`OnDemand`]).

use rayon::prelude::*;

use super::System;
use crate::transport::form_factor::{FormFactors, Method, Work};

/// Shots for each patch, at most.
const MOST_SWEEPS: usize = 2000;
/// The stop is looked at every so many shots.
const LOOK: usize = 16;
/// Patches whose flux differs by rounding alone shoot in their own order: equal lamps one after the other.
const TIE: f64 = 1e-9;

/// Where a shot finds the exchange areas of its patch.
pub trait ExchangeRows {
    /// Exchange areas of patch `i` with all.
    fn exchange_row(&mut self, i: usize) -> &[f64];
}

impl ExchangeRows for &FormFactors {
    fn exchange_row(&mut self, i: usize) -> &[f64] {
        FormFactors::exchange_row(self, i)
    }
}

/// Rows of form factors worked out when a patch first shoots.
pub struct OnDemand<'a> {
    method: &'a dyn Method,
    areas: &'a [f64],
    rows: Vec<Vec<f64>>,
    closed: bool,
    /// Rays cast.
    pub rays: u64,
    /// Form factors worked out.
    pub factors: u64,
}

impl std::fmt::Debug for OnDemand<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OnDemand").field("rays", &self.rays).field("factors", &self.factors).finish_non_exhaustive()
    }
}

impl<'a> OnDemand<'a> {
    /// No rows yet. Those of a `closed` scene are scaled to sum to one.
    #[must_use]
    pub fn new(method: &'a dyn Method, areas: &'a [f64], closed: bool) -> Self {
        Self { method, areas, rows: vec![Vec::new(); areas.len()], closed, rays: 0, factors: 0 }
    }
}

impl ExchangeRows for OnDemand<'_> {
    fn exchange_row(&mut self, i: usize) -> &[f64] {
        if self.rows[i].is_empty() {
            let n = self.areas.len();
            let mut row = vec![0.0; n];
            let mut work = Work::default();
            if n > 0 && self.method.exchange(i, i, &mut work).is_some() {
                let part = n.div_ceil(4 * rayon::current_num_threads()).max(1);
                let counts: Vec<(u64, u64)> = row
                    .par_chunks_mut(part)
                    .enumerate()
                    .map(|(c, chunk)| {
                        let mut work = Work::default();
                        for (k, x) in chunk.iter_mut().enumerate() {
                            *x = self.method.exchange(i, c * part + k, &mut work).unwrap_or(0.0);
                        }
                        (work.all_rays(), work.all_factors())
                    })
                    .collect();
                for (rays, factors) in counts {
                    self.rays += rays;
                    self.factors += factors;
                }
            } else {
                self.method.row(i, &mut row, &mut work);
                row.iter_mut().for_each(|f| *f *= self.areas[i]);
            }
            self.rays += work.all_rays();
            self.factors += work.all_factors();
            row[i] = 0.0;
            let sum: f64 = row.iter().sum();
            let too_much = self.closed || sum > self.areas[i];
            if sum > 0.0 && too_much {
                row.iter_mut().for_each(|x| *x *= self.areas[i] / sum);
            }
            self.rows[i] = row;
        }
        &self.rows[i]
    }
}

/// A solution in the making.
#[derive(Debug)]
pub struct Shooting<'a, R> {
    system: &'a System,
    rows: R,
    /// Radiosity received and emitted so far.
    radiosity: Vec<f64>,
    unshot: Vec<f64>,
    /// `Σ_b A |ΔB| / Φ_b` of each patch: all bands count alike.
    urgency: Vec<f64>,
    weights: Vec<f64>,
    mean_rho: Vec<f64>,
    overshoot: bool,
    shots: usize,
}

impl<'a, R: ExchangeRows> Shooting<'a, R> {
    /// Begins with what is emitted.
    #[must_use]
    pub fn new(system: &'a System, rows: R, overshoot: bool) -> Self {
        let weights = system.emitted_flux().iter().map(|f| if *f > 0.0 { 1.0 / f } else { 0.0 }).collect();
        let mean_rho = system.mean_rho();
        let mut state = Self {
            system,
            rows,
            radiosity: system.emitted.clone(),
            unshot: system.emitted.clone(),
            urgency: vec![0.0; system.len()],
            weights,
            mean_rho,
            overshoot,
            shots: 0,
        };
        for i in 0..system.len() {
            state.urgency[i] = state.urgency_of(i, &[]);
        }
        state
    }

    /// Flux that the patch would shoot, as a share of what is emitted; with an ambient term its return is shot as well.
    fn urgency_of(&self, i: usize, ambient: &[f64]) -> f64 {
        let bands = self.system.bands;
        let shot = |band: usize| {
            let k = i * bands + band;
            (self.unshot[k] + self.system.rho[k] * ambient.get(band).copied().unwrap_or(0.0)).abs()
        };
        self.system.areas[i] * (0..bands).map(|b| shot(b) * self.weights[b]).sum::<f64>()
    }

    /// One shot; the patch that shot, or nothing where all is shot.
    pub fn shoot(&mut self) -> Option<usize> {
        let bands = self.system.bands;
        let ambient = if self.overshoot { self.ambient() } else { vec![0.0; bands] };
        if self.overshoot {
            for i in 0..self.system.len() {
                self.urgency[i] = self.urgency_of(i, &ambient);
            }
        }
        let higher = |best: (usize, f64), (i, u): (usize, &f64)| if *u > best.1 * (1.0 + TIE) { (i, *u) } else { best };
        let (i, most) = self.urgency.iter().enumerate().fold((0, 0.0), higher);
        if most == 0.0 {
            return None;
        }
        let own = &self.system.rho[i * bands..(i + 1) * bands];
        let extra: Vec<f64> = ambient.iter().zip(own).map(|(u, r)| u * r).collect();
        let shot: Vec<f64> = self.unshot[i * bands..(i + 1) * bands].iter().zip(&extra).map(|(u, e)| u + e).collect();
        let row = self.rows.exchange_row(i);
        for (j, x) in row.iter().enumerate() {
            if *x > 0.0 {
                let f = x / self.system.areas[j];
                let mut urgency = 0.0;
                for band in 0..bands {
                    let k = j * bands + band;
                    let received = self.system.rho[k] * f * shot[band];
                    self.radiosity[k] += received;
                    self.unshot[k] += received;
                    urgency += self.unshot[k].abs() * self.weights[band];
                }
                self.urgency[j] = urgency * self.system.areas[j];
            }
        }
        for band in 0..bands {
            self.unshot[i * bands + band] = -extra[band];
        }
        self.urgency[i] = self.urgency_of(i, &[]);
        self.shots += 1;
        Some(i)
    }

    /// The ambient term `U = Σ A ΔB / Σ A / (1 − ρ̄)`: irradiance of what is unshot, spread evenly. W/(m² nm) per band.
    #[must_use]
    pub fn ambient(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.system.bands];
        let mut total = 0.0;
        for (a, u) in self.system.areas.iter().zip(self.unshot.chunks_exact(self.system.bands)) {
            sums.iter_mut().zip(u).for_each(|(s, u)| *s += a * u);
            total += a;
        }
        sums.iter().zip(&self.mean_rho).map(|(s, r)| s / (total * (1.0 - r).max(1e-12))).collect()
    }

    /// Unshot flux against emitted flux, the largest over the bands.
    #[must_use]
    pub fn unshot(&self) -> f64 {
        self.system.flux(&self.unshot).iter().zip(&self.weights).map(|(u, w)| u * w).fold(0.0, f64::max)
    }

    /// Shots so far.
    #[must_use]
    pub fn shots(&self) -> usize {
        self.shots
    }

    /// Where the rows come from.
    #[must_use]
    pub fn rows(&self) -> &R {
        &self.rows
    }

    /// Radiosity as it stands, for display: with the ambient term or without. The term is never fed back.
    #[must_use]
    pub fn displayed(&self, with_ambient: bool) -> Vec<f64> {
        let mut shown = self.radiosity.clone();
        if with_ambient {
            let ambient = self.ambient();
            for (k, b) in shown.iter_mut().enumerate() {
                *b += self.system.rho[k] * ambient[k % self.system.bands];
            }
        }
        shown
    }

    /// Falls back to plain shooting.
    pub fn stop_overshooting(&mut self) {
        self.overshoot = false;
    }
}

/// Shoots until the unshot flux cannot change the answer by more than `accuracy`; shots in sweeps, rounded up.
pub(super) fn to_the_end(system: &System, factors: &FormFactors, accuracy: f64, overshoot: bool) -> (Vec<f64>, usize) {
    let mut state = Shooting::new(system, factors, overshoot);
    let n = system.len();
    let mut last = f64::INFINITY;
    let mut grew = 0;
    while state.shots < MOST_SWEEPS * n {
        if state.shots.is_multiple_of(LOOK) && settled(&state.unshot, &state.radiosity, accuracy) {
            break;
        }
        if overshoot && state.shots.is_multiple_of(n.max(1)) {
            // More unshot after a sweep than before, twice: overshooting does not pay here.
            let now = state.unshot();
            grew = if now > last { grew + 1 } else { 0 };
            last = now;
            if grew == 2 {
                state.stop_overshooting();
            }
        }
        if state.shoot().is_none() {
            break;
        }
    }
    // What is unshot counts for the patches that hold it.
    (state.radiosity, state.shots.div_ceil(n.max(1)))
}

/// Has no patch unshot radiosity of more than `accuracy` of its own? A dim room behind a hole must not hide behind the
/// bright one before it.
fn settled(unshot: &[f64], radiosity: &[f64], accuracy: f64) -> bool {
    unshot.iter().zip(radiosity).all(|(u, b)| u.abs() <= accuracy * b)
}
