//! An eight-wide bounding volume hierarchy over triangles, built by binned surface-area heuristic (Wald 2007).

use glam::Vec3A;
use rayon::prelude::*;

/// Lanes of a node and of a leaf.
pub(super) const WIDTH: usize = 8;
/// An empty child.
pub(super) const EMPTY: u32 = u32::MAX;
/// Marks a child that is a leaf.
pub(super) const LEAF: u32 = 1 << 31;

/// Eight boxes, by axis.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Node {
    pub(super) low: [[f32; WIDTH]; 3],
    pub(super) high: [[f32; WIDTH]; 3],
    pub(super) child: [u32; WIDTH],
    children: u32,
}

impl Node {
    /// Lanes with children, in bits.
    #[inline(always)]
    pub(super) fn used(&self) -> u32 {
        (1 << self.children) - 1
    }
}

/// Eight triangles, by vertex and axis; unused lanes come last and hold no numbers, which nothing hits.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Leaf {
    pub(super) vertex: [[[f32; WIDTH]; 3]; 3],
    pub(super) surface: [u32; WIDTH],
}

/// A triangle with the surface it belongs to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) vertices: [Vec3A; 3],
    pub(super) surface: u32,
}

/// Levels above the triangles from which on each part holds half of them, whatever the heuristic says: 2^31 triangles then
/// end within [`MOST_LEVELS`].
const HEURISTIC_LEVELS: usize = 24;
/// Levels of nodes at most.
pub(super) const MOST_LEVELS: usize = 36;

/// The tree: `nodes[0]` is the root.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
    pub(super) leaves: Vec<Leaf>,
}

#[derive(Clone, Copy)]
struct Bounds {
    low: Vec3A,
    high: Vec3A,
}

