//! Direct light: the part of each emitter that a point sees, by exact clipping; sky and sun next door (`daylight.rs`).
//!
//! Where the blockers in the cone between point and emitter are few, each is subtracted from the emitter's polygon:
//! no noise. Where they are many, or clear glass is among them, stratified shadow rays give the visible share, and
//! the exact unoccluded factor the rest.

use glam::{DVec2, DVec3};

use super::caster::{MISS, Ray};
use super::daylight::{Parts, SUN, SkyScratch, daylight};
use super::hung::luminaire_lx;
use super::optics::Optics;
use super::panels::{Wanted, panel_light};
use super::points::Points;
use super::umbra::hidden;
use super::visible::{Visible, cone_planes};
use super::world::{Kind, World};
use crate::light::{Emitter, Luminaire, above_plane, configuration_factor};
use crate::mesh::{polygon_area, sample_polygon};

/// More blockers than this are sampled.
pub(super) const MAX_BLOCKERS: usize = 48;
/// Share of an element's light below which an emitter is looked at from fewer places, and below which it takes part in a
/// draw.
const SMALL: f64 = 0.25;
const MINOR: f64 = 0.02;
/// From so many luminaires on, those that could give less than this share of the light of all take part in a draw at one of
/// many points.
const MANY_LUMINAIRES: usize = 6;
const MAJOR: f64 = 0.15;
/// Surfaces that together hide a lamp, at most, where more than that stand in the way.
const MAX_LOOKS: usize = 8;
/// Surfaces that are remembered to hide a lamp, at most.
const MAX_HIDERS: usize = 4;
/// Visible share of a lamp that is rounding.
const SLIVER: f64 = 1e-11;
/// Shadow rays: a first look, and all of them where that look sees a penumbra.
pub(super) const FEW_RAYS: u32 = 32;
pub(super) const MANY_RAYS: u32 = 256;
/// Widest piece of a window with a BSDF that one point stands for at a vertex of a path, radians.
const VERTEX_WIDTH: f64 = 0.7;
/// At one of many places of an element.
pub(super) const ROUGH_RAYS: u32 = 8;

/// Buffers of one thread, and what was done with them.
#[derive(Debug, Default)]
pub struct DirectScratch {
    pub(super) polygon: Vec<DVec3>,
    pub(super) whole: Vec<DVec3>,
    pub(super) planes: Vec<DVec3>,
    pub(super) blockers: Vec<u32>,
    pub(super) visible: Visible,
    pub(super) sky: SkyScratch,
    /// For each emitter, then each luminaire, at every how manyth place of the element at work it is looked at; 0 where none sees it.
    every: Vec<usize>,
    /// Emitters of which one is drawn for each set of places: number, and light of it and of all before it.
    minor: Vec<(usize, f64)>,
    /// What each luminaire could give at a point.
    draw: Vec<f64>,
    /// Places of a set.
    places: usize,
    /// What hid each source whole from the last place of the element that looked at it; nothing where it was seen.
    hiders: Vec<Vec<u32>>,
    /// The source that is looked at from a place of an element.
    looked_at: Option<usize>,
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

    /// Is it prepared for places of an element, of which one may err?
    pub(super) fn at_places(&self) -> bool {
        self.places > 0
    }

    /// Lets daylight through coloured panes, into factors of [`Optics::columns`]; without, such panes let nothing by.
    #[must_use]
    pub fn in_bands(mut self, optics: &Optics) -> Self {
        self.sky = self.sky.in_bands(optics);
        self
    }

    /// Panes on the way of the sun that was looked at last.
    #[must_use]
    pub fn panes(&self) -> &[u32] {
        &self.sky.through
    }

