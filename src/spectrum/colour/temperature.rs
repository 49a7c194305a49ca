//! Correlated colour temperature.

use std::sync::LazyLock;

use super::super::cie;
use super::super::illuminant::planck;
use super::super::tables::cie1931::CMF;
use super::uv_1960;

/// Correlated colour temperature and distance from the Planckian locus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cct {
    /// Kelvin.
    pub kelvin: f64,
    /// Distance in the CIE 1960 plane, positive above the locus (greenish).
    pub duv: f64,
}

/// Farther from the locus than this, a colour temperature has no meaning (CIE 15:2018).
const MOST_DUV: f64 = 0.05;

/// The locus is tabulated at steps of 4 mired (1e6/K), from 100 000 K to 1000 K and a little beyond: it is smooth
/// through 0 mired and below, so that the polynomials find points on both sides.
const LOCUS_MIRED: std::ops::RangeInclusive<f64> = 10.0..=1000.0;
const STEP_MIRED: f64 = 4.0;

/// Distances, in steps of the table, of the points of the locus that a parabola is laid through in turn: each
/// finds the nearest point well enough for the next, the last to 1e-8 of the temperature.
const NARROWING: [f64; 3] = [1.0, 0.1, 0.01];

/// Points of the table on either side of a place between them, for the polynomial through all of them.
const REACH: usize = 3;

static LOCUS: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| {
    let count = ((LOCUS_MIRED.end() - LOCUS_MIRED.start()) / STEP_MIRED).ceil() as usize + 2 * (REACH + 1);
    (0..count).map(|i| planckian_uv(1e6 / mired_at(i as f64))).collect()
});

fn mired_at(place: f64) -> f64 {
    LOCUS_MIRED.start() + STEP_MIRED * (place - REACH as f64)
}

/// The locus at a place of its table, by the polynomial through the points around it (Lagrange).
fn between(place: f64) -> [f64; 2] {
    let first = place as usize + 1 - REACH;
    let t = place - first as f64;
    let mut uv = [0.0; 2];
    for i in 0..2 * REACH {
        let others = (0..2 * REACH).filter(|&j| j != i);
        let weight: f64 = others.map(|j| (t - j as f64) / (i as f64 - j as f64)).product();
        for c in 0..2 {
            uv[c] += weight * LOCUS[first + i][c];
        }
    }
    uv
}

/// Chromaticity u, v (CIE 1960) of a black body, summed at 1 nm.
fn planckian_uv(kelvin: f64) -> [f64; 2] {
    let mut xyz = [0.0; 3];
    for (i, cmf) in CMF.iter().enumerate() {
        let s = planck(cie::FIRST_NM + i as f64, kelvin);
        for c in 0..3 {
            xyz[c] += s * cmf[c];
        }
    }
    let sum: f64 = xyz.iter().sum();
    uv_1960([xyz[0] / sum, xyz[1] / sum])
}

/// Correlated colour temperature of a chromaticity x, y: the nearest point of the Planckian locus in the CIE
/// 1960 plane. `None` farther than 0.05 from the locus or outside 1000 to 100 000 K.
#[must_use]
pub fn cct([x, y]: [f64; 2]) -> Option<Cct> {
    let uv = uv_1960([x, y]);
    let distance2 = |p: &[f64; 2]| (p[0] - uv[0]).powi(2) + (p[1] - uv[1]).powi(2);
    let (nearest, least) = LOCUS.iter().map(distance2).enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
    // NaN must not pass.
    let near = least.sqrt() <= 1.01 * MOST_DUV;
    if !near || nearest < REACH || nearest + REACH + 1 >= LOCUS.len() {
        return None;
    }
    let (mut place, mut foot) = (nearest as f64, LOCUS[nearest]);
    for step in NARROWING {
        let (t, found) = nearest_on_parabola(&[-step, 0.0, step].map(|d| between(place + d)), uv);
        (place, foot) = (place + t * step, found);
    }
    let duv = distance2(&foot).sqrt().copysign(uv[1] - foot[1]);
    let mired = mired_at(place);
    (duv.abs() <= MOST_DUV && LOCUS_MIRED.contains(&mired)).then_some(Cct { kelvin: 1e6 / mired, duv })
}

/// Parameter (-1, 0, 1 at the three points) and place of the point of the parabola through them that is
/// nearest to `p`.
fn nearest_on_parabola(points: &[[f64; 2]], p: [f64; 2]) -> (f64, [f64; 2]) {
    let slope: [f64; 2] = std::array::from_fn(|c| 0.5 * (points[2][c] - points[0][c]));
    let bend: [f64; 2] = std::array::from_fn(|c| points[2][c] - 2.0 * points[1][c] + points[0][c]);
    let place = |t: f64| std::array::from_fn(|c| points[1][c] + t * slope[c] + 0.5 * t * t * bend[c]);
    let mut t = 0.0;
    for _ in 0..8 {
        let q: [f64; 2] = place(t);
        let (mut first, mut second) = (0.0, 0.0);
        for c in 0..2 {
            let tangent = slope[c] + t * bend[c];
            first += (q[c] - p[c]) * tangent;
            second += tangent * tangent + (q[c] - p[c]) * bend[c];
        }
        if second <= 0.0 {
            break;
        }
        t = (t - first / second).clamp(-1.0, 1.0);
    }
    (t, place(t))
}

#[cfg(test)]
mod tests {
    use super::super::super::from_cct;
    use super::super::xy;
    use super::*;

    #[test]
    fn a_black_body_has_its_own_temperature_and_no_duv() {
        for kelvin in [1500.0, 2700.0, 3999.0] {
            let found = cct(xy(from_cct(kelvin).unwrap().xyz()).unwrap()).unwrap();
            // The spectrum is sampled at 5 nm and linear in between.
            assert!((found.kelvin - kelvin).abs() < 1.0, "{found:?}");
            assert!(found.duv.abs() < 1e-4, "{found:?}");
        }
        for kelvin in [1000.1, 1500.3, 2856.0, 6321.0, 24_700.0, 85_432.1, 99_990.0] {
            let [u, v] = planckian_uv(kelvin);
            let d = 2.0 * u - 8.0 * v + 4.0;
            let found = cct([3.0 * u / d, 2.0 * v / d]).unwrap();
            assert!((found.kelvin - kelvin).abs() < 1e-8 * kelvin, "{kelvin}: {found:?}");
        }
    }

    #[test]
    fn coloured_light_has_no_colour_temperature() {
        assert_eq!(cct([0.64, 0.33]), None);
        assert_eq!(cct([0.15, 0.06]), None);
        assert_eq!(cct([f64::NAN, 0.3]), None);
    }
}
