//! Scales of false colours and axes: round numbers.

use colorous::Gradient;

use super::canvas::Colour;

/// How values become places on a colour bar.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Spacing {
    Linear,
    Logarithmic,
}

/// A range of values with its ticks and colours.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    pub(super) lo: f64,
    pub(super) hi: f64,
    pub(super) ticks: Vec<f64>,
    spacing: Spacing,
    /// Colours from the lower to the upper end.
    colours: Vec<Colour>,
}

/// Colours of a scale: as many as a screen shows along it, and no more, for equal neighbours compress well.
const COLOURS: usize = 384;
/// Most steps of a linear scale.
const STEPS: f64 = 12.0;
/// A range wider than this is shown logarithmically.
const WIDEST_LINEAR: f64 = 40.0;
/// Decades of a logarithmic scale that have ticks at 1, 2 and 5; more have them at 1 alone.
const FINE_DECADES: f64 = 3.5;
/// Lower end of a scale over a year, lx.
const LEAST_OF_YEAR_LX: f64 = 10.0;
/// Most decades that are shown.
const MOST_DECADES: i32 = 5;

impl Scale {
    /// For illuminances: linear unless the largest is far above the typical one.
    pub(super) fn illuminance(values: &[f64]) -> Self {
        let (min, max) = extremes(values);
        let typical = percentile(values, 0.5);
        if min > 0.0 && max > WIDEST_LINEAR * typical.max(min) {
            let low = percentile(values, 0.02);
            return Self::logarithmic(low, max, colorous::VIRIDIS);
        }
        Self::linear(min, max, colorous::VIRIDIS)
    }

    /// For shares, in percent.
    pub(super) fn percent() -> Self {
        Self::linear(0.0, 100.0, colorous::VIRIDIS)
    }

    /// From zero, for quantities without a usual range.
    pub(super) fn from_zero(values: &[f64]) -> Self {
        Self::linear(0.0, extremes(values).1, colorous::VIRIDIS)
    }

    /// For illuminances over a year: logarithmic, from the little that can be read by.
    pub(super) fn of_year(values: &[f64]) -> Self {
        Self::logarithmic(LEAST_OF_YEAR_LX, extremes(values).1.max(10.0 * LEAST_OF_YEAR_LX), colorous::INFERNO)
    }

    /// For luminances: logarithmic, without the darkest hundredth.
    pub(super) fn luminance(values: &[f64]) -> Self {
        let lit: Vec<f64> = values.iter().copied().filter(|&v| v > 0.0).collect();
        let (_, max) = extremes(&lit);
        Self::logarithmic(percentile(&lit, 0.01), max, colorous::TURBO)
    }

    fn linear(min: f64, max: f64, gradient: Gradient) -> Self {
        let (min, max) = if max > 0.0 { (min, max) } else { (0.0, 1.0) };
        // An even field is shown from zero, lest its noise look like a pattern.
        let from = if min > 0.5 * max && max - min > 0.05 * max { min } else { 0.0 };
        let step = round_step((max - from) / STEPS);
        let (first, last) = ((from / step).floor(), (max / step - 1e-9).ceil());
        let count = (last - first).max(1.0) as usize;
        let ticks: Vec<f64> = (0..=count).map(|i| (first + i as f64) * step).collect();
        Self { lo: ticks[0], hi: ticks[count], ticks, spacing: Spacing::Linear, colours: colours(gradient) }
    }

