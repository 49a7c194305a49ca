//! Panes as guides to the sky: where a path asks for daylight by one ray, it is sent through a pane.
//!
//! A ray that happens to leave finds the same light; the two ways are weighted by the balance heuristic (Veach and Guibas
//! 1995), so that neither the panes' size nor their nearness spoils the estimate. Without panes chance does it alone.

use glam::DVec3;

use super::chain::Tint;
use super::daylight::pass_out;
use super::specular::Speculars;
use super::world::World;
use crate::mesh::{Surfaces, sample_polygon};

/// The panes of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Portals {
    surfaces: Vec<u32>,
    area: f64,
}

impl Portals {
    pub(super) fn new(surfaces: &Surfaces, is_pane: impl Fn(usize) -> bool) -> Self {
        let list = &surfaces.list;
        let panes: Vec<u32> = (0..list.len()).filter(|s| is_pane(list[*s].material)).map(|s| s as u32).collect();
        Self { area: panes.iter().map(|s| list[*s as usize].area).sum(), surfaces: panes }
    }

    /// A direction to a uniform point of all panes.
    pub(super) fn sample(&self, surfaces: &Surfaces, x: DVec3, (choice, a, b): (f64, f64, f64)) -> Option<DVec3> {
        let mut want = choice * self.area;
        let chosen = self.surfaces.iter().find(|s| {
            want -= surfaces.list[**s as usize].area;
            want <= 0.0
        });
        let surface = &surfaces.list[*chosen.or(self.surfaces.last())? as usize];
        (surface.point(sample_polygon(&surface.outline, a, b)) - x).try_normalize()
    }

    /// Density of [`Self::sample`] in a direction, per steradian: every pane that the direction meets adds to it.
    pub(super) fn density(&self, surfaces: &Surfaces, x: DVec3, direction: DVec3) -> f64 {
        self.surfaces
            .iter()
            .filter_map(|s| {
                let surface = &surfaces.list[*s as usize];
                let slope = surface.normal.dot(direction);
                let distance = -surface.height(x) / slope;
                if !(distance > 0.0 && distance.is_finite()) {
                    return None;
                }
                let uv = surface.uv(x + direction * distance);
                let outline = &surface.outline;
                let inside = (0..outline.len()).all(|k| {
                    let (p, q) = (outline[k], outline[(k + 1) % outline.len()]);
                    (q - p).perp_dot(uv - p) >= 0.0
                });
                inside.then(|| distance * distance / (slope.abs() * self.area))
            })
            .sum()
    }
}

/// Daylight by one ray through a pane: the group and its irradiance per unit, less what `tint` tells, weighted against
/// [`chance_weight`].
pub fn through_panes(
    world: &World,
    speculars: &Speculars,
    (x, normal): (DVec3, DVec3),
    place: (f64, f64, f64),
    tint: &mut Tint,
    rays: &mut u64,
) -> Option<(usize, f64)> {
    let direction = world.portals().sample(&world.surfaces, x, place)?;
    let cosine = normal.dot(direction);
    let (group, light) = world.background(direction).filter(|_| cosine > 0.0)?;
    let is_seen = pass_out(world, speculars, x, direction, tint, rays);
    let chance = cosine * std::f64::consts::FRAC_1_PI;
    let density = world.portals().density(&world.surfaces, x, direction) + chance;
    is_seen.then(|| (group, light * chance / density))
}

/// Weight of daylight that a cosine-distributed ray met by chance, not by a mirror.
#[must_use]
pub fn chance_weight(world: &World, (x, normal): (DVec3, DVec3), direction: DVec3) -> f64 {
    let chance = normal.dot(direction).max(0.0) * std::f64::consts::FRAC_1_PI;
    if chance <= 0.0 {
        return 0.0;
    }
    chance / (chance + world.portals().density(&world.surfaces, x, direction))
}
