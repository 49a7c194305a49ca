//! Elements: cells of a surface's grid, one per side, made when a ray first asks for them.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::importance::{Importance, Tiles, most_at};
use super::polygon::{clip_halfplane, clip_line, polygon_area};
use super::surfaces::{Surface, Surfaces};

/// No element here (yet).
pub const NO_ELEMENT: u32 = u32::MAX;
/// The cell is cut: its pieces are found by key.
const CUT_CELL: u32 = u32::MAX - 1;
/// Lines that may cut one cell; further ones are left to the samples, which do not count inside solids.
const MAX_CUTS: usize = 9;

/// Names an element before it exists: surface (24 bits), side (1), first cell of its block (30), side of each cut (9).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ElementKey(u64);

impl ElementKey {
    fn new(surface: usize, front: bool, cell: usize, mask: u64) -> Self {
        Self(((surface as u64) << 40) | (u64::from(front) << 39) | ((cell as u64) << MAX_CUTS) | mask)
    }

    fn surface(self) -> usize {
        (self.0 >> 40) as usize
    }

    fn front(self) -> bool {
        (self.0 >> 39) & 1 == 1
    }

    fn cell(self) -> usize {
        ((self.0 >> MAX_CUTS) & ((1 << 30) - 1)) as usize
    }

    fn mask(self) -> u64 {
        self.0 & ((1 << MAX_CUTS) - 1)
    }

    /// The same piece of the surface, seen from the other side.
    #[must_use]
    pub fn other_side(self) -> Self {
        Self(self.0 ^ (1 << 39))
    }

    /// The same for all elements of one side of a surface that lie on the same side of its cuts: they share one
    /// sequence of points.
    #[must_use]
    pub fn family(self) -> u64 {
        Self::new(self.surface(), self.front(), 0, self.mask()).0
    }
}

/// A piece of a surface, seen from one side.
#[derive(Clone, Debug)]
pub struct Element {
    /// Its name.
    pub key: ElementKey,
    /// Index of the surface.
    pub surface: u32,
    /// Which side.
    pub front: bool,
    /// Outline in the surface's (u, v), counter-clockwise, convex.
    pub outline: Vec<DVec2>,
    /// Area, in the program's frame.
    pub area: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct CutLine {
    point: DVec2,
    normal: DVec2,
}

#[derive(Clone, Debug)]
struct SurfaceGrid {
    cells: [usize; 2],
    step: DVec2,
    /// Start of the back's and the front's cells in the table.
    start: [usize; 2],
    /// How many cells are joined, and where.
    tiles: Tiles,
}

/// The elements made so far, and where to find them.
#[derive(Clone, Debug)]
pub struct Elements {
    /// Side of a cell aimed at, in the program's frame.
    pub size: f64,
    grids: Vec<SurfaceGrid>,
    table: Vec<u32>,
    cuts: HashMap<(u32, u32), Vec<CutLine>>,
    pieces: HashMap<u64, u32>,
    list: Vec<Element>,
}

impl Elements {
    /// An empty mesh with cells of about `size`, joined to blocks where importance is thin.
    #[must_use]
    pub fn new(surfaces: &Surfaces, size: f64, importance: &Importance) -> Self {
        let cells = surfaces.cells(size);
        let tiles = importance.tiles(&surfaces.list, &cells);
        let mut grids = Vec::with_capacity(surfaces.list.len());
        let mut used = 0;
        for ((s, cells), tiles) in surfaces.list.iter().zip(cells).zip(tiles) {
            let n = cells[0] * cells[1];
            let step = s.extent / DVec2::new(cells[0] as f64, cells[1] as f64);
            grids.push(SurfaceGrid { cells, step, start: [used, used + n], tiles });
            used += 2 * n;
        }
        let mut mesh = Self {
            size,
            grids,
            table: vec![NO_ELEMENT; used],
            cuts: HashMap::new(),
            pieces: HashMap::new(),
            list: Vec::new(),
        };
        for (i, s) in surfaces.list.iter().enumerate() {
            mesh.enter_cuts(i, s);
        }
        mesh
    }

