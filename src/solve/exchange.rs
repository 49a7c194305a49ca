//! Sampled rows, balanced so that flux is conserved.
//!
//! A row sums to what its own rays saw closed. Reciprocity asks more: the light that arrives from an element must be
//! what its area allows, `Σ_i A_i F_ij = A_j h_j` with `h` the closed share of row *j*. Sampled rows meet this only on
//! average, and near a reflectance of one the difference is amplified without bound. It is mended in two steps, both
//! local to a set of neighbouring elements `g`:
//!
//! 1. columns are scaled by set until `Σ_i A_i Σ_{j∈g} F_ij = Σ_{j∈g} A_j h_j`, rows being renormalised (Sinkhorn and
//!    Knopp 1967);
//! 2. what is left within a set, `c_j = A_j h_j − Σ_i A_i F_ij`, is given to all who look at the set: the product takes
//!    `x_j + Σ_{k∈g} c_k x_k / Σ_{k∈g} A_k h_k` in place of `x_j`. Flux is then conserved to rounding.
//!
//! Sets never join what no ray joins, so nothing leaks into a sealed room. Entering each ray in both its rows instead
//! would be exactly reciprocal, but every ray would then carry light back the way it came, which was measured to bias
//! reflected light by 1 to 2 %.

use std::ops::Range;

use rayon::prelude::*;

use super::bicgstab::PIECE;
use super::is_open;
use crate::mesh::Elements;
use crate::transport::{Rows, Target};
use crate::vector::wide;

/// Elements in a set, about.
const SET: usize = 64;
/// Rays that a set must receive to be balanced: with fewer, the mend is noisier than the ill.
const ENOUGH: usize = 96;
const MAX_SWEEPS: usize = 60;
/// Rows that are summed by themselves.
const STRETCH: usize = 1 << 16;

/// The transport matrix `F` of one replica, by rows.
#[derive(Clone, Debug)]
pub struct Exchange {
    /// Valid area of each element, in the program's frame.
    pub area: Vec<f64>,
    start: Vec<u32>,
    /// Element and value of each entry; tints where there are any.
    columns: Vec<u32>,
    values: Vec<f32>,
    tints: Vec<u32>,
    /// Largest correction of a set, `|c − 1|`.
    pub correction: f64,
    /// Set of each element; [`ALONE`] where it is left as it is.
    set: Vec<u32>,
    /// What each element's column lacks, over what its set sends.
    lack: Vec<f64>,
    sets: usize,
}

/// In no set.
const ALONE: u32 = u32::MAX;

/// Share of an element's radiosity that arrives nowhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exit {
    pub(super) element: u32,
    pub(super) share: f32,
    pub(super) tint: u32,
    pub(super) way: Way,
}

/// How light leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// Out of the scene.
    Escaped,
    /// Absorbed by mirrors and panes, the same in all bands.
    Lost,
    /// The part of `share` that the tint does not let through.
    Tinted,
}

/// What the rays of one replica saw closed and open.
#[derive(Clone, Debug, Default)]
pub(super) struct Openings {
    /// Share of each row that stays in the scene.
    pub(super) closed: Vec<f64>,
    /// What does not arrive at an element.
    pub(super) exits: Vec<Exit>,
}

impl Openings {
    pub(super) fn new(rows: &Rows, replica: usize) -> Self {
        let mut openings = Self::default();
        for i in 0..rows.valid.len() {
            let closed = openings.enter(rows, replica, i);
            openings.closed.push(closed);
        }
        openings
    }

    /// Enters one row; returns the share of it that stays in the scene.
    fn enter(&mut self, rows: &Rows, replica: usize, i: usize) -> f64 {
        let weight = weight(rows, replica, i);
        let mut closed = 0.0;
        for (target, share, tint) in rows.row(replica, i) {
            let mut exit = |share: f32, tint, way| {
                if share > 0.0 {
                    self.exits.push(Exit { element: i as u32, share, tint, way });
                }
            };
            let value = share * weight;
            if let Target::Element(_) = target {
                closed += f64::from(value);
            } else if is_open(target) {
                exit(value, tint, if target == Target::Escaped { Way::Escaped } else { Way::Lost });
            }
            if target != Target::Covered {
                exit(weight - value, 0, Way::Lost);
                if tint != 0 {
                    exit(value, tint, Way::Tinted);
                }
            }
        }
        closed
    }

