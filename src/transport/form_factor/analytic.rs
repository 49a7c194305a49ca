//! Analytic form factors of a mesh.

use glam::DVec3;

use super::pairs::{Pairs, face_each_other, sender};
use super::{Method, Work};
use crate::light::Emitter;
use crate::mesh::{Patch, Patches};
use crate::transport::World;
use crate::transport::visible_factor;

/// Analytic form factors of a mesh.
#[derive(Debug)]
pub struct Analytic<'a> {
    world: &'a World,
    patches: &'a [Patch],
    senders: Vec<Emitter>,
    pairs: Pairs<'a>,
}

impl<'a> Analytic<'a> {
    /// Prepares the patches of a mesh.
    #[must_use]
    pub fn new(world: &'a World, mesh: &'a dyn Patches) -> Self {
        let patches = mesh.list();
        Self { world, patches, senders: patches.iter().map(sender).collect(), pairs: Pairs::new(world) }
    }

    /// Factor of patch `j` at a point: irradiance per unit radiosity.
    #[must_use]
    pub fn at_point(&self, x: DVec3, normal: DVec3, j: usize, work: &mut Work) -> f64 {
        let stream = j as u64;
        visible_factor(self.world, &self.senders[j], x, normal, stream, &mut work.scratch)
    }

    /// Exchange area of a patch `a` (of this mesh or a finer one) with patch `j`.
    #[must_use]
    pub fn between(&self, a: &Patch, j: usize, work: &mut Work) -> f64 {
        let b = &self.patches[j];
        if !face_each_other(a, b) {
            return 0.0;
        }
        let blocked = self.pairs.blockers(a, b, self.pairs.all()).next().is_some();
        self.pairs.exchange(a, b, blocked, work)
    }
}

impl Method for Analytic<'_> {
    fn describe(&self) -> String {
        "analytic: contour integrals, exact clipping where something stands between".into()
    }

    fn row(&self, i: usize, row: &mut [f64], work: &mut Work) {
        let a = &self.patches[i];
        for (j, f) in row.iter_mut().enumerate() {
            *f = self.between(a, j, work) / a.area;
        }
    }

    fn exchange(&self, i: usize, j: usize, work: &mut Work) -> Option<f64> {
        Some(self.between(&self.patches[i], j, work))
    }
}
