//! Direct light: the part of each emitter that a point sees, by exact clipping; sky and sun next door (`daylight.rs`).
//!
//! Where the blockers in the cone between point and emitter are few, each is subtracted from the emitter's polygon:
//! no noise. Where they are many, or clear glass is among them, stratified shadow rays give the visible share, and
//! the exact unoccluded factor the rest.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::caster::{MISS, Ray};
use super::daylight::{Parts, SUN, SkyScratch, daylight};
use super::hung::luminaire_lx;
use super::optics::Optics;
use super::panels::{Wanted, panel_light};
use super::places::Choice;
use super::points::Points;
use super::visible::{Visible, cone_planes};
use super::world::{Kind, World};
use crate::light::{Emitter, Luminaire, above_plane, configuration_factor};
use crate::mesh::{polygon_area, sample_polygon};

/// More blockers than this are sampled.
pub(super) const MAX_BLOCKERS: usize = 48;
/// Surfaces that together hide a lamp, at most, where more than that stand in the way.
const MAX_LOOKS: usize = 8;
/// Visible share of a lamp that is rounding.
const SLIVER: f64 = 1e-11;
/// Shadow rays: a first look, and all of them where that look sees a penumbra.
pub(super) const FEW_RAYS: u32 = 32;
pub(super) const MANY_RAYS: u32 = 256;
/// Widest piece of a window with a BSDF that one point stands for at a vertex of a path, radians.
const VERTEX_WIDTH: f64 = 0.7;
/// At one of many places of an element.
pub(super) const ROUGH_RAYS: u32 = 8;
/// Diameter of a lamp over its distance up to which one place on it tells its light at one of many points; and where the
/// lamp was drawn out of several, of which any might have been hidden.
pub(super) const SMALL_LAMP: f64 = 0.125;
const SMALL_DRAWN: f64 = 0.5;

/// Buffers of one thread, and what was done with them.
#[derive(Debug, Default)]
pub struct DirectScratch {
    pub(super) polygon: Vec<DVec3>,
    pub(super) whole: Vec<DVec3>,
    pub(super) planes: Vec<DVec3>,
    pub(super) blockers: Vec<u32>,
    pub(super) visible: Visible,
    pub(super) sky: SkyScratch,
    /// What the element at work looks at, or what a vertex does.
    pub(super) choice: Choice,
    /// Exitance of each group, all bands together.
    pub(super) strength: Vec<f64>,
    /// Is the point one of many, which make up for what one misses?
    pub(super) is_one_of_many: bool,
    /// Was the source at work drawn out of several?
    pub(super) is_drawn: bool,
    /// The set of cells that is read of windows with a BSDF.
    pub set: usize,
    /// The side of a window with a BSDF that receives the light: what passes it does not count.
    pub receiver: Option<(u32, bool)>,
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

    /// Lets daylight through coloured panes, into factors of [`Optics::columns`]; without, such panes let nothing by. Tells
    /// strong lamps from weak ones.
    #[must_use]
    pub fn in_bands(mut self, optics: &Optics) -> Self {
        self.sky = self.sky.in_bands(optics);
        self.strength = optics.exitance.iter().map(|m| m.iter().map(|m| f64::from(*m)).sum()).collect();
        self
    }

    /// How windows with a BSDF are looked at, at a vertex of a path one of many of them.
    pub(super) fn wanted(&self, is_vertex: bool) -> Wanted {
        let width = if is_vertex { VERTEX_WIDTH } else { self.sky.panel_width() };
        Wanted { width, one: is_vertex, set: self.set, receiver: self.receiver }
    }

    /// Panes on the way of the sun that was looked at last.
    #[must_use]
    pub fn panes(&self) -> &[u32] {
        &self.sky.through
    }
}

/// Irradiance per unit exitance from every group of light at a point with a normal; adds to `out`.
///
/// `sample` seeds the shadow rays where they are needed.
pub fn direct(world: &World, x: DVec3, normal: DVec3, sample: u64, scratch: &mut DirectScratch, out: &mut [f64]) {
    scratch.is_one_of_many = false;
    for k in 0..sources(world) {
        add_source(world, k, (x, normal), 1.0, sample, scratch, out);
    }
    add_daylight(world, (x, normal), sample, true, scratch, out);
    add_windows(world, (x, normal), sample, false, scratch, out);
}

