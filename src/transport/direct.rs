//! Direct light of area emitters: the part of each emitter that a point sees, by exact clipping.
//!
//! Where the blockers in the cone between point and emitter are few, each is subtracted from the emitter's polygon:
//! no noise. Where they are many, or clear glass is among them, stratified shadow rays give the visible share, and
//! the exact unoccluded factor the rest.

use glam::{DVec2, DVec3};

use super::caster::{MISS, Ray};
use super::points::Points;
use super::world::{Kind, World};
use crate::light::{Emitter, above_plane, configuration_factor};
use crate::mesh::{polygon_area, sample_polygon};

/// More blockers than this are sampled.
const MAX_BLOCKERS: usize = 48;
/// More pieces than this are sampled.
const MAX_PIECES: usize = 256;
/// Visible share of a lamp that is rounding.
const SLIVER: f64 = 1e-11;
/// Shadow rays: a first look, and all of them where that look sees a penumbra.
const FEW_RAYS: u32 = 32;
const MANY_RAYS: u32 = 256;

/// Buffers of one thread, and what was done with them.
#[derive(Debug, Default)]
pub struct DirectScratch {
    polygon: Vec<DVec3>,
    blocker: Vec<DVec3>,
    clipped: Vec<DVec3>,
    planes: Vec<DVec3>,
    blockers: Vec<u32>,
    pieces: Vec<Vec<DVec3>>,
    next: Vec<Vec<DVec3>>,
    spare: Vec<Vec<DVec3>>,
    /// Shadow rays cast.
    pub rays: u64,
    /// Exact factors worked out.
    pub factors: u64,
}

/// Irradiance per unit exitance from every group of emitters at a point with a normal; adds to `out`.
///
/// `sample` seeds the shadow rays where they are needed.
pub fn direct(world: &World, x: DVec3, normal: DVec3, sample: u64, scratch: &mut DirectScratch, out: &mut [f64]) {
    for (k, emitter) in world.emitters.list.iter().enumerate() {
        out[emitter.group] += visible_factor(world, emitter, x, normal, sample ^ ((k as u64) << 32), scratch);
    }
}

/// Irradiance at a point with a normal, per unit exitance of one emitting polygon, by the part of it that the point sees.
///
/// The polygon may be a part of its surface. `sample` seeds the shadow rays where they are needed.
pub fn visible_factor(
    world: &World,
    emitter: &Emitter,
    x: DVec3,
    normal: DVec3,
    sample: u64,
    s: &mut DirectScratch,
) -> f64 {
    let height = emitter.normal.dot(x - emitter.vertices[0]);
    if height <= 1e-9 {
        return 0.0; // behind the emitter or in its plane
    }
    s.clipped.clear();
    s.clipped.extend(emitter.vertices.iter().map(|v| *v - x));
    above_plane(&s.clipped, normal, 0.0, &mut s.polygon);
    if s.polygon.len() < 3 {
        return 0.0;
    }
    s.factors += 1;
    cone_planes(&s.polygon, &mut s.planes);
    let ceiling = (emitter.normal, emitter.normal.dot(emitter.vertices[0]));
    let few = s.planes.len() <= 15
        && world.caster.in_cone(x, &s.planes, ceiling, MAX_BLOCKERS, &mut s.blockers)
        && !s.blockers.iter().any(|b| world.kind(*b) == Kind::Glass);
    if few && subtract_blockers(world, emitter, x, height, s) {
        let seen: f64 = s.pieces.iter().map(|p| configuration_factor(p, normal)).sum();
        // Rounding leaves slivers of a lamp that is hidden: a trace of light in a dark room.
        let is_sliver = seen < 1e-9 && seen < SLIVER * configuration_factor(&s.polygon, normal);
        return if is_sliver { 0.0 } else { seen };
    }
    let whole = configuration_factor(&s.polygon, normal);
    whole * visible_share(world, emitter, x, normal, sample, s)
}

/// Inward unit normals of the planes through the origin and the edges of a convex polygon.
fn cone_planes(polygon: &[DVec3], planes: &mut Vec<DVec3>) {
    planes.clear();
    let middle = polygon.iter().copied().sum::<DVec3>();
    for (k, a) in polygon.iter().enumerate() {
        let n = a.cross(polygon[(k + 1) % polygon.len()]);
        let length = n.length();
        if length > 1e-300 {
            planes.push(n / if n.dot(middle) < 0.0 { -length } else { length });
        }
    }
}

