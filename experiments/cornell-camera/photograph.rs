//! Photographs of a scene against what was computed: read, registered by corner points, one factor fitted, compared by region.

use std::path::Path;

use clerestory::{Error, Result};
use tiff::decoder::{Decoder, DecodingResult};

use super::filters::{Stack, read_exr};

/// A place in a picture, pixels from the top left.
pub(crate) type Place = [f64; 2];

/// Reads a photograph: EXR with any number of channels, or TIFF of 8 or 16 bit or floats in one grey channel, whose name is
/// that of the file.
pub(crate) fn read(path: &Path) -> Result<Stack> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        return read_exr(path);
    }
    let broken = |what: String| Error::malformed(what).in_file(path);
    let file = std::fs::File::open(path).map_err(|e| Error::io(path, &e))?;
    let mut decoder = Decoder::new(std::io::BufReader::new(file)).map_err(|e| broken(e.to_string()))?;
    let (width, height) = decoder.dimensions().map_err(|e| broken(e.to_string()))?;
    let values: Vec<f32> = match decoder.read_image().map_err(|e| broken(e.to_string()))? {
        DecodingResult::U8(v) => v.into_iter().map(f32::from).collect(),
        DecodingResult::U16(v) => v.into_iter().map(f32::from).collect(),
        DecodingResult::F32(v) => v,
        _ => return Err(broken("expected 8 or 16 bit or floats".into())),
    };
    let (width, height) = (width as usize, height as usize);
    if values.len() != width * height {
        return Err(broken(format!("{} values in {width} × {height} pixels, expected one grey channel", values.len())));
    }
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    Ok(Stack { width, height, pictures: vec![(name, values)] })
}

/// The projective map that takes the first places to the second, by least squares: Hartley and Zisserman's direct linear
/// transform with its last entry set to one. Two cameras at one place see every scene, flat or not, so related.
pub(crate) fn homography(pairs: &[(Place, Place)]) -> Option<[f64; 9]> {
    if pairs.len() < 4 {
        return None;
    }
    // Normal equations of two rows a pair.
    let (mut a, mut b) = ([[0.0; 8]; 8], [0.0; 8]);
    for ([x, y], [u, v]) in pairs {
        for (row, to) in
            [([*x, *y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y], u), ([0.0, 0.0, 0.0, *x, *y, 1.0, -v * x, -v * y], v)]
        {
            for i in 0..8 {
                b[i] += row[i] * to;
                for j in 0..8 {
                    a[i][j] += row[i] * row[j];
                }
            }
        }
    }
    // Gauss's elimination with the largest pivot; what is next to nothing means that the corners lie in a line.
    for k in 0..8 {
        let pivot = (k..8).max_by(|i, j| a[*i][k].abs().total_cmp(&a[*j][k].abs()))?;
        a.swap(k, pivot);
        b.swap(k, pivot);
        if a[k][k].abs() < 1e-9 {
            return None;
        }
        for i in 0..8 {
            if i != k {
                let f = a[i][k] / a[k][k];
                for j in k..8 {
                    a[i][j] -= f * a[k][j];
                }
                b[i] -= f * b[k];
            }
        }
    }
    let mut h = [1.0; 9];
    for k in 0..8 {
        h[k] = b[k] / a[k][k];
    }
    Some(h)
}

/// Where a place goes.
pub(crate) fn mapped(h: &[f64; 9], [x, y]: Place) -> Place {
    let w = h[6] * x + h[7] * y + h[8];
    [(h[0] * x + h[1] * y + h[2]) / w, (h[3] * x + h[4] * y + h[5]) / w]
}

/// The value at a place, linear between the middles of pixels; none outside.
fn value(values: &[f32], width: usize, height: usize, [x, y]: Place) -> Option<f64> {
    let (x, y) = (x - 0.5, y - 0.5);
    if !(x >= 0.0 && y >= 0.0 && x <= width as f64 - 1.0 && y <= height as f64 - 1.0) {
        return None;
    }
    let (i, j) = ((x as usize).min(width - 2), (y as usize).min(height - 2));
    let (s, t) = (x - i as f64, y - j as f64);
    let at = |i: usize, j: usize| f64::from(values[j * width + i]);
    Some((1.0 - t) * ((1.0 - s) * at(i, j) + s * at(i + 1, j)) + t * ((1.0 - s) * at(i, j + 1) + s * at(i + 1, j + 1)))
}

/// A part of the computed picture: name, upper left and lower right pixel.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    pub(crate) name: String,
    pub(crate) from: [usize; 2],
    pub(crate) to: [usize; 2],
}

/// Photographed over computed in a region of a picture, after the common factor.
#[derive(Clone, Debug)]
pub(crate) struct Ratio {
    pub(crate) picture: String,
    pub(crate) region: String,
    pub(crate) mean: f64,
    /// Standard deviation over the pixels.
    pub(crate) spread: f64,
    pub(crate) pixels: usize,
}

/// Computed and photographed values of pixels.
type Pairs = Vec<(f64, f64)>;

/// Compares pictures of the same names. One factor for all of them: least squares over all pixels of all regions.
pub(crate) fn compare(computed: &Stack, photographs: &[Stack], h: &[f64; 9], regions: &[Region]) -> (f64, Vec<Ratio>) {
    let mut lists: Vec<(String, String, Pairs)> = Vec::new();
    for (name, ours) in &computed.pictures {
        let Some((stack, theirs)) =
            photographs.iter().find_map(|s| s.pictures.iter().find(|(n, _)| n == name).map(|(_, values)| (s, values)))
        else {
            continue;
        };
        for region in regions {
            let mut pairs = Vec::new();
            for j in region.from[1]..region.to[1] {
                for i in region.from[0]..region.to[0] {
                    let there = mapped(h, [i as f64 + 0.5, j as f64 + 0.5]);
                    if let Some(photographed) = value(theirs, stack.width, stack.height, there) {
                        pairs.push((f64::from(ours[j * computed.width + i]), photographed));
                    }
                }
            }
            lists.push((name.clone(), region.name.clone(), pairs));
        }
    }
    let all = || lists.iter().flat_map(|l| &l.2);
    let factor = all().map(|(c, p)| c * p).sum::<f64>() / all().map(|(c, _)| c * c).sum::<f64>();
    let ratios = lists
        .iter()
        .filter(|l| !l.2.is_empty())
        .map(|(picture, region, pairs)| {
            let n = pairs.len() as f64;
            let ratio = |(c, p): &(f64, f64)| p / (factor * c);
            let mean = pairs.iter().map(ratio).sum::<f64>() / n;
            let square = pairs.iter().map(|q| (ratio(q) - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
            let (picture, region) = (picture.clone(), region.clone());
            Ratio { picture, region, mean, spread: square.sqrt(), pixels: pairs.len() }
        })
        .collect();
    (factor, ratios)
}
