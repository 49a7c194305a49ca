//! What the eye makes of light: chromaticity, colour spaces, adaptation, differences, colour temperature and rendering.
//!
//! The starting point is CIE XYZ, from [`Spectrum::xyz`](super::Spectrum::xyz), [`Bands::xyz`](super::Bands::xyz) or, as
//! tables of colour are made, from [`cie::sum`](super::cie::sum).

mod adaptation;
mod difference;
mod rendering;
mod rgb;
mod temperature;

pub use adaptation::{BRADFORD, CAT02, CAT16, adapt, adaptation};
pub use difference::{ciede2000, lab, luv};
pub use rendering::{Rendering, rendering};
pub use rgb::{
    ACESCG, Primaries, RADIANCE, REC709, REC2020, linear_srgb, rec2020_decode, rec2020_encode, reflectance_rgb,
    srgb_decode, srgb_encode,
};
pub use temperature::{Cct, cct};

/// A 3 × 3 matrix, row by row.
pub type Matrix = [[f64; 3]; 3];

/// Matrix times matrix.
#[must_use]
pub fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| std::array::from_fn(|c| (0..3).map(|k| row[k] * b[k][c]).sum()))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dark_has_no_chromaticity() {
        assert_eq!(xy([0.0; 3]), None);
        assert_eq!(uv_prime([0.0; 3]), None);
    }
}
