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

use super::is_open;
use crate::mesh::Elements;
use crate::transport::{Rows, Target};
use crate::vector::wide;

/// Elements in a set, about.
const SET: usize = 64;
/// Rays that a set must receive to be balanced: with fewer, the mend is noisier than the ill.
const ENOUGH: usize = 96;
const MAX_SWEEPS: usize = 60;

/// The transport matrix `F` of one replica, by rows.
#[derive(Clone, Debug)]
pub struct Exchange {
    /// Valid area of each element, in the program's frame.
    pub area: Vec<f64>,
    /// Share of each row that stays in the scene.
    pub closed: Vec<f64>,
    start: Vec<u32>,
    entries: Vec<Entry>,
    /// What does not arrive at an element.
    pub(super) exits: Vec<Exit>,
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
    /// The matrix of one replica, as its rays have it.
    #[must_use]
    pub fn new(mesh: &Elements, rows: &Rows, replica: usize) -> Self {
        let n = mesh.len();
        let area: Vec<f64> = mesh.list().iter().zip(&rows.valid).map(|(e, v)| e.area * f64::from(*v)).collect();
        let mut exchange = Self {
            area,
            closed: Vec::with_capacity(n),
            start: Vec::with_capacity(n + 1),
            entries: Vec::with_capacity(n * rows.rays),
            exits: Vec::new(),
            correction: 0.0,
            set: Vec::new(),
            lack: Vec::new(),
            sets: 0,
        };
        exchange.start.push(0);
        for i in 0..n {
            let closed = exchange.enter(rows, replica, i);
            exchange.closed.push(closed);
        }
        exchange
    }

    /// Balances the matrix to the relative closure defect `closure`. `sends` is the closed share of each element as
    /// other replicas saw it: an element's own rays also make its radiosity, and the product of the two would count too
    /// much light.
    pub fn balance(&mut self, mesh: &Elements, sends: &[f64], closure: f64) {
        self.choose_sets(mesh);
        let sum = |shares: &[f64]| shares.iter().zip(&self.area).map(|(s, a)| s * a).sum::<f64>();
        let fit = sum(&self.closed) / sum(sends).max(1e-300);
        let sends: Vec<f64> = sends.iter().map(|s| s * fit).collect();
        self.scale(&sends, closure);
        self.find_lack(&sends);
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

    /// Neighbours on one side of one surface that rays join, and that receive enough rays.
    fn choose_sets(&mut self, mesh: &Elements) {
        let list = mesh.list();
        let component = self.components();
        let key = |i: usize| {
            let e = &list[i];
            (component[i], e.surface, e.front, mesh.morton(e) / SET as u32)
        };
        let mut order: Vec<usize> = (0..list.len()).collect();
        order.sort_unstable_by_key(|i| (key(*i), list[*i].key));
        let mut received = vec![0usize; list.len()];
        for e in &self.entries {
            received[e.column as usize] += 1;
        }
        self.set = vec![ALONE; list.len()];
        for members in order.chunk_by(|a, b| key(*a) == key(*b)) {
            // A set that sends most of its light into the open amplifies nothing, and its few rays that come back tell
            // worse what others receive from it than their own rays do.
            let closed: f64 = members.iter().map(|i| self.closed[*i]).sum();
            let is_closed = 2.0 * closed >= members.len() as f64;
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
                let (a, b) = (root(&mut parent, i as u32), root(&mut parent, self.entries[k as usize].column));
                parent[a.max(b) as usize] = a.min(b);
            }
        }
        (0..self.area.len() as u32).map(|i| root(&mut parent, i)).collect()
    }

    fn scale(&mut self, sends: &[f64], closure: f64) {
        let set = |e: &Entry| self.set[e.column as usize];
        let mut target = vec![0.0f64; self.sets];
        for (i, s) in self.set.iter().enumerate() {
            if *s != ALONE {
                target[*s as usize] += self.area[i] * sends[i];
            }
        }
        let total: f64 = target.iter().sum();
        let mut columns = vec![1.0f64; self.sets];
        let mut rows = vec![1.0f64; sends.len()];
        for _ in 0..MAX_SWEEPS {
            let mut arriving = vec![0.0f64; self.sets];
            for (i, row) in rows.iter_mut().enumerate() {
                let own = self.row(i);
                *row = self.renormalise(i, &columns);
                for e in own.iter().filter(|e| set(e) != ALONE) {
                    arriving[set(e) as usize] += self.area[i] * *row * f64::from(e.value) * columns[set(e) as usize];
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
        for i in 0..sends.len() {
            let row = self.renormalise(i, &columns);
            let own = &mut self.entries[self.start[i] as usize..self.start[i + 1] as usize];
            for e in own {
                let set = self.set[e.column as usize];
                if set != ALONE {
                    e.value = (f64::from(e.value) * columns[set as usize] * row) as f32;
                }
            }
        }
        self.correction = columns.iter().map(|c| (c - 1.0).abs()).fold(0.0, f64::max);
    }

    /// What the scaled entries of a row are multiplied by to sum to what they summed to. What goes to elements in no set
    /// stays: a room must not lose the view of a facade because few of the facade's rays find its window.
    fn renormalise(&self, i: usize, columns: &[f64]) -> f64 {
        let (mut scaled, mut alone) = (0.0, 0.0);
        for e in self.row(i) {
            match self.set[e.column as usize] {
                ALONE => alone += f64::from(e.value),
                set => scaled += f64::from(e.value) * columns[set as usize],
            }
        }
        if scaled > 0.0 { (self.closed[i] - alone) / scaled } else { 1.0 }
    }

    /// What each column lacks within its set.
    fn find_lack(&mut self, sends: &[f64]) {
        let n = self.area.len();
        let mut arriving = vec![0.0f64; n];
        for i in 0..n {
            for e in self.row(i) {
                arriving[e.column as usize] += self.area[i] * f64::from(e.value);
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
        let x = self.seen(x);
        sum_rows(self, &x, tints, out);
    }
}

wide! {
    /// Each row times `x`.
    fn sum_rows(exchange: &Exchange, x: &[[f64; 8]], tints: &[[f64; 8]], out: &mut [[f64; 8]]) {
        for (i, sum) in out.iter_mut().enumerate() {
            let mut acc = [0.0f64; 8];
            for e in exchange.row(i) {
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
