//! An eight-wide bounding volume hierarchy over triangles, built by binned surface-area heuristic (Wald 2007).

use glam::Vec3A;

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

struct Item {
    bounds: Bounds,
    triangle: Triangle,
}

impl Tree {
    pub(super) fn build(triangles: &[Triangle]) -> Self {
        let mut items: Vec<Item> = triangles
            .iter()
            .map(|t| {
                let low = t.vertices[0].min(t.vertices[1]).min(t.vertices[2]);
                let high = t.vertices[0].max(t.vertices[1]).max(t.vertices[2]);
                Item { bounds: Bounds { low, high }, triangle: *t }
            })
            .collect();
        let mut tree = Self::default();
        if !items.is_empty() {
            tree.node(&mut items, 1);
        }
        tree
    }

    fn node(&mut self, items: &mut [Item], level: usize) -> u32 {
        let index = self.nodes.len() as u32;
        self.nodes.push(Node {
            low: [[f32::INFINITY; WIDTH]; 3],
            high: [[f32::NEG_INFINITY; WIDTH]; 3],
            child: [EMPTY; WIDTH],
            children: 0,
        });
        for (lane, (part, bounds)) in split_in_eight(items, level < HEURISTIC_LEVELS).into_iter().enumerate() {
            let child = if part.len() <= WIDTH { self.leaf(part) } else { self.node(part, level + 1) };
            let node = &mut self.nodes[index as usize];
            for axis in 0..3 {
                node.low[axis][lane] = bounds.low[axis];
                node.high[axis][lane] = bounds.high[axis];
            }
            node.child[lane] = child;
            node.children += 1;
        }
        index
    }

    fn leaf(&mut self, items: &[Item]) -> u32 {
        let mut leaf = Leaf { vertex: [[[f32::NAN; WIDTH]; 3]; 3], surface: [EMPTY; WIDTH] };
        for (lane, item) in items.iter().enumerate() {
            for (v, p) in item.triangle.vertices.iter().enumerate() {
                for axis in 0..3 {
                    leaf.vertex[v][axis][lane] = p[axis];
                }
            }
            leaf.surface[lane] = item.triangle.surface;
        }
        self.leaves.push(leaf);
        (self.leaves.len() as u32 - 1) | LEAF
    }
}

fn bounds_of(items: &[Item]) -> Bounds {
    items.iter().fold(Bounds::NONE, |b, i| b.with(i.bounds))
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
        let c = i.bounds.centre();
        b.with(Bounds { low: c, high: c })
    });
    let best = (0..3).filter_map(|axis| best_plane(items, centres, axis)).min_by(|a, b| a.0.total_cmp(&b.0));
    let middle = items.len() / 2;
    let at = match best {
        Some((_, axis, bin)) => {
            let place = placer(centres, axis);
            items.sort_by_key(|i| place(i) > bin); // stable: the order is a function of the input alone
            items.iter().take_while(|i| place(i) <= bin).count()
        }
        None => {
            let d = bounds.high - bounds.low;
            let axis = if d.x >= d.y && d.x >= d.z { 0 } else { 1 + usize::from(d.z > d.y) };
            items.sort_by(|a, b| a.bounds.centre()[axis].total_cmp(&b.bounds.centre()[axis]));
            middle
        }
    };
    items.split_at_mut(if at == 0 || at == items.len() { middle } else { at })
}

fn placer(centres: Bounds, axis: usize) -> impl Fn(&Item) -> usize {
    let (low, width) = (centres.low[axis], centres.high[axis] - centres.low[axis]);
    move |i: &Item| (((i.bounds.centre()[axis] - low) / width * BINS as f32) as usize).min(BINS - 1)
}

/// The cheapest plane along an axis: cost, axis, last bin on the left.
fn best_plane(items: &[Item], centres: Bounds, axis: usize) -> Option<(f32, usize, usize)> {
    if centres.high[axis] <= centres.low[axis] {
        return None;
    }
    let place = placer(centres, axis);
    let mut bins = [(Bounds::NONE, 0usize); BINS];
    for i in items {
        let bin = &mut bins[place(i)];
        *bin = (bin.0.with(i.bounds), bin.1 + 1);
    }
    let packets = |n: usize| n.div_ceil(WIDTH) as f32;
    let mut right = [(0.0f32, 0usize); BINS];
    let mut sweep = (Bounds::NONE, 0);
    for k in (1..BINS).rev() {
        sweep = (sweep.0.with(bins[k].0), sweep.1 + bins[k].1);
        right[k] = (sweep.0.half_area(), sweep.1);
    }
    let mut best = None;
    sweep = (Bounds::NONE, 0);
    for k in 0..BINS - 1 {
        sweep = (sweep.0.with(bins[k].0), sweep.1 + bins[k].1);
        if sweep.1 == 0 || right[k + 1].1 == 0 {
            continue;
        }
        let cost = sweep.0.half_area() * packets(sweep.1) + right[k + 1].0 * packets(right[k + 1].1);
        if best.is_none_or(|(c, _, _)| cost < c) {
            best = Some((cost, axis, k));
        }
    }
    best
}
