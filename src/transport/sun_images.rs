//! The sun in plane mirrors and panes: what one reflection throws onto a point.
//!
//! A plane mirror shows one virtual sun, in a direction that is the same for every point; a point is lit where its ray to
//! that sun goes through the mirror's polygon and on to the true one. Gather rays and paths never meet the sun's disc by
//! chance, so nothing counts twice. Light of two reflections and more is left out ([`SunImages::bound`]).

use glam::DVec3;

use super::caster::{MISS, Ray};
use super::chain::Tint;
use super::daylight::pass;
use super::points::Points;
use super::specular::{Specular, Speculars};
use super::sunlight::sun_direction;
use super::world::{Kind, World};
use crate::light::sun::{self, DIAMETER_DEG};
use crate::mesh::{Surface, Surfaces};

/// Rays over the disc: a first look, and all of them where that look sees an edge.
const FEW_RAYS: u32 = 8;
const MANY_RAYS: u32 = 64;
/// Panes before a mirror.
const MAX_PANES: usize = 16;

/// The sun in one mirror or pane.
#[derive(Clone, Copy, Debug)]
struct Image {
    surface: u32,
    /// The side that the sun shines on.
    front: bool,
    /// Direction from any point to the image.
    towards: DVec3,
}

/// All images of the sun by one reflection.
#[derive(Clone, Debug, Default)]
pub struct SunImages {
    list: Vec<Image>,
    disc: Vec<DVec3>,
}

