//! The inner loops of the ray caster: the tests of boxes and triangles, and the way of one ray through the tree.
//!
//! The triangle test is watertight along shared edges (Woop, Benthin and Wald 2013): the three edge functions of two
//! triangles that share an edge are exact negatives of each other.
//!
//! What is met does not depend on the order in which the tree is walked: of all triangles in leaves whose box the ray
//! enters the nearest counts, of equals the one of the lower surface, and none counts as nearer than its leaf's box, whose
//! parents are no farther. A box that is farther than the nearest hit so far can then hold nothing that counts.

use std::mem::MaybeUninit;

#[cfg(target_arch = "x86_64")]
use super::lanes::Wide;

use super::bvh::{EMPTY, LEAF, Leaf, MOST_LEVELS, Node, Tree, WIDTH};
use super::caster::{Hit, Ray};
use super::lanes::{Lanes, Plain};
use super::packet::{PACKET, packet};

/// Boxes seem nearer by this factor: the slabs' rounding must not lose a hit (Ize 2013).
const SHY: f32 = 0.999_999;

/// Axes of the sheared frame by the largest component of the direction, which is the last of them.
pub(super) const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// Children that wait at most: seven siblings at each level, and the last child.
const WAITING: usize = 7 * MOST_LEVELS + 1;

/// Children that wait with the distances at which they are entered.
pub(super) struct Stack {
    list: [MaybeUninit<(f32, u32)>; WAITING],
    len: usize,
}

impl Stack {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { list: [const { MaybeUninit::uninit() }; WAITING], len: 0 }
    }

    #[inline(always)]
    fn get(&self, k: usize) -> (f32, u32) {
        #[expect(unsafe_code, reason = "to clear the list takes as long as a ray through a small room")]
        // SAFETY: `insert` wrote all that lies below `len`, and nothing else is asked for.
        unsafe {
            self.list[k].assume_init()
        }
    }

    /// Adds the children of a node in the lanes of these bits, the nearest on top.
    #[inline(always)]
    pub(super) fn add(&mut self, near: &[f32; WIDTH], open: u32, child: impl Fn(usize) -> u32) {
        let base = self.len;
        for l in 0..WIDTH {
            if open >> l & 1 != 0 {
                let mut k = self.len;
                while k > base && self.get(k - 1).0 < near[l] {
                    self.list[k] = self.list[k - 1];
                    k -= 1;
                }
                self.list[k] = MaybeUninit::new((near[l], child(l)));
                self.len += 1;
            }
        }
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<(f32, u32)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.get(self.len))
    }
}

/// The nearest so far; `key` is the index of the surface and one, nought where nothing was met.
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub(super) t: f32,
    pub(super) key: u32,
}

impl Best {
    #[inline(always)]
    fn or(self, t: f32, surface: u32) -> Self {
        let key = surface.wrapping_add(1);
        if (t < self.t) | ((t == self.t) & (key < self.key)) { Self { t, key } } else { self }
    }

    #[inline(always)]
    pub(super) fn hit(self) -> Hit {
        Hit { t: self.t, surface: self.key.wrapping_sub(1) }
    }
}

/// Corners of triangles from the start of a ray: across it, and along its largest component.
pub(super) struct Corners<L> {
    pub(super) x: [L; 3],
    pub(super) y: [L; 3],
    pub(super) z: [L; 3],
}

impl<L: Lanes> Corners<L> {
    /// From corner, origin and shear in the axes of the sheared frame.
    #[inline(always)]
    pub(super) fn new(at: impl Fn(usize) -> [L; 3], origin: [L; 3], shear: [L; 3]) -> Self {
        let zero = [L::all(0.0); 3];
        let mut corners = Self { x: zero, y: zero, z: zero };
        for v in 0..3 {
            let [x, y, z] = at(v);
            corners.z[v] = z - origin[2];
            corners.x[v] = (x - origin[0]) - shear[0] * corners.z[v];
            corners.y[v] = (y - origin[1]) - shear[1] * corners.z[v];
        }
        corners
    }

    /// Where rays meet triangles: distance, not less than `near`, and whether it is up to `limit`. `None` where all miss.
    #[inline(always)]
    pub(super) fn meet(&self, scale: L, near: L, limit: L) -> Option<(L, L::Mask)> {
        let Self { x, y, z } = self;
        let zero = L::all(0.0);
        let u = x[2] * y[1] - y[2] * x[1];
        let v = x[0] * y[2] - y[0] * x[2];
        let w = x[1] * y[0] - y[1] * x[0];
        let inside = zero.up_to(u.least(v.least(w))) | u.most(v.most(w)).up_to(zero);
        if L::bits(inside) == 0 {
            return None;
        }
        let t = (u * (scale * z[0]) + v * (scale * z[1]) + w * (scale * z[2])) / (u + v + w);
        let bound = t.most(near);
        // A triangle without a face has no distance that is a number.
        Some((bound, inside & zero.below(t) & bound.up_to(limit.least(L::all(f32::MAX)))))
    }
}

/// Where boxes are entered, and which of them before `t_max`.
#[inline(always)]
pub(super) fn reach<L: Lanes>(near: L, far: L, t_max: L) -> (L, u32) {
    let near = near * L::all(SHY);
    (near, L::bits(near.up_to(far) & near.up_to(t_max)))
}

/// A ray with what its tests need.
pub(super) struct Prepared {
    pub(super) origin: [f32; 3],
    /// Of the direction.
    pub(super) inverse: [f32; 3],
    pub(super) axes: [usize; 3],
    pub(super) shear: [f32; 3],
}

