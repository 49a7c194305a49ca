//! Polygons as drawn into convex planar pieces.
//!
//! A ring may repeat vertices, be concave, or leave its plane by a little; the solver wants convex planar
//! faces. A planar convex ring stays one face; all else is cut into triangles by ear clipping in its
//! Newell plane.

use earcut::Earcut;
use glam::{DVec2, DVec3};

/// A ring that leaves its Newell plane by less than this share of its size counts as planar.
pub(crate) const PLANAR: f64 = 1e-5;
/// Beyond this share of its size the user hears of it.
pub(crate) const TELL: f64 = 1e-3;

/// Why a ring has no area.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Degeneracy {
    /// Fewer than three different vertices.
    Repeated,
    /// All vertices on a line, or an area of zero.
    Flat,
}

/// What a ring becomes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Shape {
    /// One convex planar piece.
    Convex(Vec<DVec3>),
    /// Triangles.
    Pieces {
        /// The triangles, wound as the ring.
        pieces: Vec<Vec<DVec3>>,
        /// Greatest distance of a vertex from the Newell plane, as a share of the ring's size.
        deviation: f64,
        /// The triangles' area in the Newell plane against the ring's: 0 unless the ring crosses itself.
        excess: f64,
    },
    /// Nothing.
    Degenerate(Degeneracy),
}

/// Area vector by Newell's sums: length = area, direction = normal (counter-clockwise seen from its tip).
pub(crate) fn area_vector(ring: &[DVec3]) -> DVec3 {
    let Some(&o) = ring.first() else {
        return DVec3::ZERO;
    };
    ring.windows(2).map(|w| (w[0] - o).cross(w[1] - o)).sum::<DVec3>() * 0.5
}

/// Diagonal of the bounding box.
pub(crate) fn size(points: &[DVec3]) -> f64 {
    let Some(&first) = points.first() else {
        return 0.0;
    };
    let (lo, hi) = points.iter().fold((first, first), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
    (hi - lo).length()
}

/// Rounding of coordinates of this magnitude, with a margin; metres.
fn rounding(ring: &[DVec3]) -> f64 {
    4.0 * f64::EPSILON * ring.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max)
}

/// Turns a ring into convex planar pieces.
pub(crate) fn shape(ring: &[DVec3]) -> Shape {
    let size = size(ring);
    let noise = 1e-12 * size + rounding(ring);
    let ring = without_repeats(ring, noise);
    if ring.len() < 3 {
        return Shape::Degenerate(Degeneracy::Repeated);
    }
    let ring = without_collinear(&ring, noise);
    let area = area_vector(&ring);
    if ring.len() < 3 || area.length() <= noise * size {
        return Shape::Degenerate(Degeneracy::Flat);
    }
    let normal = area.normalize();
    let deviation = deviation(&ring, normal) / size;
    if deviation <= PLANAR && is_convex(&ring, normal) {
        return Shape::Convex(ring);
    }
    cut(&ring, area, deviation, noise * size)
}

/// Drops vertices that repeat their neighbour.
fn without_repeats(ring: &[DVec3], noise: f64) -> Vec<DVec3> {
    let mut kept: Vec<DVec3> = Vec::with_capacity(ring.len());
    for p in ring {
        if kept.last().is_none_or(|q| q.distance(*p) > noise) {
            kept.push(*p);
        }
    }
    while kept.len() > 1 && kept[0].distance(kept[kept.len() - 1]) <= noise {
        kept.pop();
    }
    kept
}

/// Drops vertices in the middle of a straight edge (not the tips of spikes).
fn without_collinear(ring: &[DVec3], noise: f64) -> Vec<DVec3> {
    let n = ring.len();
    let straight = |i: usize| {
        let (a, b, c) = (ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]);
        let chord = c - a;
        (b - a).dot(c - b) > 0.0 && (b - a).cross(chord).length() <= noise * chord.length()
    };
    (0..n).filter(|&i| !straight(i)).map(|i| ring[i]).collect()
}

