//! The scene as the rays see it.

use glam::DVec3;

use super::caster::Caster;
use super::glass::Pane;
use crate::light::Emitters;
use crate::mesh::Surfaces;
use crate::scene::{MaterialKind, Scene};
use crate::spectrum::SpectralValue;

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
    kinds: Vec<Kind>,
    panes: Vec<Option<Pane>>,
    groups: Vec<[Option<u32>; 2]>,
    has_specular: bool,
    has_glass: bool,
}

/// Distance, in units of the scene's size, by which a ray's start is lifted off its surface.
const SKIN: f64 = 4e-6;

impl World {
    /// Prepares a scene for rays.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let surfaces = Surfaces::new(scene);
        let emitters = Emitters::new(scene, &surfaces);
        let mut groups = vec![[None; 2]; surfaces.list.len()];
        for e in &emitters.list {
            groups[e.surface][usize::from(e.front)] = Some(e.group as u32);
        }
        let kinds = scene.materials.iter().map(|m| match m.kind {
            MaterialKind::Diffuse { .. } => Kind::Diffuse,
            MaterialKind::Mirror { .. } => Kind::Mirror,
            MaterialKind::Glass { .. } => Kind::Glass,
        });
        let panes = scene.materials.iter().map(|m| match m.kind {
            MaterialKind::Glass { transmittance: SpectralValue::Grey(t), refractive_index } => {
                Some(Pane::new(t, refractive_index))
            }
            _ => None,
        });
        let kinds: Vec<Kind> = kinds.collect();
        let any = |wanted: &dyn Fn(Kind) -> bool| surfaces.list.iter().any(|s| wanted(kinds[s.material]));
        Self {
            has_specular: any(&|k| k != Kind::Diffuse),
            has_glass: any(&|k| k == Kind::Glass),
            caster: Caster::new(&surfaces),
            kinds,
            panes: panes.collect(),
            groups,
            surfaces,
            emitters,
        }
    }

    /// What a ray does at a surface.
    #[must_use]
    #[inline]
    pub fn kind(&self, surface: u32) -> Kind {
        self.kinds[self.surfaces.list[surface as usize].material]
    }

    /// Any mirror or glass in the scene?
    #[must_use]
    pub fn has_specular(&self) -> bool {
        self.has_specular
    }

    /// Any glass in the scene?
    #[must_use]
    pub fn has_glass(&self) -> bool {
        self.has_glass
    }

    /// The pane of a surface of grey glass: shadow rays go through it.
    #[must_use]
    pub fn pane(&self, surface: u32) -> Option<&Pane> {
        self.panes[self.surfaces.list[surface as usize].material].as_ref()
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

/// A direction about `normal`, distributed as the cosine, from a point of the unit square.
///
/// The square goes to the disc by the area-preserving map of Shirley and Chiu 1997, the disc to the hemisphere by
/// Malley's method.
#[must_use]
#[inline]
pub fn cosine_direction(normal: DVec3, x: f64, y: f64) -> DVec3 {
    let (a, b) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    let (r, phi) = if a.abs() > b.abs() {
        (a, std::f64::consts::FRAC_PI_4 * (b / a))
    } else if b != 0.0 {
        (b, std::f64::consts::FRAC_PI_2 - std::f64::consts::FRAC_PI_4 * (a / b))
    } else {
        (0.0, 0.0)
    };
    let (sine, cosine) = phi.sin_cos();
    let (u, v) = normal.any_orthonormal_pair();
    u * (r * cosine) + v * (r * sine) + normal * (1.0 - r * r).max(0.0).sqrt()
}
