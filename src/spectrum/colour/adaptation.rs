//! Chromatic adaptation by von Kries' rule: the responses of three cone-like receptors are scaled so that one white
//! becomes the other.

use super::{Matrix, apply, inverse, multiply};

/// Sharpened cone responses of XYZ after Lam 1985 ("Bradford"), as ICC.1:2022, annex E prints them.
pub const BRADFORD: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// Cone responses of CIECAM02 (CIE 159:2004).
pub const CAT02: Matrix = [[0.7328, 0.4296, -0.1624], [-0.7036, 1.6975, 0.0061], [0.0030, 0.0136, 0.9834]];

/// Cone responses of CAM16 (Li et al. 2017; CIE 248:2022).
pub const CAT16: Matrix =
    [[0.401288, 0.650173, -0.051461], [-0.250268, 1.204414, 0.045854], [-0.002079, 0.048952, 0.953127]];

/// The matrix that turns XYZ seen under one white into XYZ that look the same under another; `lms` is one of
/// [`BRADFORD`], [`CAT02`] and [`CAT16`]. Adaptation is complete.
#[must_use]
pub fn adaptation(lms: &Matrix, from_white: [f64; 3], to_white: [f64; 3]) -> Matrix {
    let (from, to) = (apply(lms, from_white), apply(lms, to_white));
    let scaled: Matrix = std::array::from_fn(|r| lms[r].map(|v| v * to[r] / from[r]));
    multiply(&inverse(lms), &scaled)
}

/// XYZ adapted by Bradford's responses, see [`adaptation`].
#[must_use]
pub fn adapt(xyz: [f64; 3], from_white: [f64; 3], to_white: [f64; 3]) -> [f64; 3] {
    apply(&adaptation(&BRADFORD, from_white, to_white), xyz)
}

#[cfg(test)]
mod tests {
    use super::*;

    const D65: [f64; 3] = [0.95047, 1.0, 1.08883];
    const D50: [f64; 3] = [0.96422, 1.0, 0.82521];

    #[test]
    fn white_becomes_white_and_the_way_back_undoes_it() {
        for lms in [BRADFORD, CAT02, CAT16] {
            let there = adaptation(&lms, D65, D50);
            let white = apply(&there, D65);
            assert!((0..3).all(|k| (white[k] - D50[k]).abs() < 1e-14), "{white:?}");
            let back = apply(&adaptation(&lms, D50, D65), apply(&there, [0.3, 0.2, 0.1]));
            assert!((back[0] - 0.3).abs() < 1e-14 && (back[2] - 0.1).abs() < 1e-14, "{back:?}");
        }
    }

    #[test]
    fn bradford_from_d65_to_d50_is_as_lindbloom_prints_it() {
        let published = [
            [1.0478112, 0.0228866, -0.0501270],
            [0.0295424, 0.9904844, -0.0170491],
            [-0.0092345, 0.0150436, 0.7521316],
        ];
        let ours = adaptation(&BRADFORD, D65, D50);
        for (row, theirs) in ours.iter().flatten().zip(published.iter().flatten()) {
            // Seven decimals, from whites of five.
            assert!((row - theirs).abs() < 2e-6, "{ours:?}");
        }
    }
}
