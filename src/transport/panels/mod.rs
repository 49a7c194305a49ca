//! Windows with a BSDF as they shine: what they send on of sky, ground and sun, place by place and patch by patch.
//!
//! Each window is divided into cells. At a point of each, the directions from which sky and ground are seen are sorted into
//! the patches of the BSDF (`E_i = ∫ L cos θ dω` over the patch, exact clipping, panes before it included), the sun falls
//! into the patch of its middle, and `L_o = Σ_i f(o, i) E_i` (Klems 1994; Ward et al. 2011) is what leaves the other side.
//! There are four sets of cells, shifted against each other, each with points of its own: their scatter tells what cells and
//! points cost, and runs into the errors of the sensors.

mod columns;
mod sight;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::daylight::{DAYLIGHT_GROUPS, GROUND, SKY, SUN, visible_directions};
use super::direct::DirectScratch;
use super::points::{Points, seed};
use super::scatterer::Scatterer;
use super::sunlight::sun_factor;
use super::world::World;
use crate::mesh::{Surface, clip_halfplane, sample_polygon};

pub use self::columns::{PanelColumns, PanelLook, PanelSun};
pub(super) use self::sight::{Wanted, panel_light};

/// Independent sets of cells.
pub const PANEL_SETS: usize = 4;
/// Where the lattices of the sets begin, in cells.
const SHIFTS: [DVec2; PANEL_SETS] =
    [DVec2::new(0.125, 0.625), DVec2::new(0.375, 0.125), DVec2::new(0.625, 0.875), DVec2::new(0.875, 0.375)];
/// Cells of all windows together in each set at a tolerance of 5 %, and at most.
const CELLS: f64 = 256.0;
const MOST_CELLS: f64 = 4096.0;
/// Most cells of a window along a side.
const MOST_ACROSS: f64 = 128.0;
/// Widest cone of sky that one direction stands for, radians, at a tolerance of 5 %, and least: about a patch; the direction
/// lies anywhere in the cone, and cells are many.
const WIDTH: f64 = 0.2;
const LEAST_WIDTH: f64 = 0.1;
/// Points of a cell at which the sun is looked for.
const SUN_POINTS: u32 = 4;

/// All windows with a BSDF.
#[derive(Clone, Debug, Default)]
pub struct Panels {
    windows: Vec<Window>,
    /// Window of each surface.
    of_surface: Vec<Option<u32>>,
}

#[derive(Clone, Debug)]
struct Window {
    surface: u32,
    sets: Vec<CellSet>,
    /// Does any light leave the back, the front?
    shines: [bool; 2],
}

/// One lattice over a window.
#[derive(Clone, Debug)]
struct CellSet {
    lattice: Lattice,
    /// What leaves back and front: `[cell][group][patch]`, sr⁻¹ per unit of the group.
    leaving: [Vec<f32>; 2],
    /// What arrives on back and front and does not pass, over the mean share that does not: irradiance by cell.
    kept: [Vec<[f32; DAYLIGHT_GROUPS]>; 2],
}

#[derive(Clone, Copy, Debug)]
struct Lattice {
    cells: [usize; 2],
    step: DVec2,
    shift: DVec2,
}

impl Lattice {
    fn new(surface: &Surface, count: f64, shift: DVec2) -> Self {
        let side = (surface.extent.x * surface.extent.y / count).sqrt();
        let across = (surface.extent / side).round().clamp(DVec2::ONE, DVec2::splat(MOST_ACROSS));
        // A lattice that does not begin at the corner has one more.
        Self { cells: [across.x as usize + 1, across.y as usize + 1], step: surface.extent / across, shift }
    }

    fn len(&self) -> usize {
        self.cells[0] * self.cells[1]
    }

    fn cell(&self, uv: DVec2) -> usize {
        let place = (uv / self.step + self.shift).max(DVec2::ZERO);
        let [u, v] = [(place.x as usize).min(self.cells[0] - 1), (place.y as usize).min(self.cells[1] - 1)];
        v * self.cells[0] + u
    }

    /// Lower left corner of a cell, in cells.
    fn corner(&self, cell: usize) -> DVec2 {
        DVec2::new((cell % self.cells[0]) as f64, (cell / self.cells[0]) as f64) - self.shift
    }

