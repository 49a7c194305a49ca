//! Convex polygons in the plane of a surface.

use glam::DVec2;

/// Area of a polygon, by the shoelace formula; positive when counter-clockwise.
#[must_use]
pub fn polygon_area(polygon: &[DVec2]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    polygon.windows(2).skip(1).map(|e| (e[0] - first).perp_dot(e[1] - first)).sum::<f64>() * 0.5
}

/// The part of a convex polygon on the side `normal · (p − point) ≥ 0` (Sutherland and Hodgman 1974).
pub fn clip_halfplane(polygon: &[DVec2], point: DVec2, normal: DVec2, out: &mut Vec<DVec2>) {
    out.clear();
    let n = polygon.len();
    for (k, &a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % n];
        let (da, db) = (normal.dot(a - point), normal.dot(b - point));
        if da >= 0.0 {
            out.push(a);
        }
        if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
            out.push(a + (b - a) * (da / (da - db)));
        }
    }
}

/// The parameter interval of the segment `a..b` inside a convex counter-clockwise polygon, if longer than nothing.
#[must_use]
pub fn clip_line(polygon: &[DVec2], a: DVec2, b: DVec2) -> Option<(f64, f64)> {
    let (mut lo, mut hi) = (0.0f64, 1.0f64);
    let d = b - a;
    for (k, &p) in polygon.iter().enumerate() {
        let edge = polygon[(k + 1) % polygon.len()] - p;
        let inward = DVec2::new(-edge.y, edge.x);
        let (start, slope) = (inward.dot(a - p), inward.dot(d));
        if slope.abs() <= 1e-14 * edge.length() {
            if start < 0.0 {
                return None;
            }
        } else if slope > 0.0 {
            lo = lo.max(-start / slope);
        } else {
            hi = hi.min(-start / slope);
        }
    }
    (lo < hi).then_some((lo, hi))
}

/// Maps a point of the unit square to a convex polygon, uniformly in area.
///
/// `x` chooses the triangle of the fan and its place across, `y` the place along: strata of the square stay
/// strata of the polygon.
#[must_use]
pub fn sample_polygon(polygon: &[DVec2], x: f64, y: f64) -> DVec2 {
    let first = polygon[0];
    if let [_, b, c, d] = *polygon
        && (first + c - b - d).abs().max_element() < 1e-12
    {
        return first + (b - first) * x + (d - first) * y; // parallelogram: the common case
    }
    let total = polygon_area(polygon);
    let mut want = x * total;
    let last = polygon.len() - 2;
    for k in 1..=last {
        let (p, q) = (polygon[k] - first, polygon[k + 1] - first);
        let area = 0.5 * p.perp_dot(q);
        if want <= area || k == last {
            let s = if area > 0.0 { (want / area).clamp(0.0, 1.0) } else { 0.0 };
            let root = y.sqrt();
            return first + (p * (1.0 - s) + q * s) * root;
        }
        want -= area;
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hexagon() -> Vec<DVec2> {
        (0..6).map(|k| DVec2::from_angle(f64::from(k) * std::f64::consts::FRAC_PI_3)).collect()
    }

    #[test]
    fn halves_of_a_polygon_sum_to_the_whole() {
        let (mut left, mut right) = (Vec::new(), Vec::new());
        let (p, n) = (DVec2::new(0.1, 0.2), DVec2::new(0.6, -0.8));
        clip_halfplane(&hexagon(), p, n, &mut left);
        clip_halfplane(&hexagon(), p, -n, &mut right);
        let whole = polygon_area(&hexagon());
        assert!((polygon_area(&left) + polygon_area(&right) - whole).abs() < 1e-12, "{whole}");
    }

    #[test]
    fn samples_have_the_centroid_of_the_polygon() {
        let n = 64;
        let triangle = [DVec2::ZERO, DVec2::new(3.0, 0.0), DVec2::new(0.0, 3.0)];
        let mut mean = DVec2::ZERO;
        for i in 0..n {
            for j in 0..n {
                let p = sample_polygon(&triangle, (f64::from(i) + 0.5) / 64.0, (f64::from(j) + 0.5) / 64.0);
                mean += p / f64::from(n * n);
            }
        }
        // Midpoint rule: the integrand sqrt(y) has an error of order n^-3/2.
        assert!((mean - DVec2::ONE).length() < 2e-3, "{mean}");
    }
}
