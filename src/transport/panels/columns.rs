//! Windows with a BSDF under any sky: what they send on of each column of daylight, as a year wants it.
//!
//! Sky and ground are sorted into the patches of the BSDF as for a moment, but each column of them is kept apart. The sun falls
//! into the patch of its middle: a window has a few zones, and each zone under a sun in each patch is a column of its own. How
//! much of the sun falls on a zone is found hour by hour.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::sight::panel_spots;
use super::{CellSet, Lattice, Spot, Window, places};
use crate::mesh::sample_polygon;
use crate::transport::chain::Tint;
use crate::transport::daylight::{DAYLIGHT_GROUPS, SUN, Seen, visible_directions};
use crate::transport::direct::DirectScratch;
use crate::transport::optics::LANES;
use crate::transport::points::{Points, seed};
use crate::transport::scatterer::Scatterer;
use crate::transport::sunlight::sun_factor;
use crate::transport::world::World;

/// Zones of all windows together.
const ZONES: f64 = 8.0;
/// Points of a zone at which the sun is looked for.
const ZONE_POINTS: u32 = 8;

/// What windows with a BSDF take in, column by column: those of sky and ground, then those of the sun.
#[derive(Debug)]
pub struct PanelColumns {
    skies: usize,
    suns: Vec<SunColumn>,
    windows: Vec<Columns>,
    /// Number of spots, and of cells that keep light, of all windows.
    spots: usize,
}

/// The sun in a patch of a side of a window, on one of its zones; the zones follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct SunColumn {
    window: usize,
    front: bool,
    patch: usize,
    zone: usize,
}

#[derive(Debug)]
struct Columns {
    zones: Lattice,
    /// Area of each zone over that of the window.
    areas: Vec<f64>,
    /// What the cells of each set take in by back and front.
    taken: Vec<[Vec<Vec<Taken>>; 2]>,
    /// First spot of the light that leaves back and front.
    spots: [usize; 2],
    /// First cell that keeps light of back and front, by the same numbers.
    kept: [usize; 2],
}

/// Irradiance of a cell in a patch for each unit of luminance of a column.
#[derive(Clone, Copy, Debug)]
struct Taken {
    column: u32,
    patch: u32,
    irradiance: f32,
}

/// The sun on a window.
#[derive(Clone, Debug)]
pub struct PanelSun {
    /// The column of the first zone.
    pub first: usize,
    /// Irradiance of each zone per unit of the sun's face on.
    pub irradiance: Vec<f64>,
    /// Mean over the window.
    pub mean: f64,
    /// Panes before the window.
    pub panes: Vec<u32>,
}

/// How a point looks at windows with a BSDF.
#[derive(Clone, Copy, Debug)]
pub struct PanelLook {
    /// The set of cells that is read.
    pub set: usize,
    /// Is it a vertex of one of many paths?
    pub is_vertex: bool,
    /// The side of such a window where it lies.
    pub receiver: Option<(u32, bool)>,
}

