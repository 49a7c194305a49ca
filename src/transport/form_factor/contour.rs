//! Form factor between two polygons that nothing stands between, by a double contour integral.
//!
//! ```text
//! A_1 F_12 = 1/(2π) |∮∮ ln r dx_1 · dx_2|
//! ```
//! Source: Sparrow 1963; Goral, Torrance, Greenberg and Battaile 1984. The inner integral along a straight edge has a
//! closed form. The outer one is smooth where the edges lie well apart, and takes a few Gauss points; where they are
//! near each other it is split at the feet of the other edge's ends and takes a rule for singular ends.

use std::f64::consts::TAU;

use glam::DVec3;

use super::quadrature::{double_exponential, gauss_legendre};
use crate::light::{above_plane, configuration_factor};

/// Accuracy of an outer integral that needs the rule for singular ends, relative to its edge.
const ACCURACY: f64 = 1e-14;
/// Distance, in extents of both polygons, beyond which the contour integrals cancel so far that a rule over the area keeps
/// more digits: it is off by the inverse cube of this.
const FAR: f64 = 1000.0;

/// Exchange area `A_1 F_12 = A_2 F_21` of two convex planar polygons, in the square of their unit of length.
///
/// `front` and `back` of each are told by its normal: vertices counter-clockwise seen from the front, normals of unit
/// length. Only the parts in front of each other count. Nothing may stand between the two. Accurate to about 1e-10 of
/// the smaller area in any position, edges and corners in common included; far apart to about 1e-9 of the value.
#[must_use]
pub fn exchange_area(a: &[DVec3], normal_a: DVec3, b: &[DVec3], normal_b: DVec3) -> f64 {
    let (Some(&origin_a), Some(&origin_b)) = (a.first(), b.first()) else { return 0.0 };
    let (mut seen_a, mut seen_b) = (Vec::new(), Vec::new());
    // What touches the plane by rounding alone is not in front of it.
    let slack = 1e-14 * (extent(a) + extent(b) + (origin_a - origin_b).length());
    above_plane(b, normal_a, normal_a.dot(origin_a) + slack, &mut seen_b);
    above_plane(a, normal_b, normal_b.dot(origin_b) + slack, &mut seen_a);
    if seen_a.len() < 3 || seen_b.len() < 3 {
        return 0.0;
    }
    let distance = (centre(&seen_a) - centre(&seen_b)).length();
    if distance > FAR * (extent(&seen_a) + extent(&seen_b)) {
        return far(&seen_a, normal_a, &seen_b);
    }
    // A constant factor of r drops out of closed contours: logarithms near zero keep their digits.
    let scale = distance.max(extent(&seen_a));
    let mut sum = 0.0;
    for p in edges(&seen_a) {
        for q in edges(&seen_b) {
            sum += edge_pair(p, q, scale);
        }
    }
    sum.abs() / TAU
}

/// `∫ F dA` over `a` of the exact factor of `b` at a point, by the middles of the sides of triangles: exact for squares.
fn far(a: &[DVec3], normal: DVec3, b: &[DVec3]) -> f64 {
    let factor = |x: DVec3| {
        let seen: Vec<DVec3> = b.iter().map(|p| *p - x).collect();
        configuration_factor(&seen, normal)
    };
    let triangle = |e: &[DVec3]| {
        let (p, q, r) = (a[0], e[0], e[1]);
        let area = 0.5 * (q - p).cross(r - p).length();
        area * ([p + q, q + r, r + p].iter().map(|sum| factor(*sum * 0.5)).sum::<f64>() / 3.0)
    };
    a[1..].windows(2).map(triangle).sum()
}

fn edges(polygon: &[DVec3]) -> impl Iterator<Item = [DVec3; 2]> + '_ {
    (0..polygon.len()).map(|k| [polygon[k], polygon[(k + 1) % polygon.len()]])
}

fn centre(polygon: &[DVec3]) -> DVec3 {
    polygon.iter().sum::<DVec3>() / polygon.len() as f64
}

fn extent(polygon: &[DVec3]) -> f64 {
    polygon.iter().map(|p| (*p - polygon[0]).length()).fold(0.0, f64::max)
}

/// `∫∫ ln(r/scale) dx_1 · dx_2` over two straight edges.
fn edge_pair(p: [DVec3; 2], q: [DVec3; 2], scale: f64) -> f64 {
    let lengths = [(p[1] - p[0]).length(), (q[1] - q[0]).length()];
    let cosine = (p[1] - p[0]).dot(q[1] - q[0]) / (lengths[0] * lengths[1]);
    if cosine.abs() <= 1e-15 || cosine.is_nan() {
        return 0.0; // perpendicular, or without length
    }
    // The shorter edge is the smoother one to step along.
    let (outer, inner, length) = if lengths[0] <= lengths[1] { (p, q, lengths[0]) } else { (q, p, lengths[1]) };
    let along = (inner[1] - inner[0]) / lengths[0].max(lengths[1]);
    let gap = ((p[0] + p[1] - q[0] - q[1]).length() - lengths[0] - lengths[1]) * 0.5;
    let at = |t: f64| outer[0] + (outer[1] - outer[0]) * t;
    let points = match gap / length {
        r if r > 10.0 => 3,
        r if r > 3.0 => 4,
        r if r > 1.5 => 6,
        r if r > 0.7 => 10,
        _ => return cosine * length * near(outer, inner, |t| log_integral(at(t), inner, along, scale)),
    };
    let rule = gauss_legendre(points).iter();
    cosine * length * rule.map(|(t, w)| w * log_integral(at(*t), inner, along, scale)).sum::<f64>()
}