/// Greatest distance of a vertex from the plane through the centre.
fn deviation(ring: &[DVec3], normal: DVec3) -> f64 {
    let centre = ring.iter().sum::<DVec3>() / ring.len() as f64;
    ring.iter().map(|p| (*p - centre).dot(normal).abs()).fold(0.0, f64::max)
}

/// Turns left at every corner, and once around in all.
fn is_convex(ring: &[DVec3], normal: DVec3) -> bool {
    let n = ring.len();
    let mut turned = 0.0;
    for i in 0..n {
        let before = ring[(i + 1) % n] - ring[i];
        let after = ring[(i + 2) % n] - ring[(i + 1) % n];
        let angle = before.cross(after).dot(normal).atan2(before.dot(after));
        if angle < -1e-9 {
            return false;
        }
        turned += angle;
    }
    // A star turns left twice around: 4π.
    turned < 3.0 * std::f64::consts::PI
}

/// Two unit vectors that span the plane of `normal`, right-handed with it.
pub(crate) fn basis(normal: DVec3) -> (DVec3, DVec3) {
    let u = normal.any_orthonormal_vector();
    (u, normal.cross(u))
}

/// Ear clipping in the Newell plane.
fn cut(ring: &[DVec3], area: DVec3, deviation: f64, least_area: f64) -> Shape {
    let normal = area.normalize();
    let (u, v) = basis(normal);
    let flat: Vec<[f64; 2]> = ring.iter().map(|p| [(*p - ring[0]).dot(u), (*p - ring[0]).dot(v)]).collect();
    let mut corners: Vec<usize> = Vec::new();
    Earcut::new().earcut_slice(&flat, &[], &mut corners);
    earcut::refine(&mut corners, &flat);
    let mut covered = 0.0;
    let mut pieces = Vec::new();
    for t in corners.chunks_exact(3) {
        let mut piece = vec![ring[t[0]], ring[t[1]], ring[t[2]]];
        let mut projected = area_vector(&piece).dot(normal);
        if projected < 0.0 {
            piece.swap(1, 2);
            projected = -projected;
        }
        if projected > least_area {
            covered += projected;
            pieces.push(piece);
        }
    }
    if pieces.is_empty() {
        return Shape::Degenerate(Degeneracy::Flat);
    }
    Shape::Pieces { pieces, deviation, excess: (covered / area.length() - 1.0).abs() }
}

/// The part of convex polygon `a` inside convex polygon `b` (both counter-clockwise): its area.
pub(crate) fn overlap_area(a: &[DVec2], b: &[DVec2]) -> f64 {
    let mut part = a.to_vec();
    for i in 0..b.len() {
        let (p, q) = (b[i], b[(i + 1) % b.len()]);
        let inside = |x: DVec2| (q - p).perp_dot(x - p);
        let mut next = Vec::with_capacity(part.len() + 1);
        for j in 0..part.len() {
            let (s, e) = (part[j], part[(j + 1) % part.len()]);
            let (ds, de) = (inside(s), inside(e));
            if ds >= 0.0 {
                next.push(s);
            }
            if (ds > 0.0 && de < 0.0) || (ds < 0.0 && de > 0.0) {
                next.push(s + (e - s) * (ds / (ds - de)));
            }
        }
        part = next;
    }
    let Some(&o) = part.first() else { return 0.0 };
    0.5 * part.windows(2).map(|w| (w[0] - o).perp_dot(w[1] - o)).sum::<f64>()
}

