//! Direct light of the sun at a point: a disc that is clipped like the sky, so that penumbras are exact.

use glam::DVec3;

use super::caster::MISS;
use super::chain::Tint;
use super::daylight::{Eye, MAX_BLOCKERS, SUN, SkyScratch, deposit, pass, with_eye};
use super::points::{Points, seed};
use super::sun_images::SunImages;
use super::visible::cone_planes;
use super::world::World;
use crate::light::{above_plane, configuration_factor, sun};

/// Rays over the disc where too much stands before it.
const SUN_RAYS: u32 = 64;

/// Adds the factors of the sun's disc about `direction`, wherever the sun of the world stands, to those of daylight: see
/// [`deposit`]. [`super::DirectScratch::panes`] then tells the panes that it comes through. Returns rays that chance chose.
pub fn sun_factor(
    world: &World,
    (x, normal): (DVec3, DVec3),
    direction: DVec3,
    sample: u64,
    scratch: &mut super::DirectScratch,
    out: &mut [f64],
) -> u64 {
    with_eye(world, (x, normal), sample, &mut scratch.sky, |eye, s| eye.sun_at(direction, s, out))
}

/// Tells `found` the sun's light by its images in mirrors and panes, wherever the sun of the world stands: irradiance per unit
/// of the sun's face on, less what the tint tells, and the panes on the way. Returns rays that chance chose.
pub fn mirrored_sun(
    world: &World,
    (x, normal): (DVec3, DVec3),
    images: &SunImages,
    sample: u64,
    scratch: &mut super::DirectScratch,
    found: impl FnMut(f64, &Tint, &[u32]),
) -> u64 {
    with_eye(world, (x, normal), sample, &mut scratch.sky, |eye, s| eye.images(images, s, found))
}

impl Eye<'_> {
    /// The sun of the world. Returns rays that chance chose.
    pub(super) fn sun(&self, s: &mut SkyScratch, out: &mut [f64]) -> u64 {
        self.world.daylight().and_then(|d| d.sun).map_or(0, |direction| self.sun_at(direction, s, out))
    }

    fn sun_at(&self, direction: DVec3, s: &mut SkyScratch, out: &mut [f64]) -> u64 {
        s.through.clear();
        let disc = sun::disc(direction);
        let face_on = configuration_factor(&disc, direction);
        let mut above = Vec::with_capacity(16);
        let mut polygon = Vec::with_capacity(16);
        above_plane(&disc, self.normal, 0.0, &mut above);
        above_plane(&above, DVec3::Z, 0.0, &mut polygon);
        if polygon.len() < 3 {
            return 0;
        }
        cone_planes(&polygon, &mut s.planes);
        let ceiling = (self.normal, self.normal.dot(self.x));
        let few = self.world.caster.in_cone(self.x, &s.planes, ceiling, MAX_BLOCKERS, &mut s.blockers);
        if few && s.visible.clip(self.world, self.x, (self.normal, 0.0), &polygon, s.blockers.iter().copied()) {
            for piece in s.visible.pieces.iter().filter(|p| !self.is_shut(p)) {
                let factor = configuration_factor(&piece.polygon, self.normal) / face_on;
                self.enter(piece.panes(), direction, (SUN, factor), &mut s.tint, out);
                s.through.extend_from_slice(piece.panes());
            }
            return 0;
        }
        let points = Points::new(seed(&[self.sample, 99]));
        let mut rays = 0;
        let whole = configuration_factor(&polygon, self.normal) / face_on;
        for k in 0..SUN_RAYS {
            let (a, b) = points.pair(k, 0);
            s.tint.reset();
            let towards = sun_direction(&disc, a, b);
            let each = |pane| s.through.push(pane);
            if pass(self.world, self.speculars, (self.x, towards), MISS, &mut s.tint, &mut rays, each) {
                deposit(out, SUN, whole / f64::from(SUN_RAYS), &s.tint);
            }
        }
        rays
    }

    /// The sun of the world by its images.
    pub(super) fn mirrored_sun(&self, s: &mut SkyScratch, out: &mut [f64]) -> u64 {
        self.images(self.world.sun_images(), s, |cosine, tint, _| deposit(out, SUN, cosine, tint))
    }

    fn images(&self, images: &SunImages, s: &mut SkyScratch, found: impl FnMut(f64, &Tint, &[u32])) -> u64 {
        let (scene, at) = ((self.world, self.speculars), (self.x, self.normal));
        images.light(scene, at, seed(&[self.sample, 98]), (&mut s.tint, &mut s.through), found)
    }
}

/// A direction to the sun's disc from a point of the unit square.
#[must_use]
pub fn sun_direction(disc: &[DVec3], a: f64, b: f64) -> DVec3 {
    let centre = disc.iter().sum::<DVec3>() / disc.len() as f64;
    let place = a * disc.len() as f64;
    let k = (place as usize).min(disc.len() - 1);
    let (p, q) = (disc[k] - centre, disc[(k + 1) % disc.len()] - centre);
    let across = place - k as f64;
    (centre + (p * (1.0 - across) + q * across) * b.sqrt()).normalize()
}
