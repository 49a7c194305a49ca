//! Colour rendering index of light sources, CIE 13.3-1995.

use super::super::cie::{Observer, sum};
use super::super::illuminant::{LEAST_PHASE_K, black_body, daylight};
use super::super::tables::test_colours::SAMPLES;
use super::super::{Beyond, Spectrum};
use super::{cct, uv_1960, xy};

/// Where the standard sums, nm: range and step.
const SUM_NM: (f64, f64, f64) = (380.0, 780.0, 5.0);

/// How well a light shows colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rendering {
    /// General colour rendering index Ra: mean of the first eight special ones.
    pub ra: f64,
    /// Special colour rendering indices R1 to R14.
    pub special: [f64; 14],
}

/// What the eye makes of a light and of the samples under it.
struct Seen {
    /// Chromaticity of the light, CIE 1960.
    light: [f64; 2],
    /// Chromaticity and Y of each sample, Y of the light being 100.
    samples: [([f64; 2], f64); 14],
}

/// Colour rendering indices; `None` of a light without a colour temperature from 1000 to 25000 K.
#[must_use]
pub fn rendering(light: &Spectrum) -> Option<Rendering> {
    let (lo, hi, step) = SUM_NM;
    let kelvin = cct(xy(sum(Observer::Cie1931, &[light], lo, hi, step))?)?.kelvin;
    let reference = if kelvin < LEAST_PHASE_K { black_body(kelvin) } else { daylight(kelvin) };
    let (tested, reference) = (Seen::under(light)?, Seen::under(&reference)?);
    let special: [f64; 14] = std::array::from_fn(|i| {
        let one = uniform(reference.samples[i].0, reference.samples[i].1, reference.light);
        let moved = adapted(tested.samples[i].0, tested.light, reference.light);
        let two = uniform(moved, tested.samples[i].1, reference.light);
        let distance = (0..3).map(|k| (one[k] - two[k]).powi(2)).sum::<f64>().sqrt();
        100.0 - 4.6 * distance
    });
    Some(Rendering { ra: special[..8].iter().sum::<f64>() / 8.0, special })
}

impl Seen {
    fn under(light: &Spectrum) -> Option<Self> {
        let (lo, hi, step) = SUM_NM;
        let white = sum(Observer::Cie1931, &[light], lo, hi, step);
        let mut samples = [([0.0; 2], 0.0); 14];
        for (i, seen) in samples.iter_mut().enumerate() {
            let xyz = sum(Observer::Cie1931, &[light, &sample(i)], lo, hi, step);
            *seen = (uv_1960(xy(xyz)?), 100.0 * xyz[1] / white[1]);
        }
        Some(Self { light: uv_1960(xy(white)?), samples })
    }
}

/// Test colour sample `i`, counted from 0.
fn sample(i: usize) -> Spectrum {
    let (lo, _, step) = SUM_NM;
    let nm = (0..SAMPLES.len()).map(|k| lo + step * k as f64).collect();
    Spectrum::from_knots(nm, SAMPLES.iter().map(|row| row[i]).collect(), Beyond::Hold)
}

/// Chromaticity of a sample after the eye has gone from the tested light to the reference (CIE 13.3, section 5.7).
fn adapted(sample: [f64; 2], tested: [f64; 2], reference: [f64; 2]) -> [f64; 2] {
    let cd = |[u, v]: [f64; 2]| [(4.0 - u - 10.0 * v) / v, (1.708 * v + 0.404 - 1.481 * u) / v];
    let (s, t, r) = (cd(sample), cd(tested), cd(reference));
    let [c, d]: [f64; 2] = std::array::from_fn(|k| r[k] / t[k] * s[k]);
    let below = 16.518 + 1.481 * c - d;
    [(10.872 + 0.404 * c - 4.0 * d) / below, 5.520 / below]
}

/// CIE 1964 W*, U*, V* against the reference light.
fn uniform(sample: [f64; 2], y: f64, light: [f64; 2]) -> [f64; 3] {
    let w = 25.0 * y.cbrt() - 17.0;
    [w, 13.0 * w * (sample[0] - light[0]), 13.0 * w * (sample[1] - light[1])]
}

#[cfg(test)]
mod tests {
    use super::super::super::illuminant;
    use super::*;

    #[test]
    fn a_reference_light_renders_perfectly() {
        for light in [black_body(2700.0), daylight(6500.0)] {
            let found = rendering(&light).unwrap();
            // The 5 nm sums move the colour temperature a little away from the one that the light was made for.
            assert!(found.special.iter().all(|r| *r > 99.9), "{found:?}");
        }
    }

    #[test]
    fn fluorescent_lamps_have_their_published_index() {
        // CIE 15:2018, table 11: general colour rendering index of FL 1 to FL 12, in whole numbers.
        for (i, ra) in [76, 64, 57, 51, 72, 59, 90, 95, 90, 81, 83, 83].iter().enumerate() {
            let name = format!("F{}", i + 1);
            let ours = rendering(&illuminant(&name).unwrap()).unwrap().ra;
            assert!((ours - f64::from(*ra)).abs() <= 0.6, "{name}: {ours}, published {ra}");
        }
    }

    #[test]
    fn coloured_light_has_no_index() {
        let red = Spectrum::new(vec![640.0, 650.0], vec![1.0, 1.0], Beyond::Zero).unwrap();
        assert_eq!(rendering(&red), None);
    }
}