    fn enter_cuts(&mut self, index: usize, surface: &Surface) {
        for [a, b] in &surface.cuts {
            let along = (*b - *a).normalize_or_zero();
            let line = CutLine { point: *a, normal: DVec2::new(-along.y, along.x) };
            let grid = &self.grids[index];
            let low = (a.min(*b) / grid.step).floor() - 1.0;
            let high = (a.max(*b) / grid.step).floor() + 1.0;
            let range = |lo: f64, hi: f64, n: usize| (lo.max(0.0) as usize)..=(hi.clamp(0.0, (n - 1) as f64) as usize);
            for iv in range(low.y, high.y, grid.cells[1]) {
                for iu in range(low.x, high.x, grid.cells[0]) {
                    let grid = &self.grids[index];
                    let cell = grid.block(iu, iv);
                    if !crosses(&grid.rectangle(cell), *a, *b) {
                        continue;
                    }
                    let lines = self.cuts.entry((index as u32, cell as u32)).or_default();
                    // Every cell of a block finds the line.
                    if lines.len() < MAX_CUTS && lines.last() != Some(&line) {
                        lines.push(line);
                    }
                    for start in grid.start {
                        self.table[start + cell] = CUT_CELL;
                    }
                }
            }
        }
    }

    /// The element under a point of a surface, by name.
    #[must_use]
    pub fn key_at(&self, surface: usize, front: bool, uv: DVec2) -> ElementKey {
        let grid = &self.grids[surface];
        let index = |x: f64, step: f64, n: usize| ((x / step).max(0.0) as usize).min(n - 1);
        let cell = grid.block(index(uv.x, grid.step.x, grid.cells[0]), index(uv.y, grid.step.y, grid.cells[1]));
        let mask = if self.table[grid.start[usize::from(front)] + cell] == CUT_CELL {
            let lines = &self.cuts[&(surface as u32, cell as u32)];
            lines
                .iter()
                .enumerate()
                .map(|(bit, l)| u64::from(l.normal.dot(uv - l.point) >= 0.0) << bit)
                .fold(0, |a, b| a | b)
        } else {
            0
        };
        ElementKey::new(surface, front, cell, mask)
    }

    /// The element of that name, or [`NO_ELEMENT`].
    #[must_use]
    pub fn find(&self, key: ElementKey) -> u32 {
        let grid = &self.grids[key.surface()];
        match self.table[grid.start[usize::from(key.front())] + key.cell()] {
            CUT_CELL => self.pieces.get(&key.0).copied().unwrap_or(NO_ELEMENT),
            id => id,
        }
    }

    /// Makes the element, if it does not exist.
    pub fn make(&mut self, surfaces: &Surfaces, key: ElementKey) -> u32 {
        let found = self.find(key);
        if found != NO_ELEMENT {
            return found;
        }
        let id = self.list.len() as u32;
        let element = self.element(&surfaces.list[key.surface()], key);
        self.list.push(element);
        let grid = &self.grids[key.surface()];
        let slot = &mut self.table[grid.start[usize::from(key.front())] + key.cell()];
        if *slot == CUT_CELL {
            self.pieces.insert(key.0, id);
        } else {
            *slot = id;
        }
        id
    }

    fn element(&self, surface: &Surface, key: ElementKey) -> Element {
        let grid = &self.grids[key.surface()];
        let mut outline = surface.outline.clone();
        let mut scratch = Vec::new();
        let mut keep = |outline: &mut Vec<DVec2>, point, normal| {
            clip_halfplane(outline, point, normal, &mut scratch);
            // A sliver that rounding empties keeps its last outline: it has been hit, so it exists.
            if scratch.len() >= 3 {
                std::mem::swap(outline, &mut scratch);
            }
        };
        if grid.cells != [1, 1] {
            let [low, _, high, _] = grid.rectangle(key.cell());
            for (point, normal) in [(low, DVec2::X), (low, DVec2::Y), (high, -DVec2::X), (high, -DVec2::Y)] {
                keep(&mut outline, point, normal);
            }
        }
        if let Some(lines) = self.cuts.get(&(key.surface() as u32, key.cell() as u32)) {
            for (bit, line) in lines.iter().enumerate() {
                let sign = if (key.mask() >> bit) & 1 == 1 { 1.0 } else { -1.0 };
                keep(&mut outline, line.point, line.normal * sign);
            }
        }
        Element {
            key,
            surface: key.surface() as u32,
            front: key.front(),
            area: polygon_area(&outline).max(1e-30),
            outline,
        }
    }

