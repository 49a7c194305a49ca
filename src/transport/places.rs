//! Direct light at one of many points: the places of an element, or a vertex of one of many paths.
//!
//! What one of them misses the others make up for. Sources that could give much are looked at; of those that could give
//! next to nothing one is drawn. A lamp that is small from there is asked by one ray.

use glam::DVec3;

use super::close;
use super::direct::{DirectScratch, SMALL_LAMP, Source, add_daylight, add_source, add_windows, source, sources};
use super::lamps::{Look, rough};
use super::points::Points;
use super::umbra::hidden;
use super::world::World;
use crate::light::{Luminaire, above_plane, configuration_factor};

/// Share of an element's light below which an emitter is looked at from fewer places, and below which it takes part in a
/// draw. The noise of the rows is several times what they leave.
const SMALL: f64 = 1.0;
const MINOR: f64 = 0.2;
/// Share of the light of all from which a cluster of lamps is no longer drawn as one.
const OPENED: f64 = 0.02;
/// Share of the light that one draw of a set of places stands for, at most.
const DRAWN: f64 = 0.25;
/// From so many sources on, a vertex looks at those that could give more than this share of the light of all, and draws one
/// of the others.
const MANY_SOURCES: usize = 6;
const MAJOR: f64 = 0.15;
/// Surfaces that are remembered to hide a lamp, at most.
const MAX_HIDERS: usize = 4;

/// What is looked at, and what is drawn.
#[derive(Debug, Default)]
pub(super) struct Choice {
    /// Sources that the element at work looks at, with at every how manyth place.
    every: Vec<(usize, usize)>,
    /// What one is drawn of, with its light and that of all before it.
    minor: Vec<(Look, f64)>,
    /// What each could give.
    looks: Vec<(Look, f64)>,
    /// Places of a set from one draw to the next.
    draw_every: usize,
    /// What hid each source whole from the last place of the element that looked at it; nothing where it was seen.
    hiders: Vec<Vec<u32>>,
    /// Luminaires that the whole element looks at, in place of its places.
    close: Vec<usize>,
    /// Number in `every` of what is looked at from a place of an element.
    looked_at: Option<usize>,
}

impl DirectScratch {
    /// Prepares for [`direct_at_place`] at places of a convex polygon: how often each emitter is worth a look there.
    ///
    /// An emitter that could give no more than a small share of the light is looked at from fewer of the `places` of a set
    /// than one in `every`; of those that could give next to nothing some are drawn.
    pub fn within(&mut self, world: &World, polygon: &[DVec3], normal: DVec3, every: usize, places: usize) {
        self.is_one_of_many = true;
        let mut choice = std::mem::take(&mut self.choice);
        self.survey(world, polygon, normal, &mut choice.looks);
        choice.close.clear();
        if self.receiver.is_none() {
            choice.looks.retain(|(look, _)| match look {
                Look::Source(k) if close_luminaire(world, *k, polygon, normal).is_some() => {
                    choice.close.push(*k);
                    false
                }
                _ => true,
            });
        }
        let sum: f64 = choice.looks.iter().map(|l| l.1).sum();
        choice.minor.clear();
        choice.every.clear();
        let (mut drawn, mut major) = (0.0, 0.0);
        choice.looks.retain(|&(look, light)| {
            let Look::Source(k) = look else {
                drawn += light;
                choice.minor.push((look, drawn));
                return false;
            };
            if light < MINOR * sum {
                drawn += light;
                choice.minor.push((look, drawn));
                return false;
            }
            let target = match source(world, k) {
                // A ray from each place costs less than to find out.
                Source::Side(_) if world.lamps().is_small(k, polygon[0], SMALL_LAMP) => {
                    major += light;
                    return true;
                }
                Source::Side(e) => (&e.vertices[..], e.surface),
                Source::Hung(l) => (&l.corners[..], usize::MAX),
            };
            let seen = !hidden(world, polygon, normal, target, &mut self.visible, &mut self.rays);
            major += if seen { light } else { 0.0 };
            seen
        });
        let sum = major + drawn;
        let turns = |light: f64| ((SMALL * sum / light) as usize).clamp(1, places).next_power_of_two();
        choice.every.extend(choice.looks.iter().filter_map(|&(look, light)| match look {
            Look::Source(k) => Some((k, (every * turns(light)).min(places))),
            Look::Cluster(_) => None,
        }));
        let draws = (drawn / (DRAWN * sum).max(f64::MIN_POSITIVE)).ceil().clamp(1.0, places as f64);
        choice.draw_every = (places / (draws as usize).next_power_of_two()).max(1);
        choice.hiders.iter_mut().for_each(Vec::clear);
        choice.hiders.resize_with(choice.hiders.len().max(choice.every.len()), Vec::new);
        self.choice = choice;
    }

