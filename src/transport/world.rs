//! The scene as the rays see it.

use std::sync::Arc;

use glam::DVec3;

use super::caster::{Caster, MISS, Ray};
use super::daylight::{DAYLIGHT_GROUPS, GROUND, SKY};
use super::lamps::Lamps;
use super::panels::Panels;
use super::points::Points;
use super::portals::Portals;
use super::scatterer::Scatterer;
use super::specular::Speculars;
use super::sun_images::SunImages;
use crate::light::sun::DIAMETER_DEG;
use crate::light::{Daylight, Emitters, Luminaires};
use crate::mesh::{Surfaces, sample_polygon};
use crate::scene::{MaterialKind, Scene};

/// What a ray does at a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It ends.
    Diffuse,
    /// It is reflected.
    Mirror,
    /// It is reflected or goes on.
    Glass,
}

/// Geometry, ray caster and emitters: everything that does not depend on the band.
#[derive(Clone, Debug)]
pub struct World {
    /// Polygons in the program's frame.
    pub surfaces: Surfaces,
    /// Closest hits.
    pub caster: Caster,
    /// What emits.
    pub emitters: Emitters,
    lamps: Lamps,
    kinds: Vec<Kind>,
    greys: Speculars,
    groups: Vec<[Option<u32>; 2]>,
    has_specular: bool,
    has_glass: bool,
    translucent: Vec<bool>,
    /// By material.
    scatterers: Vec<Option<Arc<Scatterer>>>,
    has_bsdf: bool,
    panels: Panels,
    bsdf_portals: Portals,
    glowing: bool,
    outside: Vec<bool>,
    daylight: Option<Daylight>,
    portals: Portals,
    sun_images: SunImages,
}

/// Distance, in units of the scene's size, by which a ray's start is lifted off its surface.
const SKIN: f64 = 4e-6;

/// Emitters, and rays from each, that tell whether a scene glows.
const GLOW_EMITTERS: usize = 256;
const GLOW_RAYS: u32 = 32;