    /// The part of a surface in a cell; the whole where rounding leaves nothing.
    fn outline(&self, surface: &Surface, cell: usize) -> Vec<DVec2> {
        let corner = self.corner(cell);
        let (low, high) = (corner * self.step, (corner + 1.0) * self.step);
        let mut outline = surface.outline.clone();
        let mut part = Vec::new();
        for (point, normal) in [(low, DVec2::X), (low, DVec2::Y), (high, -DVec2::X), (high, -DVec2::Y)] {
            clip_halfplane(&outline, point, normal, &mut part);
            std::mem::swap(&mut outline, &mut part);
        }
        if outline.len() < 3 { surface.outline.clone() } else { outline }
    }
}

/// What a look at a window with a BSDF meets: a patch of the directions in which light leaves a cell of a side.
#[derive(Clone, Copy, Debug)]
struct Spot {
    window: usize,
    front: bool,
    set: usize,
    cell: usize,
    patch: usize,
    /// Number of patches of that side.
    patches: usize,
}

/// What one cell gets and gives, by the side that the light arrives on.
struct Cell {
    leaving: [Vec<f32>; 2],
    kept: [[f32; DAYLIGHT_GROUPS]; 2],
}

impl Panels {
    /// What the windows of a world take from its sky, ground and sun.
    pub(super) fn new(world: &World, tolerance: f64, stream: u64) -> Self {
        let list = &world.surfaces.list;
        let surfaces: Vec<u32> = (0..list.len() as u32).filter(|s| world.scatterer(*s).is_some()).collect();
        let area: f64 = surfaces.iter().map(|s| list[*s as usize].area).sum();
        let cells = (CELLS * 0.05 / tolerance).min(MOST_CELLS);
        let width = (WIDTH * (tolerance / 0.05).sqrt()).clamp(LEAST_WIDTH, WIDTH);
        let mut of_surface = vec![None; list.len()];
        let mut windows = Vec::new();
        for surface in surfaces {
            let Some(scatterer) = world.scatterer(surface) else { continue };
            let count = (cells * list[surface as usize].area / area).max(1.0);
            let set = |k: usize| cell_set(world, (surface, scatterer), (count, k), width, stream);
            let sets: Vec<CellSet> = (0..PANEL_SETS).map(set).collect();
            let shines = [0, 1].map(|side| sets.iter().any(|s| s.leaving[side].iter().any(|l| *l > 0.0)));
            of_surface[surface as usize] = Some(windows.len() as u32);
            windows.push(Window { surface, sets, shines });
        }
        Self { windows, of_surface }
    }

    /// Irradiance of sky, ground and sun on a side of a window at a place, each per unit of its group, of what does not pass
    /// and over the mean share that does not.
    pub(super) fn kept(&self, set: usize, surface: u32, front: bool, uv: DVec2) -> [f64; DAYLIGHT_GROUPS] {
        let Some(window) = self.of_surface.get(surface as usize).copied().flatten() else { return [0.0; 3] };
        let set = &self.windows[window as usize].sets[set];
        set.kept[usize::from(front)][set.lattice.cell(uv)].map(f64::from)
    }

    /// Radiance of sky, ground and sun that leaves a side of a window at a place along `travel`, per unit of each group.
    #[must_use]
    pub fn radiance(
        &self,
        world: &World,
        (surface, front): (u32, bool),
        set: usize,
        uv: DVec2,
        travel: DVec3,
    ) -> [f64; DAYLIGHT_GROUPS] {
        let window = self.of_surface.get(surface as usize).copied().flatten();
        window.map_or([0.0; DAYLIGHT_GROUPS], |window| {
            self.of_spot(self.spot(world, (window as usize, front), set, uv, travel))
        })
    }

    /// What lies at a place of a side of a window, for light that leaves along `travel`.
    fn spot(&self, world: &World, (window, front): (usize, bool), set: usize, uv: DVec2, travel: DVec3) -> Spot {
        let Window { surface, sets, .. } = &self.windows[window];
        let own = &world.surfaces.list[*surface as usize];
        let (patch, patches) =
            world.scatterer(*surface).map_or((0, 0), |s| (s.outgoing_patch(own, front, travel), s.outgoing(front)));
        Spot { window, front, set, cell: sets[set].lattice.cell(uv), patch, patches }
    }

    /// Radiance of sky, ground and sun of a spot, per unit of each group.
    fn of_spot(&self, Spot { window, front, set, cell, patch, patches }: Spot) -> [f64; DAYLIGHT_GROUPS] {
        let leaving = &self.windows[window].sets[set].leaving[usize::from(front)];
        let first = cell * DAYLIGHT_GROUPS * patches + patch;
        std::array::from_fn(|group| leaving.get(first + group * patches).map_or(0.0, |l| f64::from(*l)))
    }
}