    /// Adds `times` the mean illuminance of the polygon by the luminaires close to it, which its places do not look at.
    pub(super) fn add_close(
        &mut self,
        world: &World,
        (polygon, area): (&[DVec3], f64),
        normal: DVec3,
        (times, sample): (f64, u64),
        out: &mut [f32],
    ) {
        let close = std::mem::take(&mut self.choice.close);
        for k in &close {
            if let Some(l) = close_luminaire(world, *k, polygon, normal) {
                let lux = close::mean_lx(world, l, (polygon, area), normal, sample ^ ((*k as u64) << 32), self);
                out[l.group] += (times * lux) as f32;
            }
        }
        self.choice.close = close;
    }

    /// What each source, or cluster of them, could give at a polygon.
    fn survey(&mut self, world: &World, polygon: &[DVec3], normal: DVec3, looks: &mut Vec<(Look, f64)>) {
        let middle = polygon.iter().copied().sum::<DVec3>() / polygon.len() as f64;
        let reach = polygon.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        let Self { whole, polygon: upper, strength, .. } = self;
        let mut side = |k: usize| {
            if world.lamps().is_small(k, middle, SMALL_LAMP) {
                let light = |p: &DVec3| rough(world, k, *p, normal, strength);
                return [&middle].into_iter().chain(polygon).map(light).find(|l| *l > 0.0).unwrap_or(0.0);
            }
            let e = &world.emitters.list[k];
            let faces = |p: &DVec3| e.normal.dot(*p - e.vertices[0]) > 0.0;
            if !polygon.iter().any(faces) {
                return 0.0;
            }
            whole.clear();
            whole.extend(e.vertices.iter().map(|v| *v - middle));
            above_plane(whole, normal, 0.0, upper);
            let factor = if upper.len() < 3 { f64::MIN_POSITIVE } else { configuration_factor(upper, normal) };
            super::lamps::strength_of(strength, e.group) * factor
        };
        world.lamps().survey((middle, reach), normal, strength, &mut side, looks);
        world.lamps().open_stronger(OPENED, &mut side, looks);
        let hung = world.emitters.list.len()..sources(world);
        looks.extend(hung.map(|k| {
            let at = polygon.iter().chain([&middle]);
            (Look::Source(k), at.map(|p| rough(world, k, *p, normal, strength)).fold(0.0, f64::max))
        }));
        looks.retain(|l| l.1 > 0.0);
    }

    /// Does what hid the source at work from another place of the element hide all of `polygon` from this one too?
    pub(super) fn hidden_again(&mut self, world: &World, x: DVec3, between: (DVec3, f64)) -> bool {
        let Some(hiders) = self.choice.looked_at.map(|at| &self.choice.hiders[at]).filter(|h| !h.is_empty()) else {
            return false;
        };
        self.visible.clip(world, x, between, &self.polygon, hiders.iter().copied()) && self.visible.pieces.is_empty()
    }

    /// Remembers, for other places of the element, the few surfaces that left nothing of the source in the last clipping.
    pub(super) fn remember(&mut self) {
        let Some(at) = self.choice.looked_at else { return };
        self.choice.hiders[at].clear();
        if self.visible.pieces.is_empty() && self.visible.cutters.len() <= MAX_HIDERS {
            self.choice.hiders[at].extend_from_slice(&self.visible.cutters);
        }
    }

