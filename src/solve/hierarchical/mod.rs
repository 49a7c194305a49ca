//! Hierarchical radiosity: light is exchanged between patches of the sizes that the exchange needs.
//!
//! Source: Hanrahan, Salzman and Aupperle 1991. In: a [`PatchTree`] of roots, reflectances and emission, and a
//! [`Refinement`]. Out: the tree divided, links between its nodes, and the solution at its leaves. Links are refined by
//! what they carry (`refine.rs`); the system is solved anew with them, until no link asks to be refined. The links act as
//! the matrix of the leaves without its entries: radiosities are pulled up the tree, gathered over the links, and pushed
//! down, so that the solvers of [`dense`](super::dense) can work on them.

mod refine;

use rayon::prelude::*;

use super::dense::{Operator, Outcome, System};
use crate::error::Result;
use crate::mesh::{Patch, PatchTree, Patches};
use crate::transport::World;
use crate::transport::form_factor::{sees_anything, staying_shares, too_far_off};

pub use refine::Refinement;
use refine::{Link, Refiner};

/// Solutions that links are refined by, at most; few are needed, each adds what a bounce makes bright.
const MOST_ROUNDS: usize = 12;
/// Residual of the solutions that only tell where light is.
const ROUGH: f64 = 1e-3;
/// Rays from each leaf that tell how much of its light stays in the scene.
const LOOKS: u32 = 512;
/// Sweeps of the balance, at most, and the defect at which it ends; narrow gaps take many.
const SWEEPS: usize = 3000;
const BALANCED: f64 = 1e-7;

/// Patches of all sizes and the links between them.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    /// The patches; the system is that of the leaves.
    pub tree: PatchTree,
    /// Exchange areas of each node with the nodes that it is linked to, node by node.
    links: Vec<(u32, f64)>,
    /// For each node its first link; one more at the end.
    first: Vec<usize>,
    /// Makes rows sum what they must: of each leaf, for what it sends and what it receives.
    scale: Vec<f64>,
    /// Share of the light of each leaf that stays in the scene.
    stays: Vec<f64>,
    /// Does no light leave the scene?
    pub closed: bool,
    /// Root mean square, by area, of the relative defect of the row sums before the balance.
    pub closure_defect: f64,
    /// The largest of a root, and which one.
    pub worst_root: (f64, usize),
    /// Rays cast.
    pub rays: u64,
    /// Form factors worked out.
    pub factors: u64,
    /// Solutions that the links were refined by.
    pub rounds: usize,
}

/// A solved hierarchy.
#[derive(Clone, Debug)]
pub struct Solved {
    /// The links.
    pub hierarchy: Hierarchy,
    /// The system of the leaves.
    pub system: System,
    /// Its solution.
    pub outcome: Outcome,
}

/// Refines and solves a scene. `paint` gives the system of some patches.
///
/// # Errors
///
/// When more links are asked for than are taken, when the form factors of a root do not close to `largest` (relative), or
/// when there is no finite solution.
pub fn solve(
    world: &World,
    paint: &dyn Fn(&[Patch]) -> System,
    refinement: Refinement,
    largest: f64,
    accuracy: f64,
) -> Result<Solved> {
    let mut tree = PatchTree::new(&world.surfaces, |p| sees_anything(world, p));
    let mut refiner = Refiner::new(world, refinement);
    let mut waiting = refiner.roots(&tree);
    let emission = paint(tree.list());
    let mut brightness = brightness(&tree, &emission, &emission.emitted);
    let mut rounds = 0;
    let mut hierarchy = loop {
        refiner.refine(&mut tree, waiting, &mut brightness)?;
        rounds += 1;
        let stays = staying_shares(world, &tree, LOOKS);
        refiner.rays += stays.len() as u64 * u64::from(LOOKS);
        let mut hierarchy = Hierarchy::new(tree, &refiner.links, stays);
        hierarchy.balance();
        let system = paint(hierarchy.tree.list());
        let rough = system.solve_by_products(&hierarchy, ROUGH)?;
        brightness = self::brightness(&hierarchy.tree, &system, &rough.radiosity);
        waiting = if rounds < MOST_ROUNDS { refiner.take_bright(&hierarchy.tree, &brightness) } else { Vec::new() };
        if waiting.is_empty() {
            break hierarchy;
        }
        tree = hierarchy.tree;
    };
    let (off, root) = hierarchy.worst_root;
    if off > largest {
        return Err(too_far_off(world, &hierarchy.tree.nodes[root].patch, off, largest));
    }
    (hierarchy.rays, hierarchy.factors, hierarchy.rounds) = (refiner.rays, refiner.factors, rounds);
    let system = paint(hierarchy.tree.list());
    let outcome = system.solve_by_products(&hierarchy, accuracy)?;
    Ok(Solved { hierarchy, system, outcome })
}

