//! Emitting polygons and their groups.

use glam::DVec3;

use crate::mesh::Surfaces;
use crate::scene::{Material, Scene};

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
    /// Material of each group.
    pub materials: Vec<usize>,
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

    /// Number of groups.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.materials.len()
    }

    /// Emitting area of each group, in the program's frame.
    #[must_use]
    pub fn group_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.groups()];
        for e in &self.list {
            areas[e.group] += e.area;
        }
        areas
    }
}

fn shines(material: &Material) -> bool {
    material.emission.as_ref().is_some_and(|e| e.radiance.max() > 0.0)
}
