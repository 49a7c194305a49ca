//! The ray chain: through mirrors and panes to the diffuse surface where light is looked up.
//!
//! This is what makes the form factors "extended" (Rushmeier and Torrance 1990) and the final gather the second pass
//! of a two-pass method (Wallace, Cohen and Greenberg 1987).

use glam::DVec3;

use super::caster::{Hit, MISS, Ray};
use super::optics::Optics;
use super::scatterer::Scatterer;
use super::specular::Specular;
use super::world::{Kind, World};
use crate::mesh::Surface;

/// Mirrors and panes along one chain; what is longer is counted as lost.
const MAX_LINKS: usize = 48;

/// Where a chain ended.
#[derive(Clone, Copy, Debug)]
pub enum Landing {
    /// On a diffuse surface.
    Surface {
        /// Which.
        surface: u32,
        /// Which side.
        front: bool,
        /// The point, in the program's frame.
        point: DVec3,
        /// Length of the chain.
        distance: f64,
        /// It came by a mirror or a coloured pane, so direct light does not already count emission seen here.
        mirrored: bool,
    },
    /// Out of the scene.
    Escaped {
        /// Where to.
        direction: DVec3,
        /// It came by a mirror, so direct light does not already count what is seen there.
        mirrored: bool,
    },
    /// Out of the scene by one window with a BSDF, whose light of sky, ground and sun is direct light.
    Scattered {
        /// Where to.
        direction: DVec3,
    },
    /// Inside a solid: the start of the ray is covered.
    Covered,
    /// In a mirror maze.
    Lost,
}

/// What mirrors and panes took from a ray, and what is left.
#[derive(Clone, Debug)]
pub struct Tint {
    /// Share left, the same in all bands.
    pub scale: f32,
    /// Share left by band, beside `scale`; meaningful only when `coloured`.
    pub bands: Vec<f32>,
    /// Does `bands` hold anything?
    pub coloured: bool,
    /// Panes met.
    pub panes: u32,
    /// Reflections.
    pub mirrors: u32,
    /// Windows with a BSDF passed.
    pub scatterers: u32,
}

impl Default for Tint {
    /// For light that is the same in all bands.
    fn default() -> Self {
        Self::new(0)
    }
}

impl Tint {
    /// Nothing taken.
    #[must_use]
    pub fn new(pad: usize) -> Self {
        Self { scale: 1.0, bands: vec![1.0; pad], coloured: false, panes: 0, mirrors: 0, scatterers: 0 }
    }

    /// Nothing taken, again.
    pub fn reset(&mut self) {
        if self.coloured {
            self.bands.fill(1.0);
        }
        self.scale = 1.0;
        self.coloured = false;
        self.panes = 0;
        self.mirrors = 0;
        self.scatterers = 0;
    }

    /// Share left in one band.
    #[must_use]
    #[inline]
    pub fn share(&self, band: usize) -> f32 {
        self.scale * self.bands[band]
    }

    /// Takes a share of its own from each of the bands.
    pub(super) fn take(&mut self, bands: usize, share: impl Fn(usize) -> f32) {
        self.coloured = true;
        for (band, b) in self.bands[..bands].iter_mut().enumerate() {
            *b *= share(band);
        }
    }
}

/// Which way to take at panes of glass.
#[derive(Clone, Copy, Debug)]
pub enum Fork {
    /// By chance: a number in `[0, 1)`, spread over all panes met; the tint carries the odds.
    Chance(f64),
    /// The same for light that is shot from where the ray begins, in place of light that arrives there.
    Shot(f64),
    /// Reflected at the pane of this number (counted from zero) and straight through all others; the tint carries the
    /// plain reflectance and transmittances, so that the branches 0, 1, 2 ... and "none" add up. Windows with a BSDF end it.
    Branch(u32),
}

