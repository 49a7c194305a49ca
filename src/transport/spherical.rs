//! Spherical triangles: directions within a cone, what they stand for, and a rule that integrates over them.

use glam::DVec3;

/// Cosine between corners of a triangle that is divided in any case: seven points are too few for so wide a view.
const WIDE: f64 = 0.8;

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

/// Seven points of a triangle, exact to the fifth degree (Radon 1948): weight, and the place between the corners.
const RULE: [(f64, [f64; 3]); 7] = {
    const A: f64 = 0.470_142_064_105_115_1;
    const B: f64 = 0.101_286_507_323_456_34;
    const WA: f64 = 0.132_394_152_788_506_2;
    const WB: f64 = 0.125_939_180_544_827_15;
    [
        (0.225, [1.0 / 3.0; 3]),
        (WA, [A, A, 1.0 - 2.0 * A]),
        (WA, [A, 1.0 - 2.0 * A, A]),
        (WA, [1.0 - 2.0 * A, A, A]),
        (WB, [B, B, 1.0 - 2.0 * B]),
        (WB, [B, 1.0 - 2.0 * B, B]),
        (WB, [1.0 - 2.0 * B, B, B]),
    ]
};

/// Nodes of a rule that integrates `f` over a triangle, with weights that sum to `weight`, and `f` there: the triangle is
/// divided in four until two rules of first degree come near to that of the fifth, whose error is then far smaller.
pub(super) fn triangle_nodes(
    f: &impl Fn(DVec3) -> f64,
    [a, b, c]: [DVec3; 3],
    (limit, depth): (f64, u32),
    weight: f64,
    node: &mut impl FnMut(DVec3, f64, f64),
) {
    let nodes = RULE.map(|(w, [x, y, z])| (w, a * x + b * y + c * z));
    let values = nodes.map(|(w, p)| (w, f(p)));
    let fine: f64 = values.iter().map(|(w, v)| w * v).sum();
    let mean = |part: &[(f64, f64)]| part.iter().map(|(_, v)| v).sum::<f64>() / 3.0;
    let off = (mean(&values[1..4]) - fine).abs().max((mean(&values[4..]) - fine).abs());
    let is_wide = a.dot(b).min(b.dot(c)).min(c.dot(a))
        < WIDE * a.length_squared().min(b.length_squared()).min(c.length_squared());
    if depth == 0 || (off <= limit * fine && !is_wide) {
        nodes.iter().zip(values).for_each(|((w, p), (_, value))| node(*p, weight * w, value));
        return;
    }
    let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
    for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
        triangle_nodes(f, part, (limit, depth - 1), 0.25 * weight, node);
    }
}