/// The outer integral over `[0, 1]`, split where the integrand comes near a singularity: at the feet of the inner edge's
/// ends and where the two lines come nearest.
fn near(outer: [DVec3; 2], inner: [DVec3; 2], f: impl Fn(f64) -> f64) -> f64 {
    let d = outer[1] - outer[0];
    let foot = |x: DVec3| (x - outer[0]).dot(d) / d.length_squared();
    let e = inner[1] - inner[0];
    let (dd, de, ee) = (d.dot(d), d.dot(e), e.dot(e));
    let w = outer[0] - inner[0];
    let denominator = dd * ee - de * de;
    let nearest = if denominator > 1e-12 * dd * ee { (de * e.dot(w) - ee * d.dot(w)) / denominator } else { 0.0 };
    let mut cuts = [0.0, foot(inner[0]), foot(inner[1]), nearest, 1.0].map(|t| t.clamp(0.0, 1.0));
    cuts.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    for pair in cuts.windows(2) {
        let width = pair[1] - pair[0];
        if width > 1e-15 {
            sum += width * double_exponential(ACCURACY, |t| f(pair[0] + width * t));
        }
    }
    sum
}

/// `∫ ln(|x − y|/scale) ds` over the points `y` of an edge with unit direction `along`.
fn log_integral(x: DVec3, edge: [DVec3; 2], along: DVec3, scale: f64) -> f64 {
    let (to_start, to_end) = (edge[0] - x, edge[1] - x);
    let (u0, u1) = (to_start.dot(along), to_end.dot(along));
    let height = (to_start - along * u0).length();
    let length = u1 - u0;
    let term = |u: f64, r2: f64| if r2 > 0.0 { 0.5 * u * (r2 / (scale * scale)).ln() } else { 0.0 };
    let angle = (height * length).atan2(height * height + u0 * u1);
    term(u1, to_end.length_squared()) - term(u0, to_start.length_squared()) - length + height * angle
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(corner: DVec3, u: DVec3, v: DVec3) -> ([DVec3; 4], DVec3) {
        ([corner, corner + u, corner + u + v, corner + v], u.cross(v).normalize())
    }

    fn factor(a: ([DVec3; 4], DVec3), b: ([DVec3; 4], DVec3)) -> f64 {
        exchange_area(&a.0, a.1, &b.0, b.1)
    }

    /// Directly opposed unit squares at distance `h` (Howell C-11 with X = Y = 1/h).
    fn opposed(h: f64) -> f64 {
        let x = 1.0 / h;
        let q = 1.0 + x * x;
        2.0 / (std::f64::consts::PI * x * x)
            * ((q * q / (1.0 + 2.0 * x * x)).sqrt().ln() + 2.0 * x * q.sqrt() * (x / q.sqrt()).atan()
                - 2.0 * x * x.atan())
    }

    #[test]
    fn opposed_squares_match_the_closed_form_at_any_distance() {
        let floor = square(DVec3::ZERO, DVec3::X, DVec3::Y);
        for h in [1e-3, 0.01, 0.1, 1.0, 3.0, 10.0, 30.0] {
            let ceiling = square(DVec3::new(0.0, 0.0, h), DVec3::Y, DVec3::X);
            let (value, exact) = (factor(floor, ceiling), opposed(h));
            // The closed form itself loses digits as h grows: its terms cancel to h^-4.
            assert!((value - exact).abs() < 1e-10 * exact.max(1e-3), "{h}: {value} against {exact}");
        }
    }

    #[test]
    fn squares_with_an_edge_in_common_match_the_closed_form() {
        // Perpendicular unit squares: closure of the cube gives (1 − F_opposed)/4 (Howell C-14).
        let floor = square(DVec3::ZERO, DVec3::X, DVec3::Y);
        let wall = square(DVec3::ZERO, DVec3::Y, DVec3::Z);
        assert!((factor(floor, wall) - 0.25 * (1.0 - opposed(1.0))).abs() < 1e-12);
    }

    #[test]
    fn a_meshed_wall_sums_to_the_whole_one() {
        let floor = square(DVec3::ZERO, DVec3::X, DVec3::Y);
        let mut sum = 0.0;
        for i in 0..9 {
            for j in 0..9 {
                let corner = DVec3::new(0.0, f64::from(i), f64::from(j)) / 9.0;
                sum += factor(floor, square(corner, DVec3::Y / 9.0, DVec3::Z / 9.0));
            }
        }
        assert!((sum - 0.25 * (1.0 - opposed(1.0))).abs() < 1e-11, "{sum}");
    }

    #[test]
    fn what_is_turned_away_or_coplanar_gets_nothing() {
        let floor = square(DVec3::ZERO, DVec3::X, DVec3::Y);
        assert_eq!(factor(floor, square(DVec3::Z, DVec3::X, DVec3::Y)), 0.0);
        assert_eq!(factor(floor, square(DVec3::X, DVec3::X, DVec3::Y)), 0.0);
    }
}
