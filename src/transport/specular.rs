//! Mirrors and panes: what they leave of a ray, band by band.

use std::sync::Arc;

use super::chain::Tint;
use super::glass::{Glazing, GlazingUnit};
use super::world::World;
use crate::scene::{MaterialKind, Scene};
use crate::spectrum::SpectralValue;

/// What a mirror or a pane does.
#[derive(Clone, Debug)]
pub enum Specular {
    /// Neither a mirror nor a pane.
    None,
    /// Reflectance, the same at every wavelength.
    Mirror(f32),
    /// Reflectance by band.
    ColouredMirror(Vec<f32>),
    /// Shares by angle and band.
    Glass(Glazing),
}

impl Specular {
    fn is_coloured(&self) -> bool {
        match self {
            Self::None | Self::Mirror(_) => false,
            Self::ColouredMirror(_) => true,
            Self::Glass(glazing) => !glazing.is_grey(),
        }
    }
}

/// Mirrors and panes by material.
#[derive(Clone, Debug)]
pub struct Speculars(Arc<[Specular]>);

impl Speculars {
    /// In the bands of a run: `values` averages over them.
    pub(super) fn in_bands(scene: &Scene, values: impl Fn(&SpectralValue) -> Vec<f64>) -> Self {
        let of = |kind| if is_grey(kind) { grey(kind) } else { specular(kind, &values, false) };
        Self(scene.materials.iter().map(|m| of(&m.kind)).collect())
    }

    /// The grey ones, which are the same in any bands; coloured ones let nothing by.
    pub(super) fn grey(scene: &Scene) -> Self {
        let of = |kind| if is_grey(kind) { grey(kind) } else { Specular::None };
        Self(scene.materials.iter().map(|m| of(&m.kind)).collect())
    }

    /// What a surface of the scene is.
    #[must_use]
    #[inline]
    pub fn of(&self, world: &World, surface: u32) -> &Specular {
        &self.0[world.surfaces.list[surface as usize].material]
    }

    /// The pane that a surface is.
    #[must_use]
    #[inline]
    pub fn pane(&self, world: &World, surface: u32) -> Option<&Glazing> {
        match self.of(world, surface) {
            Specular::Glass(glazing) => Some(glazing),
            _ => None,
        }
    }

    /// Does any take more at one wavelength than at another? Even in a single band those are never among the grey ones.
    #[must_use]
    pub fn are_coloured(&self) -> bool {
        self.0.iter().any(Specular::is_coloured)
    }
}

/// All that is specular of a material.
fn spectral_values(kind: &MaterialKind) -> Vec<&SpectralValue> {
    match kind {
        MaterialKind::Diffuse { .. } | MaterialKind::Translucent { .. } | MaterialKind::Bsdf { .. } => Vec::new(),
        MaterialKind::Mirror { reflectance } => vec![reflectance],
        MaterialKind::Glass { panes, .. } => panes.values(),
    }
}

fn is_grey(kind: &MaterialKind) -> bool {
    spectral_values(kind).iter().all(|v| v.is_grey())
}

fn grey(kind: &MaterialKind) -> Specular {
    specular(kind, &|v| vec![v.max()], true)
}

fn specular(kind: &MaterialKind, values: &impl Fn(&SpectralValue) -> Vec<f64>, is_grey: bool) -> Specular {
    match kind {
        MaterialKind::Diffuse { .. } | MaterialKind::Translucent { .. } | MaterialKind::Bsdf { .. } => Specular::None,
        MaterialKind::Mirror { reflectance } => {
            let rho: Vec<f32> = values(reflectance).iter().map(|r| *r as f32).collect();
            if is_grey { Specular::Mirror(rho[0]) } else { Specular::ColouredMirror(rho) }
        }
        MaterialKind::Glass { panes, refractive_index, maintenance_factor } => {
            let units = GlazingUnit::in_bands(panes, *refractive_index, values).into_iter();
            let units: Vec<GlazingUnit> = units.map(|u| u.in_use(*maintenance_factor)).collect();
            Specular::Glass(Glazing::new(&units, is_grey))
        }
    }
}

impl Tint {
    /// Straight through a pane, by a way that has the odds.
    pub(super) fn pass(&mut self, glazing: &Glazing, cosine: f64, odds: f64) {
        if glazing.is_grey() {
            self.scale *= (glazing.mean(cosine).passed / odds) as f32;
        } else {
            self.take(glazing.bands(), |band| (glazing.in_band(cosine, band).passed / odds) as f32);
        }
    }

    /// Reflected by the front or the back of a mirror or a pane, by a way that has the odds; nothing is left by what is
    /// neither.
    pub(super) fn reflect(&mut self, specular: &Specular, (cosine, front): (f64, bool), odds: f64) {
        let side = usize::from(front);
        match specular {
            Specular::None => self.scale = 0.0,
            Specular::Mirror(rho) => self.scale *= rho,
            Specular::ColouredMirror(rho) => self.take(rho.len(), |band| rho[band]),
            Specular::Glass(glazing) if glazing.is_grey() => {
                self.scale *= (glazing.mean(cosine).reflected[side] / odds) as f32;
            }
            Specular::Glass(glazing) => {
                self.take(glazing.bands(), |band| (glazing.in_band(cosine, band).reflected[side] / odds) as f32);
            }
        }
    }
}