    /// Prepares for [`direct_at_place`] at places of a convex polygon: how often each emitter is worth a look there.
    ///
    /// An emitter that could give no more than a small share of the light is looked at from fewer of the `places` of a set
    /// than one in `every`; of those that could give next to nothing one is drawn. `strength` is the exitance of each group.
    pub fn within(
        &mut self,
        world: &World,
        polygon: &[DVec3],
        normal: DVec3,
        strength: &[f64],
        every: usize,
        places: usize,
    ) {
        let middle = polygon.iter().copied().sum::<DVec3>() / polygon.len() as f64;
        let Self { visible, rays, whole, polygon: upper, .. } = self;
        let mut light: Vec<f64> = world
            .emitters
            .list
            .iter()
            .map(|e| {
                let faces = |p: &DVec3| e.normal.dot(*p - e.vertices[0]) > 0.0;
                if !polygon.iter().any(faces) {
                    return 0.0;
                }
                whole.clear();
                whole.extend(e.vertices.iter().map(|v| *v - middle));
                above_plane(whole, normal, 0.0, upper);
                strength[e.group]
                    * if upper.len() < 3 { f64::MIN_POSITIVE } else { configuration_factor(upper, normal) }
            })
            .collect();
        let area_m2 = world.surfaces.frame.area_m2();
        light.extend(world.emitters.luminaires.iter().map(|l| {
            let most = polygon.iter().chain([&middle]).map(|p| l.rough(*p, normal)).fold(0.0, f64::max);
            strength[l.group] * most / area_m2
        }));
        let sum: f64 = light.iter().sum();
        self.minor.clear();
        let mut drawn = 0.0;
        for (k, light) in light.iter_mut().enumerate() {
            let is_minor = *light > 0.0 && *light < MINOR * sum;
            if is_minor {
                drawn += *light;
                self.minor.push((k, drawn));
            }
            let target = match source(world, k) {
                Source::Side(e) => (&e.vertices[..], e.surface),
                Source::Hung(l) => (&l.corners[..], usize::MAX),
            };
            if is_minor || (*light > 0.0 && hidden(world, polygon, normal, target, visible, rays)) {
                *light = 0.0;
            }
        }
        let sum: f64 = light.iter().sum::<f64>() + drawn;
        let turns = |light: f64| ((SMALL * sum / light) as usize).clamp(1, places).next_power_of_two();
        self.every.clear();
        self.every.extend(light.iter().map(|l| if *l > 0.0 { (every * turns(*l)).min(places) } else { 0 }));
        self.places = places;
        self.hiders.iter_mut().for_each(Vec::clear);
        self.hiders.resize_with(light.len(), Vec::new);
    }

    /// Does what hid the source at work from another place of the element hide all of `polygon` from this one too?
    pub(super) fn hidden_again(&mut self, world: &World, x: DVec3, between: (DVec3, f64)) -> bool {
        let Some(hiders) = self.looked_at.map(|k| &self.hiders[k]).filter(|h| !h.is_empty()) else { return false };
        self.visible.clip(world, x, between, &self.polygon, hiders.iter().copied()) && self.visible.pieces.is_empty()
    }

    /// Remembers, for other places of the element, the few surfaces that left nothing of the source in the last clipping.
    pub(super) fn remember(&mut self) {
        let Some(k) = self.looked_at else { return };
        self.hiders[k].clear();
        if self.visible.pieces.is_empty() && self.visible.cutters.len() <= MAX_HIDERS {
            self.hiders[k].extend_from_slice(&self.visible.cutters);
        }
    }
}

/// Irradiance per unit exitance from every group of light at a point with a normal; adds to `out`.
///
/// `sample` seeds the shadow rays where they are needed.
pub fn direct(world: &World, x: DVec3, normal: DVec3, sample: u64, scratch: &mut DirectScratch, out: &mut [f64]) {
    direct_parts(world, (x, normal), sample, true, scratch, out);
}

/// The same, with or without the light of sky and ground, which takes longest; without it, at one of many points, not every
/// luminaire is looked at.
pub fn direct_parts(
    world: &World,
    (x, normal): (DVec3, DVec3),
    sample: u64,
    diffuse: bool,
    scratch: &mut DirectScratch,
    out: &mut [f64],
) {
    let hung = world.emitters.luminaires.len();
    let all = if !diffuse && hung >= MANY_LUMINAIRES { world.emitters.list.len() } else { sources(world) };
    for k in 0..all {
        add_source(world, k, (x, normal), 1.0, sample, scratch, out);
    }
    if all < sources(world) {
        add_hung_by_chance(world, (x, normal), sample, scratch, out);
    }
    add_daylight(world, (x, normal), sample, diffuse, scratch, out);
}

/// Light of luminaires at one of many points: those that could give much are looked at, of the others one is drawn.
fn add_hung_by_chance(world: &World, at: (DVec3, DVec3), sample: u64, scratch: &mut DirectScratch, out: &mut [f64]) {
    let first = world.emitters.list.len();
    let mut draw = std::mem::take(&mut scratch.draw);
    draw.clear();
    draw.extend(world.emitters.luminaires.iter().map(|l| l.rough(at.0, at.1)));
    let major = MAJOR * draw.iter().sum::<f64>();
    let mut minor = 0.0;
    for (k, light) in draw.iter_mut().enumerate() {
        if *light >= major && *light > 0.0 {
            *light = 0.0;
            add_source(world, first + k, at, 1.0, sample, scratch, out);
        }
        minor += *light;
    }
    let mut want = minor * Points::new(sample).get(0, 2);
    let chosen = draw.iter().position(|light| {
        want -= *light;
        want < 0.0
    });
    if let Some(k) = chosen {
        add_source(world, first + k, at, minor / draw[k], sample, scratch, out);
    }
    scratch.draw = draw;
}