impl World {
    /// Prepares a scene for rays, without daylight.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        Self::with_daylight(scene, None)
    }

    /// Prepares a scene for rays, with sky, sun and ground around it.
    #[must_use]
    pub fn with_daylight(scene: &Scene, daylight: Option<Daylight>) -> Self {
        let surfaces = Surfaces::new(scene);
        let emitters = Emitters::new(scene, &surfaces);
        let mut groups = vec![[None; 2]; surfaces.list.len()];
        for e in &emitters.list {
            groups[e.surface][usize::from(e.front)] = Some(e.group as u32);
        }
        let kinds = scene.materials.iter().map(|m| match m.kind {
            MaterialKind::Diffuse { .. } | MaterialKind::Translucent { .. } | MaterialKind::Bsdf { .. } => {
                Kind::Diffuse
            }
            MaterialKind::Mirror { .. } => Kind::Mirror,
            MaterialKind::Glass { .. } => Kind::Glass,
        });
        let kinds: Vec<Kind> = kinds.collect();
        let scatterers: Vec<Option<Arc<Scatterer>>> = scene.materials.iter().map(|m| scatterer(&m.kind)).collect();
        let any = |wanted: &dyn Fn(Kind) -> bool| surfaces.list.iter().any(|s| wanted(kinds[s.material]));
        let sun = daylight.as_ref().and_then(|d| d.sun);
        let mut world = Self {
            glowing: false,
            portals: Portals::new(&surfaces, |material| kinds[material] == Kind::Glass),
            has_specular: any(&|k| k != Kind::Diffuse),
            has_glass: any(&|k| k == Kind::Glass),
            caster: Caster::new(&surfaces),
            translucent: scene.materials.iter().map(|m| m.kind.is_translucent()).collect(),
            has_bsdf: surfaces.list.iter().any(|s| scatterers[s.material].is_some()),
            bsdf_portals: Portals::new(&surfaces, |material| scatterers[material].is_some()),
            scatterers,
            panels: Panels::default(),
            sun_images: sun.map_or_else(SunImages::default, |sun| SunImages::new(&surfaces, &kinds, sun)),
            kinds,
            greys: Speculars::grey(scene),
            groups,
            surfaces,
            lamps: Lamps::new(&emitters.list),
            emitters,
            outside: scene.materials.iter().map(|m| m.outside).collect(),
            daylight,
        };
        world.glowing = world.daylight.is_none() && world.emitters_see_emitters() > 0.5;
        world
    }

    /// The same with luminaires, which are no geometry.
    #[must_use]
    pub fn hang(mut self, luminaires: Luminaires) -> Self {
        self.emitters.hang(luminaires, &self.surfaces.frame);
        self.glowing &= self.emitters.luminaires.is_empty();
        self
    }

    /// The same with the light that windows with a BSDF take from sky, ground and sun, as finely as a tolerance wants.
    #[must_use]
    pub fn glaze(mut self, tolerance: f64, seed: u64) -> Self {
        if self.has_bsdf && self.daylight.is_some() {
            self.panels = Panels::new(&self, tolerance, seed);
        }
        self
    }

    /// Share of the emitters' light that lands on emitters first.
    fn emitters_see_emitters(&self) -> f64 {
        let (mut landed, mut sent) = (0.0, 0.0);
        let points = Points::new(0);
        for e in self.emitters.list.iter().take(GLOW_EMITTERS) {
            let surface = &self.surfaces.list[e.surface];
            for k in 0..GLOW_RAYS {
                let ((a, b), (c, d)) = (points.pair(k, 0), points.pair(k, 2));
                let start = self.lift(surface.point(sample_polygon(&surface.outline, a, b)), e.normal);
                let direction = cosine_direction(e.normal, c, d);
                let hit = self.caster.closest(&Ray::new(start, direction));
                sent += e.area;
                if hit.surface != MISS {
                    let front = self.surfaces.list[hit.surface as usize].normal.dot(direction) < 0.0;
                    landed += if self.group(hit.surface, front).is_some() { e.area } else { 0.0 };
                }
            }
        }
        if sent > 0.0 { landed / sent } else { 0.0 }
    }

    /// Number of groups of light: those of the emitters, then those of daylight.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.emitters.groups() + if self.daylight.is_some() { DAYLIGHT_GROUPS } else { 0 }
    }

    /// The first group of daylight.
    #[must_use]
    pub fn daylight_group(&self) -> Option<usize> {
        self.daylight.as_ref().map(|_| self.emitters.groups())
    }

    /// Sky, sun and ground.
    #[must_use]
    pub fn daylight(&self) -> Option<&Daylight> {
        self.daylight.as_ref()
    }

    /// The sun in mirrors and panes.
    #[must_use]
    pub fn sun_images(&self) -> &SunImages {
        &self.sun_images
    }

    /// A sun in a direction in mirrors and panes.
    #[must_use]
    pub fn images_of(&self, sun: DVec3) -> SunImages {
        SunImages::new(&self.surfaces, &self.kinds, sun)
    }

    /// Emitting sides, where they are many.
    pub(super) fn lamps(&self) -> &Lamps {
        &self.lamps
    }

    /// Panes, as guides to the sky.
    pub(super) fn portals(&self) -> &Portals {
        &self.portals
    }

    /// What a ray sees that leaves the scene: the group, and π times its radiance per unit of the group.
    #[must_use]
    pub fn background(&self, direction: DVec3) -> Option<(usize, f64)> {
        let (daylight, first) = (self.daylight.as_ref()?, self.daylight_group()?);
        if direction.z < 0.0 {
            return Some((first + GROUND, 1.0));
        }
        daylight.sky.map(|sky| (first + SKY, std::f64::consts::PI * sky.luminance(direction)))
    }

    /// π times the radiance of the sun per unit of its irradiance face on, where a direction meets its disc.
    #[must_use]
    pub fn sun_disc(&self, direction: DVec3) -> Option<f64> {
        let sun = self.daylight.as_ref()?.sun?;
        let radius = (0.5 * DIAMETER_DEG).to_radians();
        (direction.z > 0.0 && direction.dot(sun) > radius.cos()).then(|| 1.0 / radius.sin().powi(2))
    }

    /// Does light that a surface reflects last come from outside?
    #[must_use]
    pub fn is_outside(&self, surface: u32) -> bool {
        self.outside[self.surfaces.list[surface as usize].material]
    }

    /// What a ray does at a surface.
    #[must_use]
    #[inline]
    pub fn kind(&self, surface: u32) -> Kind {
        self.kinds[self.surfaces.list[surface as usize].material]
    }

    /// Does light that arrives on one side of a surface leave the other diffusely?
    #[must_use]
    #[inline]
    pub fn is_translucent(&self, surface: u32) -> bool {
        self.translucent[self.surfaces.list[surface as usize].material]
    }

    /// The BSDF of a surface, if it is a window element with one.
    #[must_use]
    #[inline]
    pub fn scatterer(&self, surface: u32) -> Option<&Scatterer> {
        if self.has_bsdf { self.scatterer_of(self.surfaces.list[surface as usize].material) } else { None }
    }

    /// The BSDF of a material.
    pub(super) fn scatterer_of(&self, material: usize) -> Option<&Scatterer> {
        self.scatterers[material].as_deref()
    }

    /// Any window element with a BSDF in the scene?
    #[must_use]
    pub fn has_bsdf(&self) -> bool {
        self.has_bsdf
    }

    /// What such windows send on of sky, ground and sun.
    #[must_use]
    pub fn panels(&self) -> &Panels {
        &self.panels
    }

    /// Such windows, as guides to the sky.
    pub(super) fn bsdf_portals(&self) -> &Portals {
        &self.bsdf_portals
    }

    /// Any translucent surface in the scene?
    #[must_use]
    pub fn has_translucent(&self) -> bool {
        self.surfaces.list.iter().any(|s| self.translucent[s.material])
    }

    /// Any mirror or glass in the scene?
    #[must_use]
    pub fn has_specular(&self) -> bool {
        self.has_specular
    }

    /// Does most of what emitters send land on emitters, as in a furnace?
    ///
    /// Then emission is carried by rows and gather rays together with reflected light: what every ray meets is nearly
    /// the same, and splitting it into an exact and a sampled part would make noise where there is none.
    #[must_use]
    #[inline]
    pub fn glowing(&self) -> bool {
        self.glowing
    }

    /// Any glass in the scene?
    #[must_use]
    pub fn has_glass(&self) -> bool {
        self.has_glass
    }

    /// Mirrors and panes that are the same in all bands: shadow rays to lamps go through these panes.
    #[must_use]
    pub fn greys(&self) -> &Speculars {
        &self.greys
    }

    /// The group of emitters that a side of a surface belongs to.
    #[must_use]
    #[inline]
    pub fn group(&self, surface: u32, front: bool) -> Option<usize> {
        self.groups[surface as usize][usize::from(front)].map(|g| g as usize)
    }

    /// Distance by which a ray's start is lifted off its surface.
    #[must_use]
    pub fn skin(&self) -> f64 {
        SKIN
    }

    /// A point just above a side of a surface.
    #[must_use]
    pub fn lift(&self, p: DVec3, side_normal: DVec3) -> DVec3 {
        p + side_normal * SKIN
    }
}

