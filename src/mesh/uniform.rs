//! Uniform meshes: every side of every surface divided into cells of one size, all made at once.
//!
//! The classic methods need all patches before they begin; [`Elements`](super::Elements) are made on demand instead. Like
//! those, patches are cut along the lines on which other surfaces stand.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::linear::Weights;
use super::polygon::{clip_halfplane, clip_line, polygon_area};
use super::surfaces::{Surface, Surfaces};

/// A piece with less than this share of its cell is left out.
const SLIVER: f64 = 1e-9;
/// Cells along one side of a surface, at most.
const MOST_CELLS: f64 = 4096.0;

/// A piece of one side of a surface.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Index of the surface.
    pub surface: u32,
    /// Which side.
    pub front: bool,
    /// Outline in the surface's (u, v), counter-clockwise, convex.
    pub outline: Vec<DVec2>,
    /// The same in the program's frame, counter-clockwise as seen from its side.
    pub polygon: Vec<DVec3>,
    /// Unit normal of its side.
    pub normal: DVec3,
    /// Centroid.
    pub centre: DVec3,
    /// Area, in the program's frame.
    pub area: f64,
    cell: [u32; 2],
}

/// Patches that cover the surfaces of a scene.
pub trait Patches: Sync + std::fmt::Debug {
    /// The patches.
    fn list(&self) -> &[Patch];

    /// The patch under a point of a surface's side.
    fn find(&self, surface: usize, front: bool, uv: DVec2) -> Option<u32>;

    /// Patches and their weights in a value at a point of a surface's side, linear between the middles of patches; `None`
    /// where it cannot be had.
    fn weights(&self, surface: usize, front: bool, uv: DVec2) -> Option<Weights>;
}

/// The patches of one side of one surface.
#[derive(Clone, Debug)]
struct Side {
    cells: [usize; 2],
    step: DVec2,
    /// For each cell, the number of its first patch; one more at the end.
    first: Vec<u32>,
}

/// All patches of a scene.
#[derive(Clone, Debug)]
pub struct PatchMesh {
    /// The patches, surface by surface, back before front, cell by cell.
    pub list: Vec<Patch>,
    sides: Vec<[Side; 2]>,
}

impl PatchMesh {
    /// Divides all surfaces into cells of about `size` (in the program's frame); only patches that are to be `kept` become
    /// part of the mesh.
    #[must_use]
    pub fn uniform(surfaces: &Surfaces, size: f64, kept: impl FnMut(&Patch) -> bool) -> Self {
        let count = |side: f64| (side / size - 1e-6).ceil().clamp(1.0, MOST_CELLS) as usize;
        let cells = |_: usize, s: &Surface| [count(s.extent.x), count(s.extent.y)];
        Self::build(surfaces, cells, kept)
    }

    /// Divides every cell into `parts × parts` elements: a substructured mesh (Cohen, Greenberg, Immel and Brock 1986).
    #[must_use]
    pub fn elements(&self, surfaces: &Surfaces, parts: usize) -> Self {
        let cells = |i: usize, _: &Surface| self.sides[i][1].cells.map(|n| n * parts);
        let mut fine = Self::build(surfaces, cells, |p| self.under(surfaces, p).is_some());
        fine.list.shrink_to_fit();
        fine
    }

    /// The patch that an element lies in.
    #[must_use]
    pub fn under(&self, surfaces: &Surfaces, element: &Patch) -> Option<u32> {
        let surface = element.surface as usize;
        self.find(surface, element.front, surfaces.list[surface].uv(element.centre))
    }

    fn build(
        surfaces: &Surfaces,
        cells: impl Fn(usize, &Surface) -> [usize; 2],
        mut kept: impl FnMut(&Patch) -> bool,
    ) -> Self {
        let mut mesh = Self { list: Vec::new(), sides: Vec::with_capacity(surfaces.list.len()) };
        for (i, s) in surfaces.list.iter().enumerate() {
            let cells = cells(i, s);
            let step = s.extent / DVec2::new(cells[0] as f64, cells[1] as f64);
            let pieces: Vec<([u32; 2], Vec<DVec2>)> = (0..cells[0] * cells[1])
                .flat_map(|k| {
                    let cell = [(k % cells[0]) as u32, (k / cells[0]) as u32];
                    pieces_of_cell(s, cell, step).into_iter().map(move |p| (cell, p))
                })
                .collect();
            let sides = [false, true].map(|front| {
                let mut side = Side { cells, step, first: vec![mesh.list.len() as u32; cells[0] * cells[1] + 1] };
                for (cell, outline) in &pieces {
                    let patch = Patch::new(s, i as u32, front, *cell, outline.clone());
                    if kept(&patch) {
                        mesh.list.push(patch);
                    }
                    side.first[(cell[1] as usize * cells[0] + cell[0] as usize) + 1] = mesh.list.len() as u32;
                }
                // Cells without pieces begin where the next one does.
                for k in 1..side.first.len() {
                    side.first[k] = side.first[k].max(side.first[k - 1]);
                }
                side
            });
            mesh.sides.push(sides);
        }
        mesh
    }

    /// The patch under a point of a surface's side.
    #[must_use]
    pub fn find(&self, surface: usize, front: bool, uv: DVec2) -> Option<u32> {
        let side = &self.sides[surface][usize::from(front)];
        let index = |x: f64, step: f64, n: usize| ((x / step).max(0.0) as usize).min(n - 1);
        let cell = [index(uv.x, side.step.x, side.cells[0]), index(uv.y, side.step.y, side.cells[1])];
        deepest(side.of(cell), |i| &self.list[i as usize].outline, uv)
    }
}

impl Patches for PatchMesh {
    fn list(&self) -> &[Patch] {
        &self.list
    }