    /// Mean closed share of each element over the replicas other than one.
    pub(super) fn closed_by_others(all: &[Self], replica: usize) -> Vec<f64> {
        let others: Vec<&Self> =
            all.iter().enumerate().filter(|(r, _)| *r != replica || all.len() == 1).map(|(_, o)| o).collect();
        let share = 1.0 / others.len() as f64;
        (0..all[replica].closed.len()).map(|i| others.iter().map(|o| o.closed[i]).sum::<f64>() * share).collect()
    }
}

/// Share of one ray of a row.
fn weight(rows: &Rows, replica: usize, i: usize) -> f32 {
    1.0 / rows.row(replica, i).filter(|(t, _, _)| *t != Target::Covered).count().max(1) as f32
}

impl Exchange {
    /// The matrix of one replica, balanced to the relative closure defect `closure`.
    ///
    /// What each element sends is its closed share as other replicas saw it: an element's own rays also make its
    /// radiosity, and the product of the two would count too much light.
    pub(super) fn balanced(
        mesh: &Elements,
        rows: &Rows,
        (openings, replica): (&[Openings], usize),
        closure: f64,
    ) -> Self {
        let mut exchange = Self::new(mesh, rows, replica);
        let closed = &openings[replica].closed;
        exchange.choose_sets(mesh, closed);
        let sum = |shares: &[f64]| shares.iter().zip(&exchange.area).map(|(s, a)| s * a).sum::<f64>();
        let mut sends = Openings::closed_by_others(openings, replica);
        let fit = sum(closed) / sum(&sends).max(1e-300);
        sends.iter_mut().for_each(|s| *s *= fit);
        exchange.scale(closed, &sends, closure);
        exchange.find_lack(&sends);
        exchange
    }

    /// Bytes that an element takes with so many rays: entries with their sets, and a dozen numbers.
    pub(super) fn bytes_per_element(rays: usize) -> usize {
        rays * 3 * size_of::<u32>() + 12 * size_of::<f64>()
    }

    /// The matrix as its rays have it.
    fn new(mesh: &Elements, rows: &Rows, replica: usize) -> Self {
        let n = mesh.len();
        let area: Vec<f64> = mesh.list().iter().zip(&rows.valid).map(|(e, v)| e.area * f64::from(*v)).collect();
        let mut exchange = Self {
            area,
            start: Vec::with_capacity(n + 1),
            columns: Vec::with_capacity(n * rows.rays),
            values: Vec::with_capacity(n * rows.rays),
            tints: Vec::new(),
            correction: 0.0,
            set: Vec::new(),
            lack: Vec::new(),
            sets: 0,
        };
        exchange.start.push(0);
        for i in 0..n {
            let weight = weight(rows, replica, i);
            for (target, share, tint) in rows.row(replica, i) {
                let Target::Element(column) = target else { continue };
                exchange.columns.push(column);
                exchange.values.push(share * weight);
                if rows.tints.len() > 1 {
                    exchange.tints.push(tint);
                }
            }
            exchange.start.push(exchange.columns.len() as u32);
        }
        exchange
    }