/// What gives light that is looked at by itself.
pub(super) enum Source<'a> {
    Side(&'a Emitter),
    Hung(&'a Luminaire),
}

pub(super) fn sources(world: &World) -> usize {
    world.emitters.list.len() + world.emitters.luminaires.len()
}

pub(super) fn source(world: &World, k: usize) -> Source<'_> {
    let sides = &world.emitters.list;
    if k < sides.len() { Source::Side(&sides[k]) } else { Source::Hung(&world.emitters.luminaires[k - sides.len()]) }
}

/// Adds the light of one source, `times` over.
pub(super) fn add_source(
    world: &World,
    k: usize,
    (x, normal): (DVec3, DVec3),
    times: f64,
    sample: u64,
    scratch: &mut DirectScratch,
    out: &mut [f64],
) {
    let sample = sample ^ ((k as u64) << 32);
    let small = if scratch.is_drawn { SMALL_DRAWN } else { SMALL_LAMP };
    let (group, light) = match source(world, k) {
        Source::Side(e) if scratch.is_one_of_many && world.lamps().is_small(k, x, small) => {
            (e.group, factor_by_ray(world, e, (x, normal), sample, scratch))
        }
        Source::Side(e) => (e.group, visible_factor(world, e, x, normal, sample, scratch)),
        Source::Hung(l) => (l.group, luminaire_lx(world, l, x, normal, sample, scratch)),
    };
    let kept = if light > 0.0 { kept(world, scratch.receiver, x, &source(world, k)) } else { 0.0 };
    out[group] += times * light * kept;
}

/// Share of a source's light that does not pass the window with a BSDF that receives it, over the mean share of any light.
fn kept(world: &World, receiver: Option<(u32, bool)>, x: DVec3, source: &Source<'_>) -> f64 {
    let Some((surface, front)) = receiver else { return 1.0 };
    let middle = match source {
        Source::Side(e) => e.vertices.iter().sum::<DVec3>() / e.vertices.len() as f64,
        Source::Hung(l) => l.position,
    };
    let own = &world.surfaces.list[surface as usize];
    world.scatterer(surface).map_or(1.0, |s| s.keeps(own, front, (x - middle).normalize_or(-own.side_normal(front))))
}

/// Adds sky, ground and sun, or the sun alone.
pub(super) fn add_daylight(
    world: &World,
    at: (DVec3, DVec3),
    sample: u64,
    diffuse: bool,
    scratch: &mut DirectScratch,
    out: &mut [f64],
) {
    let Some(first) = world.daylight_group() else { return };
    let out = &mut out[first..];
    if let Some((surface, front)) = scratch.receiver {
        let uv = world.surfaces.list[surface as usize].uv(at.0);
        let kept = world.panels().kept(scratch.set, surface, front, uv);
        let first = if diffuse { 0 } else { SUN };
        out.iter_mut().zip(kept).skip(first).for_each(|(sum, e)| *sum += e);
    } else {
        let parts = if diffuse { Parts::All } else { Parts::Sun };
        scratch.rays += daylight(world, at, sample, parts, &mut scratch.sky, out);
    }
}