/// Does `p`, in the plane, lie in the convex face (edges included within `tolerance`, metres)?
pub(crate) fn contains(face: &[DVec3], normal: DVec3, p: DVec3, tolerance: f64) -> bool {
    (0..face.len()).all(|i| {
        let (a, b) = (face[i], face[(i + 1) % face.len()]);
        let edge = b - a;
        edge.cross(p - a).dot(normal) >= -tolerance * edge.length()
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn flat(points: &[(f64, f64)]) -> Vec<DVec3> {
        points.iter().map(|(x, y)| DVec3::new(*x, *y, 0.0)).collect()
    }

    fn total(pieces: &[Vec<DVec3>]) -> f64 {
        pieces.iter().map(|p| area_vector(p).length()).sum()
    }

    #[test]
    fn a_concave_l_becomes_triangles_of_its_exact_area() {
        let l = flat(&[(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]);
        for ring in [l.clone(), l.iter().rev().copied().collect()] {
            let Shape::Pieces { pieces, deviation, excess } = shape(&ring) else { panic!("must be cut") };
            assert!((total(&pieces) - 4.0).abs() < 1e-14 && deviation < 1e-15 && excess < 1e-14);
            let normal = area_vector(&ring).normalize();
            assert!(pieces.iter().all(|p| area_vector(p).normalize().distance(normal) < 1e-12), "winding kept");
        }
    }

    #[test]
    fn a_convex_ring_stays_one_and_loses_only_needless_vertices() {
        let ring = flat(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0), (0.0, 0.0)]);
        assert_eq!(shape(&ring), Shape::Convex(flat(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)])));
    }

    #[test]
    fn rings_without_area_are_told_apart() {
        let point = flat(&[(1.0, 1.0); 4]);
        let line = flat(&[(0.0, 0.0), (1.0, 0.0), (3.0, 0.0)]);
        assert_eq!(shape(&point), Shape::Degenerate(Degeneracy::Repeated));
        assert_eq!(shape(&line), Shape::Degenerate(Degeneracy::Flat));
    }

    #[test]
    fn a_star_is_not_convex_though_it_turns_left_throughout() {
        let star: Vec<_> =
            (0..5).map(|i| f64::from(i) * 0.8 * std::f64::consts::PI).map(|a| (a.cos(), a.sin())).collect();
        assert!(!matches!(shape(&flat(&star)), Shape::Convex(_)));
    }

    #[test]
    fn a_warped_quad_is_split_and_its_deviation_told() {
        let mut ring = flat(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        ring[2].z = 0.1;
        let Shape::Pieces { pieces, deviation, .. } = shape(&ring) else { panic!("must be cut") };
        assert_eq!(pieces.len(), 2);
        assert!((0.015..0.03).contains(&deviation), "{deviation}");
    }

    #[test]
    fn far_from_the_origin_a_square_is_still_a_square() {
        let ring: Vec<_> = flat(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
            .iter()
            .map(|p| *p + DVec3::new(4.5e6, 5.4e6, 100.0))
            .collect();
        assert_eq!(shape(&ring), Shape::Convex(ring.clone()));
    }

    #[test]
    fn overlap_of_shifted_squares() {
        let square = |x: f64| [(x, 0.0), (x + 1.0, 0.0), (x + 1.0, 1.0), (x, 1.0)].map(|(x, y)| DVec2::new(x, y));
        assert!((overlap_area(&square(0.0), &square(0.25)) - 0.75).abs() < 1e-15);
        assert_eq!(overlap_area(&square(0.0), &square(1.0)), 0.0);
    }

    proptest! {
        #[test]
        fn any_ring_gives_finite_pieces(ring in prop::collection::vec((-2.0..2.0f64, -2.0..2.0f64, -0.1..0.1f64), 0..12)) {
            let ring: Vec<DVec3> = ring.iter().map(|(x, y, z)| DVec3::new(*x, *y, *z)).collect();
            if let Shape::Pieces { pieces, .. } = shape(&ring) {
                prop_assert!(pieces.iter().all(|p| p.len() == 3 && area_vector(p).length() > 0.0));
            }
        }

        #[test]
        fn a_star_shaped_ring_keeps_its_area(radii in prop::collection::vec(0.2..2.0f64, 3..20)) {
            let n = radii.len() as f64;
            let ring: Vec<DVec3> = radii.iter().enumerate().map(|(i, r)| {
                let a = i as f64 / n * std::f64::consts::TAU;
                DVec3::new(1.0, r * a.cos(), r * a.sin())
            }).collect();
            let pieces = match shape(&ring) {
                Shape::Convex(ring) => vec![ring],
                Shape::Pieces { pieces, .. } => pieces,
                Shape::Degenerate(_) => return Ok(()),
            };
            let want = area_vector(&ring).length();
            prop_assert!((total(&pieces) - want).abs() < 1e-9 * want);
        }
    }
}
