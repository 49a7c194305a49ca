//! The configuration factor of a polygon: irradiance at a point per unit exitance of the polygon.

use glam::DVec3;

/// Lambert's formula (1760): `E/M = 1/(2π) Σ_k θ_k n·g_k`.
///
/// `polygon` holds the vertices as seen from the point (which is the origin), all in front of the point's plane;
/// `normal` is the point's unit normal. Exact up to rounding for any planar polygon; positive when the polygon is
/// wound clockwise as seen from the point, so callers take the absolute value of whole, convex polygons.
#[must_use]
pub fn configuration_factor(polygon: &[DVec3], normal: DVec3) -> f64 {
    let mut sum = 0.0;
    let Some(&last) = polygon.last() else { return 0.0 };
    let mut a = last;
    for &b in polygon {
        let cross = a.cross(b);
        let sine = cross.length();
        if sine > 1e-300 {
            // atan2 keeps its digits where acos loses them.
            sum += sine.atan2(a.dot(b)) * normal.dot(cross) / sine;
        }
        a = b;
    }
    (sum / std::f64::consts::TAU).abs()
}

/// The part of a polygon above the plane through the origin with normal `normal`.
pub fn above_plane(polygon: &[DVec3], normal: DVec3, offset: f64, out: &mut Vec<DVec3>) {
    out.clear();
    let Some(&last) = polygon.last() else { return };
    let mut a = last;
    let mut da = normal.dot(a) - offset;
    for &b in polygon {
        let db = normal.dot(b) - offset;
        if (da > 0.0) != (db > 0.0) {
            out.push(a + (b - a) * (da / (da - db)));
        }
        if db > 0.0 {
            out.push(b);
        }
        (a, da) = (b, db);
    }
}

/// Both parts of a polygon that a plane through the origin cuts.
pub fn divide_by_plane(polygon: &[DVec3], normal: DVec3, above: &mut Vec<DVec3>, below: &mut Vec<DVec3>) {
    above.clear();
    below.clear();
    let Some(&last) = polygon.last() else { return };
    let mut a = last;
    let mut da = normal.dot(a);
    for &b in polygon {
        let db = normal.dot(b);
        if (da > 0.0) != (db > 0.0) || (da < 0.0) != (db < 0.0) {
            let cut = a + (b - a) * (da / (da - db));
            if (da > 0.0) != (db > 0.0) {
                above.push(cut);
            }
            if (da < 0.0) != (db < 0.0) {
                below.push(cut);
            }
        }
        if db > 0.0 {
            above.push(b);
        } else if db < 0.0 {
            below.push(b);
        }
        (a, da) = (b, db);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(z: f64) -> [DVec3; 4] {
        [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| DVec3::new(x, y, z))
    }

    #[test]
    fn parallel_square_matches_the_closed_form() {
        // Centre of a square of side 1 at distance 1 (Howell B-4): 4/(2π) · 2 · a/√(1+a²) · atan(a/√(1+a²)), a = 1/2.
        let x = 0.5 / 1.25f64.sqrt();
        let exact = 4.0 / std::f64::consts::PI * x * x.atan();
        assert!((configuration_factor(&square(1.0), DVec3::Z) - exact).abs() < 1e-15);
    }

    #[test]
    fn polygon_below_the_horizon_counts_for_nothing() {
        let mut out = Vec::new();
        above_plane(&square(-1.0), DVec3::Z, 0.0, &mut out);
        assert!(out.is_empty());
        above_plane(&square(0.0).map(|p| p + DVec3::X), DVec3::X, 1.0, &mut out);
        assert_eq!(out.len(), 4, "cut through the middle");
    }
}
