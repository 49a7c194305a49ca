//! Sampled rows made reciprocal and closed.
//!
//! Every ray from *i* to *j* is an estimate of `A_i F_ij` and, by reciprocity, of `A_j F_ji`: it is entered half for
//! each. The symmetric exchange matrix is then scaled, `X_ij = d_i G_ij d_j`, until every row sums to the area that
//! its own rays saw closed: energy is conserved to rounding, nothing is clamped (symmetric Sinkhorn scaling; Sinkhorn
//! and Knopp 1967).

use super::is_open;
use crate::mesh::Elements;
use crate::transport::{Rows, Target};

/// Sweeps after which a scaling that has not settled is accepted as it is.
const MAX_SWEEPS: usize = 300;

/// The symmetric exchange matrix `X_ij = A_i F_ij` of one replica, by rows.
#[derive(Clone, Debug)]
pub struct Exchange {
    /// Valid area of each element, in the program's frame.
    pub area: Vec<f64>,
    start: Vec<usize>,
    entries: Vec<Entry>,
    /// Share of each element's rays that escaped or got lost, as (share, tint, escaped?).
    pub(super) exits: Vec<Vec<(f32, u32, bool)>>,
    /// Area-weighted mean of `|d − 1|`.
    pub correction: f64,
    /// Area seen open, over all elements.
    pub open: f64,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    column: u32,
    tint: u32,
    value: f32,
}

impl Exchange {
    /// Builds and balances the matrix of one replica, to the relative closure defect `closure`.
    #[must_use]
    pub fn balanced(mesh: &Elements, rows: &Rows, replica: usize, closure: f64) -> Self {
        let n = mesh.len();
        let area: Vec<f64> = mesh.list().iter().zip(&rows.valid).map(|(e, v)| e.area * f64::from(*v)).collect();
        let mut exits = vec![Vec::new(); n];
        let mut triples = Vec::with_capacity(n * rows.rays);
        let mut closed = vec![0.0f64; n];
        let mut open = 0.0;
        for i in 0..n {
            let counted = rows.row(replica, i).filter(|(t, _, _)| *t != Target::Covered).count();
            if counted == 0 {
                continue;
            }
            let weight = 1.0 / counted as f64;
            for (target, share, tint) in rows.row(replica, i) {
                let share_of_row = f64::from(share) * weight;
                if let Target::Element(j) = target {
                    triples.push((i as u32, j, tint, area[i] * share_of_row * 0.5));
                    closed[i] += area[i] * share_of_row;
                } else if is_open(target) {
                    exits[i].push((share_of_row as f32, tint, target == Target::Escaped));
                    open += area[i] * weight;
                }
                if share < 1.0 {
                    exits[i].push(((weight * f64::from(1.0 - share)) as f32, 0, false));
                    open += area[i] * weight * f64::from(1.0 - share);
                }
            }
        }
        let mut exchange = Self { area, start: Vec::new(), entries: Vec::new(), exits, correction: 0.0, open };
        exchange.symmetrise(n, &triples);
        exchange.scale(&closed, closure);
        exchange
    }

    /// Enters every triple in both rows, by counting.
    fn symmetrise(&mut self, n: usize, triples: &[(u32, u32, u32, f64)]) {
        let mut start = vec![0usize; n + 1];
        for (i, j, _, _) in triples {
            start[*i as usize + 1] += 1;
            start[*j as usize + 1] += 1;
        }
        for k in 0..n {
            start[k + 1] += start[k];
        }
        let mut next = start.clone();
        self.entries = vec![Entry { column: 0, tint: 0, value: 0.0 }; 2 * triples.len()];
        for (i, j, tint, value) in triples {
            for (row, column) in [(*i, *j), (*j, *i)] {
                self.entries[next[row as usize]] = Entry { column, tint: *tint, value: *value as f32 };
                next[row as usize] += 1;
            }
        }
        self.start = start;
    }

    fn scale(&mut self, closed: &[f64], closure: f64) {
        let n = closed.len();
        let mut d = vec![1.0f64; n];
        let mut sums = vec![0.0f64; n];
        let total: f64 = closed.iter().sum();
        for _ in 0..MAX_SWEEPS {
            let mut defect = 0.0;
            for i in 0..n {
                let row = &self.entries[self.start[i]..self.start[i + 1]];
                sums[i] = d[i] * row.iter().map(|e| f64::from(e.value) * d[e.column as usize]).sum::<f64>();
                defect += (sums[i] - closed[i]).abs();
            }
            if defect <= closure * total {
                break;
            }
            for i in 0..n {
                d[i] *= if sums[i] > 0.0 { (closed[i] / sums[i]).sqrt() } else { 0.0 };
            }
        }
        for i in 0..n {
            for e in &mut self.entries[self.start[i]..self.start[i + 1]] {
                e.value = (f64::from(e.value) * d[i] * d[e.column as usize]) as f32;
            }
        }
        let whole: f64 = self.area.iter().sum();
        self.correction = d.iter().zip(&self.area).map(|(d, a)| (d - 1.0).abs() * a).sum::<f64>() / whole.max(1e-300);
    }

    /// `out = X x`, eight bands at a time; `tints` holds the bands of this block.
    pub(super) fn product(&self, x: &[[f64; 8]], tints: &[[f64; 8]], out: &mut [[f64; 8]]) {
        for (i, sum) in out.iter_mut().enumerate() {
            let mut acc = [0.0f64; 8];
            for e in &self.entries[self.start[i]..self.start[i + 1]] {
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

    /// Sums of the rows of `X`: the area each element sees closed.
    #[must_use]
    pub fn row_sums(&self) -> Vec<f64> {
        self.start.windows(2).map(|w| self.entries[w[0]..w[1]].iter().map(|e| f64::from(e.value)).sum()).collect()
    }
}