impl Bounds {
    const NONE: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn half_area(self) -> f32 {
        let d = (self.high - self.low).max(Vec3A::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    fn centre(self) -> Vec3A {
        (self.low + self.high) * 0.5
    }
}

#[derive(Clone, Copy)]
struct Item {
    low: [f32; 3],
    high: [f32; 3],
    /// Which triangle.
    index: u32,
}

impl Item {
    fn new(index: usize, triangle: &Triangle) -> Self {
        let [a, b, c] = triangle.vertices;
        Self { low: a.min(b).min(c).to_array(), high: a.max(b).max(c).to_array(), index: index as u32 }
    }

    fn bounds(&self) -> Bounds {
        Bounds { low: Vec3A::from_array(self.low), high: Vec3A::from_array(self.high) }
    }

    fn centre(&self) -> Vec3A {
        self.bounds().centre()
    }
}

/// From so many triangles on the parts of a node grow side by side.
const SIDE_BY_SIDE: usize = 1 << 13;

impl Tree {
    pub(super) fn build(triangles: &[Triangle]) -> Self {
        let mut items: Vec<Item> = triangles.par_iter().enumerate().map(|(i, t)| Item::new(i, t)).collect();
        let mut tree = Self::default();
        if !items.is_empty() {
            tree.node(triangles, &mut items, 1);
        }
        tree
    }

    fn node(&mut self, triangles: &[Triangle], items: &mut [Item], level: usize) -> u32 {
        let index = self.nodes.len() as u32;
        self.nodes.push(Node {
            low: [[f32::INFINITY; WIDTH]; 3],
            high: [[f32::NEG_INFINITY; WIDTH]; 3],
            child: [EMPTY; WIDTH],
            children: 0,
        });
        let many = items.len() >= SIDE_BY_SIDE;
        let (parts, bounds): (Vec<_>, Vec<_>) = split_in_eight(items, level < HEURISTIC_LEVELS).into_iter().unzip();
        let children: Vec<u32> = if many {
            let grow = |part| {
                let mut tree = Self::default();
                let root = tree.child(triangles, part, level + 1);
                (tree, root)
            };
            let trees: Vec<(Self, u32)> = parts.into_par_iter().map(grow).collect();
            trees.into_iter().map(|(tree, root)| self.graft(tree, root)).collect()
        } else {
            parts.into_iter().map(|part| self.child(triangles, part, level + 1)).collect()
        };
        let node = &mut self.nodes[index as usize];
        for (lane, (child, bounds)) in children.into_iter().zip(bounds).enumerate() {
            for axis in 0..3 {
                node.low[axis][lane] = bounds.low[axis];
                node.high[axis][lane] = bounds.high[axis];
            }
            node.child[lane] = child;
            node.children += 1;
        }
        index
    }

    fn child(&mut self, triangles: &[Triangle], items: &mut [Item], level: usize) -> u32 {
        if items.len() <= WIDTH { self.leaf(triangles, items) } else { self.node(triangles, items, level) }
    }

    fn leaf(&mut self, triangles: &[Triangle], items: &[Item]) -> u32 {
        let mut leaf = Leaf { vertex: [[[f32::NAN; WIDTH]; 3]; 3], surface: [EMPTY; WIDTH] };
        for (lane, item) in items.iter().enumerate() {
            let triangle = &triangles[item.index as usize];
            for (v, p) in triangle.vertices.iter().enumerate() {
                for axis in 0..3 {
                    leaf.vertex[v][axis][lane] = p[axis];
                }
            }
            leaf.surface[lane] = triangle.surface;
        }
        self.leaves.push(leaf);
        (self.leaves.len() as u32 - 1) | LEAF
    }

    /// Takes over a tree that grew by itself, and gives its root.
    fn graft(&mut self, tree: Self, root: u32) -> u32 {
        let (nodes, leaves) = (self.nodes.len() as u32, self.leaves.len() as u32);
        let moved = |child: u32| match child {
            EMPTY => EMPTY,
            _ if child & LEAF != 0 => child + leaves,
            _ => child + nodes,
        };
        self.nodes.extend(tree.nodes.into_iter().map(|node| Node { child: node.child.map(moved), ..node }));
        self.leaves.extend(tree.leaves);
        moved(root)
    }
}

fn bounds_of(items: &[Item]) -> Bounds {
    items.iter().fold(Bounds::NONE, |b, i| b.with(i.bounds()))
}

/// Up to eight parts: the part with the largest surface, or the one with most triangles, is split again and again.
fn split_in_eight(items: &mut [Item], by_surface: bool) -> Vec<(&mut [Item], Bounds)> {
    let bounds = bounds_of(items);
    let mut parts = vec![(items, bounds)];
    while parts.len() < WIDTH {
        let Some(largest) = (0..parts.len()).filter(|k| parts[*k].0.len() > WIDTH).max_by(|a, b| {
            let (a, b) = (&parts[*a], &parts[*b]);
            let by_count = a.0.len().cmp(&b.0.len());
            if by_surface { a.1.half_area().total_cmp(&b.1.half_area()) } else { by_count }
        }) else {
            break;
        };
        let (part, bounds) = parts.swap_remove(largest);
        let middle = part.len() / 2;
        let (left, right) = if by_surface { split(part, bounds) } else { part.split_at_mut(middle) };
        let (l, r) = (bounds_of(left), bounds_of(right));
        parts.push((left, l));
        parts.push((right, r));
    }
    parts
}

const BINS: usize = 16;

/// Splits where the surface-area heuristic says; leaves are filled in eights.
fn split(items: &mut [Item], bounds: Bounds) -> (&mut [Item], &mut [Item]) {
    let centres = items.iter().fold(Bounds::NONE, |b, i| {
        let c = i.centre();
        b.with(Bounds { low: c, high: c })
    });
    let middle = items.len() / 2;
    let at = match best_plane(items, centres) {
        Some((axis, bin)) => {
            let place = placer(centres);
            parted(items, |i| place(i)[axis] <= bin)
        }
        None => {
            let d = bounds.high - bounds.low;
            let axis = if d.x >= d.y && d.x >= d.z { 0 } else { 1 + usize::from(d.z > d.y) };
            items.sort_by(|a, b| a.centre()[axis].total_cmp(&b.centre()[axis]));
            middle
        }
    };
    items.split_at_mut(if at == 0 || at == items.len() { middle } else { at })
}

/// Puts items that belong to the left before the others, and counts them.
fn parted(items: &mut [Item], left: impl Fn(&Item) -> bool) -> usize {
    let (mut at, mut end) = (0, items.len());
    while at < end {
        if left(&items[at]) {
            at += 1;
        } else {
            end -= 1;
            items.swap(at, end);
        }
    }
    at
}

/// The bin of an item along each axis.
fn placer(centres: Bounds) -> impl Fn(&Item) -> [usize; 3] {
    let width = centres.high - centres.low;
    let bins = Vec3A::splat(BINS as f32);
    move |i| ((i.centre() - centres.low) / width * bins).to_array().map(|x| (x as usize).min(BINS - 1))
}

/// The cheapest plane: axis, and last bin on the left.
fn best_plane(items: &[Item], centres: Bounds) -> Option<(usize, usize)> {
    let place = placer(centres);
    let mut bins = [[(Bounds::NONE, 0usize); BINS]; 3];
    for i in items {
        for (bins, at) in bins.iter_mut().zip(place(i)) {
            let bin = &mut bins[at];
            *bin = (bin.0.with(i.bounds()), bin.1 + 1);
        }
    }
    let packets = |n: usize| n.div_ceil(WIDTH) as f32;
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|axis| centres.low[*axis] < centres.high[*axis]) {
        let bins = &bins[axis];
        let mut right = [(0.0f32, 0usize); BINS];
        let mut sweep = (Bounds::NONE, 0);
        for k in (1..BINS).rev() {
            sweep = (sweep.0.with(bins[k].0), sweep.1 + bins[k].1);
            right[k] = (sweep.0.half_area(), sweep.1);
        }
        sweep = (Bounds::NONE, 0);
        for k in 0..BINS - 1 {
            sweep = (sweep.0.with(bins[k].0), sweep.1 + bins[k].1);
            if sweep.1 == 0 || right[k + 1].1 == 0 {
                continue;
            }
            let cost = sweep.0.half_area() * packets(sweep.1) + right[k + 1].0 * packets(right[k + 1].1);
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, k));
            }
        }
    }
    best.map(|(_, axis, bin)| (axis, bin))
}
