//! PNG files, and the tone-mapped picture of a view.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::error::{Error, ErrorKind, Result};
use crate::measure::ViewResult;
use crate::spectrum::colour::{linear_srgb, srgb_encode};

/// Eight bits per channel, sRGB.
pub(super) fn encode(width: usize, height: usize, rgb: &[u8]) -> Result<Vec<u8>> {
    let side =
        |v: usize| u32::try_from(v).map_err(|_| Error::unsupported(format!("a picture of {width} × {height} pixels")));
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(rgb, side(width)?, side(height)?, ExtendedColorType::Rgb8)
        .map_err(|e| Error::new(ErrorKind::Internal, format!("a picture: {e}")))?;
    Ok(bytes)
}

/// The picture as an eye-like camera would show it: exposed for the surfaces, lamps may clip. The colour of
/// the light is kept.
pub(super) fn tone_mapped(result: &ViewResult) -> Result<Vec<u8>> {
    let luminance: Vec<f64> = result.xyz.iter().map(|p| f64::from(p[1])).collect();
    let exposure = Exposure::of(&luminance);
    let mut rgb = Vec::with_capacity(3 * result.xyz.len());
    for xyz in &result.xyz {
        rgb.extend(exposure.develop(xyz.map(f64::from)));
    }
    encode(result.view.width, result.view.height, &rgb)
}

/// Where the mean of the surfaces goes, linear: the grey of a photographer's card.
const MID_GREY: f64 = 0.18;
/// Pixels farther above or below the logarithmic mean than these factors are lamps or holes.
const LAMP: f64 = 16.0;
const HOLE: f64 = 1e-3;
/// Least exposed luminance that is shown as white.
const LEAST_WHITE: f64 = 1.5;

/// Reinhard's global operator: `L (1 + L/W²)/(1 + L)` of the exposed luminance L; W becomes white.
struct Exposure {
    /// Per cd/m².
    gain: f64,
    white: f64,
}

impl Exposure {
    fn of(luminance: &[f64]) -> Self {
        let lit: Vec<f64> = luminance.iter().copied().filter(|&v| v > 0.0).collect();
        let mut mean = log_mean(lit.iter().copied());
        let surfaces = |mean: f64| {
            let range = HOLE * mean..LAMP * mean;
            lit.iter().copied().filter(move |v| range.contains(v))
        };
        // Without the lamps the mean falls, and dimmer lamps show up as such: a few rounds settle it.
        for _ in 0..4 {
            mean = log_mean(surfaces(mean));
        }
        let brightest = surfaces(mean).fold(0.0, f64::max);
        // The operator takes 0.22 to the grey.
        let gain = MID_GREY / (1.0 - MID_GREY) / mean;
        Self { gain, white: (gain * brightest).max(LEAST_WHITE) }
    }

    fn develop(&self, xyz: [f64; 3]) -> [u8; 3] {
        let l = self.gain * xyz[1];
        if l <= 0.0 {
            return [0; 3];
        }
        let shown = l * (1.0 + l / (self.white * self.white)) / (1.0 + l);
        let rgb = linear_srgb(xyz.map(|v| v * shown / xyz[1]));
        in_gamut(rgb, shown.min(1.0)).map(|v| (255.0 * srgb_encode(v)).round() as u8)
    }
}

/// Draws a colour towards the grey of its luminance until every channel is between 0 and 1.
fn in_gamut(rgb: [f64; 3], grey: f64) -> [f64; 3] {
    let room = |v: f64| {
        if v > 1.0 {
            (1.0 - grey) / (v - grey)
        } else if v < 0.0 {
            grey / (grey - v)
        } else {
            1.0
        }
    };
    let keep = rgb.iter().map(|&v| room(v)).fold(1.0, f64::min);
    rgb.map(|v| grey + keep * (v - grey))
}

/// Logarithmic mean; 1 of nothing.
fn log_mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_u32), |(s, n), v| (s + v.ln(), n + 1));
    if count == 0 { 1.0 } else { (sum / f64::from(count)).exp() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lamp_does_not_darken_the_room() {
        let mut room = vec![10.0; 900];
        let alone = Exposure::of(&room).gain;
        room.extend([20_000.0; 100]);
        assert!((Exposure::of(&room).gain / alone - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_mean_of_the_surfaces_becomes_mid_grey() {
        let white = [0.9505, 1.0, 1.089];
        let exposure = Exposure::of(&[50.0; 100]);
        let shown = exposure.develop(white.map(|v| 50.0 * v));
        // 0.18 is 118 of 255 when encoded; the white point lifts it a little.
        assert!(shown.iter().all(|&v| (117..=124).contains(&v)), "{shown:?}");
    }

    #[test]
    fn the_dark_and_coloured_light_stay_in_range() {
        assert_eq!(Exposure::of(&[0.0; 9]).develop([0.0; 3]), [0; 3]);
        let exposure = Exposure::of(&[1.0; 9]);
        // Sodium light: far outside of sRGB.
        let lamp = exposure.develop([1.4e3, 1e3, 0.0]);
        assert!(lamp[0] >= lamp[1] && lamp[1] >= lamp[2]);
        let dim = exposure.develop([0.14, 0.1, 0.0]);
        assert!(dim[0] > dim[2], "{dim:?}");
    }
}