/// Cuts every blocker's shadow out of the polygon; the pieces that stay are seen. `false`: too many pieces.
fn subtract_blockers(world: &World, emitter: &Emitter, x: DVec3, height: f64, s: &mut DirectScratch) -> bool {
    s.spare.append(&mut s.pieces);
    let mut first = s.spare.pop().unwrap_or_default();
    first.clone_from(&s.polygon);
    s.pieces.push(first);
    for b in 0..s.blockers.len() {
        let index = s.blockers[b] as usize;
        if index == emitter.surface {
            continue;
        }
        let surface = &world.surfaces.list[index];
        if surface.height(x).abs() < 1e-9 {
            continue; // seen edge-on
        }
        s.clipped.clear();
        s.clipped.extend(surface.vertices.iter().map(|v| *v - x));
        // Only what lies between the point and the emitter's plane can block.
        above_plane(&s.clipped, emitter.normal, -height * (1.0 - 1e-9), &mut s.blocker);
        if s.blocker.len() < 3 || outside_cone(&s.blocker, &s.planes) {
            continue;
        }
        subtract(s);
        if s.pieces.is_empty() {
            return true;
        }
        if s.pieces.len() > MAX_PIECES {
            return false;
        }
    }
    true
}

fn outside_cone(polygon: &[DVec3], planes: &[DVec3]) -> bool {
    planes.iter().any(|n| polygon.iter().all(|p| n.dot(*p) <= 1e-12))
}

/// Subtracts the cone over `s.blocker` from all pieces.
fn subtract(s: &mut DirectScratch) {
    let mut cone = [DVec3::ZERO; 16];
    let mut edges = 0;
    let middle = s.blocker.iter().copied().sum::<DVec3>();
    for (k, a) in s.blocker.iter().enumerate() {
        let n = a.cross(s.blocker[(k + 1) % s.blocker.len()]);
        let length = n.length();
        if length > 1e-18 && edges < cone.len() {
            cone[edges] = n / if n.dot(middle) < 0.0 { -length } else { length };
            edges += 1;
        }
    }
    let cone = &cone[..edges];
    if edges < 3 {
        return;
    }
    s.next.clear();
    while let Some(piece) = s.pieces.pop() {
        if outside_cone(&piece, cone) {
            s.next.push(piece);
            continue;
        }
        let mut inside = piece;
        for n in cone {
            let mut outside = s.spare.pop().unwrap_or_default();
            above_plane(&inside, -*n, 0.0, &mut outside);
            if outside.len() >= 3 {
                s.next.push(outside);
            } else {
                s.spare.push(outside);
            }
            above_plane(&inside, *n, 0.0, &mut s.clipped);
            std::mem::swap(&mut inside, &mut s.clipped);
            if inside.len() < 3 {
                break;
            }
        }
        s.spare.push(inside);
    }
    std::mem::swap(&mut s.pieces, &mut s.next);
}

/// Share of the emitter's light that reaches the point, by shadow rays weighted with the kernel.
fn visible_share(world: &World, emitter: &Emitter, x: DVec3, normal: DVec3, sample: u64, s: &mut DirectScratch) -> f64 {
    let points = Points::new(sample);
    let surface = &world.surfaces.list[emitter.surface];
    let mut outline: Vec<DVec2> = emitter.vertices.iter().map(|v| surface.uv(*v)).collect();
    if polygon_area(&outline) < 0.0 {
        outline.reverse();
    }
    let (mut seen, mut all) = (0.0, 0.0);
    let mut count = FEW_RAYS;
    let mut k = 0;
    while k < count {
        let (a, b) = points.pair(k, 0);
        let d = surface.point(sample_polygon(&outline, a, b)) - x;
        let (r2, cosines) = (d.length_squared(), normal.dot(d).max(0.0) * -emitter.normal.dot(d));
        let weight = cosines / (r2 * r2);
        if weight > 0.0 {
            all += weight;
            seen += weight * transmittance_to(world, x, d, emitter.surface, s);
        }
        k += 1;
        let mixed = seen > 0.0 && seen < all;
        if k == FEW_RAYS && mixed {
            count = MANY_RAYS;
        }
    }
    if all > 0.0 { seen / all } else { 0.0 }
}

/// What is left of light from `x + d` on surface `target` at `x`: clear panes attenuate, all else blocks.
pub fn transmittance_to(world: &World, x: DVec3, d: DVec3, target: usize, s: &mut DirectScratch) -> f64 {
    let distance = d.length();
    let direction = d / distance;
    let mut start = 0.0;
    let mut left = 1.0;
    for _ in 0..16 {
        let ray = Ray::to(x + direction * start, direction, ((distance - start) * (1.0 - 1e-6)) as f32);
        let hit = world.caster.closest(&ray);
        s.rays += 1;
        if hit.surface == MISS || hit.surface as usize == target {
            return left;
        }
        let Some(pane) = world.pane(hit.surface) else { return 0.0 };
        let cosine = world.surfaces.list[hit.surface as usize].normal.dot(direction).abs();
        left *= pane.transmittance(cosine);
        start += f64::from(hit.t) + world.skin();
    }
    0.0
}
