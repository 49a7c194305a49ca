//! Uniform colour spaces and differences in them.

use super::uv_prime;

/// Where the cube root of CIE 15:2018, eq. 8.6, gives way to a straight line, and the slope of that line.
const EPSILON: f64 = 216.0 / 24389.0;
const KAPPA: f64 = 24389.0 / 27.0;

/// CIE 1976 lightness of Y over the Y of white.
fn lightness(y: f64) -> f64 {
    if y > EPSILON { 116.0 * y.cbrt() - 16.0 } else { KAPPA * y }
}

/// CIE 1976 L*, a*, b* of XYZ against a white (CIE 15:2018, section 8.2.1).
#[must_use]
pub fn lab(xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    let [fx, fy, fz] = std::array::from_fn(|k| (lightness(xyz[k] / white[k]) + 16.0) / 116.0);
    [116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)]
}

/// CIE 1976 L*, u*, v* of XYZ against a white (CIE 15:2018, section 8.2.2). Black has no chromaticity: it is 0, 0, 0.
#[must_use]
pub fn luv(xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    let l = lightness(xyz[1] / white[1]);
    match (uv_prime(xyz), uv_prime(white)) {
        (Some([u, v]), Some([un, vn])) => [l, 13.0 * l * (u - un), 13.0 * l * (v - vn)],
        _ => [l, 0.0, 0.0],
    }
}

/// 25⁷, the chroma at which CIEDE2000's corrections of the blue region are half done.
const CHROMA_7: f64 = 6_103_515_625.0;

/// Colour difference CIEDE2000 of two colours in L*, a*, b*, with k_L = k_C = k_H = 1 (ISO/CIE 11664-6:2022; the cases of
/// hue as Sharma, Wu and Dalal 2005 state them).
#[must_use]
pub fn ciede2000(one: [f64; 3], two: [f64; 3]) -> f64 {
    let bent = |c: f64| (c.powi(7) / (c.powi(7) + CHROMA_7)).sqrt();
    let mean_chroma = 0.5 * (one[1].hypot(one[2]) + two[1].hypot(two[2]));
    let g = 0.5 * (1.0 - bent(mean_chroma));
    let polar = |c: [f64; 3]| {
        let a = (1.0 + g) * c[1];
        let hue = if a == 0.0 && c[2] == 0.0 { 0.0 } else { c[2].atan2(a).to_degrees().rem_euclid(360.0) };
        (c[0], a.hypot(c[2]), hue)
    };
    let ((l1, c1, h1), (l2, c2, h2)) = (polar(one), polar(two));
    let (difference_deg, mean_deg) = hues(c1 * c2, h1, h2);
    let (l, c) = (0.5 * (l1 + l2), 0.5 * (c1 + c2));
    let cos_deg = |v: f64| v.to_radians().cos();
    let t =
        1.0 - 0.17 * cos_deg(mean_deg - 30.0) + 0.24 * cos_deg(2.0 * mean_deg) + 0.32 * cos_deg(3.0 * mean_deg + 6.0)
            - 0.20 * cos_deg(4.0 * mean_deg - 63.0);
    let s_l = 1.0 + 0.015 * (l - 50.0).powi(2) / (20.0 + (l - 50.0).powi(2)).sqrt();
    let (s_c, s_h) = (1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let turn_deg = 60.0 * (-((mean_deg - 275.0) / 25.0).powi(2)).exp();
    let r_t = -2.0 * bent(c) * turn_deg.to_radians().sin();
    let hue = 2.0 * (c1 * c2).sqrt() * (0.5 * difference_deg).to_radians().sin();
    let (dl, dc, dh) = ((l2 - l1) / s_l, (c2 - c1) / s_c, hue / s_h);
    (dl * dl + dc * dc + dh * dh + r_t * dc * dh).max(0.0).sqrt()
}

/// Difference (second less first, the short way) and mean of two hues, degrees; without chroma there is no hue.
fn hues(chromas: f64, h1: f64, h2: f64) -> (f64, f64) {
    if chromas == 0.0 {
        return (0.0, h1 + h2);
    }
    let plain = h2 - h1;
    if plain.abs() <= 180.0 {
        return (plain, 0.5 * (h1 + h2));
    }
    let short = if plain > 180.0 { plain - 360.0 } else { plain + 360.0 };
    let around = if h1 + h2 < 360.0 { 360.0 } else { -360.0 };
    (short, 0.5 * (h1 + h2 + around))
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: [f64; 3] = [0.95047, 1.0, 1.08883];

    #[test]
    fn the_scales_run_from_black_to_white() {
        for space in [lab, luv] {
            let (black, white) = (space([0.0; 3], WHITE), space(WHITE, WHITE));
            assert!(black.iter().all(|v| v.abs() < 1e-12), "{black:?}");
            assert!((white[0] - 100.0).abs() < 1e-12 && white[1].hypot(white[2]) < 1e-10, "{white:?}");
            // The middle grey of 18.42 % is L* = 50 by definition: ((50 + 16)/116)³.
            let grey = WHITE.map(|v| v * (66.0f64 / 116.0).powi(3));
            assert!((space(grey, WHITE)[0] - 50.0).abs() < 1e-12);
        }
    }

    #[test]
    fn ciede2000_has_the_published_differences() {
        // Sharma, Wu and Dalal 2005, table 1, pairs 1, 7, 10, 17, 25, 31 and 34: those that find slips.
        let pairs = [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.001], 7.1792),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
            ([36.2715, 1.0, 0.0], [36.2715, 1.0, 0.0], 0.0),
            ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
        ];
        for (one, two, published) in pairs {
            for ours in [ciede2000(one, two), ciede2000(two, one)] {
                assert!((ours - published).abs() < 6e-5, "{one:?} {two:?}: {ours}, published {published}");
            }
        }
    }
}