    /// Looks at one of what is drawn from, chosen by what it could give, `times` over.
    fn look_at_drawn(&mut self, world: &World, at: (DVec3, DVec3), times: f64, sample: u64, out: &mut [f64]) {
        let minor = &self.choice.minor;
        let Some(all) = minor.last().map(|m| m.1).filter(|all| *all > 0.0) else { return };
        let points = Points::new(sample);
        let want = all * points.get(0, 2);
        let chosen = minor.partition_point(|m| m.1 <= want).min(minor.len() - 1);
        let (look, upto) = minor[chosen];
        let times = times * all / (upto - if chosen > 0 { minor[chosen - 1].1 } else { 0.0 });
        self.is_drawn = true;
        match look {
            Look::Source(k) => add_source(world, k, at, times, sample, self, out),
            Look::Cluster(c) => {
                if let Some((k, one_of)) = world.lamps().draw(c, at.0, at.1, points.get(0, 3)) {
                    add_source(world, k, at, times * one_of, sample, self, out);
                }
            }
        }
        self.is_drawn = false;
    }
}

fn close_luminaire<'a>(world: &'a World, k: usize, polygon: &[DVec3], normal: DVec3) -> Option<&'a Luminaire> {
    match source(world, k) {
        Source::Hung(l) if close::is_close(l, polygon, normal, world.skin()) => Some(l),
        _ => None,
    }
}

/// Irradiance per unit exitance at one of many places of the polygon for which `scratch` was prepared
/// ([`DirectScratch::within`]), but not by luminaires close to it: what is looked at from every other place alone counts twice there. Light of sky and sun as
/// `daylight` wants: both, sun or none.
pub fn direct_at_place(
    world: &World,
    (x, normal): (DVec3, DVec3),
    place: usize,
    sample: u64,
    daylight: (bool, bool),
    scratch: &mut DirectScratch,
    out: &mut [f64],
) {
    for at in 0..scratch.choice.every.len() {
        let (k, every) = scratch.choice.every[at];
        if (place + k).is_multiple_of(every) {
            scratch.choice.looked_at = Some(at);
            add_source(world, k, (x, normal), every as f64, sample, scratch, out);
        }
    }
    scratch.choice.looked_at = None;
    let draw_every = scratch.choice.draw_every;
    if place.is_multiple_of(draw_every) {
        scratch.look_at_drawn(world, (x, normal), draw_every as f64, sample, out);
    }
    if daylight.0 || daylight.1 {
        add_daylight(world, (x, normal), sample, daylight.0, scratch, out);
    }
}

/// Irradiance per unit exitance at a vertex of one of many paths: all lamps, the sun, no other light of the day.
pub fn direct_at_vertex(
    world: &World,
    (x, normal): (DVec3, DVec3),
    sample: u64,
    scratch: &mut DirectScratch,
    out: &mut [f64],
) {
    scratch.is_one_of_many = true;
    scratch.choice.looked_at = None;
    if sources(world) < MANY_SOURCES {
        (0..sources(world)).for_each(|k| add_source(world, k, (x, normal), 1.0, sample, scratch, out));
    } else {
        look_at_some(world, (x, normal), sample, scratch, out);
    }
    // A window with a BSDF knows its sky already.
    add_daylight(world, (x, normal), sample, scratch.receiver.is_some(), scratch, out);
    add_windows(world, (x, normal), sample, true, scratch, out);
}

/// Light of many lamps at a vertex: those that could give much are looked at, of the others one is drawn.
fn look_at_some(world: &World, at: (DVec3, DVec3), sample: u64, scratch: &mut DirectScratch, out: &mut [f64]) {
    let mut looks = std::mem::take(&mut scratch.choice.looks);
    let strength = &scratch.strength;
    let light = |k: usize| rough(world, k, at.0, at.1, strength);
    world.lamps().survey((at.0, 0.0), at.1, strength, light, &mut looks);
    world.lamps().open_stronger(MAJOR, light, &mut looks);
    looks.extend((world.emitters.list.len()..sources(world)).map(|k| (Look::Source(k), light(k))));
    let major = MAJOR * looks.iter().map(|l| l.1).sum::<f64>();
    scratch.choice.minor.clear();
    let mut drawn = 0.0;
    for (look, light) in &looks {
        match look {
            Look::Source(k) if *light >= major && *light > 0.0 => {
                add_source(world, *k, at, 1.0, sample, scratch, out);
            }
            _ if *light > 0.0 => {
                drawn += light;
                scratch.choice.minor.push((*look, drawn));
            }
            _ => {}
        }
    }
    scratch.choice.looks = looks;
    scratch.look_at_drawn(world, at, 1.0, sample, out);
}