    fn logarithmic(low: f64, max: f64, gradient: Gradient) -> Self {
        let max = if max > 0.0 { max } else { 1.0 };
        let hi = round_up(max);
        let low = low.max(hi * 10f64.powi(-MOST_DECADES)).min(hi / 10.0);
        let lo = round_down(low);
        let fine = (hi / lo).log10() <= FINE_DECADES;
        let digits: &[f64] = if fine { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let decades = lo.log10().floor() as i32..=hi.log10().ceil() as i32;
        let ticks = decades
            .flat_map(|k| digits.iter().map(move |d| decimal(*d, k)))
            .filter(|v| *v >= lo * 0.999 && *v <= hi * 1.001)
            .collect();
        Self { lo, hi, ticks, spacing: Spacing::Logarithmic, colours: colours(gradient) }
    }

    /// Place of a value, 0 at the lower end and 1 at the upper, held there.
    pub(super) fn place(&self, v: f64) -> f64 {
        let t = match self.spacing {
            Spacing::Linear => (v - self.lo) / (self.hi - self.lo),
            Spacing::Logarithmic => (v / self.lo).max(1e-300).ln() / (self.hi / self.lo).ln(),
        };
        if t > 0.0 { t.min(1.0) } else { 0.0 }
    }

    pub(super) fn colour(&self, v: f64) -> Colour {
        self.colour_at(self.place(v))
    }

    /// Colour of a place from 0 to 1.
    pub(super) fn colour_at(&self, place: f64) -> Colour {
        self.colours[(place * (COLOURS - 1) as f64 + 0.5) as usize]
    }

    /// A tick as text.
    pub(super) fn label(&self, v: f64) -> String {
        match self.spacing {
            Spacing::Linear => with_step(v, self.ticks[1] - self.ticks[0]),
            Spacing::Logarithmic => three_digits(v),
        }
    }
}

fn colours(gradient: Gradient) -> Vec<Colour> {
    (0..COLOURS).map(|i| gradient.eval_rational(i, COLOURS).into_array()).collect()
}

/// 1, 2 or 5 times a power of ten, at least `least`.
pub(super) fn round_step(least: f64) -> f64 {
    round_up(least.max(f64::MIN_POSITIVE))
}

fn round_up(v: f64) -> f64 {
    let k = v.log10().floor() as i32;
    [decimal(1.0, k), decimal(2.0, k), decimal(5.0, k)]
        .into_iter()
        .find(|r| *r >= v * (1.0 - 1e-9))
        .unwrap_or(decimal(1.0, k + 1))
}

fn round_down(v: f64) -> f64 {
    let k = v.log10().floor() as i32;
    [decimal(5.0, k), decimal(2.0, k)].into_iter().find(|r| *r <= v * (1.0 + 1e-9)).unwrap_or(decimal(1.0, k))
}

/// `digit · 10^k` as the literal would be read.
fn decimal(digit: f64, k: i32) -> f64 {
    if k >= 0 { digit * 10f64.powi(k) } else { digit / 10f64.powi(-k) }
}

/// A multiple of `step`, with the decimals that it needs.
pub(super) fn with_step(v: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
    // Adding zero turns -0 into 0.
    let text = format!("{:.decimals$}", v + 0.0);
    if text.trim_start_matches(['-', '0', '.']).is_empty() {
        return text.trim_start_matches('-').into();
    }
    text
}

/// A number with three significant digits, without needless zeros behind the point.
pub(super) fn three_digits(v: f64) -> String {
    if v == 0.0 || !v.is_finite() {
        return "0".into();
    }
    let k = v.abs().log10().floor() as i32;
    if !(-4..7).contains(&k) {
        return format!("{v:.2e}");
    }
    let decimals = (2 - k).max(0) as usize;
    let text = format!("{v:.decimals$}");
    if decimals == 0 {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').into()
}

fn extremes(values: &[f64]) -> (f64, f64) {
    let min = values.iter().copied().reduce(f64::min).unwrap_or(0.0);
    let max = values.iter().copied().reduce(f64::max).unwrap_or(0.0);
    (min, max)
}

/// The value below which a share of the others lies; 0 if there is none.
pub(super) fn percentile(values: &[f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let mut values = values.to_vec();
    let at = ((values.len() - 1) as f64 * share).round() as usize;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_enclose_the_values() {
        for (min, max) in [(3.0, 97.0), (120.0, 980.0), (498.0, 502.0), (0.0, 0.03), (0.0, 1.0)] {
            let s = Scale::illuminance(&[min, 0.5 * (min + max), max]);
            assert!(s.lo <= min && s.hi >= max, "{s:?}");
            assert!((3..=14).contains(&s.ticks.len()), "{s:?}");
            assert!(s.ticks.is_sorted());
        }
    }

    #[test]
    fn a_few_bright_points_make_the_scale_logarithmic() {
        let mut values = vec![100.0; 100];
        values.push(50_000.0);
        let s = Scale::illuminance(&values);
        assert_eq!((s.lo, s.hi), (100.0, 50_000.0));
        assert_eq!(s.spacing, Spacing::Logarithmic);
    }

    #[test]
    fn scales_of_nothing_and_of_the_dark_are_usable() {
        for values in [vec![], vec![0.0; 4], vec![7.0; 4]] {
            for s in [Scale::illuminance(&values), Scale::luminance(&values)] {
                assert!(s.lo < s.hi && s.ticks.len() >= 2, "{s:?}");
                assert_eq!(s.place(f64::NAN), 0.0);
                assert!((0.0..=1.0).contains(&s.place(0.0)));
            }
        }
    }

    #[test]
    fn labels_are_short() {
        assert_eq!(with_step(0.30000000000000004, 0.1), "0.3");
        assert_eq!(with_step(-0.0, 0.5), "0.0");
        assert_eq!(with_step(250.0, 50.0), "250");
        assert_eq!(three_digits(1234.5), "1234");
        assert_eq!(three_digits(0.5), "0.5");
        assert_eq!(three_digits(4.126), "4.13");
        assert_eq!(three_digits(2e-6), "2.00e-6");
    }
}
