//! Squares of pixels that look for their records together.

use glam::DVec2;
use rayon::prelude::*;

use super::records::Records;
use super::sheets::Sheets;
use super::sight::Sight;

/// Side of a square.
const SIDE: usize = 16;

/// What a square sees of one sheet, and the records that may take part in a fit there.
#[derive(Debug)]
pub(super) struct Span {
    sheet: u32,
    centre: DVec2,
    radius: f64,
    records: Vec<u32>,
}

/// All squares of a picture, row by row.
#[derive(Debug)]
pub(super) struct Tiles {
    size: (usize, usize),
    spans: Vec<Vec<Span>>,
    /// Number of records that the squares know.
    known: usize,
}

impl Tiles {
    /// For a picture of `width` by `height` pixels and the sights of each of them.
    pub(super) fn new((width, height): (usize, usize), sights: &[Vec<Sight>], sheets: &Sheets) -> Self {
        let mut tiles = Self { size: (width, height), spans: Vec::new(), known: 0 };
        tiles.spans = (0..width.div_ceil(SIDE) * height.div_ceil(SIDE))
            .into_par_iter()
            .map(|tile| {
                let mut boxes: Vec<(u32, DVec2, DVec2)> = Vec::new();
                let sights = tiles.pixels(tile).flat_map(|pixel| &sights[pixel]);
                for (sheet, at) in sights.filter_map(|sight| sheets.place(sight)) {
                    match boxes.iter_mut().find(|b| b.0 == sheet) {
                        Some((_, low, high)) => (*low, *high) = (low.min(at), high.max(at)),
                        None => boxes.push((sheet, at, at)),
                    }
                }
                let span = |(sheet, low, high): (u32, DVec2, DVec2)| Span {
                    sheet,
                    centre: (low + high) * 0.5,
                    radius: low.distance(high) * 0.5,
                    records: Vec::new(),
                };
                boxes.into_iter().map(span).collect()
            })
            .collect();
        tiles
    }

    pub(super) fn count(&self) -> usize {
        self.spans.len()
    }

    /// Rows of pixels that are done with a square: all of its rows, told by the first square of each.
    pub(super) fn rows_done(&self, tile: usize) -> u64 {
        if tile.is_multiple_of(self.size.0.div_ceil(SIDE)) { SIDE as u64 } else { 0 }
    }

    /// Pixels of a square.
    pub(super) fn pixels(&self, tile: usize) -> impl Iterator<Item = usize> + use<> {
        let (w, h) = self.size;
        let columns = w.div_ceil(SIDE);
        let (x, y) = (tile % columns * SIDE, tile / columns * SIDE);
        (y..(y + SIDE).min(h)).flat_map(move |j| (x..(x + SIDE).min(w)).map(move |i| j * w + i))
    }

    /// The square of a pixel.
    pub(super) fn of(&self, pixel: usize) -> usize {
        let (x, y) = (pixel % self.size.0, pixel / self.size.0);
        y / SIDE * self.size.0.div_ceil(SIDE) + x / SIDE
    }

    /// Records on a sheet that may take part in a fit within a square; `None` where none of its pixels shows the sheet in
    /// its middle.
    pub(super) fn near(&self, tile: usize, sheet: u32) -> Option<&[u32]> {
        self.spans[tile].iter().find(|s| s.sheet == sheet).map(|s| &s.records[..])
    }

    /// Takes in what records were added, and forgets those that now reach less far: the reach of a record never grows.
    pub(super) fn update(&mut self, records: &Records) {
        let known = self.known as u32;
        self.spans.par_iter_mut().flatten().for_each(|span| {
            let reaches = |k: &u32| records.reaches(*k, span.centre, span.radius);
            span.records.retain(reaches);
            let all = records.of_sheet(span.sheet);
            let new = &all[all.partition_point(|k| *k < known)..];
            span.records.extend(new.iter().copied().filter(reaches));
        });
        self.known = records.list.len();
    }
}
