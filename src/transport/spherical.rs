//! Spherical triangles: directions within a cone, and what they stand for.

use glam::DVec3;

/// Visits parts of a spherical triangle of unit vectors, none of them with a side whose cosine is below `least`: its longest
/// side is halved until it is short enough. With the solid angle of each, sr.
pub(super) fn parts([a, b, c]: [DVec3; 3], least: f64, visit: &mut impl FnMut([DVec3; 3], f64)) {
    let (ab, bc, ca) = (a.dot(b), b.dot(c), c.dot(a));
    if ab.min(bc).min(ca) < least {
        let (p, q, r) = if ab <= bc && ab <= ca {
            (a, b, c)
        } else if bc <= ca {
            (b, c, a)
        } else {
            (c, a, b)
        };
        let middle = (p + q).normalize();
        parts([p, middle, r], least, visit);
        parts([middle, q, r], least, visit);
        return;
    }
    // tan Ω/2 by van Oosterom and Strackee 1983; small, so that two terms of the arc tangent are enough.
    let half = a.dot(b.cross(c)).abs() / (1.0 + ab + bc + ca);
    visit([a, b, c], 2.0 * half * (1.0 - half * half / 3.0));
}

/// A direction anywhere in a triangle, chosen by two numbers below one: on the whole, as much falls to each side of a border
/// as lies there. With the solid angle that it stands for: `dω = h dA/r³` on the plane of the corners, which lies at the
/// height `h`.
pub(super) fn anywhere([a, b, c]: [DVec3; 3], (u, v): (f64, f64)) -> (DVec3, f64) {
    let root = u.sqrt();
    let p = a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v);
    let length = p.length();
    (p / length, 0.5 * a.dot(b.cross(c)).abs() / length.powi(3))
}
