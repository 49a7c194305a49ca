//! Sampled rows, balanced so that flux is conserved.
//!
//! A row sums to what its own rays saw closed. Reciprocity asks more: over a set of elements, the light that arrives
//! must be what the set's area allows, `Σ_i A_i Σ_{j∈g} F_ij = Σ_{j∈g} A_j h_j` with `h` the closed share of a row.
//! Sampled rows meet this only on average; near a reflectance of one the difference is amplified without bound. So
//! columns are scaled by set until it holds, rows being renormalised (Sinkhorn and Knopp 1967). The sets are large on
//! purpose: entering each ray in both its rows instead would be exactly reciprocal, but every ray would then carry
//! light back the way it came, which was measured to bias reflected light by 1 to 2 %.

use super::is_open;
use crate::mesh::Elements;
use crate::transport::{Rows, Target};

/// Elements in a set.
const SET: usize = 256;
const MAX_SWEEPS: usize = 60;

/// The transport matrix `F` of one replica, by rows.
#[derive(Clone, Debug)]
pub struct Exchange {
    /// Valid area of each element, in the program's frame.
    pub area: Vec<f64>,
    start: Vec<u32>,
    entries: Vec<Entry>,
    /// What does not arrive at an element.
    pub(super) exits: Vec<Exit>,
    /// Largest correction of a set, `|c − 1|`.
    pub correction: f64,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    column: u32,
    value: f32,
    tint: u32,
}

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

impl Exchange {
    /// Builds and balances the matrix of one replica, to the relative closure defect `closure`.
    #[must_use]
    pub fn balanced(mesh: &Elements, rows: &Rows, replica: usize, closure: f64) -> Self {
        let n = mesh.len();
        let area: Vec<f64> = mesh.list().iter().zip(&rows.valid).map(|(e, v)| e.area * f64::from(*v)).collect();
        let mut exchange = Self {
            area,
            start: Vec::with_capacity(n + 1),
            entries: Vec::with_capacity(n * rows.rays),
            exits: Vec::new(),
            correction: 0.0,
        };
        exchange.start.push(0);
        let mut closed = vec![0.0f64; n];
        for (i, closed) in closed.iter_mut().enumerate() {
            *closed = exchange.enter(rows, replica, i);
        }
        exchange.balance(&sets(mesh), &closed, closure);
        exchange
    }

    /// Enters one row; returns the share of it that stays in the scene.
    fn enter(&mut self, rows: &Rows, replica: usize, i: usize) -> f64 {
        let counted = rows.row(replica, i).filter(|(t, _, _)| *t != Target::Covered).count();
        let weight = 1.0 / counted.max(1) as f32;
        let mut closed = 0.0;
        for (target, share, tint) in rows.row(replica, i) {
            let mut exit = |share: f32, tint, way| {
                if share > 0.0 {
                    self.exits.push(Exit { element: i as u32, share, tint, way });
                }
            };
            let value = share * weight;
            if let Target::Element(column) = target {
                self.entries.push(Entry { column, value, tint });
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
        self.start.push(self.entries.len() as u32);
        closed
    }

    fn balance(&mut self, sets: &[u32], closed: &[f64], closure: f64) {
        let count = sets.iter().max().map_or(0, |m| *m as usize + 1);
        let mut target = vec![0.0f64; count];
        for (i, s) in sets.iter().enumerate() {
            target[*s as usize] += self.area[i] * closed[i];
        }
        let total: f64 = target.iter().sum();
        let mut columns = vec![1.0f64; count];
        let mut rows = vec![1.0f64; closed.len()];
        for _ in 0..MAX_SWEEPS {
            let mut arriving = vec![0.0f64; count];
            for (i, row) in rows.iter_mut().enumerate() {
                let own = self.row(i);
                let sum: f64 = own.iter().map(|e| f64::from(e.value) * columns[sets[e.column as usize] as usize]).sum();
                *row = if sum > 0.0 { closed[i] / sum } else { 1.0 };
                let factor = self.area[i] * *row;
                for e in own {
                    let s = sets[e.column as usize] as usize;
                    arriving[s] += factor * f64::from(e.value) * columns[s];
                }
            }
            let defect: f64 = arriving.iter().zip(&target).map(|(a, t)| (a - t).abs()).sum();
            if defect <= closure * total {
                break;
            }
            for ((c, a), t) in columns.iter_mut().zip(&arriving).zip(&target) {
                if *a > 0.0 && *t > 0.0 {
                    *c *= t / a;
                }
            }
        }
        for i in 0..closed.len() {
            for e in &mut self.entries[self.start[i] as usize..self.start[i + 1] as usize] {
                e.value = (f64::from(e.value) * rows[i] * columns[sets[e.column as usize] as usize]) as f32;
            }
        }
        self.correction = columns.iter().map(|c| (c - 1.0).abs()).fold(0.0, f64::max);
    }

    fn row(&self, i: usize) -> &[Entry] {
        &self.entries[self.start[i] as usize..self.start[i + 1] as usize]
    }

    /// Does any light leave the scene, or get lost in mirrors?
    #[must_use]
    pub fn is_open(&self) -> bool {
        !self.exits.is_empty()
    }

    /// `out = F x`, eight bands at a time; `tints` holds the bands of this block.
    pub(super) fn product(&self, x: &[[f64; 8]], tints: &[[f64; 8]], out: &mut [[f64; 8]]) {
        for (i, sum) in out.iter_mut().enumerate() {
            let mut acc = [0.0f64; 8];
            for e in self.row(i) {
                let (v, xj) = (f64::from(e.value), &x[e.column as usize]);
                if e.tint == 0 {
                    for lane in 0..8 {
                        acc[lane] += v * xj[lane];
                    }
                } else {
                    let t = &tints[e.tint as usize];
                    for lane in 0..8 {
                        acc[lane] += v * t[lane] * xj[lane];
                    }
                }
            }
            *sum = acc;
        }
    }
}

/// The set of every element: neighbours in the order of their keys, which keeps surfaces together.
fn sets(mesh: &Elements) -> Vec<u32> {
    let list = mesh.list();
    let mut order: Vec<usize> = (0..list.len()).collect();
    order.sort_unstable_by_key(|i| {
        let e = &list[*i];
        (e.surface, e.front, mesh.morton(e), e.key)
    });
    let count = list.len().div_ceil(SET).max(1);
    let mut sets = vec![0; list.len()];
    for (rank, i) in order.into_iter().enumerate() {
        sets[i] = (rank * count / list.len()) as u32;
    }
    sets
}
