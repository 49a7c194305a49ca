//! Gaussian elimination (Goral, Torrance, Greenberg and Battaile 1984).

use rayon::prelude::*;

use super::System;
use crate::error::{Error, Result};
use crate::transport::form_factor::FormFactors;

/// Radiosities, by eliminating each band's matrix `I − ρF`.
pub(super) fn solve(system: &System, factors: &FormFactors) -> Result<Vec<f64>> {
    let (n, bands) = (system.len(), system.bands);
    let columns: Vec<Vec<f64>> =
        (0..bands).into_par_iter().map(|band| eliminate(system, factors, band)).collect::<Result<_>>()?;
    let mut radiosity = vec![0.0; n * bands];
    for (band, column) in columns.iter().enumerate() {
        for (i, b) in column.iter().enumerate() {
            radiosity[i * bands + band] = *b;
        }
    }
    Ok(radiosity)
}

/// Solves one band. Rows are dominated by their diagonal, so no pivots are sought.
fn eliminate(system: &System, factors: &FormFactors, band: usize) -> Result<Vec<f64>> {
    let n = system.len();
    let at = |i: usize| i * system.bands + band;
    let mut rows: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let share = -system.rho[at(i)] / system.areas[i];
            let mut row: Vec<f64> = factors.exchange_row(i).iter().map(|x| share * x).collect();
            row[i] += 1.0;
            row
        })
        .collect();
    let mut b: Vec<f64> = (0..n).map(|i| system.emitted[at(i)]).collect();
    for k in 0..n {
        let (above, below) = rows.split_at_mut(k + 1);
        let pivot = &above[k][k..];
        if pivot[0] <= 0.0 || pivot[0].is_nan() {
            return Err(Error::impossible("the light of the room never goes away: its equations have no solution"));
        }
        let bk = b[k];
        for (row, b) in below.iter_mut().zip(&mut b[k + 1..]) {
            let share = row[k] / pivot[0];
            if share != 0.0 {
                row[k..].iter_mut().zip(pivot).for_each(|(x, p)| *x -= share * p);
                *b -= share * bk;
            }
        }
    }
    for k in (0..n).rev() {
        let known: f64 = rows[k][k + 1..].iter().zip(&b[k + 1..]).map(|(x, b)| x * b).sum();
        b[k] = (b[k] - known) / rows[k][k];
    }
    Ok(b)
}
