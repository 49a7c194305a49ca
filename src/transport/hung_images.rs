//! Luminaires in plane mirrors and panes: the most that one reflection could throw onto a point. The light itself is left out.

use glam::DVec3;

use super::specular::{Specular, Speculars};
use super::sun_images::most_reflected;
use super::world::{Kind, World};
use crate::light::Luminaire;
use crate::mesh::Surface;

/// Illuminance that images of luminaires by one reflection could give at a point with a normal, at most, lx: without
/// anything in the way, each image that a ray to any corner or the middle of it meets counted whole, with the greatest
/// intensity and cosine and the least distance of these rays.
#[must_use]
pub fn most_mirrored_lx(world: &World, speculars: &Speculars, (x, normal): (DVec3, DVec3)) -> f64 {
    let unit = 1.0 / world.surfaces.frame.area_m2();
    let mut sum = 0.0;
    for (k, mirror) in world.surfaces.list.iter().enumerate() {
        let height = mirror.height(x);
        if world.kind(k as u32) == Kind::Diffuse || height == 0.0 {
            continue;
        }
        let (front, specular) = (height > 0.0, speculars.of(world, k as u32));
        // The point's image sees the luminaire as the point sees the luminaire's image.
        let image = (x - mirror.normal * (2.0 * height), normal - mirror.normal * (2.0 * mirror.normal.dot(normal)));
        let of = |l: &Luminaire| mirrored(l, (mirror, specular, front), image);
        sum += world.emitters.luminaires.iter().map(of).sum::<f64>();
    }
    unit * sum
}

fn mirrored(l: &Luminaire, (mirror, specular, front): (&Surface, &Specular, bool), (x, normal): (DVec3, DVec3)) -> f64 {
    let rays = || l.corners.iter().chain([&l.position]).map(|p| *p - x);
    let through = |d: &DVec3| {
        let slope = mirror.normal.dot(*d);
        let t = -mirror.height(x) / slope;
        let uv = mirror.uv(x + *d * t);
        let n = mirror.outline.len();
        let edge = |k: usize| (mirror.outline[(k + 1) % n] - mirror.outline[k]).perp_dot(uv - mirror.outline[k]) >= 0.0;
        (0.0..1.0).contains(&t) && (0..n).all(edge)
    };
    if !rays().any(|d| through(&d)) {
        return 0.0;
    }
    let most = |f: &dyn Fn(DVec3) -> f64| rays().map(f).fold(0.0, f64::max);
    let nearest = rays().map(DVec3::length).fold(f64::INFINITY, f64::min);
    let reflected = most(&|d| most_reflected(specular, mirror.normal.dot(d.normalize()).abs(), front));
    reflected * most(&|d| l.intensity(-d)) * most(&|d| normal.dot(d.normalize()).max(0.0)) / (nearest * nearest)
}
