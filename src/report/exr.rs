//! Spectral pictures as OpenEXR.
//!
//! Layout of the spectral channels: Fichet, Pacanowski and Wilkie 2021 ("An OpenEXR Layout for Spectral
//! Images"). R, G, B and Y lie beside them, so that any viewer shows the picture.

use std::io::Cursor;

use exr::meta::attribute::{AttributeValue, Chromaticities};
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder, SmallVec,
    Text, Vec2, WritableImage,
};

use super::Provenance;
use crate::error::{Error, ErrorKind, Result};
use crate::measure::{Measurement, ViewResult};
use crate::scene::Scene;
use crate::spectrum::colour::{REC709, linear_srgb};

/// The picture as the bytes of an EXR file.
pub(super) fn encode(scene: &Scene, m: &Measurement, result: &ViewResult, provenance: &Provenance) -> Result<Vec<u8>> {
    let size = Vec2(result.view.width, result.view.height);
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = colour_channels(result).into();
    if is_spectral(m) {
        channels.extend(spectral_channels(m, result));
    }
    let mut layer = Layer::new(
        size,
        attributes(scene, m, provenance),
        Encoding {
            // 512 x 512 pixels in 76 bands: ZIP makes 72 MB of 84 in 2.7 s of processor time, more than the light takes;
            // PIZ (57 MB, 1.7 s) is known to fewer readers.
            compression: Compression::Uncompressed,
            // Otherwise the blocks come in the order in which threads finish them.
            line_order: LineOrder::Increasing,
            ..Encoding::default()
        },
        AnyChannels::sort(channels),
    );
    layer.attributes.layer_name = None;
    let mut image = Image::from_layer(layer);
    let [r, g, b, w] = [REC709.red, REC709.green, REC709.blue, REC709.white].map(|[x, y]| Vec2(x as f32, y as f32));
    image.attributes.chromaticities = Some(Chromaticities { red: r, green: g, blue: b, white: w });
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).map_err(|e| internal(result, &e.to_string()))?;
    in_fixed_order(bytes.into_inner()).ok_or_else(|| internal(result, "the header of the EXR file is not understood"))
}

fn internal(result: &ViewResult, what: &str) -> Error {
    Error::new(ErrorKind::Internal, format!("view {:?}: {what}", result.view.name))
}

fn is_spectral(m: &Measurement) -> bool {
    m.bands.is_spectral() && m.bands.len() > 1
}

/// R, G, B (linear sRGB) and Y, all in cd/m².
fn colour_channels(result: &ViewResult) -> Vec<AnyChannel<FlatSamples>> {
    let rgb: Vec<[f64; 3]> = result.xyz.iter().map(|xyz| linear_srgb(xyz.map(f64::from))).collect();
    let mut channels: Vec<_> = ["R", "G", "B"]
        .iter()
        .enumerate()
        .map(|(c, name)| channel(name, rgb.iter().map(|p| p[c] as f32).collect()))
        .collect();
    channels.push(channel("Y", result.xyz.iter().map(|p| p[1]).collect()));
    channels
}

/// One channel per band, W/(m² sr nm), named by the middle of the band.
fn spectral_channels(m: &Measurement, result: &ViewResult) -> Vec<AnyChannel<FlatSamples>> {
    let names = m.bands.limits_nm().iter().map(|(lo, hi)| channel_name(0.5 * (lo + hi)));
    names.zip(planes(&result.radiance, m.bands.len())).map(|(name, values)| channel(&name, values)).collect()
}

/// Values with the band fastest into one plane per band.
fn planes(values: &[f32], bands: usize) -> Vec<Vec<f32>> {
    /// Pixels that stay in the cache while every plane takes its own.
    const TOGETHER: usize = 64;
    let mut planes = vec![Vec::with_capacity(values.len() / bands.max(1)); bands];
    for block in values.chunks(TOGETHER * bands.max(1)) {
        for (band, plane) in planes.iter_mut().enumerate() {
            plane.extend(block.iter().skip(band).step_by(bands));
        }
    }
    planes
}

/// `S0.550,000000nm`: the Stokes component and the wavelength with a decimal comma.
fn channel_name(nm: f64) -> String {
    format!("S0.{nm:.6}nm").replacen("S0.", "S0;", 1).replace('.', ",").replace("S0;", "S0.")
}

fn channel(name: &str, values: Vec<f32>) -> AnyChannel<FlatSamples> {
    AnyChannel::new(name, FlatSamples::F32(values))
}

fn attributes(scene: &Scene, m: &Measurement, provenance: &Provenance) -> LayerAttributes {
    let mut attributes = LayerAttributes {
        // RGB are in cd/m², so that R = G = B = 1 shows one.
        white_luminance: Some(1.0),
        software_name: Text::new_or_none(format!("clerestory {}", provenance.version)),
        ..LayerAttributes::default()
    };
    let mut set = |name: &str, value: String| {
        if let Some(text) = Text::new_or_none(&value) {
            attributes.other.insert(Text::from(name), AttributeValue::Text(text));
        }
    };
    set("clerestory:title", scene.title.clone());
    set(
        "clerestory:rgbUnits",
        "R, G, B: linear sRGB primaries, scaled so that Y is the luminance in cd/m2; Y: luminance in cd/m2".into(),
    );
    if is_spectral(m) {
        set("spectralLayoutVersion", "1.0".into());
        set("emissiveUnits", "W.m^-2.sr^-1".into());
        set("clerestory:spectralUnits", "W.m^-2.sr^-1.nm^-1, average over the band".into());
        let edges = m.bands.limits_nm().iter();
        let edges: Vec<String> = edges.map(|(lo, hi)| format!("{lo}-{hi}")).collect();
        set("clerestory:bandEdges_nm", edges.join(" "));
    }
    attributes
}

/// Sorts the attributes in the header by name, so that a run gives the same bytes each time: the library keeps
/// them in hash order. Their lengths stay, and so does every offset behind them.
fn in_fixed_order(mut bytes: Vec<u8>) -> Option<Vec<u8>> {
    /// Magic number and version.
    const START: usize = 8;
    let mut attributes = Vec::new();
    let mut at = START;
    while *bytes.get(at)? != 0 {
        let end = attribute_end(&bytes, at)?;
        attributes.push(bytes.get(at..end)?.to_vec());
        at = end;
    }
    attributes.sort();
    bytes[START..at].copy_from_slice(&attributes.concat());
    Some(bytes)
}

/// An attribute is a name, a type, both ended by zero, a length in four bytes and as many bytes of value.
fn attribute_end(bytes: &[u8], start: usize) -> Option<usize> {
    let zero = |from: usize| Some(from + bytes.get(from..)?.iter().position(|&b| b == 0)?);
    let size_at = zero(zero(start)? + 1)? + 1;
    let size = bytes.get(size_at..size_at + 4)?.try_into().ok()?;
    Some(size_at + 4 + u32::from_le_bytes(size) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_named_with_a_decimal_comma() {
        assert_eq!(channel_name(550.0), "S0.550,000000nm");
        assert_eq!(channel_name(402.5), "S0.402,500000nm");
    }
}
