//! Direct light: the part of each emitter that a point sees, by exact clipping; sky and sun next door (`daylight.rs`).
//!
//! Where the blockers in the cone between point and emitter are few, each is subtracted from the emitter's polygon:
//! no noise. Where they are many, or clear glass is among them, stratified shadow rays give the visible share, and
//! the exact unoccluded factor the rest.

use glam::{DVec2, DVec3};

use super::caster::{MISS, Ray};
use super::daylight::{Parts, SkyScratch, daylight};
use super::points::Points;
use super::visible::{Visible, cone_planes};
use super::world::{Kind, World};
use crate::light::{Emitter, above_plane, configuration_factor};
use crate::mesh::{polygon_area, sample_polygon};

/// More blockers than this are sampled.
const MAX_BLOCKERS: usize = 48;
/// Visible share of a lamp that is rounding.
const SLIVER: f64 = 1e-11;
/// Shadow rays: a first look, and all of them where that look sees a penumbra.
const FEW_RAYS: u32 = 32;
const MANY_RAYS: u32 = 256;

/// Buffers of one thread, and what was done with them.
#[derive(Debug, Default)]
pub struct DirectScratch {
    polygon: Vec<DVec3>,
    whole: Vec<DVec3>,
    planes: Vec<DVec3>,
    blockers: Vec<u32>,
    visible: Visible,
    sky: SkyScratch,
    /// Shadow rays cast.
    pub rays: u64,
    /// Exact factors worked out.
    pub factors: u64,
}

impl DirectScratch {
    /// For points that are reported at a tolerance: the sky is integrated more finely than for elements.
    #[must_use]
    pub fn for_tolerance(tolerance: f64) -> Self {
        Self { sky: SkyScratch::for_tolerance(tolerance), ..Self::default() }
    }
}

/// Irradiance per unit exitance from every group of light at a point with a normal; adds to `out`.
///
/// `sample` seeds the shadow rays where they are needed.
pub fn direct(world: &World, x: DVec3, normal: DVec3, sample: u64, scratch: &mut DirectScratch, out: &mut [f64]) {
    direct_parts(world, (x, normal), sample, true, scratch, out);
}

/// The same, with or without the light of sky and ground, which takes longest.
pub fn direct_parts(
    world: &World,
    (x, normal): (DVec3, DVec3),
    sample: u64,
    diffuse: bool,
    scratch: &mut DirectScratch,
    out: &mut [f64],
) {
    for (k, emitter) in world.emitters.list.iter().enumerate() {
        out[emitter.group] += visible_factor(world, emitter, x, normal, sample ^ ((k as u64) << 32), scratch);
    }
    if let Some(first) = world.daylight_group() {
        let parts = if diffuse { Parts::All } else { Parts::Sun };
        scratch.rays += daylight(world, (x, normal), sample, parts, &mut scratch.sky, &mut out[first..]);
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
    s.whole.clear();
    s.whole.extend(emitter.vertices.iter().map(|v| *v - x));
    above_plane(&s.whole, normal, 0.0, &mut s.polygon);
    if s.polygon.len() < 3 {
        return 0.0;
    }
    s.factors += 1;
    cone_planes(&s.polygon, &mut s.planes);
    let ceiling = (emitter.normal, emitter.normal.dot(emitter.vertices[0]));
    let few = s.planes.len() <= 15
        && world.caster.in_cone(x, &s.planes, ceiling, MAX_BLOCKERS, &mut s.blockers)
        && !s.blockers.iter().any(|b| world.kind(*b) == Kind::Glass);
    // Only what lies between the point and the emitter's plane can block.
    let between = (emitter.normal, -height * (1.0 - 1e-9));
    let blockers = s.blockers.iter().copied().filter(|b| *b as usize != emitter.surface);
    if few && s.visible.clip(world, x, between, &s.polygon, blockers) {
        let seen: f64 = s.visible.pieces.iter().map(|p| configuration_factor(&p.polygon, normal)).sum();
        // Rounding leaves slivers of a lamp that is hidden: a trace of light in a dark room.
        let is_sliver = seen < 1e-9 && seen < SLIVER * configuration_factor(&s.polygon, normal);
        return if is_sliver { 0.0 } else { seen };
    }
    let whole = configuration_factor(&s.polygon, normal);
    whole * visible_share(world, emitter, x, normal, sample, s)
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