impl Prepared {
    /// As the packet's groups do for all their rays at once.
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        let [x, y, z] = ray.direction;
        let size = [x.abs(), y.abs(), z.abs()];
        // Branches, not indices: rays of one direction in turn need not wait for them.
        let (axes, [across, aside, along]) = if size[1] < size[0] && size[2] < size[0] {
            (AXES[0], [y, z, x])
        } else if size[0] <= size[1] && size[2] < size[1] {
            (AXES[1], [z, x, y])
        } else {
            (AXES[2], [x, y, z])
        };
        let inverse = [x, y, z].map(|d| 1.0 / if d.abs() < LEAST { LEAST.copysign(d) } else { d });
        Self { origin: ray.origin, inverse, axes, shear: [across / along, aside / along, 1.0 / along] }
    }

    #[inline(always)]
    fn enter<L: Lanes>(&self, node: &Node, t_max: f32) -> (L, u32) {
        let (mut near, mut far) = (L::all(0.0), L::all(f32::INFINITY));
        for a in 0..3 {
            let (o, inverse) = (L::all(self.origin[a]), L::all(self.inverse[a]));
            let ahead = self.inverse[a] > 0.0;
            let (first, second) = if ahead { (&node.low[a], &node.high[a]) } else { (&node.high[a], &node.low[a]) };
            near = ((L::load(first) - o) * inverse).most(near);
            far = ((L::load(second) - o) * inverse).least(far);
        }
        reach(near, far, L::all(t_max))
    }

    #[inline(always)]
    fn meet<L: Lanes>(&self, leaf: &Leaf, near: f32, best: Best) -> Best {
        let [x, y, z] = self.axes;
        let at = |v: usize| [L::load(&leaf.vertex[v][x]), L::load(&leaf.vertex[v][y]), L::load(&leaf.vertex[v][z])];
        let o = [L::all(self.origin[x]), L::all(self.origin[y]), L::all(self.origin[z])];
        let shear = [L::all(self.shear[0]), L::all(self.shear[1]), L::all(self.shear[2])];
        let Some((t, hit)) = Corners::new(at, o, shear).meet(shear[2], L::all(near), L::all(best.t)) else {
            return best;
        };
        let (t, hit) = (t.store(), L::bits(hit));
        let mut best = best;
        for l in 0..WIDTH {
            if hit >> l & 1 != 0 {
                best = best.or(t[l], leaf.surface[l]);
            }
        }
        best
    }
}

/// Components of directions do not count as less: their inverses stay numbers.
pub(super) const LEAST: f32 = 1e-30;

/// The way of one ray from a child of the tree on, which it enters at a distance, or from the root.
#[inline(always)]
pub(super) fn single<L: Lanes>(tree: &Tree, ray: &Prepared, mut best: Best, from: (f32, u32)) -> Best {
    let mut stack = Stack::new();
    let mut next = Some(from);
    while let Some((near, child)) = next {
        if near <= best.t {
            if child & LEAF != 0 {
                best = ray.meet::<L>(&tree.leaves[(child ^ LEAF) as usize], near, best);
            } else {
                let node = &tree.nodes[child as usize];
                let (near, open) = ray.enter::<L>(node, best.t);
                stack.add(&near.store(), open & node.used(), |l| node.child[l]);
            }
        }
        next = stack.pop();
    }
    best
}

#[inline(always)]
fn packets_by<L: Lanes>(tree: &Tree, packets: &[[Ray; PACKET]], hits: &mut [[Hit; PACKET]]) {
    for (rays, hits) in packets.iter().zip(hits) {
        packet::<L>(tree, rays, hits);
    }
}

#[inline(always)]
fn singles_by<L: Lanes>(tree: &Tree, rays: &[Ray], hits: &mut [Hit]) {
    for (ray, hit) in rays.iter().zip(hits) {
        *hit = single::<L>(tree, &Prepared::new(ray), Best { t: ray.t_max, key: 0 }, (0.0, 0)).hit();
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn packets_with_avx2(tree: &Tree, packets: &[[Ray; PACKET]], hits: &mut [[Hit; PACKET]]) {
    packets_by::<Wide>(tree, packets, hits);
}

/// Apart from packets, whose large frame would slow it.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn singles_with_avx2(tree: &Tree, rays: &[Ray], hits: &mut [Hit]) {
    singles_by::<Wide>(tree, rays, hits);
}

/// Closest hits of a slice of rays: sixteen together where there are so many, the rest one by one.
#[inline]
pub(super) fn closest(tree: &Tree, rays: &[Ray], hits: &mut [Hit]) {
    if tree.nodes.is_empty() {
        hits.iter_mut().zip(rays).for_each(|(h, r)| *h = Hit { t: r.t_max, surface: EMPTY });
        return;
    }
    let (packets, rest) = rays.as_chunks::<PACKET>();
    let (hits, last) = hits.split_at_mut(packets.len() * PACKET);
    let hits = hits.as_chunks_mut::<PACKET>().0;
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        #[expect(unsafe_code, reason = "the run-time check for AVX2 is the condition of the calls")]
        // SAFETY: the feature was found just above.
        unsafe {
            if !packets.is_empty() {
                packets_with_avx2(tree, packets, hits);
            }
            if !rest.is_empty() {
                singles_with_avx2(tree, rest, last);
            }
        }
        return;
    }
    packets_by::<Plain>(tree, packets, hits);
    singles_by::<Plain>(tree, rest, last);
}

#[cfg(test)]
#[path = "kernel_tests.rs"]
mod tests;
