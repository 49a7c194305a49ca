//! What a point sees of a cone of directions: the cone less the shadow of every blocker, exactly.
//!
//! Panes do not block: where one stands in the way, the piece behind it is kept apart and remembers it.

use glam::DVec3;

use super::world::{Kind, World};
use crate::light::{above_plane, divide_by_plane};

/// More pieces than this are given up.
const MAX_PIECES: usize = 256;
/// Panes that light may pass through in one direction; further ones block.
const MAX_PANES: usize = 8;
/// A piece with a smaller share of the whole area is rounding along an edge.
const SLIVER: f64 = 1e-13;

/// A convex cone of directions, by a polygon that it goes through; the apex is the point that looks.
#[derive(Clone, Debug, Default)]
pub(super) struct Piece {
    pub(super) polygon: Vec<DVec3>,
    panes: [u32; MAX_PANES],
    count: usize,
}

impl Piece {
    /// The panes that it is seen through.
    pub(super) fn panes(&self) -> &[u32] {
        &self.panes[..self.count]
    }
}

/// Buffers, and the pieces that are left.
#[derive(Debug, Default)]
pub(super) struct Visible {
    pub(super) pieces: Vec<Piece>,
    next: Vec<Piece>,
    spare: Vec<Piece>,
    blocker: Vec<DVec3>,
    cone: Vec<DVec3>,
    /// Planes of the whole cone that is looked at.
    sides: Vec<DVec3>,
    clipped: Vec<DVec3>,
    sliver: f64,
    /// What took something out of the pieces, in that order.
    pub(super) cutters: Vec<u32>,
}

impl Visible {
    /// Leaves the visible part of the cone over `polygon` in `pieces`; `false` where they are too many.
    ///
    /// `blockers` may hold more than what stands in the cone. Only what lies above a plane blocks: `above` is its normal
    /// and its height over `x` (which is negative where an emitter's plane looks down at `x`).
    pub(super) fn clip(
        &mut self,
        world: &World,
        x: DVec3,
        above: (DVec3, f64),
        polygon: &[DVec3],
        blockers: impl Iterator<Item = u32>,
    ) -> bool {
        self.spare.append(&mut self.pieces);
        let mut first = self.spare.pop().unwrap_or_default();
        first.polygon.clear();
        first.polygon.extend_from_slice(polygon);
        first.count = 0;
        self.pieces.push(first);
        self.sliver = SLIVER * twice_area(polygon);
        self.sides.clear();
        self.cutters.clear();
        for b in blockers {
            let surface = &world.surfaces.list[b as usize];
            if surface.height(x).abs() < 1e-9 {
                continue; // seen edge-on
            }
            self.clipped.clear();
            self.clipped.extend(surface.vertices.iter().map(|v| *v - x));
            above_plane(&self.clipped, above.0, above.1, &mut self.blocker);
            if self.blocker.len() < 3 {
                continue;
            }
            if self.sides.is_empty() {
                cone_planes(polygon, &mut self.sides);
            }
            if outside(&self.blocker, &self.sides) {
                continue;
            }
            cone_planes(&self.blocker, &mut self.cone);
            let pane = (world.kind(b) == Kind::Glass).then_some(b);
            if self.subtract(pane) {
                self.cutters.push(b);
            }
            if self.pieces.is_empty() {
                return true;
            }
            if self.pieces.len() > MAX_PIECES {
                return false;
            }
        }
        true
    }

    /// Takes the cone of one blocker out of all pieces; a pane keeps what is behind it. Tells whether it met any.
    fn subtract(&mut self, pane: Option<u32>) -> bool {
        if self.cone.len() < 3 {
            return false;
        }
        let mut met = false;
        self.next.clear();
        while let Some(mut piece) = self.pieces.pop() {
            if outside(&piece.polygon, &self.cone) {
                self.next.push(piece);
                continue;
            }
            met = true;
            for n in &self.cone {
                if piece.polygon.iter().all(|p| n.dot(*p) > 0.0) {
                    continue;
                }
                let mut rest = self.spare.pop().unwrap_or_default();
                divide_by_plane(&piece.polygon, *n, &mut self.clipped, &mut rest.polygon);
                if twice_area(&rest.polygon) > self.sliver {
                    (rest.panes, rest.count) = (piece.panes, piece.count);
                    self.next.push(rest);
                } else {
                    self.spare.push(rest);
                }
                std::mem::swap(&mut piece.polygon, &mut self.clipped);
                if piece.polygon.len() < 3 {
                    break;
                }
            }
            match pane {
                Some(pane) if twice_area(&piece.polygon) > self.sliver && piece.count < MAX_PANES => {
                    piece.panes[piece.count] = pane;
                    piece.count += 1;
                    self.next.push(piece);
                }
                _ => self.spare.push(piece),
            }
        }
        std::mem::swap(&mut self.pieces, &mut self.next);
        met
    }
}

/// Inward unit normals of the planes through the apex and the edges of a convex polygon.
pub(super) fn cone_planes(polygon: &[DVec3], planes: &mut Vec<DVec3>) {
    planes.clear();
    let middle = polygon.iter().copied().sum::<DVec3>();
    let closing = polygon.last().zip(polygon.first());
    for (a, b) in polygon.iter().zip(polygon.iter().skip(1)).chain(closing) {
        let n = a.cross(*b);
        let length = n.length();
        // Two corners nearer than rounding have no plane.
        if length > 1e-13 * (a.length_squared() + b.length_squared()) {
            planes.push(n / if n.dot(middle) < 0.0 { -length } else { length });
        }
    }
}

/// Does the polygon lie wholly outside one of the planes?
pub(super) fn outside(polygon: &[DVec3], planes: &[DVec3]) -> bool {
    planes.iter().any(|n| polygon.iter().all(|p| n.dot(*p) <= 1e-12))
}

/// Twice the area of a planar polygon; nothing for what is none.
fn twice_area(polygon: &[DVec3]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    polygon.windows(2).skip(1).map(|e| (e[0] - first).cross(e[1] - first)).sum::<DVec3>().length()
}
