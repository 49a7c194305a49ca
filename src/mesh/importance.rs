//! How finely each part of the scene is worth dividing: importance, what a sensor feels of a place (Smits, Arvo and Salesin
//! 1992, "An importance-driven radiosity algorithm").
//!
//! Walks that begin at the sensors and survive each reflection with the chance of its reflectance leave landings in
//! proportion to importance. An element's noise reaches a sensor times the importance of the element; with a number of
//! elements to spend, the sum of their variances is least when they lie as densely as importance does. Where it is thin
//! the cells of a surface's grid are joined to larger blocks.

use glam::DVec2;

use super::surfaces::{Surface, Surfaces};

/// Side of a tile, the largest block, in cells: 2 to this power.
pub(super) const TILE_LEVEL: u32 = 4;
/// Importance, as a share of what is typical, below which blocks have 2 × 2 cells; a quarter of it for each further level.
const THIN: f64 = 0.25;

/// Landings of the sensors' walks.
#[derive(Clone, Debug, Default)]
pub struct Importance {
    /// Surface and place on it.
    landings: Vec<(u32, DVec2)>,
}

/// The tiles of one surface's grid.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    columns: usize,
    levels: Vec<u8>,
}

impl Importance {
    /// The importance that these landings tell: surface and (u, v). Without any, all is equally important.
    #[must_use]
    pub fn new(landings: Vec<(u32, DVec2)>) -> Self {
        Self { landings }
    }

    /// Area on which importance lies: as large as the scene where all is as important, smaller where parts are not felt.
    #[must_use]
    pub fn felt_area(&self, surfaces: &Surfaces, size: f64) -> f64 {
        let typical = typical(&self.counts(&surfaces.list, &surfaces.cells(size)));
        if typical > 0.0 { self.landings.len() as f64 / typical } else { 0.0 }
    }

    /// Levels of the tiles of all surfaces, whose grids have these numbers of cells.
    pub(super) fn tiles(&self, surfaces: &[Surface], cells: &[[usize; 2]]) -> Vec<Tiles> {
        let grids = self.counts(surfaces, cells);
        let typical = typical(&grids);
        grids
            .iter()
            .map(|g| Tiles { columns: g.columns, levels: g.tiles().map(|(c, a)| level(c, typical * a)).collect() })
            .collect()
    }

    fn counts(&self, surfaces: &[Surface], cells: &[[usize; 2]]) -> Vec<Counts> {
        let mut grids: Vec<Counts> = surfaces.iter().zip(cells).map(|(s, c)| Counts::new(s, *c)).collect();
        for (surface, uv) in &self.landings {
            grids[*surface as usize].enter(*uv);
        }
        grids
    }
}

/// Density of landings where importance lies: the mean over all landings of how many others there are to an area.
fn typical(grids: &[Counts]) -> f64 {
    let all = grids.iter().flat_map(Counts::tiles);
    let (pairs, sum) = all.fold((0.0, 0.0), |(p, s), (count, area)| (p + count * (count - 1.0) / area, s + count));
    if sum > 0.0 { pairs / sum } else { 0.0 }
}

/// One landing more than there was, lest chance look like emptiness where few were to be expected.
fn level(count: f64, typical: f64) -> u8 {
    let share = (count + 1.0) / typical.max(1e-300);
    if share >= THIN {
        return 0;
    }
    (1.0 + (THIN / share).log(4.0)).min(f64::from(TILE_LEVEL)) as u8
}

/// Largest importance of a place with blocks of that level, as a share of what is typical.
pub(super) fn most_at(level: u32) -> f64 {
    if level == 0 { 1.0 } else { THIN * 0.25f64.powi(level as i32 - 1) }
}

impl Tiles {
    /// Level of the blocks at a cell.
    pub(super) fn level(&self, iu: usize, iv: usize) -> u32 {
        u32::from(self.levels[(iv >> TILE_LEVEL) * self.columns + (iu >> TILE_LEVEL)])
    }
}

/// Landings in the tiles of one surface.
struct Counts {
    columns: usize,
    rows: usize,
    /// Side of a tile.
    side: DVec2,
    extent: DVec2,
    /// Share of the bounding rectangle that the surface fills.
    fill: f64,
    counts: Vec<f64>,
}

impl Counts {
    fn new(surface: &Surface, cells: [usize; 2]) -> Self {
        let [columns, rows] = cells.map(|n| n.div_ceil(1 << TILE_LEVEL));
        let side = surface.extent / DVec2::new(cells[0] as f64, cells[1] as f64) * f64::from(1 << TILE_LEVEL);
        let fill = surface.area / (surface.extent.x * surface.extent.y).max(1e-300);
        Self { columns, rows, side, extent: surface.extent, fill, counts: vec![0.0; columns * rows] }
    }

    fn enter(&mut self, uv: DVec2) {
        let index = |x: f64, side: f64, n: usize| ((x / side).max(0.0) as usize).min(n - 1);
        let tile = index(uv.y, self.side.y, self.rows) * self.columns + index(uv.x, self.side.x, self.columns);
        self.counts[tile] += 1.0;
    }

    /// Landings and area of each.
    fn tiles(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.counts.iter().enumerate().map(|(k, count)| {
            let low = DVec2::new((k % self.columns) as f64, (k / self.columns) as f64) * self.side;
            let part = self.side.min(self.extent - low);
            (*count, (part.x * part.y * self.fill).max(1e-30))
        })
    }
}
