//! The hemicube: form factors of all patches at once from an item buffer on half a cube.
//!
//! Source: Cohen and Greenberg 1985. A pixel at `(x, y)` of the top has the form factor `ΔA/(π (x² + y² + 1)²)`, one of a
//! side at height `z` has `z ΔA/(π (y² + z² + 1)²)`. What a pixel shows is found by a ray through its middle, which gives
//! the same item buffer as projecting all patches, and the same aliasing: a patch narrower than a pixel is seen whole or
//! not at all. Closure does not reveal it.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Method, Work};
use crate::mesh::Patches;
use crate::transport::World;
use crate::transport::caster::{Hit, MISS, Ray};

/// Form factors through a hemicube at the centre of each patch.
#[derive(Debug)]
pub struct Hemicube<'a> {
    /// Geometry.
    pub world: &'a World,
    /// The patches.
    pub mesh: &'a dyn Patches,
    /// Pixels along the side of the top; even.
    pub resolution: usize,
}

impl Hemicube<'_> {
    /// Adds the factors of all patches at a point: irradiance per unit radiosity. `turn` is a direction in the point's
    /// plane, along which the cube lies.
    pub fn at_point(&self, x: DVec3, normal: DVec3, turn: DVec3, row: &mut [f64], work: &mut Work) {
        let (u, v) = (turn, normal.cross(turn));
        let mut rays = Vec::with_capacity(self.resolution);
        let mut hits = Vec::new();
        let mut shares = Vec::with_capacity(self.resolution);
        let n = self.resolution;
        let step = 2.0 / n as f64;
        let place = |k: usize| (k as f64 + 0.5) * step - 1.0;
        let mut scan = |row: &mut [f64], across: DVec3, origin: DVec3, side: bool, height: f64| {
            rays.clear();
            shares.clear();
            for k in 0..n {
                let y = place(k);
                let d = origin + across * y;
                let r2 = y * y + height * height + 1.0;
                shares.push(if side { height } else { 1.0 } * step * step / (PI * r2 * r2));
                rays.push(Ray::new(x, d / r2.sqrt()));
            }
            hits.clear();
            hits.resize(n, Hit { t: 0.0, surface: MISS });
            self.world.caster.closest_batch(&rays, &mut hits);
            work.rays += n as u64;
            for ((ray, hit), share) in rays.iter().zip(&hits).zip(&shares) {
                if let Some(j) = patch_hit(self.world, self.mesh, ray, hit) {
                    row[j as usize] += share;
                }
            }
        };
        for i in 0..n {
            scan(row, v, normal + u * place(i), false, place(i));
        }
        for i in 0..n / 2 {
            let z = (i as f64 + 0.5) * step;
            for (out, across) in [(u, v), (-u, v), (v, u), (-v, u)] {
                scan(row, across, out + normal * z, true, z);
            }
        }
    }
}

impl Method for Hemicube<'_> {
    fn describe(&self) -> String {
        format!("hemicubes of {} pixels", self.resolution)
    }

    fn row(&self, i: usize, row: &mut [f64], work: &mut Work) {
        let p = &self.mesh.list()[i];
        let axis = self.world.surfaces.list[p.surface as usize].axes[0];
        self.at_point(self.world.lift(p.centre, p.normal), p.normal, askew(axis, p.normal), row, work);
    }
}

/// An axis in the plane of a normal, turned so that rows of pixels do not run along the edges of a rectangular room.
#[must_use]
pub fn askew(axis: DVec3, normal: DVec3) -> DVec3 {
    axis * 0.3f64.cos() + normal.cross(axis) * 0.3f64.sin()
}

/// The patch that a ray landed on.
pub(super) fn patch_hit(world: &World, mesh: &dyn Patches, ray: &Ray, hit: &Hit) -> Option<u32> {
    if hit.surface == MISS {
        return None;
    }
    let s = &world.surfaces.list[hit.surface as usize];
    let direction = DVec3::from_array(ray.direction.map(f64::from));
    let (place, front) = (ray.at(hit.t), s.normal.dot(direction) < 0.0);
    let find = |p: DVec3| mesh.find(hit.surface as usize, front, s.uv(p));
    // Rounding takes what lands at the foot of a solid beneath it, where no patch is.
    find(place).or_else(|| find(place - direction * (2.0 * world.skin())))
}