/// Follows a ray whose first hit is known. `tint` is multiplied.
pub fn follow(
    world: &World,
    optics: &Optics,
    mut ray: Ray,
    mut hit: Hit,
    mut fork: Fork,
    tint: &mut Tint,
    rays: &mut u64,
) -> Landing {
    let mut distance = 0.0;
    // A coloured pane was passed: lamps behind it are left to chance.
    let mut coloured = false;
    for _ in 0..MAX_LINKS {
        if hit.surface == MISS {
            let direction = DVec3::from_array(ray.direction.map(f64::from));
            if tint.scatterers == 1 && tint.mirrors == 0 {
                return Landing::Scattered { direction };
            }
            return Landing::Escaped { direction, mirrored: tint.mirrors + tint.scatterers > 0 };
        }
        let surface = &world.surfaces.list[hit.surface as usize];
        let direction = DVec3::from_array(ray.direction.map(f64::from));
        let cosine = surface.normal.dot(direction);
        let front = cosine < 0.0;
        let point = ray.at(hit.t);
        distance += f64::from(hit.t);
        if world.kind(hit.surface) == Kind::Diffuse {
            if surface.solid && !front {
                return Landing::Covered;
            }
            if let Some(scatterer) = world.scatterer(hit.surface)
                && let Some(next) = fork.scatter((scatterer, surface), front, direction)
            {
                tint.scatterers += 1;
                ray = Ray::new(world.lift(point, -surface.side_normal(front)), next);
                *rays += 1;
                hit = world.caster.closest(&ray);
                continue;
            }
            let mirrored = tint.mirrors + tint.scatterers > 0 || coloured;
            return Landing::Surface { surface: hit.surface, front, point, distance, mirrored };
        }
        let normal = surface.side_normal(front);
        let specular = optics.speculars.of(world, hit.surface);
        let (reflects, odds) = match specular {
            Specular::Glass(glazing) => {
                let mean = glazing.mean(cosine.abs());
                let (t, r) = (mean.passed, mean.reflected[usize::from(front)]);
                tint.panes += 1;
                fork.choose(r / (t + r).max(1e-300), tint.panes - 1)
            }
            _ => (true, 1.0),
        };
        let (next, side) = match specular {
            Specular::Glass(glazing) if !reflects => {
                coloured |= !glazing.is_grey();
                tint.pass(glazing, cosine.abs(), odds);
                (direction, -normal)
            }
            _ => {
                tint.mirrors += 1;
                tint.reflect(specular, (cosine.abs(), front), odds);
                ((direction - surface.normal * (2.0 * cosine)).normalize(), normal)
            }
        };
        if tint.scale == 0.0 {
            return Landing::Lost;
        }
        ray = Ray::new(world.lift(point, side), next);
        *rays += 1;
        hit = world.caster.closest(&ray);
    }
    Landing::Lost
}

impl Fork {
    /// Reflected here? And the odds that the tint has to be divided by.
    fn choose(&mut self, reflect: f64, pane: u32) -> (bool, f64) {
        match self {
            Self::Branch(at) => (*at == pane, 1.0),
            Self::Chance(u) | Self::Shot(u) if *u < reflect => {
                *u /= reflect;
                (true, reflect)
            }
            Self::Chance(u) | Self::Shot(u) => {
                *u = (*u - reflect) / (1.0 - reflect);
                (false, 1.0 - reflect)
            }
        }
    }

    /// Where to a ray goes on through a window with a BSDF; `None` where it stays.
    fn scatter(
        &mut self,
        (scatterer, surface): (&Scatterer, &Surface),
        front: bool,
        direction: DVec3,
    ) -> Option<DVec3> {
        let (u, passed, is_shot) = match self {
            Self::Branch(_) => return None,
            Self::Chance(u) => (u, scatterer.passed(surface, front, -direction), false),
            Self::Shot(u) => (u, scatterer.lets_by(surface, front, direction), true),
        };
        if *u >= passed {
            *u = (*u - passed) / (1.0 - passed).max(f64::MIN_POSITIVE);
            return None;
        }
        *u /= passed;
        let on = if is_shot { Scatterer::shoot_on } else { Scatterer::read_on };
        Some(on(scatterer, surface, front, direction, *u))
    }
}
