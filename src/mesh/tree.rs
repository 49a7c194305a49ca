//! A quadtree over both sides of every surface: patches of all sizes, for hierarchical radiosity.
//!
//! Source: Hanrahan, Salzman and Aupperle 1991. Roots are whole sides, cut along the lines on which other surfaces stand; a
//! node is divided when somebody asks, into quarters or, where it is long, into halves.

use std::ops::Range;

use glam::DVec2;

use super::linear::Weights;
use super::polygon::{clip_halfplane, polygon_area};
use super::surfaces::{Surface, Surfaces};
use super::uniform::{Patch, Patches, deepest, pieces_of_cell};

/// A piece with less than this share of its node is left out.
const SLIVER: f64 = 1e-9;
/// A node longer than this many times its width is halved across.
const LONG: f64 = 1.5;

/// A patch of some size, and those that it is made of.
#[derive(Clone, Debug)]
pub struct Node {
    /// The patch.
    pub patch: Patch,
    /// Nodes that divide it; none for a leaf.
    pub children: Range<u32>,
    /// Bounding rectangle in the surface's (u, v).
    low: DVec2,
    high: DVec2,
    /// Place among the leaves, when it is one.
    leaf: u32,
}

/// Patches of all sizes; children come after their parents.
#[derive(Clone, Debug)]
pub struct PatchTree {
    /// All nodes.
    pub nodes: Vec<Node>,
    /// Roots of both sides of every surface.
    roots: Vec<[Range<u32>; 2]>,
    leaves: Vec<Patch>,
}

impl Node {
    fn new(patch: Patch) -> Self {
        let low = patch.outline.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = patch.outline.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        Self { patch, children: 0..0, low, high, leaf: 0 }
    }

    /// Longer side of its rectangle, in the program's frame.
    #[must_use]
    pub fn size(&self) -> f64 {
        (self.high - self.low).max_element()
    }

    /// Is it undivided?
    #[must_use]
    pub fn is_leaf(&self) -> bool {
        self.children.is_empty()
    }

    /// Its outline cut into quarters, or across where it is long.
    fn parts(&self) -> Vec<Vec<DVec2>> {
        let (middle, extent) = (0.5 * (self.low + self.high), self.high - self.low);
        let mut parts = vec![self.patch.outline.clone()];
        for (axis, long) in [(DVec2::X, extent.y > LONG * extent.x), (DVec2::Y, extent.x > LONG * extent.y)] {
            if !long {
                let halves = |p: &Vec<DVec2>| {
                    [-axis, axis].map(|normal| {
                        let mut half = Vec::new();
                        clip_halfplane(p, middle, normal, &mut half);
                        half
                    })
                };
                parts = parts.iter().flat_map(halves).collect();
            }
        }
        parts.retain(|p| p.len() >= 3 && polygon_area(p) > SLIVER * extent.x * extent.y);
        parts
    }
}

impl PatchTree {
    /// The roots alone; those that are not to be `kept` never become part of it.
    #[must_use]
    pub fn new(surfaces: &Surfaces, mut kept: impl FnMut(&Patch) -> bool) -> Self {
        let mut tree = Self { nodes: Vec::new(), roots: Vec::with_capacity(surfaces.list.len()), leaves: Vec::new() };
        for (i, s) in surfaces.list.iter().enumerate() {
            let pieces = pieces_of_cell(s, [0, 0], s.extent);
            let roots = [false, true].map(|front| {
                let first = tree.nodes.len() as u32;
                let patches = pieces.iter().map(|outline| Patch::new(s, i as u32, front, [0, 0], outline.clone()));
                tree.nodes.extend(patches.filter(|p| kept(p)).map(Node::new));
                first..tree.nodes.len() as u32
            });
            tree.roots.push(roots);
        }
        tree.number_leaves();
        tree
    }

    /// Number of roots: they come first side by side, before any child.
    #[must_use]
    pub fn roots(&self) -> usize {
        self.roots.last().map_or(0, |sides| sides[1].end as usize)
    }