/// Radiosity of every node against that which the light would have if it were spread evenly, `Φ / (A (1 − ρ̄))`; the
/// largest over the bands.
fn brightness(tree: &PatchTree, system: &System, radiosity: &[f64]) -> Vec<f64> {
    let bands = system.bands;
    let area: f64 = system.areas.iter().sum();
    let (emitted, reflecting) = (system.emitted_flux(), system.mean_rho());
    let even: Vec<f64> =
        emitted.iter().zip(&reflecting).map(|(flux, rho)| flux / (area * (1.0 - rho).max(1e-6))).collect();
    let relative = |b: &[f64]| b.iter().zip(&even).filter(|(_, e)| **e > 0.0).map(|(b, e)| b / e).fold(0.0, f64::max);
    tree.pull(radiosity, bands).chunks_exact(bands.max(1)).map(relative).collect()
}

impl Hierarchy {
    /// Sorts the links by node. `tree` has its leaves numbered.
    fn new(tree: PatchTree, list: &[Link], stays: Vec<f64>) -> Self {
        let mut first = vec![0; tree.nodes.len() + 1];
        let ends = || list.iter().flat_map(|l| [(l.a, l.b, l.exchange), (l.b, l.a, l.exchange)]);
        ends().for_each(|(node, _, _)| first[node as usize + 1] += 1);
        (1..first.len()).for_each(|k| first[k] += first[k - 1]);
        let (mut links, mut next) = (vec![(0, 0.0); 2 * list.len()], first.clone());
        for (node, other, exchange) in ends() {
            links[next[node as usize]] = (other, exchange);
            next[node as usize] += 1;
        }
        let scale = vec![1.0; tree.list().len()];
        let mut new = Self {
            tree,
            links,
            first,
            scale,
            closed: stays.iter().all(|share| *share == 1.0),
            stays,
            closure_defect: 0.0,
            worst_root: (0.0, 0),
            rays: 0,
            factors: 0,
            rounds: 0,
        };
        new.find_defects();
        new
    }

    /// Number of links.
    #[must_use]
    pub fn links(&self) -> usize {
        self.links.len() / 2
    }

    /// What the form factors of each leaf sum to: the share of its light that stays in the scene.
    #[must_use]
    pub fn row_sums(&self) -> Vec<f64> {
        self.irradiance(&vec![1.0; self.scale.len()], 1)
    }

    /// Scales what leaves send and receive until rows sum what they must (symmetric Sinkhorn scaling); reciprocity stays.
    ///
    /// That is what rays say that stays in the scene: one in a closed one. Links alone cannot tell it: the rows of leaves
    /// lie about the truth by the doubt of their links, too high where much of the light goes back and forth.
    fn balance(&mut self) {
        for _ in 0..SWEEPS {
            let sums = self.row_sums();
            let mut defect = 0.0f64;
            for (scale, (sum, wanted)) in self.scale.iter_mut().zip(sums.iter().zip(&self.stays)) {
                if *sum > 0.0 && *wanted > 0.0 {
                    defect = defect.max((sum / wanted - 1.0).abs());
                    *scale *= (wanted / sum).sqrt();
                }
            }
            if defect < BALANCED {
                break;
            }
        }
    }

    /// A leaf's row errs by the doubt of its links. Over a root that averages out: what is left is a leak, or form factors
    /// that are wrong.
    fn find_defects(&mut self) {
        let sums = self.row_sums();
        let defect = |sum: f64| if self.closed { sum - 1.0 } else { (sum - 1.0).max(0.0) };
        let (mut squares, mut total) = (0.0, 0.0);
        for (sum, patch) in sums.iter().zip(self.tree.list()) {
            squares += patch.area * defect(*sum).powi(2);
            total += patch.area;
        }
        self.closure_defect = if total > 0.0 { (squares / total).sqrt() } else { 0.0 };
        for (root, sum) in self.tree.pull(&sums, 1).into_iter().take(self.tree.roots()).enumerate() {
            if defect(sum).abs() > self.worst_root.0 {
                self.worst_root = (defect(sum).abs(), root);
            }
        }
    }

    /// A field of the leaves times their scales.
    fn scaled(&self, mut field: Vec<f64>, bands: usize) -> Vec<f64> {
        for (x, scale) in field.chunks_exact_mut(bands.max(1)).zip(&self.scale) {
            x.iter_mut().for_each(|x| *x *= scale);
        }
        field
    }
}

impl Operator for Hierarchy {
    fn irradiance(&self, radiosity: &[f64], bands: usize) -> Vec<f64> {
        let sent = self.tree.pull(&self.scaled(radiosity.to_vec(), bands), bands);
        let mut received = vec![0.0; sent.len()];
        received.par_chunks_mut(bands.max(1)).enumerate().with_min_len(64).for_each(|(node, h)| {
            for (other, exchange) in &self.links[self.first[node]..self.first[node + 1]] {
                let from = *other as usize * bands;
                h.iter_mut().zip(&sent[from..from + bands]).for_each(|(h, b)| *h += exchange * b);
            }
            h.iter_mut().for_each(|h| *h /= self.tree.nodes[node].patch.area);
        });
        self.scaled(self.tree.push(received, bands), bands)
    }

    fn is_closed(&self) -> bool {
        self.closed
    }
}
