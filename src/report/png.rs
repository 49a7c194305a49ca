//! PNG files, and the tone-mapped picture of a view.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::scale::percentile;
use crate::error::{Error, ErrorKind, Result};
use crate::measure::ViewResult;
use crate::scene::Scene;
use crate::spectrum::colour::{linear_srgb, srgb_encode};

/// A fifth of the default's time for half as many bytes again: the pictures are written more often than they are sent.
const LEVEL: CompressionType = CompressionType::Fast;

/// Eight bits per channel, sRGB.
pub(super) fn encode(width: usize, height: usize, rgb: &[u8]) -> Result<Vec<u8>> {
    let side =
        |v: usize| u32::try_from(v).map_err(|_| Error::unsupported(format!("a picture of {width} × {height} pixels")));
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, LEVEL, FilterType::Adaptive)
        .write_image(rgb, side(width)?, side(height)?, ExtendedColorType::Rgb8)
        .map_err(|e| Error::new(ErrorKind::Internal, format!("a picture: {e}")))?;
    Ok(bytes)
}

/// The picture as a camera would show it: exposed for the surfaces, lamps burn out to white.
///
/// One factor per pixel takes all three channels, so that no hue shifts. Only what lies outside of sRGB is
/// drawn towards grey, as far as it must be. The colour of the light is kept: nothing balances the white.
pub(super) fn tone_mapped(scene: &Scene, result: &ViewResult) -> Result<Vec<u8>> {
    let rgb = Film::for_picture(scene, &result.xyz).develop(&result.xyz);
    encode(result.view.width, result.view.height, rgb.as_flattened())
}

/// An exposure to show several pictures with.
pub(super) struct Film(Exposure);

impl Film {
    /// Exposed for one picture.
    pub(super) fn for_picture(scene: &Scene, xyz: &[[f32; 3]]) -> Self {
        Self(Exposure::of(&pixels(xyz), least_lamp(scene)))
    }

    /// Pixels in sRGB.
    pub(super) fn develop(&self, xyz: &[[f32; 3]]) -> Vec<[u8; 3]> {
        pixels(xyz).iter().map(|p| self.0.develop(p)).collect()
    }
}

fn pixels(xyz: &[[f32; 3]]) -> Vec<Pixel> {
    xyz.iter().map(|xyz| Pixel::new(xyz.map(f64::from))).collect()
}

/// Share of the pixels on surfaces that are shown darker than [`BRIGHT`].
const SHARE: f64 = 0.99;
/// Where that share ends; 1 is the white of the display, linear.
const BRIGHT: f64 = 0.8;
/// Up to here the picture is proportional to the light; above, it nears white ever more slowly.
const KNEE: f64 = 0.6;
/// Exposed values between which a lamp's colour goes over into white.
const BURN: std::ops::Range<f64> = 2.0..8.0;
/// A lamp is this many times as bright as the logarithmic mean of the rest ...
const LAMP: f64 = 16.0;
/// ... and has this share of the least luminance of the scene's emitters, for panes and bands take some.
const LAMP_SHARE: f64 = 0.5;

/// Luminance of the dimmest emitter, cd/m²; infinite where nothing emits, zero where luminaires do: theirs changes with the
/// direction.
fn least_lamp(scene: &Scene) -> f64 {
    if !scene.luminaires.is_empty() {
        return 0.0;
    }
    let emissions = scene.materials.iter().filter_map(|m| m.emission.as_ref());
    emissions.map(|e| e.radiance.luminous()).filter(|&l| l > 0.0).fold(f64::INFINITY, f64::min)
}

/// A colour in linear sRGB and its luminance, cd/m².
struct Pixel {
    rgb: [f64; 3],
    luminance: f64,
}

impl Pixel {
    fn new(xyz: [f64; 3]) -> Self {
        Self { rgb: linear_srgb(xyz), luminance: xyz[1] }
    }

    /// The channel that reaches the white of the display first.
    fn peak(&self) -> f64 {
        self.rgb.iter().copied().fold(self.luminance, f64::max)
    }
}

/// How light becomes display values.
struct Exposure {
    /// Per cd/m².
    gain: f64,
}

impl Exposure {
    fn of(pixels: &[Pixel], least_lamp: f64) -> Self {
        let lit: Vec<&Pixel> = pixels.iter().filter(|p| p.luminance > 0.0).collect();
        let mut limit = f64::INFINITY;
        // Without the lamps the mean falls, and dimmer lamps show up as such: a few rounds settle it.
        for _ in 0..4 {
            let mean = log_mean(lit.iter().map(|p| p.luminance).filter(|&l| l < limit));
            limit = (LAMP * mean).max(LAMP_SHARE * least_lamp);
        }
        let peaks: Vec<f64> = lit.iter().filter(|p| p.luminance < limit).map(|p| p.peak()).collect();
        let bright = percentile(&peaks, SHARE);
        Self { gain: if bright > 0.0 { unshouldered(BRIGHT) / bright } else { 1.0 } }
    }

