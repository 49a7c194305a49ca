//! Sixteen rays through the tree together: what none of them can meet is passed by with one test of eight boxes, a box is
//! entered and a triangle met by eight rays at a time.
//!
//! The hits are those of single rays to the last bit: tests and order of precedence are the same (`kernel.rs`).

use super::bvh::{EMPTY, LEAF, Leaf, Node, Tree, WIDTH};
use super::caster::{Hit, Ray};
use super::kernel::{AXES, Best, Corners, LEAST, Prepared, Stack, reach, single};
use super::lanes::Lanes;

const GROUPS: usize = 2;
/// Rays of a packet.
pub(super) const PACKET: usize = GROUPS * WIDTH;
/// So few rays go on one by one.
const FEW: u32 = 5;

/// Eight rays, and what they met.
struct Group<L: Lanes> {
    origin: [L; 3],
    inverse: [L; 3],
    shear: [L; 3],
    /// Is the first axis, or the second, the largest component of the direction?
    largest: [L::Mask; 2],
    /// Which one is, if it is the same in all.
    alike: Option<usize>,
    t: L,
    /// [`Best::key`].
    key: L,
}

/// Into the axes of the sheared frame.
#[inline(always)]
fn turn<L: Lanes>(largest: [L::Mask; 2], [x, y, z]: [L; 3]) -> [L; 3] {
    let pick = |a, b, c| L::pick(largest[0], a, L::pick(largest[1], b, c));
    [pick(y, z, x), pick(z, x, y), pick(x, y, z)]
}

impl<L: Lanes> Group<L> {
    #[inline(always)]
    fn new(rays: &[Ray]) -> Self {
        let (mut origin, mut direction, mut t) = ([[0.0; WIDTH]; 3], [[0.0; WIDTH]; 3], [0.0; WIDTH]);
        for l in 0..WIDTH {
            for a in 0..3 {
                origin[a][l] = rays[l].origin[a];
                direction[a][l] = rays[l].direction[a];
            }
            t[l] = rays[l].t_max;
        }
        let d = [L::load(&direction[0]), L::load(&direction[1]), L::load(&direction[2])];
        let (one, least) = (L::all(1.0), L::all(LEAST));
        let (mut size, mut inverse) = (d, d);
        for a in 0..3 {
            size[a] = d[a].size();
            inverse[a] = one / L::pick(size[a].below(least), least.signed_as(d[a]), d[a]);
        }
        let [x, y, z] = size;
        let largest = [y.below(x) & z.below(x), x.up_to(y) & z.below(y)];
        let [across, aside, along] = turn::<L>(largest, d);
        let all = (1 << WIDTH) - 1;
        let alike = match largest.map(L::bits) {
            [bits, _] if bits == all => Some(0),
            [_, bits] if bits == all => Some(1),
            [0, 0] => Some(2),
            _ => None,
        };
        Self {
            origin: [L::load(&origin[0]), L::load(&origin[1]), L::load(&origin[2])],
            inverse,
            shear: [across / along, aside / along, one / along],
            largest,
            alike,
            t: L::load(&t),
            key: L::all(0.0),
        }
    }

    /// Where the rays enter a child's box; infinity where they do not.
    #[inline(always)]
    fn enter(&self, node: &Node, child: usize) -> (L, u32) {
        let (mut near, mut far) = (L::all(0.0), L::all(f32::INFINITY));
        for a in 0..3 {
            let low = (L::all(node.low[a][child]) - self.origin[a]) * self.inverse[a];
            let high = (L::all(node.high[a][child]) - self.origin[a]) * self.inverse[a];
            near = low.least(high).most(near);
            far = low.most(high).least(far);
        }
        reach(near, far, self.t)
    }

