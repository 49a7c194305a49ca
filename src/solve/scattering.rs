//! What elements do with light that arrives: they reflect it and, where they are translucent, pass it to their other side.

use rayon::prelude::*;

use super::bicgstab::{LANES, Lanes, PIECE};
use crate::mesh::{Element, Elements, NO_ELEMENT};
use crate::transport::{Optics, World};

/// `S`: reflectances on the diagonal, transmittances between the two sides of translucent elements; eight lanes abreast.
#[derive(Debug)]
pub(super) struct Scattering {
    /// Reflectance of the back and of the front of each material.
    rho: Vec<[Lanes; 2]>,
    /// Material and side of each element.
    sides: Vec<(u32, bool)>,
    /// The two sides of a translucent element, and its transmittance.
    pairs: Vec<(usize, usize, Lanes)>,
}

impl Scattering {
    /// `lanes` chooses from the bands.
    pub(super) fn new(world: &World, optics: &Optics, mesh: &Elements, lanes: impl Fn(&[f32]) -> Lanes) -> Self {
        let material = |e: &Element| world.surfaces.list[e.surface as usize].material;
        let pair = |(i, e): (usize, &Element)| {
            let other = mesh.find(e.key.other_side());
            // Each pair once.
            let is_pair = world.is_translucent(e.surface) && other != NO_ELEMENT && i < other as usize;
            is_pair.then(|| (i, other as usize, lanes(optics.tau(material(e)))))
        };
        Self {
            rho: optics.reflectance.iter().map(|sides| [lanes(&sides[0]), lanes(&sides[1])]).collect(),
            sides: mesh.list().iter().map(|e| (material(e) as u32, e.front)).collect(),
            pairs: mesh.list().iter().enumerate().filter_map(pair).collect(),
        }
    }

    fn rho(&self, (material, front): (u32, bool)) -> &Lanes {
        &self.rho[material as usize][usize::from(front)]
    }

    /// From what arrives to what leaves.
    pub(super) fn act(&self, light: &mut [Lanes]) {
        let through = |from: usize, tau: &Lanes| -> Lanes { std::array::from_fn(|l| tau[l] * light[from][l]) };
        let passed: Vec<[Lanes; 2]> =
            self.pairs.iter().map(|(i, j, tau)| [through(*j, tau), through(*i, tau)]).collect();
        light.par_iter_mut().with_min_len(PIECE).zip(&self.sides).for_each(|(light, side)| {
            let rho = self.rho(*side);
            *light = std::array::from_fn(|l| rho[l] * light[l]);
        });
        for ((i, j, _), sides) in self.pairs.iter().zip(passed) {
            for (to, came) in [*i, *j].into_iter().zip(sides) {
                light[to] = std::array::from_fn(|l| light[to][l] + came[l]);
            }
        }
    }

    /// Share of what arrives that each element keeps.
    pub(super) fn absorbed(&self) -> Vec<Lanes> {
        let mut kept: Vec<Lanes> = self.sides.iter().map(|side| self.rho(*side).map(|r| 1.0 - r)).collect();
        for (i, j, tau) in &self.pairs {
            for side in [*i, *j] {
                for l in 0..LANES {
                    kept[side][l] -= tau[l];
                }
            }
        }
        kept
    }
}