    fn develop(&self, pixel: &Pixel) -> [u8; 3] {
        let exposed = self.gain * pixel.peak();
        if exposed <= 0.0 {
            return [0; 3];
        }
        let scale = self.gain * shoulder(exposed) / exposed;
        let rgb = without_negatives(pixel.rgb.map(|v| scale * v), scale * pixel.luminance);
        let way = ((exposed - BURN.start) / (BURN.end - BURN.start)).clamp(0.0, 1.0);
        let burnt = way * way * (3.0 - 2.0 * way);
        rgb.map(|v| (255.0 * srgb_encode(v + burnt * (1.0 - v))).round() as u8)
    }
}

/// Proportional up to the knee, then towards 1 with the same slope at the start.
fn shoulder(exposed: f64) -> f64 {
    if exposed <= KNEE { exposed } else { 1.0 - (1.0 - KNEE) * (-(exposed - KNEE) / (1.0 - KNEE)).exp() }
}

/// The inverse of [`shoulder`], for values from the knee to below 1.
fn unshouldered(shown: f64) -> f64 {
    KNEE - (1.0 - KNEE) * ((1.0 - shown) / (1.0 - KNEE)).ln()
}

/// Draws a colour towards the grey of its luminance until no channel is below zero.
fn without_negatives(rgb: [f64; 3], grey: f64) -> [f64; 3] {
    let least = rgb.iter().copied().fold(0.0, f64::min);
    let keep = if least < 0.0 { grey / (grey - least) } else { 1.0 };
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

    const WHITE: [f64; 3] = [0.9505, 1.0, 1.089];

    fn grey(luminance: &[f64]) -> Vec<Pixel> {
        luminance.iter().map(|l| Pixel::new(WHITE.map(|v| v * l))).collect()
    }

    #[test]
    fn a_lamp_does_not_darken_the_room_and_is_white() {
        let mut room = vec![10.0; 900];
        let alone = Exposure::of(&grey(&room), 20_000.0).gain;
        room.extend([20_000.0; 100]);
        let lit = Exposure::of(&grey(&room), 20_000.0);
        assert!((lit.gain / alone - 1.0).abs() < 1e-12);
        let orange = Pixel::new([24_000.0, 20_000.0, 6_000.0]);
        assert_eq!(lit.develop(&orange), [255; 3]);
    }

    #[test]
    fn bright_patches_without_an_emitter_are_no_lamps() {
        let mut room = vec![10.0; 900];
        room.extend([1_000.0; 100]);
        let exposure = Exposure::of(&grey(&room), f64::INFINITY);
        // 0.8 is 231 of 255 when encoded.
        let patch = exposure.develop(&grey(&[1_000.0])[0]);
        assert!(patch.iter().all(|v| (229..=233).contains(v)), "{patch:?}");
    }

    #[test]
    fn the_shoulder_is_smooth_and_ends_at_white() {
        assert!((shoulder(unshouldered(BRIGHT)) - BRIGHT).abs() < 1e-12);
        let step = 1e-6;
        let slope = (shoulder(KNEE + step) - shoulder(KNEE)) / step;
        assert!((slope - 1.0).abs() < 1e-4, "{slope}");
        assert!((1..2000).all(|i| shoulder(0.01 * f64::from(i)) <= 1.0));
    }

    #[test]
    fn the_ratio_of_the_channels_survives_the_shoulder() {
        let exposure = Exposure::of(&grey(&[50.0; 100]), f64::INFINITY);
        let decode = |v: u8| {
            let e = f64::from(v) / 255.0;
            ((e + 0.055) / 1.055).powf(2.4)
        };
        // A warm wall, twice as bright as what the picture is exposed for.
        let warm = Pixel { rgb: [120.0, 60.0, 30.0], luminance: 70.0 };
        let [r, g, b] = exposure.develop(&warm).map(decode);
        // Half a step of 255 is 0.7 % at the blue.
        assert!((r / g - 2.0).abs() < 0.03 && (g / b - 2.0).abs() < 0.03, "{r} {g} {b}");
    }

    #[test]
    fn the_dark_and_coloured_light_stay_in_range() {
        assert_eq!(Exposure::of(&grey(&[0.0; 9]), 1.0).develop(&grey(&[0.0])[0]), [0; 3]);
        let exposure = Exposure::of(&grey(&[1.0; 9]), f64::INFINITY);
        // Sodium light: far outside of sRGB.
        let dim = exposure.develop(&Pixel::new([0.14, 0.1, 0.0]));
        assert!(dim[0] > dim[1] && dim[1] > dim[2], "{dim:?}");
    }
}
