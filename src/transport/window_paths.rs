//! Windows with a BSDF for path tracing: one ray through the window tells of sky and ground, one to the sun of the sun.
//!
//! It shares the BSDF with [`super::Panels`] and nothing else: no cells, no sums over patches, no clipping.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::caster::{MISS, Ray};
use super::chain::Tint;
use super::daylight::{SUN, pass_out};
use super::specular::Speculars;
use super::sunlight::sun_direction;
use super::world::World;
use crate::light::sun::disc;

/// A place on a side of a window with a BSDF.
#[derive(Clone, Copy, Debug)]
pub struct WindowSight {
    surface: u32,
    front: bool,
    point: DVec3,
}

/// Ways to look for windows with a BSDF from a point, weighted against each other by the balance heuristic (Veach and
/// Guibas 1995): a place on the windows, chosen evenly, and a ray that chance sends there.
#[derive(Clone, Copy, Debug)]
pub struct WindowLook {
    /// Where to.
    pub direction: DVec3,
    /// What irradiance per π times the radiance that is found there counts for.
    pub weight: f64,
}

impl WindowLook {
    /// To a place chosen by three random numbers.
    #[must_use]
    pub fn chosen(world: &World, (x, normal): (DVec3, DVec3), place: (f64, f64, f64)) -> Option<Self> {
        let direction = world.bsdf_portals().sample(&world.surfaces, x, place)?;
        let chance = normal.dot(direction) * FRAC_1_PI;
        let density = chance + world.bsdf_portals().density(&world.surfaces, x, direction);
        (chance > 0.0).then(|| Self { direction, weight: chance / density })
    }

    /// Along a ray that is distributed as the cosine.
    #[must_use]
    pub fn by_chance(world: &World, (x, normal): (DVec3, DVec3), direction: DVec3) -> Self {
        let chance = normal.dot(direction).max(f64::MIN_POSITIVE) * FRAC_1_PI;
        Self { direction, weight: chance / (chance + world.bsdf_portals().density(&world.surfaces, x, direction)) }
    }
}

/// The window with a BSDF that a ray meets first behind clear panes, whose tint is taken.
pub fn window_along(
    world: &World,
    speculars: &Speculars,
    x: DVec3,
    direction: DVec3,
    tint: &mut Tint,
    rays: &mut u64,
) -> Option<WindowSight> {
    let mut start = x;
    for _ in 0..16 {
        let ray = Ray::new(start, direction);
        let hit = world.caster.closest(&ray);
        *rays += 1;
        if hit.surface == MISS {
            return None;
        }
        let surface = &world.surfaces.list[hit.surface as usize];
        let cosine = surface.normal.dot(direction);
        if world.scatterer(hit.surface).is_some() {
            return Some(WindowSight { surface: hit.surface, front: cosine < 0.0, point: ray.at(hit.t) });
        }
        tint.pass(speculars.pane(world, hit.surface)?, cosine.abs(), 1.0);
        start = ray.at(hit.t) + direction * world.skin();
    }
    None
}

impl WindowSight {
    /// Tells `add` the light that the window sends against `look`: group of daylight, π times its radiance per unit of the
    /// group, and what panes leave of it. An unbiased estimate where the three numbers are random.
    pub fn shine(
        &self,
        (world, speculars): (&World, &Speculars),
        look: DVec3,
        (chance, a, b): (f64, f64, f64),
        before: &Tint,
        rays: &mut u64,
        mut add: impl FnMut(usize, f64, &Tint),
    ) {
        let (Some(scatterer), Some(light)) = (world.scatterer(self.surface), world.daylight()) else { return };
        let Some(first) = world.daylight_group() else { return };
        let surface = &world.surfaces.list[self.surface as usize];
        let beyond = surface.side_normal(!self.front);
        let start = world.lift(self.point, beyond);
        let passed = scatterer.passed(surface, self.front, -look);
        let on = scatterer.read_on(surface, self.front, look, chance);
        let mut tint = before.clone();
        if passed > 0.0
            && let Some((group, seen)) = world.background(on)
            && pass_out(world, speculars, start, on, &mut tint, rays)
        {
            add(group, passed * seen, &tint);
        }
        let Some(sun) = light.sun else { return };
        let towards = sun_direction(&disc(sun), a, b);
        let cosine = beyond.dot(towards);
        if cosine <= 0.0 || towards.z <= 0.0 {
            return;
        }
        let value = scatterer.value(surface, self.front, -look, -towards);
        tint = before.clone();
        if value > 0.0 && pass_out(world, speculars, start, towards, &mut tint, rays) {
            add(first + SUN, PI * value * cosine, &tint);
        }
    }

    /// Share of light that arrives along `travel` that does not pass, over its mean.
    #[must_use]
    pub fn keeps(world: &World, (surface, front): (u32, bool), travel: DVec3) -> f64 {
        world.scatterer(surface).map_or(1.0, |s| s.keeps(&world.surfaces.list[surface as usize], front, travel))
    }
}
