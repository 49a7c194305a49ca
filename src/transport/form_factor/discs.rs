//! Ray-traced form factors: the source made up of discs, a shadow ray to each.
//!
//! ```text
//! ΔF = V (A/n) cos θ_i cos θ_j / (π r² + A/n)
//! ```
//! Source: Wallace, Elmquist and Haines 1989. Right where discs are small against their distance; near an edge in common
//! they are not.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Method, Work};
use crate::mesh::{Patch, Patches, sample_polygon};
use crate::transport::World;
use crate::transport::transmittance_to;

/// Form factors by discs, seen from the centre of the receiver.
#[derive(Debug)]
pub struct Discs<'a> {
    /// Geometry.
    pub world: &'a World,
    /// The patches.
    pub mesh: &'a dyn Patches,
    /// Discs along each side of a source: its square makes the source.
    pub per_side: usize,
}

impl Discs<'_> {
    /// Factor of a patch at a point: irradiance per unit radiosity.
    #[must_use]
    pub fn at_point(&self, x: DVec3, normal: DVec3, source: &Patch, work: &mut Work) -> f64 {
        let surface = &self.world.surfaces.list[source.surface as usize];
        let n = self.per_side;
        let area = source.area / (n * n) as f64;
        let place = |k: usize| (k as f64 + 0.5) / n as f64;
        let mut sum = 0.0;
        for k in 0..n * n {
            let d = surface.point(sample_polygon(&source.outline, place(k % n), place(k / n))) - x;
            let r2 = d.length_squared();
            let cosines = normal.dot(d).max(0.0) * (-source.normal.dot(d)).max(0.0);
            if cosines > 0.0 {
                work.factors += 1;
                let seen = transmittance_to(self.world, x, d, source.surface as usize, &mut work.scratch);
                sum += seen * area * (cosines / r2) / (PI * r2 + area);
            }
        }
        sum
    }
}

impl Method for Discs<'_> {
    fn describe(&self) -> String {
        format!("{} discs to a patch", self.per_side * self.per_side)
    }

    fn row(&self, i: usize, row: &mut [f64], work: &mut Work) {
        let p = &self.mesh.list()[i];
        let x = self.world.lift(p.centre, p.normal);
        for (f, source) in row.iter_mut().zip(self.mesh.list()) {
            *f = self.at_point(x, p.normal, source, work);
        }
    }
}