    /// One triangle after the other.
    #[inline(always)]
    fn meet(&mut self, leaf: &Leaf, near: L, open: u32) {
        // A ray that does not enter the box meets nothing of what it holds.
        let mut near = near.store();
        for l in 0..WIDTH {
            near[l] = if open >> l & 1 != 0 { near[l] } else { f32::INFINITY };
        }
        let near = L::load(&near);
        let [x, y, z] = self.origin;
        let origin = match self.alike {
            Some(0) => [y, z, x],
            Some(1) => [z, x, y],
            Some(_) => [x, y, z],
            None => turn::<L>(self.largest, self.origin),
        };
        let axes = AXES[self.alike.unwrap_or(2)];
        for (k, surface) in leaf.surface.into_iter().enumerate().take_while(|(_, surface)| *surface != EMPTY) {
            let at = |v: usize| {
                let p = &leaf.vertex[v];
                let p = [L::all(p[axes[0]][k]), L::all(p[axes[1]][k]), L::all(p[axes[2]][k])];
                if self.alike.is_some() { p } else { turn::<L>(self.largest, p) }
            };
            if let Some((t, hit)) = Corners::new(at, origin, self.shear).meet(self.shear[2], near, self.t) {
                let key = L::all(f32::from_bits(surface + 1));
                let closer = hit & (t.below(self.t) | key.lower_index(self.key));
                self.t = L::pick(closer, t, self.t);
                self.key = L::pick(closer, key, self.key);
            }
        }
    }

    /// Rays of these lanes go on by themselves.
    #[inline(always)]
    fn part(&mut self, tree: &Tree, near: L, open: u32, child: u32) {
        let lanes = |of: &[L; 3]| [of[0].store(), of[1].store(), of[2].store()];
        let (origin, inverse, shear) = (lanes(&self.origin), lanes(&self.inverse), lanes(&self.shear));
        let [first, second] = self.largest.map(L::bits);
        let (near, mut t, mut key) = (near.store(), self.t.store(), self.key.store());
        for l in 0..WIDTH {
            if open >> l & 1 != 0 {
                let of = |lanes: &[[f32; WIDTH]; 3]| [lanes[0][l], lanes[1][l], lanes[2][l]];
                let largest = if first >> l & 1 != 0 { 0 } else { 2 - (second >> l & 1) as usize };
                let (origin, inverse, shear) = (of(&origin), of(&inverse), of(&shear));
                let ray = Prepared { origin, inverse, axes: AXES[largest], shear };
                let best = Best { t: t[l], key: key[l].to_bits() };
                let best = single::<L>(tree, &ray, best, (near[l], child));
                (t[l], key[l]) = (best.t, f32::from_bits(best.key));
            }
        }
        (self.t, self.key) = (L::load(&t), L::load(&key));
    }
}

/// The greatest number in any lane.
#[inline(always)]
fn highest<L: Lanes>(of: L) -> f32 {
    let mut most = f32::NEG_INFINITY;
    for x in of.store() {
        most = if x > most { x } else { most };
    }
    most
}

/// Distance beyond which no ray of a packet looks for anything.
#[inline(always)]
fn furthest<L: Lanes>(groups: &[Group<L>; GROUPS]) -> f32 {
    let mut most = L::all(f32::NEG_INFINITY);
    for group in groups {
        most = group.t.most(most);
    }
    highest(most)
}

/// Least and greatest of a quantity over the rays of a packet.
#[derive(Clone, Copy)]
struct Span<L> {
    least: L,
    most: L,
}

impl<L: Lanes> Span<L> {
    /// The same in all lanes.
    #[inline(always)]
    fn even(self) -> Self {
        Self { least: L::all(-highest(L::all(0.0) - self.least)), most: L::all(highest(self.most)) }
    }
}

/// Bounds on all rays of a packet, by axis. Rounding keeps order, so that they bound what comes of the rays as well.
struct Bounds<L> {
    origin: [Span<L>; 3],
    /// Inverse of the directions that lead ahead.
    ahead: [Span<L>; 3],
    /// The same of those that lead back, without sign.
    back: [Span<L>; 3],
}

