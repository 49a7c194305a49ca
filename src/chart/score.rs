//! How far a measurement is from the reference.

use glam::DVec3;

use super::Found;
use crate::measure::{Measurement, SensorResult, Status};
use crate::scene::Axes;

/// Two-sided 95 % quantile of Student's t for the 31 degrees of freedom of the path tracer's batches.
const STUDENT: f64 = 2.0395;
/// Sensors are compared with their own reading, but with no less than this share of the mean.
const LEAST_SHARE: f64 = 0.01;

/// What the reference reads at one sensor.
#[derive(Clone, Debug)]
pub struct Reading {
    /// Name of the grid.
    pub grid: String,
    /// Number in the grid, from 0.
    pub point: usize,
    /// Metres, in the user's axes.
    pub position: DVec3,
    /// Unit vector, in the user's axes.
    pub normal: DVec3,
    /// Illuminance, lx.
    pub illuminance_lx: f64,
    /// Its standard error, lx.
    pub standard_error_lx: f64,
}

/// A path-traced measurement to compare with.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Every sensor with a reading.
    pub readings: Vec<Reading>,
    /// Mean illuminance, lx.
    pub mean_lx: f64,
    /// Root mean square of the standard errors, over the mean.
    pub uncertainty: f64,
    /// Paths from each sensor.
    pub paths: u64,
}

impl Reference {
    pub(super) fn new(m: &Measurement, paths: u64, axes: Axes) -> Self {
        let mut readings = Vec::new();
        for grid in &m.grids {
            let lit = grid.sensors.iter().enumerate().filter(|(_, s)| s.status == Status::Ok);
            readings.extend(lit.map(|(point, s)| Reading {
                grid: grid.name.clone(),
                point,
                position: axes.to_user(s.position),
                normal: axes.to_user(s.normal),
                illuminance_lx: s.xyz[1],
                standard_error_lx: s.error_lx / STUDENT,
            }));
        }
        let count = readings.len().max(1) as f64;
        let mean_lx = readings.iter().map(|r| r.illuminance_lx).sum::<f64>() / count;
        let square = readings.iter().map(|r| r.standard_error_lx.powi(2)).sum::<f64>() / count;
        Self { readings, mean_lx, uncertainty: square.sqrt() / mean_lx, paths }
    }

    /// Number of sensors.
    #[must_use]
    pub fn len(&self) -> usize {
        self.readings.len()
    }

    /// Nothing to compare with?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.readings.is_empty()
    }
}

/// The errors of one run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Score {
    pub(super) found: Found,
}

impl Score {
    pub(super) fn new(m: &Measurement, reference: &Reference) -> Self {
        let lit = m.grids.iter().flat_map(|g| g.sensors.iter().filter(|s| s.status == Status::Ok));
        let pair = |s: &SensorResult, r: &Reading| [s.xyz[1], s.error_lx, r.illuminance_lx, r.standard_error_lx];
        let pairs: Vec<[f64; 4]> = lit.zip(&reference.readings).map(|(s, r)| pair(s, r)).collect();
        Self { found: compare(&pairs, reference) }
    }
}

/// From illuminance, stated error, reference and its standard error of every sensor.
fn compare(pairs: &[[f64; 4]], reference: &Reference) -> Found {
    let count = pairs.len().max(1) as f64;
    let mean = reference.mean_lx;
    let raw = (pairs.iter().map(|[e, _, r, _]| (e - r).powi(2)).sum::<f64>() / count).sqrt() / mean;
    let resolved = raw > 2.0 * reference.uncertainty;
    let own = |r: f64| r.max(LEAST_SHARE * mean);
    let mut errors: Vec<f64> = pairs.iter().map(|[e, _, r, _]| (e - r).abs() / own(*r)).collect();
    let mut stated: Vec<f64> = pairs.iter().map(|[_, u, r, _]| u / own(*r)).collect();
    let covered = pairs.iter().filter(|[e, u, r, s]| (e - r).abs() <= u.hypot(STUDENT * s)).count();
    Found {
        rms: if resolved { (raw * raw - reference.uncertainty.powi(2)).sqrt() } else { raw },
        bias: pairs.iter().map(|[e, _, r, _]| e - r).sum::<f64>() / count / mean,
        p95: percentile(&mut errors, 0.95),
        largest: percentile(&mut errors, 1.0),
        stated_p95: Some(percentile(&mut stated, 0.95)),
        coverage: Some(covered as f64 / count),
        resolved,
    }
}

fn percentile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let at = (share * (values.len().max(1) - 1) as f64).round() as usize;
    values.get(at).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_told_from_the_references_own() {
        let reference = Reference { readings: Vec::new(), mean_lx: 100.0, uncertainty: 0.01, paths: 1 };
        // Off by 3 and by 4 lx: RMS 3.54 %, of which 1 % is the reference's.
        let found = compare(&[[103.0, 5.0, 100.0, 1.0], [96.0, 1.0, 100.0, 1.0]], &reference);
        assert!((found.rms - (12.5e-4f64 - 1e-4).sqrt()).abs() < 1e-12 && found.resolved, "{found:?}");
        assert!((found.bias + 0.005).abs() < 1e-12);
        assert_eq!((found.largest, found.stated_p95, found.coverage), (0.04, Some(0.05), Some(0.5)));
        let near = compare(&[[101.0, 1.0, 100.0, 1.0]], &reference);
        assert!(!near.resolved && (near.rms - 0.01).abs() < 1e-12);
    }
}