fn cell_set(world: &World, window: (u32, &Scatterer), (count, k): (f64, usize), width: f64, stream: u64) -> CellSet {
    let surface = window.0;
    let lattice = Lattice::new(&world.surfaces.list[surface as usize], count, SHIFTS[k]);
    let points = seed(&[stream, 11, u64::from(surface), k as u64]);
    let cells: Vec<Cell> = (0..lattice.len())
        .into_par_iter()
        .map_init(DirectScratch::default, |scratch, cell| {
            fill_cell(world, window, (&lattice, cell), (width, points), scratch)
        })
        .collect();
    let mut set = CellSet { lattice, leaving: Default::default(), kept: Default::default() };
    for cell in cells {
        for (side, leaving) in cell.leaving.into_iter().enumerate() {
            set.leaving[side].extend(leaving);
            set.kept[side].push(cell.kept[side]);
        }
    }
    set
}

fn fill_cell(
    world: &World,
    (surface, scatterer): (u32, &Scatterer),
    (lattice, cell): (&Lattice, usize),
    (width, stream): (f64, u64),
    scratch: &mut DirectScratch,
) -> Cell {
    let own = &world.surfaces.list[surface as usize];
    let mut out = Cell { leaving: Default::default(), kept: Default::default() };
    for front in [false, true] {
        let place = places(world, own, front, (lattice, cell), stream);
        let mut irradiance = vec![vec![0.0; scatterer.incoming(front)]; DAYLIGHT_GROUPS];
        if irradiance[SKY].is_empty() {
            continue;
        }
        arriving(world, (surface, front), place, (width, stream ^ cell as u64), scratch, &mut irradiance);
        let stays = scatterer.stays(front);
        for (group, e) in irradiance.iter().enumerate() {
            let stay = |(i, e): (usize, &f64)| e * (1.0 - scatterer.lets_by_in(front, i)) / stays;
            out.kept[usize::from(front)][group] = e.iter().enumerate().map(stay).sum::<f64>() as f32;
            scatterer.pass_on(front, e, |_, l| out.leaving[usize::from(!front)].push(l as f32));
        }
    }
    out
}

/// Places on a side of a cell, by number.
fn places(
    world: &World,
    own: &Surface,
    front: bool,
    (lattice, cell): (&Lattice, usize),
    stream: u64,
) -> impl Fn(u32) -> DVec3 {
    let outline = lattice.outline(own, cell);
    let points = Points::new(seed(&[stream, cell as u64]));
    let normal = own.side_normal(front);
    move |k| {
        let (a, b) = points.pair(k, 0);
        world.lift(own.point(sample_polygon(&outline, a, b)), normal)
    }
}

/// Irradiance on a side of a window by group and patch, each per unit of its group.
fn arriving(
    world: &World,
    (surface, front): (u32, bool),
    place: impl Fn(u32) -> DVec3,
    (width, sample): (f64, u64),
    scratch: &mut DirectScratch,
    irradiance: &mut [Vec<f64>],
) {
    let (Some(light), Some(scatterer)) = (world.daylight(), world.scatterer(surface)) else { return };
    let own = &world.surfaces.list[surface as usize];
    let normal = own.side_normal(front);
    visible_directions(world, (place(0), normal), sample, (width, None), scratch, &mut |seen| {
        let patch = scatterer.incoming_patch(own, front, -seen.direction);
        let (group, luminance) = if seen.direction.z < 0.0 {
            (GROUND, if light.ground_reflectance > 0.0 { std::f64::consts::FRAC_1_PI } else { 0.0 })
        } else {
            (SKY, light.sky.map_or(0.0, |sky| sky.luminance(seen.direction)))
        };
        let projected = seen.solid_angle * normal.dot(seen.direction).max(0.0);
        irradiance[group][patch] += projected * luminance * f64::from(seen.tint.scale);
    });
    let Some(sun) = light.sun.filter(|sun| normal.dot(*sun) > 0.0) else { return };
    let patch = scatterer.incoming_patch(own, front, -sun);
    for k in 0..SUN_POINTS {
        let mut factors = [0.0; DAYLIGHT_GROUPS];
        sun_factor(world, (place(k), normal), sun, sample ^ u64::from(k), scratch, &mut factors);
        irradiance[SUN][patch] += factors[SUN] / f64::from(SUN_POINTS);
    }
}
