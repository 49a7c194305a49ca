//! Which patches are linked: an exchange is refined while it could err by more than its share.
//!
//! A link takes the irradiance that one node gives the other to be even. It is off by the spread of the form factor over
//! the receiver, and where something may stand between, by as much as that hides: `B_j ΔF_ij`, times the area of the
//! receiver a flux. Each receiver may be off by a fraction of the mean irradiance of the scene times its own area, so that
//! the test is one of brightness, form factor and area (the BFA of the paper) with errors in place of the exchange itself.

use std::sync::Arc;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::mesh::PatchTree;
use crate::transport::World;
use crate::transport::form_factor::{Pairs, Work, face_each_other};

/// Links, at most: they take a gigabyte.
const MOST_LINKS: usize = 5_000_000;
/// Least brightness that counts, so that what dark patches hide of bright ones is known too.
const DARKEST: f64 = 0.25;
/// Share of the factor that is doubtful where something may stand between.
const HIDDEN: f64 = 0.5;

/// When refinement ends.
#[derive(Clone, Copy, Debug)]
pub struct Refinement {
    /// Nodes no larger than this are not divided; program's frame.
    pub finest: f64,
    /// Error of the irradiance that a link may make, against the mean irradiance of the scene.
    pub allowed: f64,
}

/// An exchange between two nodes.
#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) a: u32,
    pub(super) b: u32,
    /// `A_a F_ab = A_b F_ba`.
    pub(super) exchange: f64,
    /// Doubt of the factor: on `a` from `b`, on `b` from `a`.
    doubt: [f64; 2],
    /// Surfaces that may stand between.
    blockers: Arc<[u32]>,
}

/// A pair of nodes to be looked at; surfaces that may stand between are among these.
#[derive(Clone, Debug)]
pub(super) struct Waiting {
    a: u32,
    b: u32,
    blockers: Arc<[u32]>,
}

/// What is to be done with a pair.
enum Verdict {
    Nothing,
    Link(Link),
    /// Divide this node, and look at its children with the other.
    Divide(u32, Waiting),
}

/// Links in the making.
#[derive(Debug)]
pub(super) struct Refiner<'a> {
    world: &'a World,
    pairs: Pairs<'a>,
    refinement: Refinement,
    pub(super) links: Vec<Link>,
    pub(super) rays: u64,
    pub(super) factors: u64,
}

impl<'a> Refiner<'a> {
    pub(super) fn new(world: &'a World, refinement: Refinement) -> Self {
        Self { world, pairs: Pairs::new(world), refinement, links: Vec::new(), rays: 0, factors: 0 }
    }

    /// All pairs of roots.
    pub(super) fn roots(&self, tree: &PatchTree) -> Vec<Waiting> {
        let n = tree.roots() as u32;
        let blockers: Arc<[u32]> = self.pairs.all().collect();
        (0..n)
            .flat_map(|a| (a + 1..n).map(move |b| (a, b)))
            .map(|(a, b)| Waiting { a, b, blockers: blockers.clone() })
            .collect()
    }

    /// Links what waits, dividing nodes as needed; new nodes are as bright as those that they divide.
    pub(super) fn refine(
        &mut self,
        tree: &mut PatchTree,
        mut waiting: Vec<Waiting>,
        brightness: &mut Vec<f64>,
    ) -> Result<()> {
        while !waiting.is_empty() {
            let verdicts: Vec<(Verdict, u64, u64)> = waiting
                .into_par_iter()
                .map_init(Work::default, |work, pair| {
                    let before = (work.all_rays(), work.all_factors());
                    let verdict = self.judge(tree, pair, brightness, work);
                    (verdict, work.all_rays() - before.0, work.all_factors() - before.1)
                })
                .collect();
            waiting = Vec::new();
            for (verdict, rays, factors) in verdicts {
                self.rays += rays;
                self.factors += factors;
                match verdict {
                    Verdict::Nothing => {}
                    Verdict::Link(link) => self.links.push(link),
                    Verdict::Divide(node, pair) => self.divide(tree, node, &pair, brightness, &mut waiting),
                }
            }
            if self.links.len() + waiting.len() > MOST_LINKS {
                return Err(Error::unsupported(format!(
                    "more than {MOST_LINKS} links between patches; hierarchical radiosity takes no more"
                ))
                .mend("use fewer --patches, or the default method, which makes only what it needs"));
            }
        }
        tree.number_leaves();
        Ok(())
    }

    /// Takes out the links that are too coarse for what they carry.
    pub(super) fn take_bright(&mut self, tree: &PatchTree, brightness: &[f64]) -> Vec<Waiting> {
        let links = std::mem::take(&mut self.links);
        let (bright, kept): (Vec<Link>, Vec<Link>) =
            links.into_iter().partition(|l| self.too_coarse(tree, (l.a, l.b), l.doubt, brightness).is_some());
        self.links = kept;
        bright.into_iter().map(|l| Waiting { a: l.a, b: l.b, blockers: l.blockers }).collect()
    }

    /// The node to divide, where the doubt carries more than is allowed: the larger of the two that may be divided.
    fn too_coarse(&self, tree: &PatchTree, (a, b): (u32, u32), doubt: [f64; 2], brightness: &[f64]) -> Option<u32> {
        let bright = |node: u32| brightness[node as usize].max(DARKEST);
        let error = (doubt[0] * bright(b)).max(doubt[1] * bright(a));
        if error <= self.refinement.allowed {
            return None;
        }
        let size = |node: u32| tree.nodes[node as usize].size();
        let larger = if size(a) >= size(b) { a } else { b };
        // Rounding alone divides nothing.
        (size(larger) > self.refinement.finest * (1.0 + 1e-9)).then_some(larger)
    }

    fn judge(&self, tree: &PatchTree, pair: Waiting, brightness: &[f64], work: &mut Work) -> Verdict {
        let [a, b] = [pair.a, pair.b].map(|node| &tree.nodes[node as usize].patch);
        if !face_each_other(a, b) {
            return Verdict::Nothing;
        }
        let blockers: Arc<[u32]> = self.pairs.blockers(a, b, pair.blockers.iter().copied()).collect();
        let blocked = !blockers.is_empty();
        let doubt = [(a, b), (b, a)].map(|(receiver, sent)| {
            let spread = self.pairs.spread(receiver, sent, blocked, work);
            if blocked { spread.seen.max(HIDDEN * spread.open) } else { spread.seen }
        });
        if let Some(node) = self.too_coarse(tree, (pair.a, pair.b), doubt, brightness) {
            return Verdict::Divide(node, Waiting { blockers, ..pair });
        }
        let exchange = self.pairs.exchange(a, b, blocked, work);
        if exchange > 0.0 {
            Verdict::Link(Link { a: pair.a, b: pair.b, exchange, doubt, blockers })
        } else {
            Verdict::Nothing
        }
    }

    fn divide(
        &self,
        tree: &mut PatchTree,
        node: u32,
        pair: &Waiting,
        brightness: &mut Vec<f64>,
        waiting: &mut Vec<Waiting>,
    ) {
        tree.divide(&self.world.surfaces.list[tree.nodes[node as usize].patch.surface as usize], node as usize);
        brightness.resize(tree.nodes.len(), brightness[node as usize]);
        let other = if node == pair.a { pair.b } else { pair.a };
        for child in tree.nodes[node as usize].children.clone() {
            waiting.push(Waiting { a: child, b: other, blockers: pair.blockers.clone() });
        }
    }
}
