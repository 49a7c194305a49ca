//! Reflectances as users give them: a number, three numbers, a curve.
//!
//! Three numbers become a curve by the sigmoid of Jakob and Hanika 2019 ("A Low-Dimensional Function Space for
//! Efficient Spectral Upsampling"), fitted to each colour when it is loaded.

use std::sync::LazyLock;

use super::colour::{Matrix, apply, inverse, linear_srgb};
use super::{Beyond, Spectrum, cie, illuminant};

/// A reflectance or transmittance as the user gave it.
#[derive(Clone, Debug)]
pub enum SpectralValue {
    /// The same at every wavelength.
    Grey(f64),
    /// Linear Rec.709 under D65; white is (1, 1, 1).
    Rgb([f64; 3]),
    /// A curve.
    Spectrum(Spectrum),
}

impl SpectralValue {
    /// The value as a curve. An RGB value is clamped to 0 to 1 first; its curve stays within 0 to 1 and has the
    /// given colour under D65 to 1e-3.
    #[must_use]
    pub fn to_spectrum(&self) -> Spectrum {
        match self {
            Self::Grey(v) => Spectrum::constant(*v),
            Self::Rgb(rgb) => from_rgb(*rgb),
            Self::Spectrum(s) => s.clone(),
        }
    }

    /// The largest number given.
    #[must_use]
    pub fn max(&self) -> f64 {
        match self {
            Self::Grey(v) => *v,
            Self::Rgb(rgb) => rgb.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            Self::Spectrum(s) => s.max(),
        }
    }

    /// The smallest number given.
    #[must_use]
    pub fn min(&self) -> f64 {
        match self {
            Self::Grey(v) => *v,
            Self::Rgb(rgb) => rgb.iter().copied().fold(f64::INFINITY, f64::min),
            Self::Spectrum(s) => s.min(),
        }
    }

    /// Is it the same at every wavelength?
    #[must_use]
    pub fn is_grey(&self) -> bool {
        match self {
            Self::Grey(_) => true,
            Self::Rgb([r, g, b]) => r == g && g == b,
            Self::Spectrum(s) => s.is_constant(),
        }
    }
}

/// Knots of the fitted curves: 360, 365, … 830 nm.
const KNOTS: usize = 95;
const STEP_NM: f64 = 5.0;

/// One value per knot.
type Curve = [f64; KNOTS];

/// Above this the sigmoid alone is not good enough, and the curve is corrected.
const GOOD: f64 = 1e-6;

/// Rows R, G, B: linear Rec.709 under D65 of a curve through the knots is this matrix times its values, each
/// channel against that of a perfect white.
static TO_RGB: LazyLock<[Curve; 3]> = LazyLock::new(|| {
    let light = illuminant("D65").unwrap_or_else(|| Spectrum::constant(1.0));
    let mut rows = [[0.0; KNOTS]; 3];
    for (nm, w) in cie::nodes(cie::FIRST_NM, cie::LAST_NM, &[light.knots_nm()]) {
        let rgb = linear_srgb(cie::cmf(nm).map(|c| w * light.at(nm) * c));
        let place = (nm - cie::FIRST_NM) / STEP_NM;
        let left = (place as usize).min(KNOTS - 2);
        let t = place - left as f64;
        for (row, v) in rows.iter_mut().zip(rgb) {
            row[left] += v * (1.0 - t);
            row[left + 1] += v * t;
        }
    }
    rows.map(|row| {
        let white: f64 = row.iter().sum();
        row.map(|v| v / white)
    })
});

fn rgb_of(curve: &Curve) -> [f64; 3] {
    std::array::from_fn(|c| TO_RGB[c].iter().zip(curve).map(|(a, s)| a * s).sum())
}

fn from_rgb(rgb: [f64; 3]) -> Spectrum {
    // The comparison turns NaN into black.
    let target = rgb.map(|v| if v > 0.0 { v.min(1.0) } else { 0.0 });
    if target[0] == target[1] && target[1] == target[2] {
        return Spectrum::constant(target[0]);
    }
    let curve = corrected(sigmoid_fit(target), target);
    let nm = (0..KNOTS).map(|i| cie::FIRST_NM + STEP_NM * i as f64);
    Spectrum::from_knots(nm.collect(), curve.to_vec(), Beyond::Hold)
}

