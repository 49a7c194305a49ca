//! The shaft between two boxes: what could stand between two patches (Haines and Wallace 1991).

use glam::{DVec2, DVec3};

use crate::mesh::Surface;

/// Overlap below which things only touch, in units of the scene's size.
const TOUCH: f64 = 2e-6;

/// An axis-parallel box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    pub(super) fn new(polygon: &[DVec3]) -> Self {
        let low = polygon.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = polygon.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        Self { low, high }
    }

    fn joined(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn overlaps(&self, other: &Self) -> bool {
        (self.low + TOUCH).cmple(other.high).all() && (other.low + TOUCH).cmple(self.high).all()
    }
}

/// The convex hull of two boxes, a little enlarged: it holds every line from one to the other.
#[derive(Clone, Debug)]
pub(super) struct Shaft {
    hull: Bounds,
    /// Slanted sides: plane axes, outward normal in that plane, offset.
    slants: Vec<([usize; 2], DVec2, f64)>,
}

impl Shaft {
    pub(super) fn new(a: &Bounds, b: &Bounds) -> Self {
        let mut slants = Vec::with_capacity(8);
        for axes in [[0, 1], [1, 2], [2, 0]] {
            let flat = |p: DVec3| DVec2::new(p[axes[0]], p[axes[1]]);
            let corner = |r: &Bounds, k: usize| {
                let (low, high) = (flat(r.low), flat(r.high));
                DVec2::new(if k & 1 == 0 { low.x } else { high.x }, if k & 2 == 0 { low.y } else { high.y })
            };
            for k in 0..4 {
                let (p, q) = (corner(a, k), corner(b, k));
                let normal = (q - p).perp().normalize_or_zero();
                if normal == DVec2::ZERO {
                    continue;
                }
                let heights = || [a, b].into_iter().flat_map(|r| (0..4).map(|c| normal.dot(corner(r, c) - p)));
                let (least, most) = heights().fold((0.0f64, 0.0f64), |(l, m), h| (l.min(h), m.max(h)));
                // A side of the hull has everything on one side of it.
                if most < 1e-12 {
                    slants.push((axes, normal, normal.dot(p)));
                } else if least > -1e-12 {
                    slants.push((axes, -normal, -normal.dot(p)));
                }
            }
        }
        Self { hull: a.joined(b), slants }
    }

    /// May a surface with these bounds reach into the shaft?
    pub(super) fn touches(&self, surface: &Surface, bounds: &Bounds) -> bool {
        self.grown().overlaps(bounds)
            && self.slants.iter().all(|(axes, normal, offset)| {
                let inside = |p: &DVec3| normal.dot(DVec2::new(p[axes[0]], p[axes[1]])) < offset - TOUCH;
                surface.vertices.iter().any(inside)
            })
    }

    /// A flat box has no inside: lend it some.
    fn grown(&self) -> Bounds {
        let thin = (self.hull.high - self.hull.low).cmplt(DVec3::splat(2.0 * TOUCH));
        let more = DVec3::select(thin, DVec3::splat(2.0 * TOUCH), DVec3::ZERO);
        Bounds { low: self.hull.low - more, high: self.hull.high + more }
    }
}
