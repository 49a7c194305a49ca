//! RGB systems: primaries, white and transfer function.

use std::sync::LazyLock;

use super::super::{Spectrum, cie};
use super::{Matrix, apply, inverse, xyz_of};

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

/// ITU-R BT.2020: D65 as white.
pub const REC2020: Primaries =
    Primaries { red: [0.708, 0.292], green: [0.170, 0.797], blue: [0.131, 0.046], white: [0.3127, 0.3290] };

/// `ACEScg` (AP1 primaries of S-2014-004): linear, with the white of ACES, so that XYZ under D65 wants
/// [`adapt`](super::adapt) first.
pub const ACESCG: Primaries =
    Primaries { red: [0.713, 0.293], green: [0.165, 0.830], blue: [0.128, 0.044], white: [0.32168, 0.33767] };

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

/// The inverse of [`srgb_encode`]; values outside 0 to 1 are clipped.
#[must_use]
pub fn srgb_decode(encoded: f64) -> f64 {
    let v = encoded.clamp(0.0, 1.0);
    // The border is where the straight piece ends in `srgb_encode`.
    if v <= 12.92 * 0.003_130_8 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Constants α and β of the transfer function of ITU-R BT.2020, to the digits that make it continuous.
const REC2020_CURVE: (f64, f64) = (1.099_296_826_809_44, 0.018_053_968_510_807);

/// The transfer function of ITU-R BT.2020, linear 0 to 1 into encoded 0 to 1; values outside are clipped.
#[must_use]
pub fn rec2020_encode(linear: f64) -> f64 {
    let (alpha, beta) = REC2020_CURVE;
    let v = linear.clamp(0.0, 1.0);
    if v < beta { 4.5 * v } else { alpha * v.powf(0.45) - (alpha - 1.0) }
}

/// The inverse of [`rec2020_encode`]; values outside 0 to 1 are clipped.
#[must_use]
pub fn rec2020_decode(encoded: f64) -> f64 {
    let (alpha, beta) = REC2020_CURVE;
    let v = encoded.clamp(0.0, 1.0);
    if v < 4.5 * beta { v / 4.5 } else { ((v + alpha - 1.0) / alpha).powf(1.0 / 0.45) }
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

#[cfg(test)]
mod tests {
    use super::super::super::illuminant;
    use super::*;

    #[test]
    fn the_matrices_undo_each_other_and_white_is_one() {
        for p in [REC709, REC2020, ACESCG, RADIANCE] {
            let white = apply(&p.rgb_from_xyz(), xyz_of(p.white, 1.0));
            assert!(white.iter().all(|v| (v - 1.0).abs() < 1e-14), "{white:?}");
            let back = apply(&p.xyz_from_rgb(), apply(&p.rgb_from_xyz(), [0.2, 0.5, 0.9]));
            assert!((back[2] - 0.9).abs() < 1e-14);
        }
        // IEC 61966-2-1 gives this row as 3.2406, -1.5372, -0.4986.
        assert!((RGB_FROM_XYZ[0][0] - 3.2406).abs() < 5e-4);
    }

    #[test]
    fn the_luminance_of_each_primary_is_as_published() {
        // BT.2020 table 4: Y' = 0.2627 R + 0.6780 G + 0.0593 B; S-2014-004: 0.2722287168, 0.6740817658, 0.0536895174.
        for (primaries, published, digits) in [
            (REC2020, [0.2627, 0.6780, 0.0593], 5e-5),
            (ACESCG, [0.272_228_716_8, 0.674_081_765_8, 0.053_689_517_4], 5e-11),
        ] {
            let row = primaries.xyz_from_rgb()[1];
            for (ours, theirs) in row.iter().zip(published) {
                assert!((ours - theirs).abs() < digits, "{row:?}");
            }
        }
    }

    #[test]
    fn decoding_undoes_encoding() {
        for step in 0..=1000 {
            let v = f64::from(step) / 1000.0;
            // The two pieces of the sRGB curve meet within 3e-8, see IEC 61966-2-1.
            assert!((srgb_decode(srgb_encode(v)) - v).abs() < 1e-7, "{v}");
            assert!((rec2020_decode(rec2020_encode(v)) - v).abs() < 1e-12, "{v}");
        }
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