/// The BSDF of a material with its dirt.
fn scatterer(kind: &MaterialKind) -> Option<Arc<Scatterer>> {
    let MaterialKind::Bsdf { bsdf, up, maintenance_factor } = kind else { return None };
    Some(Arc::new(Scatterer::new(&bsdf.as_ref().clone().dimmed(*maintenance_factor), *up)))
}

/// A direction about `normal`, distributed as the cosine, from a point of the unit square.
///
/// The square goes to the disc by the area-preserving map of Shirley and Chiu 1997, the disc to the hemisphere by
/// Malley's method.
#[must_use]
#[inline]
pub fn cosine_direction(normal: DVec3, x: f64, y: f64) -> DVec3 {
    let (a, b) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    let (r, sine, cosine) = if a.abs() > b.abs() {
        let (sine, cosine) = sin_cos(std::f64::consts::FRAC_PI_4 * (b / a));
        (a, sine, cosine)
    } else if b != 0.0 {
        let (sine, cosine) = sin_cos(std::f64::consts::FRAC_PI_4 * (a / b));
        (b, cosine, sine)
    } else {
        (0.0, 0.0, 1.0)
    };
    let (u, v) = normal.any_orthonormal_pair();
    u * (r * cosine) + v * (r * sine) + normal * (1.0 - r * r).max(0.0).sqrt()
}

/// Sine and cosine for `|x| ≤ π/4`, to 4e-10: Taylor's series, the same bits on every machine.
#[inline]
fn sin_cos(x: f64) -> (f64, f64) {
    let q = x * x;
    let sine = x * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0))));
    let cosine = 1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0 * (1.0 - q / 90.0))));
    (sine, cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_hold_on_their_octant() {
        for k in -100..=100 {
            let x = f64::from(k) / 100.0 * std::f64::consts::FRAC_PI_4;
            let (sine, cosine) = sin_cos(x);
            // First terms left out: x^11/11! and x^12/12! at π/4.
            assert!((sine - x.sin()).abs() < 2e-9 && (cosine - x.cos()).abs() < 2e-10, "{x}");
        }
    }

    #[test]
    fn directions_are_distributed_as_the_cosine() {
        // Mean cosine of a cosine-distributed direction is 2/3, its square 1/2. The cosine falls as a root at the horizon,
        // so the midpoint rule errs by the order n^-3/2: 7e-4 at 128.
        let (mut first, mut second) = (0.0, 0.0);
        for i in 0..128 {
            for j in 0..128 {
                let d = cosine_direction(DVec3::Z, (f64::from(i) + 0.5) / 128.0, (f64::from(j) + 0.5) / 128.0);
                assert!((d.length() - 1.0).abs() < 1e-8);
                first += d.z / 16_384.0;
                second += d.z * d.z / 16_384.0;
            }
        }
        assert!((first - 2.0 / 3.0).abs() < 1e-3 && (second - 0.5).abs() < 1e-3, "{first} {second}");
    }
}