    /// Number of the element's cell along a curve that keeps neighbours together (Morton 1966).
    #[must_use]
    pub fn morton(&self, element: &Element) -> u32 {
        let columns = self.grids[element.surface as usize].cells[0];
        let cell = element.key.cell();
        spread(cell % columns) | (spread(cell / columns) << 1)
    }

    /// The elements, in the order in which they were made.
    #[must_use]
    pub fn list(&self) -> &[Element] {
        &self.list
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// None made yet?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// How many the scene would have if all were made, both sides counted.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.table.len()
    }

    /// Bytes that an element takes, about: with an outline of five vertices, and places in the table for four.
    #[must_use]
    pub fn bytes_per_element() -> usize {
        size_of::<Element>() + 5 * size_of::<DVec2>() + 4 * size_of::<u32>()
    }

    /// Side of a block of that name, in sides of a cell.
    #[must_use]
    pub fn block_side(&self, key: ElementKey) -> f64 {
        f64::from(1 << self.level(key))
    }

    /// What an element is worth, at most, of a cell in a place of typical importance.
    #[must_use]
    pub fn worth(&self, element: &Element) -> f64 {
        let step = self.grids[element.surface as usize].step;
        (element.area / (step.x * step.y) * most_at(self.level(element.key))).min(1.0)
    }

    fn level(&self, key: ElementKey) -> u32 {
        let grid = &self.grids[key.surface()];
        grid.tiles.level(key.cell() % grid.cells[0], key.cell() / grid.cells[0])
    }
}

impl Element {
    /// The point of the element at a place of the unit square, uniformly in area.
    #[must_use]
    pub fn sample(&self, surface: &Surface, x: f64, y: f64) -> DVec3 {
        surface.point(super::sample_polygon(&self.outline, x, y))
    }
}

impl SurfaceGrid {
    /// First cell of the block to which a cell belongs.
    fn block(&self, iu: usize, iv: usize) -> usize {
        let level = self.tiles.level(iu, iv);
        ((iv >> level) << level) * self.cells[0] + ((iu >> level) << level)
    }

    /// The block that begins at a cell.
    fn rectangle(&self, cell: usize) -> [DVec2; 4] {
        let (iu, iv) = (cell % self.cells[0], cell / self.cells[0]);
        let side = 1 << self.tiles.level(iu, iv);
        let end = |i: usize, n: usize| (i + side).min(n) as f64;
        let low = DVec2::new(iu as f64, iv as f64) * self.step;
        let high = DVec2::new(end(iu, self.cells[0]), end(iv, self.cells[1])) * self.step;
        [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)]
    }
}

/// Puts a zero between the bits of a number below 2^16.
fn spread(x: usize) -> u32 {
    let x = x as u32 & 0xffff;
    let x = (x | (x << 8)) & 0x00ff_00ff;
    let x = (x | (x << 4)) & 0x0f0f_0f0f;
    let x = (x | (x << 2)) & 0x3333_3333;
    (x | (x << 1)) & 0x5555_5555
}

/// Does the segment go through the inside of the rectangle? Running along its border does not count.
fn crosses(rectangle: &[DVec2; 4], a: DVec2, b: DVec2) -> bool {
    let shrink = (rectangle[2] - rectangle[0]) * 1e-4;
    let inner = [
        rectangle[0] + shrink,
        rectangle[1] + DVec2::new(-shrink.x, shrink.y),
        rectangle[2] - shrink,
        rectangle[3] + DVec2::new(shrink.x, -shrink.y),
    ];
    clip_line(&inner, a, b).is_some()
}
