//! A spectral picture as the camera behind its filters has it.

use std::path::Path;

use clerestory::spectrum::{Beyond, Spectrum};
use clerestory::{Error, Result};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels, ReadLayers, Vec2,
    WritableImage, f16, read,
};

/// A stack of pictures of one size, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stack {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Names with their pixels.
    pub(crate) pictures: Vec<(String, Vec<f32>)>,
}

/// Lens and filters by their names: transmittance over the wavelength.
pub(crate) struct Camera {
    pub(crate) filters: Vec<(String, Spectrum)>,
}

fn broken(path: &Path, what: impl ToString) -> Error {
    Error::malformed(what.to_string()).in_file(path)
}

impl Camera {
    /// Reads `camera.csv`: wavelength, lens, then a column for each filter; lens and filter are multiplied.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let mut reader = csv::Reader::from_path(path).map_err(|e| broken(path, e))?;
        let names: Vec<String> =
            reader.headers().map_err(|e| broken(path, e))?.iter().skip(2).map(str::to_owned).collect();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for (i, record) in reader.records().enumerate() {
            let record = record.map_err(|e| broken(path, e))?;
            let row: std::result::Result<Vec<f64>, _> = record.iter().map(str::parse).collect();
            rows.push(row.map_err(|_| broken(path, "expected numbers").at_line(i + 2))?);
        }
        let nm: Vec<f64> = rows.iter().map(|r| r[0]).collect();
        let filter = |(k, name): (usize, &String)| {
            let curve = Spectrum::new(nm.clone(), rows.iter().map(|r| r[1] * r[k + 2]).collect(), Beyond::Zero)?;
            Ok((name.clone(), curve))
        };
        Ok(Self { filters: names.iter().enumerate().map(filter).collect::<Result<_>>()? })
    }

    /// What the camera records of a picture in bands: sums of radiance × lens × filter over the bands, with a sensor that
    /// responds alike to every wavelength.
    pub(crate) fn record(&self, bands: &[(f64, Vec<f32>)], width: usize, height: usize) -> Stack {
        let edges = edges(bands);
        let pictures = self
            .filters
            .iter()
            .map(|(name, curve)| {
                let weights: Vec<f64> = edges.windows(2).map(|e| curve.mean(e[0], e[1]) * (e[1] - e[0])).collect();
                let pixel = |p: usize| bands.iter().zip(&weights).map(|((_, v), w)| f64::from(v[p]) * w).sum::<f64>();
                (name.clone(), (0..width * height).map(|p| pixel(p) as f32).collect())
            })
            .collect();
        Stack { width, height, pictures }
    }
}

/// Edges of bands by their middles, which lie side by side.
fn edges(bands: &[(f64, Vec<f32>)]) -> Vec<f64> {
    let nm: Vec<f64> = bands.iter().map(|b| b.0).collect();
    let step = nm.get(1).map_or(1.0, |second| second - nm[0]);
    let last = nm.last().map_or(0.0, |last| last + 0.5 * step);
    let inner = nm.windows(2).map(|w| 0.5 * (w[0] + w[1]));
    std::iter::once(nm.first().map_or(0.0, |first| first - 0.5 * step)).chain(inner).chain([last]).collect()
}

/// All channels of an EXR file.
pub(crate) fn read_exr(path: &Path) -> Result<Stack> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .map_err(|e| broken(path, e))?;
    let layer = image.layer_data;
    let values = |samples: &FlatSamples| samples.values_as_f32().collect();
    let pictures = layer.channel_data.list.iter().map(|c| (c.name.to_string(), values(&c.sample_data))).collect();
    Ok(Stack { width: layer.size.0, height: layer.size.1, pictures })
}

/// The spectral channels (`S0.550,000000nm`) by the middles of their bands, nm, increasing.
pub(crate) fn spectral(stack: &Stack) -> Vec<(f64, Vec<f32>)> {
    let middle = |name: &str| name.strip_prefix("S0.")?.strip_suffix("nm")?.replace(',', ".").parse::<f64>().ok();
    let mut bands: Vec<(f64, Vec<f32>)> =
        stack.pictures.iter().filter_map(|(name, v)| Some((middle(name)?, v.clone()))).collect();
    bands.sort_by(|a, b| a.0.total_cmp(&b.0));
    bands
}

/// Writes a channel of half floats for every picture.
pub(crate) fn write_exr(path: &Path, stack: &Stack) -> Result<()> {
    let channel = |(name, values): &(String, Vec<f32>)| {
        AnyChannel::new(name.as_str(), FlatSamples::F16(values.iter().map(|v| f16::from_f32(*v)).collect()))
    };
    let layer = Layer::new(
        Vec2(stack.width, stack.height),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(stack.pictures.iter().map(channel).collect()),
    );
    Image::from_layer(layer).write().to_file(path).map_err(|e| broken(path, e))
}
