//! Solids that a hall is put together from.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

/// A closed solid or a wall of one paint; metres, z up, faces counter-clockwise seen from outside.
#[derive(Debug)]
pub(crate) struct Part {
    pub(crate) object: &'static str,
    pub(crate) vertices: Vec<DVec3>,
    /// Vertices of each face, and its material.
    pub(crate) faces: Vec<(Vec<u32>, &'static str)>,
}

/// A rectangle from a corner and two sides; it looks along `u × v`.
pub(crate) fn panel(object: &'static str, corner: DVec3, [u, v]: [DVec3; 2], material: &'static str) -> Part {
    let vertices = vec![corner, corner + u, corner + u + v, corner + v];
    Part { object, vertices, faces: vec![(vec![0, 1, 2, 3], material)] }
}

/// A box about `centre` with half sides along the columns of `axes`; its bottom may have another material.
pub(crate) fn cuboid(
    object: &'static str,
    (centre, axes, half): (DVec3, DMat3, DVec3),
    [material, bottom]: [&'static str; 2],
) -> Part {
    let corner = |k: u32| {
        let sign = |bit: u32| if k & bit == 0 { -1.0 } else { 1.0 };
        centre + axes * (half * DVec3::new(sign(1), sign(2), sign(4)))
    };
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [4, 5, 7, 6]];
    let mut faces: Vec<(Vec<u32>, &'static str)> = sides.iter().map(|s| (s.to_vec(), material)).collect();
    faces.push((vec![0, 2, 3, 1], bottom));
    Part { object, vertices: (0..8).map(corner).collect(), faces }
}

/// A box between two corners.
pub(crate) fn block(object: &'static str, low: DVec3, high: DVec3, material: &'static str) -> Part {
    cuboid(object, (0.5 * (low + high), DMat3::IDENTITY, 0.5 * (high - low)), [material; 2])
}

/// A straight member of rectangular section from `a` to `b`, `size` across and upright.
pub(crate) fn member(object: &'static str, [a, b]: [DVec3; 2], size: [f64; 2], material: &'static str) -> Part {
    let along = (b - a).normalize();
    let across = if along.z.abs() > 0.99 { DVec3::X } else { DVec3::Z.cross(along).normalize() };
    let axes = DMat3::from_cols(along, across, along.cross(across));
    let half = 0.5 * DVec3::new(a.distance(b), size[0], size[1]);
    cuboid(object, (0.5 * (a + b), axes, half), [material; 2])
}

/// A prism or a frustum of `n` sides from a circle about `a` to one about `b`; materials of sides and caps (at a, at b).
pub(crate) fn round(
    object: &'static str,
    [a, b]: [DVec3; 2],
    radius: [f64; 2],
    n: u32,
    [sides, cap_a, cap_b]: [&'static str; 3],
) -> Part {
    let (u, v) = (b - a).normalize().any_orthonormal_pair();
    let ring = |centre: DVec3, r: f64| {
        (0..n).map(move |k| {
            let (sine, cosine) = (TAU * (f64::from(k) + 0.5) / f64::from(n)).sin_cos();
            centre + r * (cosine * u + sine * v)
        })
    };
    let mut faces: Vec<(Vec<u32>, &'static str)> =
        (0..n).map(|k| (vec![k, (k + 1) % n, n + (k + 1) % n, n + k], sides)).collect();
    faces.push(((0..n).rev().collect(), cap_a));
    faces.push(((n..2 * n).collect(), cap_b));
    Part { object, vertices: ring(a, radius[0]).chain(ring(b, radius[1])).collect(), faces }
}
