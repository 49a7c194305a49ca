//! Chromaticity, RGB, colour temperature. Everything is CIE 1931, 2°.

use std::sync::LazyLock;

use super::illuminant::planck;
use super::tables::cie1931::CMF;
use super::{Spectrum, cie};

/// A 3 × 3 matrix, row by row.
pub type Matrix = [[f64; 3]; 3];

/// The primaries and the white of an RGB system, as chromaticities x, y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    /// Red.
    pub red: [f64; 2],
    /// Green.
    pub green: [f64; 2],
    /// Blue.
    pub blue: [f64; 2],
    /// White: what R = G = B shows.
    pub white: [f64; 2],
}

/// ITU-R BT.709 and sRGB: D65 as white.
pub const REC709: Primaries =
    Primaries { red: [0.64, 0.33], green: [0.30, 0.60], blue: [0.15, 0.06], white: [0.3127, 0.3290] };

/// The primaries of Radiance pictures: equal energy as white.
pub const RADIANCE: Primaries =
    Primaries { red: [0.640, 0.330], green: [0.290, 0.600], blue: [0.150, 0.060], white: [1.0 / 3.0, 1.0 / 3.0] };

impl Primaries {
    /// The matrix that turns linear RGB into XYZ; R = G = B = 1 gives Y = 1.
    #[must_use]
    pub fn xyz_from_rgb(&self) -> Matrix {
        let columns = [self.red, self.green, self.blue].map(|xy| xyz_of(xy, 1.0));
        let unscaled: Matrix = std::array::from_fn(|r| columns.map(|c| c[r]));
        let scale = apply(&inverse(&unscaled), xyz_of(self.white, 1.0));
        unscaled.map(|row| std::array::from_fn(|c| row[c] * scale[c]))
    }

    /// The matrix that turns XYZ into linear RGB.
    #[must_use]
    pub fn rgb_from_xyz(&self) -> Matrix {
        inverse(&self.xyz_from_rgb())
    }
}

/// Matrix times column vector.
#[must_use]
pub fn apply(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Inverse by cofactors; the matrices here are far from singular.
#[must_use]
pub fn inverse(m: &Matrix) -> Matrix {
    let cofactor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| m[0][c] * cofactor(0, c)).sum();
    std::array::from_fn(|r| std::array::from_fn(|c| cofactor(c, r) / determinant))
}

/// XYZ of a chromaticity and a Y.
#[must_use]
pub fn xyz_of([x, y]: [f64; 2], luminous: f64) -> [f64; 3] {
    let k = luminous / y;
    [x * k, luminous, (1.0 - x - y) * k]
}

/// Chromaticity x, y; `None` of the dark and of what is not finite.
#[must_use]
pub fn xy(xyz: [f64; 3]) -> Option<[f64; 2]> {
    let sum: f64 = xyz.iter().sum();
    let xy = [xyz[0] / sum, xyz[1] / sum];
    (sum > 0.0 && xy.iter().all(|v| v.is_finite())).then_some(xy)
}

/// Chromaticity u', v' (CIE 1976); `None` of the dark and of what is not finite.
#[must_use]
pub fn uv_prime(xyz: [f64; 3]) -> Option<[f64; 2]> {
    let d = xyz[0] + 15.0 * xyz[1] + 3.0 * xyz[2];
    let uv = [4.0 * xyz[0] / d, 9.0 * xyz[1] / d];
    (d > 0.0 && uv.iter().all(|v| v.is_finite())).then_some(uv)
}

/// Chromaticity u, v (CIE 1960) of x, y: the plane in which colour temperature is defined.
#[must_use]
pub fn uv_1960([x, y]: [f64; 2]) -> [f64; 2] {
    let d = -2.0 * x + 12.0 * y + 3.0;
    [4.0 * x / d, 6.0 * y / d]
}

static RGB_FROM_XYZ: LazyLock<Matrix> = LazyLock::new(|| REC709.rgb_from_xyz());