/// Steps from grey to the colour. Each starts from the last one's curve, so that saturated colours converge.
const WAY: usize = 4;
const ITERATIONS: usize = 12;
/// |x| beyond this is 0 or 1 to 1e-7; larger coefficients only spoil the next step's slopes.
const MOST_COEFFICIENT: f64 = 1e4;

/// The curve `S = 1/2 + x/(2 √(1 + x²))`, `x = c0 + c1 t + c2 t²`, nearest to the colour: Gauss-Newton with
/// Levenberg's damping.
fn sigmoid_fit(target: [f64; 3]) -> Curve {
    let grey = (target.iter().sum::<f64>() / 3.0).clamp(0.02, 0.98);
    let mut c = [(grey - 0.5) / (grey * (1.0 - grey)).sqrt(), 0.0, 0.0];
    for step in 1..=WAY {
        let share = step as f64 / WAY as f64;
        let goal = target.map(|v| grey + share * (v - grey));
        c = fit_from(c, goal);
    }
    sigmoid(&c).0
}

fn fit_from(mut c: [f64; 3], goal: [f64; 3]) -> [f64; 3] {
    let miss = |curve: &Curve| {
        let rgb = rgb_of(curve);
        std::array::from_fn::<f64, 3, _>(|k| goal[k] - rgb[k])
    };
    let norm = |r: &[f64; 3]| r.iter().map(|v| v * v).sum::<f64>();
    let (mut curve, mut slope) = sigmoid(&c);
    let mut residual = miss(&curve);
    let mut damping = 1e-4;
    for _ in 0..ITERATIONS {
        if norm(&residual) < 1e-20 {
            break;
        }
        let trial = step_from(c, &slope, residual, damping);
        let (next, next_slope) = sigmoid(&trial);
        let next_residual = miss(&next);
        if norm(&next_residual) < norm(&residual) {
            (c, curve, slope, residual) = (trial, next, next_slope, next_residual);
            damping *= 0.1;
        } else {
            damping *= 10.0;
        }
    }
    debug_assert!(curve.iter().all(|v| v.is_finite()));
    c
}

/// One damped Gauss-Newton step.
fn step_from(c: [f64; 3], slope: &Curve, residual: [f64; 3], damping: f64) -> [f64; 3] {
    let mut jacobian = [[0.0; 3]; 3];
    for (i, s) in slope.iter().enumerate() {
        let t = scaled_place(i);
        for (row, to_rgb) in jacobian.iter_mut().zip(TO_RGB.iter()) {
            for (power, entry) in row.iter_mut().enumerate() {
                *entry += to_rgb[i] * s * t.powi(power as i32);
            }
        }
    }
    let step = damped_solve(&jacobian, residual, damping);
    std::array::from_fn(|k| (c[k] + step[k]).clamp(-MOST_COEFFICIENT, MOST_COEFFICIENT))
}

/// Least squares `(JᵀJ + d diag(JᵀJ)) step = Jᵀ r`.
fn damped_solve(j: &Matrix, r: [f64; 3], damping: f64) -> [f64; 3] {
    let mut normal: Matrix = std::array::from_fn(|a| std::array::from_fn(|b| (0..3).map(|k| j[k][a] * j[k][b]).sum()));
    for (k, row) in normal.iter_mut().enumerate() {
        row[k] += damping * row[k] + 1e-18;
    }
    let right = std::array::from_fn(|a| (0..3).map(|k| j[k][a] * r[k]).sum());
    let step = apply(&inverse(&normal), right);
    step.map(|v| if v.is_finite() { v } else { 0.0 })
}

/// Wavelength of a knot, scaled to -1 to 1.
fn scaled_place(knot: usize) -> f64 {
    2.0 * knot as f64 / (KNOTS - 1) as f64 - 1.0
}

/// The sigmoid at the knots and its derivative by x.
fn sigmoid(c: &[f64; 3]) -> (Curve, Curve) {
    let (mut value, mut slope) = ([0.0; KNOTS], [0.0; KNOTS]);
    for i in 0..KNOTS {
        let t = scaled_place(i);
        let x = c[0] + t * (c[1] + t * c[2]);
        let root = (1.0 + x * x).sqrt();
        value[i] = 0.5 + 0.5 * x / root;
        slope[i] = 0.5 / (root * root * root);
    }
    (value, slope)
}