/// What gives light that is looked at by itself.
enum Source<'a> {
    Side(&'a Emitter),
    Hung(&'a Luminaire),
}

fn sources(world: &World) -> usize {
    world.emitters.list.len() + world.emitters.luminaires.len()
}

fn source(world: &World, k: usize) -> Source<'_> {
    let sides = &world.emitters.list;
    if k < sides.len() { Source::Side(&sides[k]) } else { Source::Hung(&world.emitters.luminaires[k - sides.len()]) }
}

/// Adds the light of one source, `times` over.
fn add_source(
    world: &World,
    k: usize,
    (x, normal): (DVec3, DVec3),
    times: f64,
    sample: u64,
    scratch: &mut DirectScratch,
    out: &mut [f64],
) {
    let sample = sample ^ ((k as u64) << 32);
    scratch.looked_at = scratch.at_places().then_some(k);
    let (group, light) = match source(world, k) {
        Source::Side(e) => (e.group, visible_factor(world, e, x, normal, sample, scratch)),
        Source::Hung(l) => (l.group, luminaire_lx(world, l, x, normal, sample, scratch)),
    };
    scratch.looked_at = None;
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

/// The same at one of many places of the polygon for which `scratch` was prepared ([`DirectScratch::within`]): what is
/// looked at from every other place alone counts twice there. Light of sky and sun as `daylight` wants: both, sun or none.
pub fn direct_at_place(
    world: &World,
    (x, normal): (DVec3, DVec3),
    place: usize,
    sample: u64,
    daylight: (bool, bool),
    scratch: &mut DirectScratch,
    out: &mut [f64],
) {
    let mut look = |k: usize, times: f64, scratch: &mut DirectScratch| {
        add_source(world, k, (x, normal), times, sample, scratch, out);
    };
    for k in 0..sources(world) {
        let every = scratch.every[k];
        if every > 0 && (place + k).is_multiple_of(every) {
            look(k, every as f64, scratch);
        }
    }
    if let Some((_, all)) = scratch.minor.last().copied().filter(|_| place.is_multiple_of(scratch.places)) {
        let want = all * Points::new(sample).get(0, 2);
        let chosen = scratch.minor.partition_point(|m| m.1 <= want).min(scratch.minor.len() - 1);
        let (k, upto) = scratch.minor[chosen];
        let own = upto - if chosen > 0 { scratch.minor[chosen - 1].1 } else { 0.0 };
        look(k, scratch.places as f64 * all / own, scratch);
    }
    if daylight.0 || daylight.1 {
        add_daylight(world, (x, normal), sample, daylight.0, scratch, out);
    }
}

fn add_daylight(
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
        let wanted = if diffuse || !scratch.at_places() { 0 } else { SUN };
        out.iter_mut().zip(kept).skip(wanted).for_each(|(sum, e)| *sum += e);
    } else {
        let parts = if diffuse { Parts::All } else { Parts::Sun };
        scratch.rays += daylight(world, at, sample, parts, &mut scratch.sky, out);
    }
    if !scratch.at_places() {
        let width = if diffuse { scratch.sky.panel_width() } else { VERTEX_WIDTH };
        add_windows(world, at, sample, (width, !diffuse), scratch, out);
    }
}

/// Sky, ground and sun by way of windows with a BSDF at a place of an element, in the columns of daylight.
pub(super) fn windows_at_place(
    world: &World,
    at: (DVec3, DVec3),
    sample: u64,
    scratch: &mut DirectScratch,
    out: &mut [f64],
) {
    let width = scratch.sky.panel_width();
    add_windows(world, at, sample, (width, false), scratch, out);
}

/// The same in pieces up to a width; of many windows `one` is drawn.
fn add_windows(
    world: &World,
    at: (DVec3, DVec3),
    sample: u64,
    (width, one): (f64, bool),
    scratch: &mut DirectScratch,
    out: &mut [f64],
) {
    if world.has_bsdf() {
        let wanted = Wanted { width, one, set: scratch.set, receiver: scratch.receiver };
        scratch.rays += panel_light(world, at, sample, wanted, scratch, out);
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
    let (few, many) = if s.places > 0 { (ROUGH_RAYS, ROUGH_RAYS) } else { (FEW_RAYS, MANY_RAYS) };
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
