//! Conjugate gradients on the symmetric form.
//!
//! With `y = √(ρA) H` the system is `(I − C) y = √(ρ/A) X M`, `C = √(ρ/A) X √(ρ/A)`, `X` the exchange areas: symmetric,
//! positive definite, eigenvalues within `1 ± ρ_max`. Black patches need no care.

use rayon::prelude::*;

use super::{Operator, System};

const MOST_PRODUCTS: usize = 1000;

/// Radiosities, and the number of products with the matrix; all bands go abreast.
pub(super) fn solve(system: &System, factors: &dyn Operator, accuracy: f64) -> (Vec<f64>, usize) {
    let bands = system.bands;
    let share: Vec<f64> = (0..system.rho.len()).map(|k| (system.rho[k] / system.areas[k / bands]).sqrt()).collect();
    let scaled = |x: &[f64]| -> Vec<f64> { x.iter().zip(&share).map(|(x, s)| x * s).collect() };
    let product = |x: &[f64]| scaled(&exchange(system, factors, x));
    let mut residual = product(&system.emitted);
    let size = dot(&residual, &residual, bands);
    let mut y = vec![0.0; residual.len()];
    let mut direction = residual.clone();
    let mut square = size.clone();
    let mut products = 1;
    // The residual of y is weighted by √(ρA); a tenth leaves room for what that hides.
    let target = 0.1 * accuracy;
    while products < MOST_PRODUCTS && square.iter().zip(&size).any(|(s, z)| *s > target * target * z) {
        let mut image = product(&scaled(&direction));
        products += 1;
        image.iter_mut().zip(&direction).for_each(|(c, d)| *c = d - *c);
        let curvature = dot(&direction, &image, bands);
        let step = ratio(&square, &curvature);
        for k in 0..y.len() {
            y[k] += step[k % bands] * direction[k];
            residual[k] -= step[k % bands] * image[k];
        }
        let next = dot(&residual, &residual, bands);
        let turn = ratio(&next, &square);
        for k in 0..y.len() {
            direction[k] = residual[k] + turn[k % bands] * direction[k];
        }
        square = next;
    }
    // B = M + ρ H = M + √(ρ/A) y.
    let radiosity = system.emitted.iter().zip(scaled(&y)).map(|(m, b)| m + b).collect();
    (radiosity, products)
}

/// `X x`: irradiance times area.
fn exchange(system: &System, factors: &dyn Operator, x: &[f64]) -> Vec<f64> {
    let mut h = system.irradiance(factors, x);
    h.par_chunks_mut(system.bands.max(1)).zip(&system.areas).for_each(|(h, a)| h.iter_mut().for_each(|h| *h *= a));
    h
}

fn dot(a: &[f64], b: &[f64], bands: usize) -> Vec<f64> {
    let mut sums = vec![0.0; bands];
    for (a, b) in a.chunks_exact(bands).zip(b.chunks_exact(bands)) {
        for band in 0..bands {
            sums[band] += a[band] * b[band];
        }
    }
    sums
}

/// Quotients; nothing where there is nothing to divide by.
fn ratio(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| if *b > 0.0 { a / b } else { 0.0 }).collect()
}