/// The curve within 0 to 1 that has the colour and lies nearest to `start`.
///
/// Colours at the rim of the gamut are reached by the sigmoid only with infinite coefficients. The nearest
/// curve is `clamp(start + Aᵀ y)` with three unknowns y, found by a damped Newton iteration.
fn corrected(start: Curve, target: [f64; 3]) -> Curve {
    let mut y = [0.0; 3];
    let mut best = start;
    let mut least = f64::INFINITY;
    for _ in 0..40 {
        let (curve, free) = shifted(&start, &y);
        let rgb = rgb_of(&curve);
        let miss: [f64; 3] = std::array::from_fn(|k| target[k] - rgb[k]);
        let size = miss.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        if size < least {
            (best, least) = (curve, size);
        }
        if size < GOOD {
            break;
        }
        let normal: Matrix = std::array::from_fn(|a| {
            std::array::from_fn(|b| {
                let ridge = if a == b { 1e-9 } else { 0.0 };
                (0..KNOTS).filter(|&i| free[i]).map(|i| TO_RGB[a][i] * TO_RGB[b][i]).sum::<f64>() + ridge
            })
        });
        let step = apply(&inverse(&normal), miss);
        for k in 0..3 {
            y[k] += step[k].clamp(-MOST_SHIFT, MOST_SHIFT);
        }
    }
    best
}

/// Longest step of the dual variables in [`corrected`]; a curve moves by at most 1, and the rows are about 0.03.
const MOST_SHIFT: f64 = 10.0;

/// `clamp(start + Aᵀ y)` and which knots are strictly inside.
fn shifted(start: &Curve, y: &[f64; 3]) -> (Curve, [bool; KNOTS]) {
    let mut free = [false; KNOTS];
    let curve = std::array::from_fn(|i| {
        let v = start[i] + (0..3).map(|c| TO_RGB[c][i] * y[c]).sum::<f64>();
        free[i] = v > 0.0 && v < 1.0;
        v.clamp(0.0, 1.0)
    });
    (curve, free)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::colour::reflectance_rgb;
    use super::*;

    fn worst_round_trip(rgb: [f64; 3]) -> f64 {
        let s = SpectralValue::Rgb(rgb).to_spectrum();
        assert!(s.min() >= 0.0 && s.max() <= 1.0, "{rgb:?}");
        let back = reflectance_rgb(&s, &illuminant("D65").unwrap()).unwrap();
        (0..3).fold(0.0, |m, c| f64::max(m, (back[c] - rgb[c]).abs()))
    }

    #[test]
    fn the_whole_rgb_cube_survives_the_round_trip() {
        let mut worst = (0.0, [0.0; 3]);
        // Sixteen even levels, and both ends of the scale more closely.
        let mut levels: Vec<f64> = (0..16).map(|i| f64::from(i) / 15.0).collect();
        levels.extend([1e-3, 0.02, 0.98, 0.999]);
        for &r in &levels {
            for &g in &levels {
                for &b in &levels {
                    let miss = worst_round_trip([r, g, b]);
                    if miss > worst.0 {
                        worst = (miss, [r, g, b]);
                    }
                }
            }
        }
        assert!(worst.0 < 1e-3, "{worst:?}");
    }

    #[test]
    fn grey_rgb_is_a_flat_curve() {
        for v in [0.0, 0.18, 1.0] {
            let value = SpectralValue::Rgb([v; 3]);
            assert!(value.is_grey());
            assert_eq!(value.to_spectrum(), Spectrum::constant(v));
        }
    }

    #[test]
    fn values_out_of_range_give_a_physical_curve() {
        for rgb in [[2.0, -1.0, 0.5], [f64::NAN, 0.5, 0.2], [f64::INFINITY; 3]] {
            let s = SpectralValue::Rgb(rgb).to_spectrum();
            assert!(s.min() >= 0.0 && s.max() <= 1.0, "{rgb:?}");
        }
    }

    proptest! {
        #[test]
        fn any_colour_survives_the_round_trip(rgb in prop::array::uniform3(0.0..=1.0f64)) {
            prop_assert!(worst_round_trip(rgb) < 1e-3);
        }
    }
}