    /// Neighbours on one side of one surface that rays join, and that receive enough rays.
    fn choose_sets(&mut self, mesh: &Elements, closed: &[f64]) {
        let list = mesh.list();
        let component = self.components();
        let key = |i: usize| {
            let e = &list[i];
            (component[i], e.surface, e.front, mesh.morton(e) / SET as u32)
        };
        let mut order: Vec<usize> = (0..list.len()).collect();
        order.sort_unstable_by_key(|i| (key(*i), list[*i].key));
        let mut received = vec![0usize; list.len()];
        for column in &self.columns {
            received[*column as usize] += 1;
        }
        self.set = vec![ALONE; list.len()];
        for members in order.chunk_by(|a, b| key(*a) == key(*b)) {
            // A set that sends most of its light into the open amplifies nothing, and its few rays that come back tell
            // worse what others receive from it than their own rays do.
            let sent: f64 = members.iter().map(|i| closed[*i]).sum();
            let is_closed = 2.0 * sent >= members.len() as f64;
            if is_closed && members.iter().map(|i| received[*i]).sum::<usize>() >= ENOUGH {
                members.iter().for_each(|i| self.set[*i] = self.sets as u32);
                self.sets += 1;
            }
        }
    }

    /// For each element, the smallest number of those that rays join with it.
    fn components(&self) -> Vec<u32> {
        let mut parent: Vec<u32> = (0..self.area.len() as u32).collect();
        fn root(parent: &mut [u32], mut i: u32) -> u32 {
            while parent[i as usize] != i {
                parent[i as usize] = parent[parent[i as usize] as usize];
                i = parent[i as usize];
            }
            i
        }
        for i in 0..self.area.len() {
            for k in self.start[i]..self.start[i + 1] {
                let (a, b) = (root(&mut parent, i as u32), root(&mut parent, self.columns[k as usize]));
                parent[a.max(b) as usize] = a.min(b);
            }
        }
        (0..self.area.len() as u32).map(|i| root(&mut parent, i)).collect()
    }

    fn scale(&mut self, closed: &[f64], sends: &[f64], closure: f64) {
        let mut target = vec![0.0f64; self.sets];
        for (i, s) in self.set.iter().enumerate() {
            if *s != ALONE {
                target[*s as usize] += self.area[i] * sends[i];
            }
        }
        let total: f64 = target.iter().sum();
        // What goes to elements in no set is in a set of its own, whose factor counts for nothing.
        let none = self.sets as u32;
        let sets: Vec<u32> = self.columns.iter().map(|c| self.set[*c as usize].min(none)).collect();
        let mut factors = vec![1.0f64; self.sets + 1];
        factors[self.sets] = 0.0;
        let alone: Vec<f64> = (0..sends.len())
            .map(|i| self.span(i).filter(|k| sets[*k] == none).map(|k| f64::from(self.values[k])).sum())
            .collect();
        // What the scaled entries of a row are multiplied by to sum to what they summed to. What goes to elements in no set
        // stays: a room must not lose the view of a facade because few of the facade's rays find its window.
        let renormalise = |i: usize, factors: &[f64]| {
            let scaled: f64 = self.span(i).map(|k| f64::from(self.values[k]) * factors[sets[k] as usize]).sum();
            if scaled > 0.0 { (closed[i] - alone[i]) / scaled } else { 1.0 }
        };
        for _ in 0..MAX_SWEEPS {
            let arriving = self.sum_in_stretches(sends.len(), |i, arriving| {
                let light = self.area[i] * renormalise(i, &factors);
                for k in self.span(i) {
                    let set = sets[k] as usize;
                    arriving[set] += light * f64::from(self.values[k]) * factors[set];
                }
            });
            let defect: f64 = arriving.iter().zip(&target).map(|(a, t)| (a - t).abs()).sum();
            if defect <= closure * total {
                break;
            }
            for ((c, a), t) in factors.iter_mut().zip(&arriving).zip(&target) {
                if *a > 0.0 && *t > 0.0 {
                    *c *= t / a;
                }
            }
        }
        let rows: Vec<f64> = (0..sends.len()).map(|i| renormalise(i, &factors)).collect();
        for (i, row) in rows.into_iter().enumerate() {
            for k in self.span(i).filter(|k| sets[*k] != none) {
                self.values[k] = (f64::from(self.values[k]) * factors[sets[k] as usize] * row) as f32;
            }
        }
        self.correction = factors[..self.sets].iter().map(|c| (c - 1.0).abs()).fold(0.0, f64::max);
    }

