//! Radiance pictures (RGBE), with the keys that Radiance's own tools look for.

use glam::DVec3;

use super::Provenance;
use crate::Result;
use crate::measure::ViewResult;
use crate::scene::{Projection, Scene, View};
use crate::spectrum::colour::{RADIANCE, apply};

/// Radiance's fixed luminous efficacy of white light, lm/W: what its tools multiply radiances by.
const WHITE_EFFICACY: f64 = 179.0;

/// Widths that the run-length encoding can hold.
const RLE_WIDTHS: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// The picture as the bytes of an HDR file.
pub(super) fn encode(scene: &Scene, result: &ViewResult, provenance: &Provenance) -> Result<Vec<u8>> {
    let to_rgb = RADIANCE.rgb_from_xyz();
    let mut clamped = 0_usize;
    let pixels: Vec<[u8; 4]> = result
        .xyz
        .iter()
        .map(|xyz| {
            let rgb = apply(&to_rgb, xyz.map(|v| f64::from(v) / WHITE_EFFICACY));
            clamped += rgb.iter().filter(|&&v| v < 0.0).count();
            rgbe(rgb)
        })
        .collect();
    let mut bytes = header(scene, &result.view, provenance, clamped).into_bytes();
    for row in pixels.chunks(result.view.width) {
        write_row(&mut bytes, row);
    }
    Ok(bytes)
}

fn header(scene: &Scene, view: &View, provenance: &Provenance, clamped: usize) -> String {
    let mut lines = vec!["#?RADIANCE".to_owned(), format!("SOFTWARE= clerestory {}", provenance.version)];
    if clamped > 0 {
        lines.push(format!("# {clamped} negative channel values were set to zero"));
    }
    lines.push(view_line(scene, view));
    lines.push("PRIMARIES= 0.6400 0.3300 0.2900 0.6000 0.1500 0.0600 0.3333 0.3333".to_owned());
    lines.push("EXPOSURE=1.0".to_owned());
    lines.push("FORMAT=32-bit_rle_rgbe".to_owned());
    format!("{}\n\n-Y {} +X {}\n", lines.join("\n"), view.height, view.width)
}

/// The view in the user's axes. Radiance knows no equirectangular view: a panorama says so in a comment.
fn view_line(scene: &Scene, view: &View) -> String {
    let (kind, h, v) = match view.projection {
        Projection::Perspective { horizontal, vertical } => ("v", horizontal, vertical),
        Projection::Fisheye { angle } => ("a", angle, angle),
        Projection::Panorama => {
            return "# equirectangular panorama, 360 by 180 degrees: no VIEW can say this".into();
        }
    };
    let triple = |p: DVec3| {
        let p = scene.axes.to_user(p);
        // Adding zero turns -0 into 0.
        format!("{} {} {}", p.x + 0.0, p.y + 0.0, p.z + 0.0)
    };
    format!(
        "VIEW= -vt{kind} -vp {} -vd {} -vu {} -vh {} -vv {} -vo 0 -va 0 -vs 0 -vl 0",
        triple(view.position),
        triple(view.direction),
        triple(view.up),
        degrees(h),
        degrees(v)
    )
}

/// An angle in degrees, without the last digits' rounding.
fn degrees(radians: f64) -> f64 {
    (radians.to_degrees() * 1e9).round() / 1e9
}

/// A colour as three mantissas and a shared exponent; negative values become zero.
fn rgbe(rgb: [f64; 3]) -> [u8; 4] {
    let rgb = rgb.map(|v| v.max(0.0));
    let most = rgb.iter().copied().fold(0.0, f64::max);
    if most < 1e-32 {
        return [0; 4];
    }
    // most = m · 2^exponent with m in 0.5..1
    let exponent = most.log2().floor() as i32 + 1;
    // 255.9999 keeps the largest mantissa in a byte.
    let scale = 255.9999 / 2f64.powi(exponent);
    let [r, g, b] = rgb.map(|v| (v * scale).min(255.0) as u8);
    [r, g, b, (exponent + 128).clamp(0, 255) as u8]
}

/// A row, run-length encoded component by component where its width allows.
fn write_row(bytes: &mut Vec<u8>, row: &[[u8; 4]]) {
    if !RLE_WIDTHS.contains(&row.len()) {
        bytes.extend(row.iter().flatten());
        return;
    }
    bytes.extend([2, 2, (row.len() >> 8) as u8, (row.len() & 0xff) as u8]);
    for component in 0..4 {
        let values: Vec<u8> = row.iter().map(|p| p[component]).collect();
        write_runs(bytes, &values);
    }
}

/// Shortest run worth its two bytes; longest run and longest stretch of single values.
const SHORTEST_RUN: usize = 4;
const LONGEST_RUN: usize = 127;
const LONGEST_STRETCH: usize = 128;

