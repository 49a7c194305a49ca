//! The horizontal illuminance of a sky, by quadrature in polar coordinates about the sun.
//!
//! A sky has a cusp at the sun: `exp(d χ)` with `χ` the distance from it. In polar coordinates about the sun that is a
//! smooth function of the radius, and Gauss's rule converges to rounding.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

/// Points of a panel. Doubling them moves no CIE sky by more than 1e-9.
const POINTS: usize = 64;
/// The same where thousands of skies are wanted.
const FEW_POINTS: usize = 20;

/// How finely a sky is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    Fine,
    Quick,
}

/// `∫ L(cos Z, f(cos χ)) cos Z dω` over the upper hemisphere, `cos Zs` being the sun's height `sun_z`.
pub(super) fn horizontal(
    indicatrix: impl Fn(f64) -> f64,
    luminance: impl Fn(f64, f64) -> f64,
    sun_z: f64,
    rule: Rule,
) -> f64 {
    static FINE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(POINTS));
    static QUICK: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(FEW_POINTS));
    let rule: &[(f64, f64)] = if rule == Rule::Fine { &FINE } else { &QUICK };
    let sun_z = sun_z.clamp(0.0, 1.0);
    let (sun_r, altitude) = ((1.0 - sun_z * sun_z).sqrt(), sun_z.asin());
    // Circles about the sun lie whole above the horizon up to its altitude, and in part up to the far horizon.
    let panels = [(0.0, altitude), (altitude, FRAC_PI_2), (FRAC_PI_2, PI - altitude)];
    panels
        .into_iter()
        .map(|panel| {
            integrate(rule, panel, |chi| {
                let (sine, cosine) = chi.sin_cos();
                let along = cosine * sun_z;
                let across = sine * sun_r;
                let on_ring = indicatrix(cosine);
                let reach = if along >= across { PI } else { (-along / across).clamp(-1.0, 1.0).acos() };
                let ring = integrate(rule, (0.0, reach), |psi| {
                    let height = (along + across * psi.cos()).max(0.0);
                    height * luminance(height, on_ring)
                });
                2.0 * ring * sine
            })
        })
        .sum()
}

/// Gauss's rule after `x → x²(3 − 2x)`, which takes away square roots at both ends.
fn integrate(rule: &[(f64, f64)], (from, to): (f64, f64), f: impl Fn(f64) -> f64) -> f64 {
    let length = to - from;
    rule.iter()
        .map(|(x, w)| {
            let place = x * x * (3.0 - 2.0 * x);
            w * 6.0 * x * (1.0 - x) * length * f(from + length * place)
        })
        .sum()
}

/// Nodes and weights on `[0, 1]`, by Newton's method on the Legendre polynomial.
fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|k| {
            let mut x = (PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let (mut before, mut p) = (0.0, 1.0);
                for j in 0..n {
                    let j = j as f64;
                    (before, p) = (p, ((2.0 * j + 1.0) * x * p - j * before) / (j + 1.0));
                }
                slope = n as f64 * (x * p - before) / (x * x - 1.0);
                let step = p / slope;
                x -= step;
                if step.abs() < 1e-15 {
                    break;
                }
            }
            (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_is_exact_for_polynomials() {
        let rule = gauss_legendre(8);
        for power in 0..16 {
            let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power)).sum();
            assert!((sum - 1.0 / f64::from(power + 1)).abs() < 1e-14, "{power}");
        }
    }

    #[test]
    fn a_cusp_at_the_sun_is_integrated_wherever_it_stands() {
        // With the sun at the zenith χ = Z: 2π ∫ exp(−d χ) sin χ cos χ dχ = 2π (1 + exp(−d π/2)) / (4 + d²).
        let d = 3.0f64;
        let exact = 2.0 * PI * (1.0 + (-d * FRAC_PI_2).exp()) / (4.0 + d * d);
        let found = horizontal(|toward| (-d * toward.clamp(-1.0, 1.0).acos()).exp(), |_, f| f, 1.0, Rule::Fine);
        assert!((found / exact - 1.0).abs() < 1e-12, "{found} {exact}");
        // cos² about an axis at altitude h: π/4 (1 + sin² h), from the closed form of the second moment.
        for h in [0.0f64, 0.2, 0.8, 1.5] {
            let found = horizontal(|toward| toward * toward, |_, f| f, h.sin(), Rule::Fine);
            let exact = PI / 4.0 * (1.0 + h.sin().powi(2));
            assert!((found / exact - 1.0).abs() < 1e-10, "{h}: {found} {exact}");
        }
    }
}