    /// Sums over the rows by set, stretch by stretch, so that they do not depend on the number of threads.
    fn sum_in_stretches(&self, rows: usize, add: impl Fn(usize, &mut [f64]) + Sync) -> Vec<f64> {
        let sum = |first: usize| {
            let mut sums = vec![0.0f64; self.sets + 1];
            (first..rows.min(first + STRETCH)).for_each(|i| add(i, &mut sums));
            sums
        };
        let firsts: Vec<usize> = (0..rows).step_by(STRETCH).collect();
        let parts: Vec<Vec<f64>> = firsts.into_par_iter().map(sum).collect();
        let mut all = vec![0.0f64; self.sets + 1];
        for part in parts {
            all.iter_mut().zip(part).for_each(|(all, p)| *all += p);
        }
        all.truncate(self.sets);
        all
    }

    /// What each column lacks within its set.
    fn find_lack(&mut self, sends: &[f64]) {
        let n = self.area.len();
        let mut arriving = vec![0.0f64; n];
        for i in 0..n {
            for k in self.span(i) {
                arriving[self.columns[k] as usize] += self.area[i] * f64::from(self.values[k]);
            }
        }
        let mut sums = vec![(0.0f64, 0.0f64); self.sets];
        for (i, s) in self.set.iter().enumerate().filter(|(_, s)| **s != ALONE) {
            let sum = &mut sums[*s as usize];
            *sum = (sum.0 + arriving[i], sum.1 + self.area[i] * sends[i]);
        }
        self.lack = (0..n)
            .map(|i| match self.set[i] {
                ALONE => 0.0,
                s => match sums[s as usize] {
                    // What the set as a whole lacks stays out: a uniform field must stay uniform to the last bit.
                    (arrived, sent) if arrived > 0.0 => {
                        (self.area[i] * sends[i] - arriving[i] * (sent / arrived)) / arrived
                    }
                    _ => 0.0,
                },
            })
            .collect();
    }

    /// What is seen of `x`: with what its set's columns lack.
    fn seen(&self, x: &[[f64; 8]]) -> Vec<[f64; 8]> {
        let mut offset = vec![[0.0f64; 8]; self.sets];
        for (i, s) in self.set.iter().enumerate().filter(|(_, s)| **s != ALONE) {
            for lane in 0..8 {
                offset[*s as usize][lane] += self.lack[i] * x[i][lane];
            }
        }
        x.iter()
            .zip(&self.set)
            .map(|(x, s)| match *s {
                ALONE => *x,
                s => std::array::from_fn(|lane| x[lane] + offset[s as usize][lane]),
            })
            .collect()
    }

    /// Entries of a row.
    fn span(&self, i: usize) -> Range<usize> {
        self.start[i] as usize..self.start[i + 1] as usize
    }

    /// `out = F x`, eight bands at a time; `tints` holds the bands of this block.
    pub(super) fn product(&self, x: &[[f64; 8]], tints: &[[f64; 8]], out: &mut [[f64; 8]]) {
        let x = self.seen(x);
        let pieces = out.par_chunks_mut(PIECE).enumerate();
        pieces.for_each(|(k, out)| sum_rows(self, &x, tints, k * PIECE, out));
    }
}

wide! {
    /// The rows from a first one on, each times `x`.
    fn sum_rows(exchange: &Exchange, x: &[[f64; 8]], tints: &[[f64; 8]], first: usize, out: &mut [[f64; 8]]) {
        for (i, sum) in out.iter_mut().enumerate() {
            let mut acc = [0.0f64; 8];
            for k in exchange.start[first + i] as usize..exchange.start[first + i + 1] as usize {
                let (v, xj) = (f64::from(exchange.values[k]), &x[exchange.columns[k] as usize]);
                match exchange.tints.get(k).copied().unwrap_or(0) {
                    0 => {
                        for lane in 0..8 {
                            acc[lane] += v * xj[lane];
                        }
                    }
                    tint => {
                        let t = &tints[tint as usize];
                        for lane in 0..8 {
                            acc[lane] += v * t[lane] * xj[lane];
                        }
                    }
                }
            }
            *sum = acc;
        }
    }
}
