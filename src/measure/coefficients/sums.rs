//! Values by column, few of which are not zero.

use crate::solve::{LANES, Lanes};

/// The columns of one row, in order, and some values for each.
#[derive(Clone, Debug, Default)]
pub(super) struct Row {
    columns: Vec<u32>,
    values: Vec<f32>,
}

impl Row {
    /// Column and value, of a row with one value for each column.
    pub(super) fn pairs(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        self.columns.iter().copied().zip(self.values.iter().copied())
    }

    pub(super) fn scale(&mut self, factor: f32) {
        self.values.iter_mut().for_each(|v| *v *= factor);
    }
}

/// Rows, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Sparse {
    start: Vec<u32>,
    rows: Row,
}

impl Sparse {
    fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.start[row] as usize..self.start[row + 1] as usize
    }

    /// Eight neighbouring columns of a row: one value of the `each` that every column has.
    pub(super) fn lanes(&self, row: usize, block: usize, (value, each): (usize, usize)) -> Lanes {
        let range = self.range(row);
        let columns = &self.rows.columns[range.clone()];
        let first = columns.partition_point(|c| (*c as usize) < block * LANES);
        let mut lanes = [0.0; LANES];
        for (k, c) in columns.iter().enumerate().skip(first).take_while(|(_, c)| (**c as usize) < (block + 1) * LANES) {
            lanes[*c as usize % LANES] = f64::from(self.rows.values[(range.start + k) * each + value]);
        }
        lanes
    }

    /// A row times a matrix of eight columns.
    pub(super) fn times(&self, row: usize, matrix: &[Lanes]) -> Lanes {
        let range = self.range(row);
        times(self.rows.columns[range.clone()].iter().copied().zip(self.rows.values[range].iter().copied()), matrix)
    }

    pub(super) fn push(&mut self, row: &Row) {
        if self.start.is_empty() {
            self.start.push(0);
        }
        self.rows.columns.extend_from_slice(&row.columns);
        self.rows.values.extend_from_slice(&row.values);
        self.start.push(self.rows.columns.len() as u32);
    }
}

/// Sum of rows of a matrix, each with its weight.
pub(super) fn times(row: impl Iterator<Item = (u32, f32)>, matrix: &[Lanes]) -> Lanes {
    let mut sum = [0.0; LANES];
    for (k, weight) in row {
        let (weight, values) = (f64::from(weight), &matrix[k as usize]);
        sum.iter_mut().zip(values).for_each(|(sum, v)| *sum += weight * v);
    }
    sum
}

/// Sums by column, of one thread.
#[derive(Debug)]
pub(super) struct Sums {
    values: Vec<f32>,
    each: usize,
    touched: Vec<u32>,
}

impl Sums {
    pub(super) fn new(columns: usize, each: usize) -> Self {
        Self { values: vec![0.0; columns * each], each, touched: Vec::new() }
    }

    /// Adds the values of a column, told by their number.
    pub(super) fn add(&mut self, column: usize, value: impl Fn(usize) -> f64) {
        let own = &mut self.values[column * self.each..(column + 1) * self.each];
        if own[0] == 0.0 {
            self.touched.push(column as u32);
        }
        own.iter_mut().enumerate().for_each(|(k, sum)| *sum += value(k) as f32);
    }

    pub(super) fn add_row(&mut self, row: &Row) {
        for (c, values) in row.columns.iter().zip(row.values.chunks_exact(self.each)) {
            self.add(*c as usize, |v| f64::from(values[v]));
        }
    }

    /// What was added, in order, times a factor; the sums are empty again.
    pub(super) fn take(&mut self, factor: f32) -> Row {
        self.touched.sort_unstable();
        self.touched.dedup();
        let mut row = Row::default();
        for column in self.touched.drain(..) {
            let own = &mut self.values[column as usize * self.each..(column as usize + 1) * self.each];
            row.columns.push(column);
            row.values.extend(own.iter_mut().map(|v| factor * std::mem::take(v)));
        }
        row
    }
}
