//! Rules of integration on the unit interval.

use std::sync::LazyLock;

/// Points with weights that sum to one.
pub(super) type Rule = Vec<(f64, f64)>;

/// Largest Gauss rule in use.
const MOST: usize = 16;

static GAUSS: LazyLock<Vec<Rule>> = LazyLock::new(|| (0..=MOST).map(gauss).collect());

/// The Gauss–Legendre rule of `n` points, `1 ≤ n ≤ 16`: exact for polynomials of degree `2n − 1`.
pub(super) fn gauss_legendre(n: usize) -> &'static [(f64, f64)] {
    &GAUSS[n.clamp(1, MOST)]
}

/// Roots of the Legendre polynomial by Newton's method from Tricomi's guess; weights `2/((1 − x²) P'²)`.
fn gauss(n: usize) -> Rule {
    let order = n as f64;
    (0..n)
        .map(|k| {
            let mut x = -(std::f64::consts::PI * (k as f64 + 0.75) / (order + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..20 {
                let (mut before, mut value) = (1.0, x);
                for m in 2..=n {
                    let m = m as f64;
                    (before, value) = (value, ((2.0 * m - 1.0) * x * value - (m - 1.0) * before) / m);
                }
                slope = order * (x * value - before) / (x * x - 1.0);
                let step = value / slope;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Levels of the double-exponential rule: each halves the step.
const LEVELS: usize = 6;
/// Beyond this argument the weights are below rounding.
const REACH: f64 = 3.2;

/// New points of each level, as distance from the nearer end, end (0 or 1), and weight for a step of one.
static DOUBLE_EXPONENTIAL: LazyLock<Vec<Vec<(f64, bool, f64)>>> = LazyLock::new(|| {
    (0..LEVELS)
        .map(|level| {
            let step = 0.5f64.powi(level as i32 + 1);
            let count = (REACH / step) as i32;
            (-count..=count)
                .filter(|k| level == 0 || k % 2 != 0)
                .map(|k| {
                    let t = f64::from(k) * step;
                    let u = std::f64::consts::FRAC_PI_2 * t.sinh();
                    let weight = std::f64::consts::FRAC_PI_4 * t.cosh() / u.cosh().powi(2);
                    // 1 − tanh without cancellation.
                    let from_end = 1.0 / (1.0 + (2.0 * u.abs()).exp());
                    (from_end, t > 0.0, weight)
                })
                .collect()
        })
        .collect()
});

/// `∫₀¹ f` by the double-exponential rule (Takahasi and Mori 1974), refined until it changes by less than `accuracy`:
/// right for integrands with any integrable trouble at the ends.
pub(super) fn double_exponential(accuracy: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let mut sum = 0.0;
    let mut last = f64::INFINITY;
    for (level, points) in DOUBLE_EXPONENTIAL.iter().enumerate() {
        for (from_end, at_one, weight) in points {
            sum += weight * f(if *at_one { 1.0 - from_end } else { *from_end });
        }
        let value = sum * 0.5f64.powi(level as i32 + 1);
        if (value - last).abs() <= accuracy {
            return value;
        }
        last = value;
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_rules_are_exact_for_their_degree() {
        for n in 1..=MOST {
            for power in 0..2 * n as i32 {
                let value: f64 = gauss_legendre(n).iter().map(|(x, w)| w * x.powi(power)).sum();
                assert!((value - 1.0 / f64::from(power + 1)).abs() < 1e-14, "{n} points, x^{power}: {value}");
            }
        }
    }

    #[test]
    fn singular_ends_are_integrated() {
        // ∫ ln x = −1, ∫ √(1 − x) = 2/3.
        let value = double_exponential(1e-14, |x| x.ln() + (1.0 - x).sqrt());
        assert!((value + 1.0 / 3.0).abs() < 1e-12, "{value}");
    }
}
