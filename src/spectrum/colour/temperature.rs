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

/// The locus is tabulated at every whole mired (1e6/K), from 100 000 K to 1000 K. A parabola through three
/// neighbours is good to 0.01 K, one through three points of the locus this near to it, in mired, to 1e-6 K.
const NEAR_MIRED: f64 = 0.05;
const LOCUS_MIRED: std::ops::RangeInclusive<u32> = 10..=1000;

static LOCUS: LazyLock<Vec<[f64; 2]>> =
    LazyLock::new(|| LOCUS_MIRED.map(|mired| planckian_uv(1e6 / f64::from(mired))).collect());

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
    if !near || nearest == 0 || nearest + 1 == LOCUS.len() {
        return None;
    }
    let (t, _) = nearest_on_parabola(&LOCUS[nearest - 1..=nearest + 1], uv);
    let about_mired = f64::from(*LOCUS_MIRED.start()) + nearest as f64 + t;
    let around = [-NEAR_MIRED, 0.0, NEAR_MIRED].map(|d| planckian_uv(1e6 / (about_mired + d)));
    let (t, foot) = nearest_on_parabola(&around, uv);
    let duv = distance2(&foot).sqrt().copysign(uv[1] - foot[1]);
    let mired = about_mired + NEAR_MIRED * t;
    (duv.abs() <= MOST_DUV).then_some(Cct { kelvin: 1e6 / mired, duv })
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
        let exact = planckian_uv(6321.0);
        let (u, v) = (exact[0], exact[1]);
        let d = 2.0 * u - 8.0 * v + 4.0;
        let found = cct([3.0 * u / d, 2.0 * v / d]).unwrap();
        assert!((found.kelvin - 6321.0).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn coloured_light_has_no_colour_temperature() {
        assert_eq!(cct([0.64, 0.33]), None);
        assert_eq!(cct([0.15, 0.06]), None);
        assert_eq!(cct([f64::NAN, 0.3]), None);
    }
}