impl PanelColumns {
    /// For `skies` columns of sky and ground, each direction of which belongs to one by `column`, no finer than `width` radians,
    /// and for a sun in any of the directions `suns`.
    #[must_use]
    pub fn new(
        world: &World,
        (skies, width): (usize, f64),
        column: &(impl Fn(&Seen<'_>) -> usize + Sync),
        suns: &[DVec3],
        stream: u64,
    ) -> Self {
        let all = &world.panels().windows;
        let list = &world.surfaces.list;
        let area: f64 = all.iter().map(|w| list[w.surface as usize].area).sum();
        let mut spots = 0;
        let mut columns = BTreeSet::new();
        let mut windows = Vec::new();
        for (number, window) in all.iter().enumerate() {
            let Some(scatterer) = world.scatterer(window.surface) else { continue };
            let surface = &list[window.surface as usize];
            let zones = Lattice::from_corner(surface, (ZONES * surface.area / area).max(1.0));
            for sun in suns {
                let front = surface.normal.dot(*sun) > 0.0;
                if scatterer.incoming(front) > 0 {
                    let patch = scatterer.incoming_patch(surface, front, -*sun);
                    columns.extend((0..zones.len()).map(|zone| SunColumn { window: number, front, patch, zone }));
                }
            }
            let cells = window.sets[0].lattice.len();
            let mut next = |count: usize| {
                spots += count;
                spots - count
            };
            windows.push(Columns {
                areas: (0..zones.len()).map(|z| zones.area(surface, z) / surface.area).collect(),
                zones,
                taken: (0..window.sets.len())
                    .map(|k| {
                        let points = seed(&[stream, u64::from(window.surface), k as u64]);
                        [false, true].map(|front| {
                            taken(world, (window, scatterer), (&window.sets[k], front), (width, points), column)
                        })
                    })
                    .collect(),
                spots: [false, true].map(|front| next(cells * scatterer.outgoing(front))),
                kept: [false, true].map(|_| next(cells)),
            });
        }
        Self { skies, suns: columns.into_iter().collect(), windows, spots }
    }

    /// Number of columns of sky and ground, and of the sun.
    #[must_use]
    pub fn count(&self) -> [usize; 2] {
        [self.skies, self.suns.len()]
    }

    /// Number of spots.
    #[must_use]
    pub fn spots(&self) -> usize {
        self.spots
    }

    /// Radiance of the spots of a set for eight neighbouring columns, per unit of each: sr⁻¹ for the sun's irradiance on a zone.
    /// Cells that keep light follow: irradiance of what does not pass, over the mean share that does not.
    #[must_use]
    pub fn block(&self, world: &World, set: usize, block: usize) -> Vec<[f64; LANES]> {
        let mut light = vec![[0.0; LANES]; self.spots];
        let columns = block * LANES..(block + 1) * LANES;
        let first_sun = self.suns.len().min(columns.start.saturating_sub(self.skies));
        let suns = &self.suns[first_sun..self.suns.len().min(columns.end.saturating_sub(self.skies))];
        for (number, (own, window)) in self.windows.iter().zip(&world.panels().windows).enumerate() {
            let Some(scatterer) = world.scatterer(window.surface) else { continue };
            for front in [false, true] {
                let (side, patches) = (usize::from(front), scatterer.outgoing(!front));
                let mut give = |cell: usize, column: usize, patch: usize, irradiance: f64| {
                    let lane = column - columns.start;
                    let spots = &mut light[own.spots[usize::from(!front)] + cell * patches..][..patches];
                    for (spot, f) in spots.iter_mut().zip(scatterer.sends(front, patch)) {
                        spot[lane] += f * irradiance;
                    }
                    let stays = (1.0 - scatterer.lets_by_in(front, patch)) / scatterer.stays(front);
                    light[own.kept[side] + cell][lane] += irradiance * stays;
                };
                for (cell, list) in own.taken[set][side].iter().enumerate() {
                    let first = list.partition_point(|t| (t.column as usize) < columns.start);
                    for t in list[first..].iter().take_while(|t| columns.contains(&(t.column as usize))) {
                        give(cell, t.column as usize, t.patch as usize, f64::from(t.irradiance));
                    }
                }
                let lattice = &window.sets[set].lattice;
                let is_own = |(_, s): &(usize, &SunColumn)| s.window == number && s.front == front;
                for (k, sun) in suns.iter().enumerate().filter(is_own) {
                    for cell in (0..lattice.len()).filter(|c| own.zones.cell(lattice.middle(*c)) == sun.zone) {
                        give(cell, self.skies + first_sun + k, sun.patch, 1.0);
                    }
                }
            }
        }
        light
    }

    /// Tells `found` the spots that a point sees, each with the irradiance for its radiance, sr, and what panes leave of it;
    /// and the cell that keeps light where it lies. Returns rays that chance chose.
    pub fn look(
        &self,
        world: &World,
        at: (DVec3, DVec3),
        sample: u64,
        look: PanelLook,
        scratch: &mut DirectScratch,
        mut found: impl FnMut(usize, f64, &Tint),
    ) -> u64 {
        (scratch.set, scratch.receiver) = (look.set, look.receiver);
        let wanted = scratch.wanted(look.is_vertex);
        if let Some((surface, front)) = look.receiver
            && let Some(window) = world.panels().of_surface[surface as usize]
        {
            let lattice = &world.panels().windows[window as usize].sets[look.set].lattice;
            let cell = lattice.cell(world.surfaces.list[surface as usize].uv(at.0));
            found(self.windows[window as usize].kept[usize::from(front)] + cell, 1.0, &Tint::default());
        }
        panel_spots(world, at, sample, wanted, scratch, &mut |spot, weight, tint| {
            let Spot { window, front, cell, patch, patches, .. } = spot;
            found(self.windows[window].spots[usize::from(front)] + cell * patches + patch, weight, tint);
        })
    }

    /// The sun about `direction` on every window that it reaches.
    #[must_use]
    pub fn sun(&self, world: &World, direction: DVec3, scratch: &mut DirectScratch) -> Vec<PanelSun> {
        let of = |(number, own): (usize, &Columns)| {
            let id = world.panels().windows[number].surface;
            let (surface, scatterer) = (&world.surfaces.list[id as usize], world.scatterer(id)?);
            let front = surface.normal.dot(direction) > 0.0;
            let normal = surface.side_normal(front);
            let patch = scatterer.incoming_patch(surface, front, -direction);
            let first = self.suns.binary_search(&SunColumn { window: number, front, patch, zone: 0 }).ok()?;
            let mut panes = Vec::new();
            let mut on_zone = |zone: usize| {
                let outline = own.zones.outline(surface, zone);
                let points = Points::new(seed(&[u64::from(id), zone as u64]));
                let at = |k: u32| {
                    let (a, b) = points.pair(k, 0);
                    let x = world.lift(surface.point(sample_polygon(&outline, a, b)), normal);
                    let mut factors = [0.0; DAYLIGHT_GROUPS];
                    sun_factor(world, (x, normal), direction, u64::from(k), scratch, &mut factors);
                    if factors[SUN] > 0.0 && panes.is_empty() {
                        panes.extend_from_slice(scratch.panes());
                    }
                    factors[SUN] / f64::from(ZONE_POINTS)
                };
                (0..ZONE_POINTS).map(at).sum()
            };
            let irradiance: Vec<f64> = (0..own.zones.len()).map(&mut on_zone).collect();
            let mean: f64 = irradiance.iter().zip(&own.areas).map(|(e, a)| e * a).sum();
            (mean > 0.0).then_some(PanelSun { first, irradiance, mean, panes })
        };
        self.windows.iter().enumerate().filter_map(of).collect()
    }
}

/// What the cells of a side take in: sorted by column.
fn taken(
    world: &World,
    (window, scatterer): (&Window, &Scatterer),
    (set, front): (&CellSet, bool),
    (width, stream): (f64, u64),
    column: &(impl Fn(&Seen<'_>) -> usize + Sync),
) -> Vec<Vec<Taken>> {
    if scatterer.incoming(front) == 0 {
        return vec![Vec::new(); set.lattice.len()];
    }
    let own = &world.surfaces.list[window.surface as usize];
    let normal = own.side_normal(front);
    let of = |scratch: &mut DirectScratch, cell: usize| {
        let x = places(world, own, front, (&set.lattice, cell), stream)(0);
        let mut list: Vec<Taken> = Vec::new();
        visible_directions(world, (x, normal), stream ^ cell as u64, (width, None), scratch, &mut |seen| {
            let patch = scatterer.incoming_patch(own, front, -seen.direction) as u32;
            let projected = seen.solid_angle * normal.dot(seen.direction).max(0.0);
            let irradiance = (projected * f64::from(seen.tint.scale)) as f32;
            list.push(Taken { column: column(&seen) as u32, patch, irradiance });
        });
        list.sort_by_key(|t| (t.column, t.patch));
        list.dedup_by(|next, kept| {
            let is_same = (next.column, next.patch) == (kept.column, kept.patch);
            kept.irradiance += if is_same { next.irradiance } else { 0.0 };
            is_same
        });
        list
    };
    (0..set.lattice.len()).into_par_iter().map_init(DirectScratch::default, of).collect()
}

impl Lattice {
    /// About so many cells that begin at the corner.
    fn from_corner(surface: &crate::mesh::Surface, count: f64) -> Self {
        let side = (surface.extent.x * surface.extent.y / count).sqrt();
        let across = (surface.extent / side).round().max(DVec2::ONE);
        Self { cells: [across.x as usize, across.y as usize], step: surface.extent / across, shift: DVec2::ZERO }
    }

    fn middle(&self, cell: usize) -> DVec2 {
        (self.corner(cell) + 0.5) * self.step
    }

    fn area(&self, surface: &crate::mesh::Surface, cell: usize) -> f64 {
        crate::mesh::polygon_area(&self.outline(surface, cell)).abs()
    }
}
