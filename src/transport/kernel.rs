//! The inner loops of the ray caster.
//!
//! The triangle test is watertight along shared edges (Woop, Benthin and Wald 2013): the three edge functions of two
//! triangles that share an edge are exact negatives of each other.

use super::bvh::{EMPTY, LEAF, Leaf, MOST_LEVELS, Node, Tree, WIDTH};
use super::caster::{Hit, Ray};
use crate::vector::wide;

/// Levels that a small stack is good for: to clear a large one takes as long as a ray through a small room.
const FEW_LEVELS: usize = 4;

/// Children that wait at most: seven siblings at each level, and the last child.
const fn waiting(levels: usize) -> usize {
    7 * levels + 1
}

struct Prepared {
    origin: [f32; 3],
    inverse: [f32; 3],
    /// Axes of the sheared frame; `axes[2]` is the largest component of the direction.
    axes: [usize; 3],
    shear: [f32; 3],
}

impl Prepared {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let kz = if d[0].abs() > d[1].abs() {
            if d[0].abs() > d[2].abs() { 0 } else { 2 }
        } else if d[1].abs() > d[2].abs() {
            1
        } else {
            2
        };
        let (mut kx, mut ky) = ((kz + 1) % 3, (kz + 2) % 3);
        if d[kz] < 0.0 {
            std::mem::swap(&mut kx, &mut ky);
        }
        let safe = |x: f32| 1.0 / if x.abs() < 1e-30 { 1e-30f32.copysign(x) } else { x };
        Self {
            origin: ray.origin,
            inverse: d.map(safe),
            axes: [kx, ky, kz],
            shear: [d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]],
        }
    }
}

#[inline(always)]
fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Where the ray enters each of the eight boxes; infinity where it does not before `t_max`.
#[inline(always)]
fn enter_boxes(node: &Node, ray: &Prepared, t_max: f32) -> [f32; WIDTH] {
    let mut near = [0.0f32; WIDTH];
    let mut far = [t_max; WIDTH];
    for axis in 0..3 {
        let (o, inv) = (ray.origin[axis], ray.inverse[axis]);
        let (first, second) =
            if inv < 0.0 { (&node.high[axis], &node.low[axis]) } else { (&node.low[axis], &node.high[axis]) };
        for lane in 0..WIDTH {
            near[lane] = most(near[lane], (first[lane] - o) * inv);
            far[lane] = least(far[lane], (second[lane] - o) * inv);
        }
    }
    // Two ulps of slack: the slabs' rounding must not lose a hit (Ize 2013).
    std::array::from_fn(|lane| if near[lane] <= far[lane] * 1.000_001 { near[lane] } else { f32::INFINITY })
}

/// Distance at which the ray meets each of the eight triangles; infinity where it does not.
#[inline(always)]
fn meet_triangles(leaf: &Leaf, ray: &Prepared, t_max: f32) -> [f32; WIDTH] {
    let [kx, ky, kz] = ray.axes;
    let [sx, sy, sz] = ray.shear;
    let mut x = [[0.0f32; WIDTH]; 3];
    let mut y = [[0.0f32; WIDTH]; 3];
    let mut z = [[0.0f32; WIDTH]; 3];
    for v in 0..3 {
        let p = &leaf.vertex[v];
        for lane in 0..WIDTH {
            let pz = p[kz][lane] - ray.origin[kz];
            x[v][lane] = (p[kx][lane] - ray.origin[kx]) - sx * pz;
            y[v][lane] = (p[ky][lane] - ray.origin[ky]) - sy * pz;
            z[v][lane] = sz * pz;
        }
    }
    let mut t = [f32::INFINITY; WIDTH];
    for lane in 0..WIDTH {
        let u = x[2][lane] * y[1][lane] - y[2][lane] * x[1][lane];
        let v = x[0][lane] * y[2][lane] - y[0][lane] * x[2][lane];
        let w = x[1][lane] * y[0][lane] - y[1][lane] * x[0][lane];
        let low = least(u, least(v, w));
        let high = most(u, most(v, w));
        let det = u + v + w;
        let distance = (u * z[0][lane] + v * z[1][lane] + w * z[2][lane]) / det;
        let inside = (low >= 0.0) | (high <= 0.0);
        let hit = inside & (det != 0.0) & (distance > 0.0) & (distance < t_max);
        t[lane] = if hit { distance } else { f32::INFINITY };
    }
    t
}

#[inline(always)]
fn closest_generic(tree: &Tree, ray: &Ray, stack: &mut [(f32, u32)]) -> Hit {
    let prepared = Prepared::new(ray);
    let mut best = Hit { t: ray.t_max, surface: EMPTY };
    stack[0] = (0.0, 0);
    let mut depth = 1;
    while depth > 0 {
        depth -= 1;
        let (near, child) = stack[depth];
        if near >= best.t {
            continue;
        }
        if child & LEAF != 0 {
            let leaf = &tree.leaves[(child ^ LEAF) as usize];
            let t = meet_triangles(leaf, &prepared, best.t);
            for lane in 0..WIDTH {
                if t[lane] < best.t {
                    best = Hit { t: t[lane], surface: leaf.surface[lane] };
                }
            }
            continue;
        }
        let node = &tree.nodes[child as usize];
        let entry = enter_boxes(node, &prepared, best.t);
        let base = depth;
        for lane in 0..WIDTH {
            if entry[lane] < f32::INFINITY && node.child[lane] != EMPTY {
                // Insertion keeps the nearest on top.
                let mut k = depth;
                while k > base && stack[k - 1].0 < entry[lane] {
                    stack[k] = stack[k - 1];
                    k -= 1;
                }
                stack[k] = (entry[lane], node.child[lane]);
                depth += 1;
            }
        }
    }
    best
}

wide! {
    fn closest_all(tree: &Tree, rays: &[Ray], hits: &mut [Hit]) {
        if tree.levels <= FEW_LEVELS {
            closest_by::<{ waiting(FEW_LEVELS) }>(tree, rays, hits);
        } else {
            closest_by::<{ waiting(MOST_LEVELS) }>(tree, rays, hits);
        }
    }
}

#[inline(always)]
fn closest_by<const WAITING: usize>(tree: &Tree, rays: &[Ray], hits: &mut [Hit]) {
    let mut stack = [(0.0, 0); WAITING];
    for (ray, hit) in rays.iter().zip(hits) {
        *hit = closest_generic(tree, ray, &mut stack);
    }
}

/// Closest hits of a slice of rays.
#[inline]
pub(super) fn closest(tree: &Tree, rays: &[Ray], hits: &mut [Hit]) {
    if tree.nodes.is_empty() {
        hits.iter_mut().zip(rays).for_each(|(h, r)| *h = Hit { t: r.t_max, surface: EMPTY });
        return;
    }
    closest_all(tree, rays, hits);
}