impl SunImages {
    /// Images of a sun in a direction, in the surfaces of materials that are not diffuse.
    pub(super) fn new(surfaces: &Surfaces, kinds: &[Kind], sun: DVec3) -> Self {
        let image = |(k, s): (usize, &Surface)| {
            let cosine = s.normal.dot(sun);
            let towards = sun - s.normal * (2.0 * cosine);
            (kinds[s.material] != Kind::Diffuse && cosine != 0.0).then_some(Image {
                surface: k as u32,
                front: cosine > 0.0,
                towards,
            })
        };
        Self { list: surfaces.list.iter().enumerate().filter_map(image).collect(), disc: sun::disc(sun).to_vec() }
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// None?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Calls `found` with irradiance per unit of the sun's face on, less what the tint tells, and the panes on the way, for
    /// rays that reach the sun by an image; they sum to the mean over the disc. Returns the rays cast.
    pub(super) fn light(
        &self,
        scene: (&World, &Speculars),
        at: (DVec3, DVec3),
        stream: u64,
        (tint, panes): (&mut Tint, &mut Vec<u32>),
        mut found: impl FnMut(f64, &Tint, &[u32]),
    ) -> u64 {
        let mut rays = 0;
        for k in (0..self.list.len()).filter(|k| self.may_light(scene.0, *k, at)) {
            let points = Points::new(stream ^ ((k as u64 + 1) << 32));
            let lit: Vec<u32> = (0..FEW_RAYS)
                .filter(|i| self.by_ray(scene, k, at, points.pair(*i, 0), (tint, panes), &mut rays).is_some())
                .collect();
            let count = match lit.len() as u32 {
                0 => continue,
                FEW_RAYS => FEW_RAYS,
                _ => MANY_RAYS,
            };
            for i in 0..count {
                if let Some(cosine) = self.by_ray(scene, k, at, points.pair(i, 0), (tint, panes), &mut rays) {
                    found(cosine / f64::from(count), tint, panes);
                }
            }
        }
        rays
    }

    /// Does the ray from a point to the middle of an image go through the mirror, or near its edge?
    #[must_use]
    fn may_light(&self, world: &World, image: usize, (x, normal): (DVec3, DVec3)) -> bool {
        let Image { surface, front, towards } = self.list[image];
        let radius = (0.5 * DIAMETER_DEG).to_radians();
        if normal.dot(towards) <= -radius.sin() {
            return false;
        }
        let s = &world.surfaces.list[surface as usize];
        let height = if front { s.height(x) } else { -s.height(x) };
        let slope = s.normal.dot(towards).abs();
        // The edge of the disc may reach the mirror where its middle does not.
        if height <= 0.0 || slope <= radius {
            return height > 0.0;
        }
        let distance = height / slope;
        let margin = 2.0 * distance * radius / slope;
        let uv = s.uv(x + towards * distance);
        let n = s.outline.len();
        (0..n).all(|k| {
            let (p, q) = (s.outline[k], s.outline[(k + 1) % n]);
            (q - p).perp_dot(uv - p) >= -margin * (q - p).length()
        })
    }

    /// The cosine at the point of a ray to a place of the disc by an image, if it gets there; the tint tells what mirror and
    /// panes leave, and these panes are listed.
    fn by_ray(
        &self,
        (world, speculars): (&World, &Speculars),
        image: usize,
        (x, normal): (DVec3, DVec3),
        (a, b): (f64, f64),
        (tint, panes): (&mut Tint, &mut Vec<u32>),
        rays: &mut u64,
    ) -> Option<f64> {
        let Image { surface, front, .. } = self.list[image];
        let mirror = &world.surfaces.list[surface as usize];
        let sun = sun_direction(&self.disc, a, b);
        let direction = sun - mirror.normal * (2.0 * mirror.normal.dot(sun));
        let cosine = normal.dot(direction);
        if cosine <= 0.0 || sun.z <= 0.0 {
            return None;
        }
        tint.reset();
        panes.clear();
        let mut start = x;
        for _ in 0..MAX_PANES {
            let ray = Ray::new(start, direction);
            let hit = world.caster.closest(&ray);
            *rays += 1;
            if hit.surface == MISS {
                return None;
            }
            let incidence = world.surfaces.list[hit.surface as usize].normal.dot(direction);
            if hit.surface == surface {
                if (incidence < 0.0) != front {
                    return None;
                }
                tint.reflect(speculars.of(world, surface), (incidence.abs(), front), 1.0);
                let point = world.lift(ray.at(hit.t), mirror.side_normal(front));
                let each = |pane| panes.push(pane);
                let is_lit = tint.scale > 0.0 && pass(world, speculars, (point, sun), MISS, tint, rays, each);
                return is_lit.then_some(cosine);
            }
            tint.pass(speculars.pane(world, hit.surface)?, incidence.abs(), 1.0);
            panes.push(hit.surface);
            start = ray.at(hit.t) + direction * world.skin();
        }
        None
    }

    /// The same for one ray to each image, as paths want it.
    pub fn by_paths(
        &self,
        scene: (&World, &Speculars),
        at: (DVec3, DVec3),
        place: (f64, f64),
        tint: &mut Tint,
        rays: &mut u64,
        mut found: impl FnMut(f64, &Tint),
    ) {
        let mut panes = Vec::new();
        for k in (0..self.list.len()).filter(|k| self.may_light(scene.0, *k, at)) {
            if let Some(cosine) = self.by_ray(scene, k, at, place, (tint, &mut panes), rays) {
                found(cosine, tint);
            }
        }
    }

    /// Most that an image of two reflections leaves of the sun's light; nothing where no mirror can see another's image.
    /// Further reflections leave less.
    #[must_use]
    pub fn bound(&self, world: &World, speculars: &Speculars) -> Option<f64> {
        let surface = |image: &Image| &world.surfaces.list[image.surface as usize];
        let is_before =
            |a: &Surface, side: DVec3, b: &Surface| b.vertices.iter().any(|v| (*v - a.vertices[0]).dot(side) > 1e-6);
        let second = |first: &Image| {
            let from = surface(first);
            let side = from.side_normal(first.front);
            let own = most_reflected(speculars.of(world, first.surface), side.dot(first.towards).abs(), first.front);
            self.list
                .iter()
                .filter_map(|next| {
                    let to = surface(next);
                    // The light goes along −towards.
                    let incidence = to.normal.dot(first.towards);
                    let front = incidence > 0.0;
                    let lies_so = is_before(from, side, to) && is_before(to, to.side_normal(front), from);
                    let share = own * most_reflected(speculars.of(world, next.surface), incidence.abs(), front);
                    (lies_so && share > 0.0).then_some(share)
                })
                .max_by(f64::total_cmp)
        };
        self.list.iter().filter_map(second).max_by(f64::total_cmp)
    }
}

/// Largest reflectance in any band.
pub(super) fn most_reflected(specular: &Specular, cosine: f64, front: bool) -> f64 {
    match specular {
        Specular::None => 0.0,
        Specular::Mirror(rho) => f64::from(*rho),
        Specular::ColouredMirror(rho) => f64::from(rho.iter().copied().fold(0.0, f32::max)),
        Specular::Glass(glazing) => {
            (0..glazing.bands()).map(|b| glazing.in_band(cosine, b).reflected[usize::from(front)]).fold(0.0, f64::max)
        }
    }
}