impl<L: Lanes> Bounds<L> {
    #[inline(always)]
    fn new(groups: &[Group<L>; GROUPS]) -> Self {
        let zero = L::all(0.0);
        // Where no ray leads ahead, or none back: enters at infinity, leaves at nought.
        let none = Span { least: L::all(f32::MAX), most: L::all(f32::MIN_POSITIVE) };
        let nowhere = Span { least: L::all(f32::INFINITY), most: L::all(f32::NEG_INFINITY) };
        let mut bounds = Self { origin: [nowhere; 3], ahead: [none; 3], back: [none; 3] };
        for a in 0..3 {
            let (origin, ahead, back) = (&mut bounds.origin[a], &mut bounds.ahead[a], &mut bounds.back[a]);
            for group in groups {
                let (o, inverse) = (group.origin[a], group.inverse[a]);
                let is_ahead = zero.below(inverse);
                *origin = Span { least: o.least(origin.least), most: o.most(origin.most) };
                *ahead = Span {
                    least: L::pick(is_ahead, inverse, none.least).least(ahead.least),
                    most: L::pick(is_ahead, inverse, none.most).most(ahead.most),
                };
                let inverse = zero - inverse;
                *back = Span {
                    least: L::pick(is_ahead, none.least, inverse).least(back.least),
                    most: L::pick(is_ahead, none.most, inverse).most(back.most),
                };
            }
            (*origin, *ahead, *back) = (origin.even(), ahead.even(), back.even());
        }
        bounds
    }

    /// No ray enters a box before, and no ray enters one that is left out.
    #[inline(always)]
    fn enter(&self, node: &Node, t_max: f32) -> (L, u32) {
        let (mut near, mut far) = (L::all(0.0), L::all(f32::INFINITY));
        for a in 0..3 {
            let (low, high) = (L::load(&node.low[a]), L::load(&node.high[a]));
            let (origin, ahead, back) = (self.origin[a], self.ahead[a], self.back[a]);
            near = ((low - origin.most) * ahead.least).most((origin.least - high) * back.least).most(near);
            far = ((high - origin.least) * ahead.most).most((origin.most - low) * back.most).least(far);
        }
        reach(near, far, L::all(t_max))
    }
}

/// Closest hits of a packet.
#[inline(always)]
pub(super) fn packet<L: Lanes>(tree: &Tree, rays: &[Ray; PACKET], hits: &mut [Hit; PACKET]) {
    let mut groups: [Group<L>; GROUPS] = [Group::new(&rays[..WIDTH]), Group::new(&rays[WIDTH..])];
    let bounds = Bounds::new(&groups);
    let mut limit = furthest(&groups);
    let mut stack = Stack::new();
    let mut next = Some(0);
    while let Some(index) = next.take() {
        let node = &tree.nodes[index as usize];
        let (near, open) = bounds.enter(node, limit);
        // A box is known by its place in the tree: its child is not, but needs the box again.
        stack.add(&near.store(), open & node.used(), |l| index * WIDTH as u32 + l as u32);
        while let Some((near, place)) = stack.pop() {
            if near > limit {
                continue;
            }
            let (node, lane) = (&tree.nodes[place as usize / WIDTH], place as usize % WIDTH);
            let entered = [groups[0].enter(node, lane), groups[1].enter(node, lane)];
            let active = entered[0].1.count_ones() + entered[1].1.count_ones();
            let child = node.child[lane];
            if active > FEW && child & LEAF == 0 {
                next = Some(child);
                break;
            }
            for (g, (near, open)) in entered.into_iter().enumerate().filter(|(_, (_, open))| *open != 0) {
                if active > FEW {
                    groups[g].meet(&tree.leaves[(child ^ LEAF) as usize], near, open);
                } else {
                    groups[g].part(tree, near, open, child);
                }
            }
            if active > 0 {
                limit = furthest(&groups);
            }
        }
    }
    for (group, hits) in groups.iter().zip(hits.chunks_exact_mut(WIDTH)) {
        let (t, key) = (group.t.store(), group.key.store());
        for l in 0..WIDTH {
            hits[l] = Best { t: t[l], key: key[l].to_bits() }.hit();
        }
    }
}
