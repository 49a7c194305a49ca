//! Gathering: every patch asks all others, sweep after sweep (Cohen and Greenberg 1985).

use super::{System, gather};
use crate::transport::form_factor::FormFactors;

/// Sweeps, at most: enough for a reflectance of 0.999 at single precision.
const MOST_SWEEPS: usize = 20_000;

/// Every patch from the last sweep's values.
pub(super) fn jacobi(system: &System, factors: &FormFactors, accuracy: f64) -> (Vec<f64>, usize) {
    let mut radiosity = system.emitted.clone();
    for sweep in 1..=MOST_SWEEPS {
        let h = system.irradiance(factors, &radiosity);
        let mut change = Change::new(system.bands);
        for (k, b) in radiosity.iter_mut().enumerate() {
            let next = system.emitted[k] + system.rho[k] * h[k];
            change.enter(k, next - *b, next - system.emitted[k]);
            *b = next;
        }
        if change.relative() <= accuracy {
            return (radiosity, sweep);
        }
    }
    (radiosity, MOST_SWEEPS)
}

/// Every patch from the newest values.
pub(super) fn gauss_seidel(system: &System, factors: &FormFactors, accuracy: f64) -> (Vec<f64>, usize) {
    let bands = system.bands;
    let mut radiosity = system.emitted.clone();
    let mut h = vec![0.0; bands];
    for sweep in 1..=MOST_SWEEPS {
        let mut change = Change::new(bands);
        for i in 0..system.len() {
            gather(factors, i, &radiosity, &mut h);
            for (band, h) in h.iter().enumerate() {
                let k = i * bands + band;
                let next = system.emitted[k] + system.rho[k] * h;
                change.enter(k, next - radiosity[k], next - system.emitted[k]);
                radiosity[k] = next;
            }
        }
        if change.relative() <= accuracy {
            return (radiosity, sweep);
        }
    }
    (radiosity, MOST_SWEEPS)
}

/// Largest change and largest reflected radiosity, band by band: beside a small fierce lamp every wall would seem settled.
struct Change {
    list: Vec<(f64, f64)>,
}

impl Change {
    fn new(bands: usize) -> Self {
        Self { list: vec![(0.0, 0.0); bands] }
    }

    fn enter(&mut self, k: usize, change: f64, value: f64) {
        let bands = self.list.len();
        let (c, v) = &mut self.list[k % bands];
        *c = c.max(change.abs());
        *v = v.max(value.abs());
    }

    fn relative(&self) -> f64 {
        self.list.iter().filter(|(_, v)| *v > 0.0).map(|(c, v)| c / v).fold(0.0, f64::max)
    }
}