    /// Divides a node that is whole; the leaves are not numbered anew.
    pub fn divide(&mut self, surface: &Surface, node: usize) {
        let (whole, first) = (&self.nodes[node], self.nodes.len() as u32);
        if whole.is_leaf() {
            let Patch { surface: number, front, .. } = whole.patch;
            let parts = whole.parts();
            self.nodes.extend(parts.into_iter().map(|p| Node::new(Patch::new(surface, number, front, [0, 0], p))));
            self.nodes[node].children = first..self.nodes.len() as u32;
        }
    }

    /// Numbers the leaves: to be called when all that is to be divided is.
    pub fn number_leaves(&mut self) {
        self.leaves.clear();
        for node in self.nodes.iter_mut().filter(|n| n.is_leaf()) {
            node.leaf = self.leaves.len() as u32;
            self.leaves.push(node.patch.clone());
        }
    }

    /// Values of all nodes from those of the leaves, a row of `width` for each: means by area.
    #[must_use]
    pub fn pull(&self, leaves: &[f64], width: usize) -> Vec<f64> {
        let mut all = vec![0.0; self.nodes.len() * width];
        for (i, node) in self.nodes.iter().enumerate().rev() {
            if node.is_leaf() {
                let from = node.leaf as usize * width;
                all[i * width..(i + 1) * width].copy_from_slice(&leaves[from..from + width]);
            } else {
                for c in node.children.clone().map(|c| c as usize) {
                    let share = self.nodes[c].patch.area / node.patch.area;
                    for k in 0..width {
                        all[i * width + k] += share * all[c * width + k];
                    }
                }
            }
        }
        all
    }

    /// Values of the leaves: each the sum over itself and the nodes that it lies in.
    #[must_use]
    pub fn push(&self, mut all: Vec<f64>, width: usize) -> Vec<f64> {
        let mut leaves = vec![0.0; self.leaves.len() * width];
        for (i, node) in self.nodes.iter().enumerate() {
            for c in node.children.clone().map(|c| c as usize) {
                for k in 0..width {
                    all[c * width + k] += all[i * width + k];
                }
            }
            if node.is_leaf() {
                let to = node.leaf as usize * width;
                leaves[to..to + width].copy_from_slice(&all[i * width..(i + 1) * width]);
            }
        }
        leaves
    }

    /// The leaf under a point of a surface's side, as a node.
    fn leaf_at(&self, surface: usize, front: bool, uv: DVec2) -> Option<&Node> {
        let mut range = self.roots[surface][usize::from(front)].clone();
        loop {
            let under = deepest(range, |i| &self.nodes[i as usize].patch.outline, uv)?;
            let node = &self.nodes[under as usize];
            if node.is_leaf() {
                return Some(node);
            }
            range = node.children.clone();
        }
    }
}

impl Patches for PatchTree {
    fn list(&self) -> &[Patch] {
        &self.leaves
    }

    fn find(&self, surface: usize, front: bool, uv: DVec2) -> Option<u32> {
        self.leaf_at(surface, front, uv).map(|n| n.leaf)
    }

    /// Linear between the middle of the leaf and places its own width away, continued to the border of the surface.
    fn weights(&self, surface: usize, front: bool, uv: DVec2) -> Option<Weights> {
        let leaf = self.leaf_at(surface, front, uv)?;
        let (middle, width) = (0.5 * (leaf.low + leaf.high), leaf.high - leaf.low);
        let at = |p: DVec2| {
            let other = self.leaf_at(surface, front, p)?;
            // The nearest leaf stands for what lies beyond the border; it is not there.
            let inside = p.cmpge(other.low - 1e-9).all() && p.cmple(other.high + 1e-9).all();
            inside.then_some(other.leaf as usize)
        };
        let across = |axis: DVec2| {
            let place = (uv - middle).dot(axis) / width.dot(axis);
            let step = |sign: f64| axis * (sign * width.dot(axis));
            let there = [place.signum(), -place.signum()].into_iter().find(|s| at(middle + step(*s)).is_some());
            there.map_or((DVec2::ZERO, 0.0), |sign| (step(sign), place * sign))
        };
        let ((du, tu), (dv, tv)) = (across(DVec2::X), across(DVec2::Y));
        Some([
            (at(middle)?, (1.0 - tu) * (1.0 - tv)),
            (at(middle + du)?, tu * (1.0 - tv)),
            (at(middle + dv)?, (1.0 - tu) * tv),
            (at(middle + du + dv)?, tu * tv),
        ])
    }
}