/// Linear sRGB (Rec.709) of XYZ; the scale is that of Y, nothing is clipped.
#[must_use]
pub fn linear_srgb(xyz: [f64; 3]) -> [f64; 3] {
    apply(&RGB_FROM_XYZ, xyz)
}

/// The sRGB transfer function (IEC 61966-2-1), linear 0 to 1 into encoded 0 to 1; values outside are clipped.
#[must_use]
pub fn srgb_encode(linear: f64) -> f64 {
    let v = linear.clamp(0.0, 1.0);
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// Linear Rec.709 of a reflectance under a light, each channel against that of a perfect white.
///
/// What a lamp of colour (R, G, B) sends onto the surface then leaves it in the exact colour. `None` where
/// the light is so coloured that a channel of the white is below a twentieth of its Y.
#[must_use]
pub fn reflectance_rgb(reflectance: &Spectrum, light: &Spectrum) -> Option<[f64; 3]> {
    let white = linear_srgb(cie::integral(light, cie::FIRST_NM, cie::LAST_NM));
    let least = 0.05 * cie::integral(light, cie::FIRST_NM, cie::LAST_NM)[1];
    if !white.iter().all(|&w| w > 0.0 && w >= least) {
        return None;
    }
    let knots = [reflectance.knots_nm(), light.knots_nm()];
    let xyz = cie::nodes(cie::FIRST_NM, cie::LAST_NM, &knots).fold([0.0; 3], |sum, (nm, w)| {
        let (v, c) = (w * light.at(nm) * reflectance.at(nm), cie::cmf(nm));
        std::array::from_fn(|k| sum[k] + v * c[k])
    });
    let rgb = linear_srgb(xyz);
    Some(std::array::from_fn(|c| rgb[c] / white[c]))
}

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
/// neighbours is good to 0.01 K.
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
    let (t, foot) = nearest_on_parabola(&LOCUS[nearest - 1..=nearest + 1], uv);
    let duv = distance2(&foot).sqrt().copysign(uv[1] - foot[1]);
    let mired = f64::from(*LOCUS_MIRED.start()) + nearest as f64 + t;
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
    use super::super::{from_cct, illuminant};
    use super::*;

    #[test]
    fn the_matrices_undo_each_other_and_white_is_one() {
        for p in [REC709, RADIANCE] {
            let white = apply(&p.rgb_from_xyz(), xyz_of(p.white, 1.0));
            assert!(white.iter().all(|v| (v - 1.0).abs() < 1e-14), "{white:?}");
            let back = apply(&p.xyz_from_rgb(), apply(&p.rgb_from_xyz(), [0.2, 0.5, 0.9]));
            assert!((back[2] - 0.9).abs() < 1e-14);
        }
        // IEC 61966-2-1 gives this row as 3.2406, -1.5372, -0.4986.
        assert!((RGB_FROM_XYZ[0][0] - 3.2406).abs() < 5e-4);
    }

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
        assert!((found.kelvin - 6321.0).abs() < 0.02, "{found:?}");
    }

    #[test]
    fn coloured_light_has_no_colour_temperature() {
        assert_eq!(cct([0.64, 0.33]), None);
        assert_eq!(cct([0.15, 0.06]), None);
        assert_eq!(cct([f64::NAN, 0.3]), None);
        assert_eq!(xy([0.0; 3]), None);
        assert_eq!(uv_prime([0.0; 3]), None);
    }

    #[test]
    fn a_grey_reflectance_is_grey_under_every_usual_lamp() {
        for name in ["D65", "A", "F11", "LED-B3"] {
            let rgb = reflectance_rgb(&Spectrum::constant(0.4), &illuminant(name).unwrap()).unwrap();
            assert!(rgb.iter().all(|v| (v - 0.4).abs() < 1e-12), "{name}");
        }
        // High-pressure sodium has next to no blue.
        assert!(reflectance_rgb(&Spectrum::constant(0.4), &illuminant("HP1").unwrap()).is_none());
    }
}