fn write_runs(bytes: &mut Vec<u8>, values: &[u8]) {
    let mut at = 0;
    let mut stretch = 0;
    while at < values.len() {
        let run = run_length(&values[at..]);
        if run < SHORTEST_RUN {
            at += run;
            continue;
        }
        write_stretch(bytes, &values[stretch..at]);
        bytes.extend([128 + run as u8, values[at]]);
        at += run;
        stretch = at;
    }
    write_stretch(bytes, &values[stretch..]);
}

fn run_length(values: &[u8]) -> usize {
    values.iter().take(LONGEST_RUN).take_while(|&&v| v == values[0]).count()
}

fn write_stretch(bytes: &mut Vec<u8>, values: &[u8]) {
    for part in values.chunks(LONGEST_STRETCH) {
        bytes.push(part.len() as u8);
        bytes.extend(part);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Reads what [`encode`] writes: the header's lines and the RGB of each pixel.
    pub(in crate::report) fn decode(bytes: &[u8]) -> (Vec<String>, Vec<[f64; 3]>) {
        let end = bytes.windows(2).position(|w| w == b"\n\n").unwrap();
        let header = String::from_utf8(bytes[..end].to_vec()).unwrap();
        let rest = &bytes[end + 2..];
        let line_end = rest.iter().position(|&b| b == b'\n').unwrap();
        let size = String::from_utf8(rest[..line_end].to_vec()).unwrap();
        let words: Vec<&str> = size.split(' ').collect();
        assert_eq!((words[0], words[2]), ("-Y", "+X"));
        let (height, width): (usize, usize) = (words[1].parse().unwrap(), words[3].parse().unwrap());
        let mut data = rest[line_end + 1..].iter().copied();
        let mut pixels = Vec::new();
        for _ in 0..height {
            pixels.extend(read_row(&mut data, width));
        }
        assert_eq!(data.next(), None, "nothing may follow the last row");
        (header.lines().map(str::to_owned).collect(), pixels)
    }

    fn read_row(data: &mut impl Iterator<Item = u8>, width: usize) -> Vec<[f64; 3]> {
        let mut planes = vec![Vec::new(); 4];
        if RLE_WIDTHS.contains(&width) {
            let start: Vec<u8> = data.take(4).collect();
            assert_eq!(start, [2, 2, (width >> 8) as u8, width as u8]);
            for plane in &mut planes {
                while plane.len() < width {
                    let n = usize::from(data.next().unwrap());
                    if n > 128 {
                        let v = data.next().unwrap();
                        plane.extend(std::iter::repeat_n(v, n - 128));
                    } else {
                        plane.extend(data.take(n));
                    }
                }
                assert_eq!(plane.len(), width);
            }
        } else {
            for _ in 0..width {
                planes.iter_mut().for_each(|p| p.push(data.next().unwrap()));
            }
        }
        (0..width)
            .map(|i| {
                let scale = 2f64.powi(i32::from(planes[3][i]) - 136);
                std::array::from_fn(|c| if planes[3][i] == 0 { 0.0 } else { (f64::from(planes[c][i]) + 0.5) * scale })
            })
            .collect()
    }

    proptest! {
        #[test]
        fn runs_survive(values in prop::collection::vec(prop_oneof![Just(7_u8), any::<u8>()], 8..400)) {
            let row: Vec<[u8; 4]> = values.iter().map(|&v| [v, 7, v / 3, 130]).collect();
            let mut bytes = format!("x\n\n-Y 1 +X {}\n", row.len()).into_bytes();
            write_row(&mut bytes, &row);
            let (_, pixels) = decode(&bytes);
            for (p, v) in pixels.iter().zip(&values) {
                prop_assert_eq!(p[0], (f64::from(*v) + 0.5) / 64.0);
            }
        }

        #[test]
        fn a_colour_keeps_one_percent_of_its_largest_channel(
            mantissa in prop::array::uniform3(0.0..1.0f64), power in -60..60i32
        ) {
            let rgb = mantissa.map(|v| v * 2f64.powi(power));
            let most = rgb.iter().copied().fold(0.0, f64::max);
            let [r, g, b, e] = rgbe(rgb);
            let scale = 2f64.powi(i32::from(e) - 136);
            for (v, m) in rgb.iter().zip([r, g, b]) {
                prop_assert!(((f64::from(m) + 0.5) * scale - v).abs() <= 0.005 * most);
            }
        }
    }

    #[test]
    fn the_extremes_stay_in_range() {
        assert_eq!(rgbe([0.0; 3]), [0; 4]);
        assert_eq!(rgbe([-1.0; 3]), [0; 4]);
        assert_eq!(rgbe([1.0; 3]), [127, 127, 127, 129]);
        assert_eq!(rgbe([1.0 - 1e-12; 3])[0], 255);
    }
}
