//! Emitting polygons and their groups.

use glam::DVec3;

use super::luminaires::{Luminaire, Luminaires};
use crate::mesh::{Frame, Surfaces};
use crate::scene::{Material, Scene};
use crate::spectrum::Spectrum;

/// One emitting side of one surface.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// Index of the surface.
    pub surface: usize,
    /// Does the front emit (or the back)?
    pub front: bool,
    /// Vertices, in the program's frame.
    pub vertices: Vec<DVec3>,
    /// Unit normal of the emitting side.
    pub normal: DVec3,
    /// Which group it belongs to.
    pub group: usize,
    /// Area, in the program's frame.
    pub area: f64,
}

/// Everything that emits.
#[derive(Clone, Debug, Default)]
pub struct Emitters {
    /// All emitting sides.
    pub list: Vec<Emitter>,
    /// Material of each group of emitting sides.
    pub materials: Vec<usize>,
    /// Luminaires, in the program's frame.
    pub luminaires: Vec<Luminaire>,
    /// Spectra of one lumen, W/(nm lm), of the groups of luminaires, which follow those of the sides.
    pub spectra: Vec<Spectrum>,
    /// Group of lamps that those of each spectrum are dimmed with.
    pub dimming: Vec<Option<String>>,
}

impl Emitters {
    /// Collects the emitting sides of a scene. Surfaces with an emission of zero do not count.
    #[must_use]
    pub fn new(scene: &Scene, surfaces: &Surfaces) -> Self {
        let mut emitters = Self::default();
        let group_of: Vec<Option<usize>> = scene
            .materials
            .iter()
            .enumerate()
            .map(|(m, material)| {
                shines(material).then(|| {
                    emitters.materials.push(m);
                    emitters.materials.len() - 1
                })
            })
            .collect();
        for (i, s) in surfaces.list.iter().enumerate() {
            let (Some(group), Some(emission)) = (group_of[s.material], &scene.materials[s.material].emission) else {
                continue;
            };
            for front in [true, false] {
                if front || emission.two_sided {
                    emitters.list.push(Emitter {
                        surface: i,
                        front,
                        vertices: s.vertices.clone(),
                        normal: s.side_normal(front),
                        group,
                        area: s.area,
                    });
                }
            }
        }
        emitters
    }

    /// Hangs luminaires among the emitting sides.
    pub fn hang(&mut self, luminaires: Luminaires, frame: &Frame) {
        let first = self.materials.len();
        self.luminaires = luminaires.list.into_iter().map(|l| l.placed(frame, first)).collect();
        self.spectra = luminaires.spectra;
        self.dimming = luminaires.dimming;
    }

    /// Does nothing emit?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty() && self.luminaires.is_empty()
    }

    /// Number of groups.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.materials.len() + self.spectra.len()
    }

    /// What the exitance of each group is multiplied by to give its flux, in the program's unit of area: the emitting
    /// area of sides, the lumens of luminaires over `area_m2`, the square metres of that unit.
    #[must_use]
    pub fn group_areas(&self, area_m2: f64) -> Vec<f64> {
        let mut areas = vec![0.0; self.groups()];
        for e in &self.list {
            areas[e.group] += e.area;
        }
        for l in &self.luminaires {
            areas[l.group] += l.flux_lm / area_m2;
        }
        areas
    }
}

fn shines(material: &Material) -> bool {
    material.emission.as_ref().is_some_and(|e| e.radiance.max() > 0.0)
}