    fn find(&self, surface: usize, front: bool, uv: DVec2) -> Option<u32> {
        Self::find(self, surface, front, uv)
    }

    /// Linear between the middles of cells, continued to the border of the surface; `None` beside cells that are cut or
    /// have no patch.
    fn weights(&self, surface: usize, front: bool, uv: DVec2) -> Option<Weights> {
        let side = &self.sides[surface][usize::from(front)];
        let across = |x: f64, step: f64, n: usize| {
            let place = x / step - 0.5;
            let low = place.floor().clamp(0.0, n.max(2) as f64 - 2.0);
            (low as usize, if n > 1 { place - low } else { 0.0 })
        };
        let (iu, tu) = across(uv.x, side.step.x, side.cells[0]);
        let (iv, tv) = across(uv.y, side.step.y, side.cells[1]);
        let mut weights: Weights = [(0, 0.0); 4];
        let corners =
            [(0, 0, (1.0 - tu) * (1.0 - tv)), (0, 1, (1.0 - tu) * tv), (1, 0, tu * (1.0 - tv)), (1, 1, tu * tv)];
        for (entry, (du, dv, weight)) in weights.iter_mut().zip(corners) {
            if weight != 0.0 {
                let range = side.of([iu + du, iv + dv]);
                *entry = ((range.len() == 1).then_some(range.start as usize)?, weight);
            }
        }
        Some(weights)
    }
}

impl Side {
    fn of(&self, cell: [usize; 2]) -> Range<u32> {
        let k = cell[1] * self.cells[0] + cell[0];
        self.first[k]..self.first[k + 1]
    }
}

impl Patch {
    pub(super) fn new(s: &Surface, surface: u32, front: bool, cell: [u32; 2], outline: Vec<DVec2>) -> Self {
        let mut polygon: Vec<DVec3> = outline.iter().map(|p| s.point(*p)).collect();
        if !front {
            polygon.reverse();
        }
        let centre = s.point(centroid(&outline));
        Self {
            surface,
            front,
            area: polygon_area(&outline),
            outline,
            polygon,
            normal: s.side_normal(front),
            centre,
            cell,
        }
    }

    /// Does a point of the surface lie in it?
    #[must_use]
    pub fn holds(&self, uv: DVec2) -> bool {
        depth(&self.outline, uv) > 0.0
    }

    /// Where in the surface's grid it lies: column, row.
    #[must_use]
    pub fn cell(&self) -> [u32; 2] {
        self.cell
    }
}

/// The pieces of a surface in a cell, cut along its contact lines.
pub(super) fn pieces_of_cell(s: &Surface, cell: [u32; 2], step: DVec2) -> Vec<Vec<DVec2>> {
    let low = DVec2::new(f64::from(cell[0]), f64::from(cell[1])) * step;
    let high = low + step;
    let mut whole = s.outline.clone();
    let mut scratch = Vec::new();
    for (point, normal) in [(low, DVec2::X), (low, DVec2::Y), (high, -DVec2::X), (high, -DVec2::Y)] {
        // Whole surfaces keep their corners to the last bit.
        let size = step.max_element();
        if whole.iter().any(|p| normal.dot(*p - point) < -1e-12 * size) {
            clip_halfplane(&whole, point, normal, &mut scratch);
            std::mem::swap(&mut whole, &mut scratch);
        }
    }
    let least = SLIVER * step.x * step.y;
    let mut pieces = vec![whole];
    for [a, b] in &s.cuts {
        pieces = pieces.into_iter().flat_map(|p| split(p, *a, *b, least)).collect();
    }
    pieces.retain(|p| p.len() >= 3 && polygon_area(p) > least);
    pieces
}

fn split(piece: Vec<DVec2>, a: DVec2, b: DVec2, least: f64) -> Vec<Vec<DVec2>> {
    let crossed =
        piece.len() >= 3 && clip_line(&piece, a, b).is_some_and(|(lo, hi)| (hi - lo) * (b - a).length() > 1e-9);
    if !crossed {
        return vec![piece];
    }
    let normal = (b - a).perp().normalize_or_zero();
    let halves = [normal, -normal].map(|n| {
        let mut half = Vec::new();
        clip_halfplane(&piece, a, n, &mut half);
        half
    });
    if halves.iter().any(|h| h.len() < 3 || polygon_area(h) <= least) {
        return vec![piece];
    }
    halves.into()
}

/// The one of some polygons in which a point lies, or lies the least outside.
pub(super) fn deepest<'a>(range: Range<u32>, outline: impl Fn(u32) -> &'a Vec<DVec2>, uv: DVec2) -> Option<u32> {
    match range.len() {
        0 => None,
        1 => Some(range.start),
        _ => range.max_by(|a, b| depth(outline(*a), uv).total_cmp(&depth(outline(*b), uv))),
    }
}

/// Least distance of a point from the outside of a convex polygon; negative outside.
fn depth(outline: &[DVec2], uv: DVec2) -> f64 {
    (0..outline.len())
        .map(|k| {
            let (p, q) = (outline[k], outline[(k + 1) % outline.len()]);
            (q - p).perp_dot(uv - p) / (q - p).length().max(1e-300)
        })
        .fold(f64::INFINITY, f64::min)
}

fn centroid(polygon: &[DVec2]) -> DVec2 {
    let first = polygon[0];
    let (mut sum, mut area) = (DVec2::ZERO, 0.0);
    for e in polygon[1..].windows(2) {
        let (p, q) = (e[0] - first, e[1] - first);
        let twice = p.perp_dot(q);
        sum += (p + q) * (twice / 3.0);
        area += twice;
    }
    if area > 0.0 { first + sum / area } else { first }
}