/// Adds sky, ground and sun by way of windows with a BSDF, at a vertex of a path from one of many such windows alone.
pub(super) fn add_windows(
    world: &World,
    at: (DVec3, DVec3),
    sample: u64,
    is_vertex: bool,
    scratch: &mut DirectScratch,
    out: &mut [f64],
) {
    let Some(first) = world.daylight_group().filter(|_| world.has_bsdf()) else { return };
    let wanted = scratch.wanted(is_vertex);
    scratch.rays += panel_light(world, at, sample, wanted, scratch, &mut out[first..]);
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
    // Only what lies between the point and the emitter's plane can block.
    let between = (emitter.normal, -height * (1.0 - 1e-9));
    if s.hidden_again(world, x, between) {
        return 0.0;
    }
    cone_planes(&s.polygon, &mut s.planes);
    let ceiling = (emitter.normal, emitter.normal.dot(emitter.vertices[0]));
    let all = s.planes.len() <= 15 && world.caster.in_cone(x, &s.planes, ceiling, MAX_BLOCKERS, &mut s.blockers);
    let few = all && !s.blockers.iter().any(|b| world.kind(*b) == Kind::Glass);
    let blockers = s.blockers.iter().copied().filter(|b| *b as usize != emitter.surface);
    if few && s.visible.clip(world, x, between, &s.polygon, blockers) {
        s.remember();
        let seen: f64 = s.visible.pieces.iter().map(|p| configuration_factor(&p.polygon, normal)).sum();
        // Rounding leaves slivers of a lamp that is hidden: a trace of light in a dark room.
        let is_sliver = seen < 1e-9 && seen < SLIVER * configuration_factor(&s.polygon, normal);
        return if is_sliver { 0.0 } else { seen };
    }
    if !all && hidden_behind_some(world, x, between, emitter.surface, s) {
        return 0.0;
    }
    let whole = configuration_factor(&s.polygon, normal);
    whole * visible_share(world, emitter, x, normal, sample, s)
}

/// Do a few surfaces hide the emitter's polygon from `x`? They are those that rays to what is left of it meet.
fn hidden_behind_some(world: &World, x: DVec3, between: (DVec3, f64), target: usize, s: &mut DirectScratch) -> bool {
    s.blockers.clear();
    let mut aim = s.polygon.iter().copied().sum::<DVec3>() / s.polygon.len() as f64;
    for _ in 0..MAX_LOOKS {
        let distance = aim.length();
        let hit = world.caster.closest(&Ray::to(x, aim / distance, (distance * (1.0 - 1e-6)) as f32));
        s.rays += 1;
        let opaque = hit.surface != MISS && hit.surface as usize != target && world.kind(hit.surface) != Kind::Glass;
        if !opaque || s.blockers.contains(&hit.surface) {
            return false;
        }
        s.blockers.push(hit.surface);
        if !s.visible.clip(world, x, between, &s.polygon, s.blockers.iter().copied()) {
            return false;
        }
        let Some(piece) = s.visible.pieces.first() else { return true };
        aim = piece.polygon.iter().copied().sum::<DVec3>() / piece.polygon.len() as f64;
    }
    false
}

/// The same by one place of the emitter, drawn evenly, and a ray to it.
fn factor_by_ray(world: &World, e: &Emitter, (x, normal): (DVec3, DVec3), sample: u64, s: &mut DirectScratch) -> f64 {
    let (a, b) = Points::new(sample).pair(0, 0);
    let d = place_on(world, e, a, b) - x;
    let (r2, cosines) = (d.length_squared(), normal.dot(d) * -e.normal.dot(d));
    if normal.dot(d) <= 0.0 || cosines <= 0.0 {
        return 0.0;
    }
    e.area * cosines / (PI * r2 * r2) * transmittance_to(world, x, d, e.surface, s)
}

/// A place of the emitter, evenly by its area.
fn place_on(world: &World, e: &Emitter, a: f64, b: f64) -> DVec3 {
    let surface = &world.surfaces.list[e.surface];
    surface.point(sample_polygon(&surface.outline, a, b))
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
    // One place of many may err: the others make up for it.
    let (few, many) = if s.is_one_of_many { (ROUGH_RAYS, ROUGH_RAYS) } else { (FEW_RAYS, MANY_RAYS) };
    let mut count = few;
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
        if k == few && mixed {
            count = many;
        }
    }
    if all > 0.0 { seen / all } else { 0.0 }
}

/// What is left of light from `x + d` on surface `target` at `x`: grey panes attenuate, all else blocks.
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
        let Some(pane) = world.greys().pane(world, hit.surface) else { return 0.0 };
        let cosine = world.surfaces.list[hit.surface as usize].normal.dot(direction).abs();
        left *= pane.mean(cosine).passed;
        start += f64::from(hit.t) + world.skin();
    }
    0.0
}
