//! What a point sees of windows with a BSDF: exact clipping, and points spread over what is left.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Panels, Spot, Window};
use crate::light::{above_plane, configuration_factor};
use crate::transport::Tint;
use crate::transport::daylight::{DAYLIGHT_GROUPS, Eye, SkyScratch, deposit, pass, with_eye};
use crate::transport::direct::{DirectScratch, MAX_BLOCKERS};
use crate::transport::points::Points;
use crate::transport::visible::{Piece, cone_planes};
use crate::transport::world::World;

/// Share of a window's hemisphere below which what is seen of it is rounding.
const DARK: f64 = 1e-13;
/// Width of the pieces that one point stands for over the width of all that is seen of a window, at most.
const SHARE: f64 = 0.5;

/// What is wanted of the light of windows with a BSDF.
#[derive(Clone, Copy, Debug)]
pub(in crate::transport) struct Wanted {
    /// Widest piece of a window that one point stands for, radians.
    pub(in crate::transport) width: f64,
    /// The set of cells that is read.
    pub(in crate::transport) set: usize,
    /// Of many windows one is drawn.
    pub(in crate::transport) one: bool,
    /// The side of a window with a BSDF that receives the light.
    pub(in crate::transport) receiver: Option<(u32, bool)>,
}

/// Adds what a point receives from all windows with a BSDF of sky, ground and sun: see [`deposit`]. Returns rays that chance
/// chose.
pub(in crate::transport) fn panel_light(
    world: &World,
    at: (DVec3, DVec3),
    sample: u64,
    wanted: Wanted,
    s: &mut DirectScratch,
    out: &mut [f64],
) -> u64 {
    panel_spots(world, at, sample, wanted, s, &mut |spot, weight, tint| {
        let radiance = world.panels().of_spot(spot);
        for group in (0..DAYLIGHT_GROUPS).filter(|g| radiance[*g] > 0.0) {
            deposit(out, group, weight * radiance[group], tint);
        }
    })
}

/// Tells `found` what a point sees of all windows with a BSDF: spots, each with the irradiance that it gives for its radiance,
/// sr, and what panes leave of it. Returns rays that chance chose.
pub(in crate::transport) fn panel_spots(
    world: &World,
    (x, normal): (DVec3, DVec3),
    sample: u64,
    wanted: Wanted,
    s: &mut DirectScratch,
    found: &mut impl FnMut(Spot, f64, &Tint),
) -> u64 {
    let panels: &Panels = world.panels();
    if !wanted.one || panels.windows.len() == 1 {
        let each = |k: usize| from_window(world, k, (x, normal), sample, (wanted, 1.0), s, found);
        return (0..panels.windows.len()).map(each).sum();
    }
    let mut upto = 0.0;
    let sums: Vec<f64> = panels
        .windows
        .iter()
        .map(|w| {
            upto += if faces(world, w, x).is_some() { whole_factor(world, w, x, normal, s) } else { 0.0 };
            upto
        })
        .collect();
    let want = upto * Points::new(sample).get(0, 3);
    let chosen = sums.partition_point(|sum| *sum <= want);
    if chosen >= panels.windows.len() {
        return 0;
    }
    let own = sums[chosen] - if chosen > 0 { sums[chosen - 1] } else { 0.0 };
    from_window(world, chosen, (x, normal), sample, (wanted, upto / own), s, found)
}

/// The side of a window that a point sees, if light leaves it.
fn faces(world: &World, window: &Window, x: DVec3) -> Option<bool> {
    let height = world.surfaces.list[window.surface as usize].height(x);
    let front = height > 0.0;
    (height.abs() > 1e-9 && window.shines[usize::from(front)]).then_some(front)
}

/// Configuration factor of a window without what hides it; its visible half is left in `s.polygon`.
fn whole_factor(world: &World, window: &Window, x: DVec3, normal: DVec3, s: &mut DirectScratch) -> f64 {
    s.whole.clear();
    s.whole.extend(world.surfaces.list[window.surface as usize].vertices.iter().map(|v| *v - x));
    above_plane(&s.whole, normal, 0.0, &mut s.polygon);
    if s.polygon.len() < 3 { 0.0 } else { configuration_factor(&s.polygon, normal) }
}

fn from_window(
    world: &World,
    number: usize,
    (x, normal): (DVec3, DVec3),
    sample: u64,
    (wanted, times): (Wanted, f64),
    s: &mut DirectScratch,
    found: &mut impl FnMut(Spot, f64, &Tint),
) -> u64 {
    let window = &world.panels().windows[number];
    let Some(front) = faces(world, window, x) else { return 0 };
    let factor = whole_factor(world, window, x, normal, s);
    if factor < DARK {
        return 0;
    }
    let surface = &world.surfaces.list[window.surface as usize];
    let side = surface.side_normal(front);
    let between = (side, -surface.height(x).abs() * (1.0 - 1e-9));
    cone_planes(&s.polygon, &mut s.planes);
    let ceiling = (side, side.dot(surface.vertices[0]));
    let few = s.planes.len() <= 15 && world.caster.in_cone(x, &s.planes, ceiling, MAX_BLOCKERS, &mut s.blockers);
    let width = wanted.width.min(SHARE * (PI * factor).sqrt());
    let DirectScratch { sky, visible, blockers, polygon, .. } = s;
    let blockers = blockers.iter().copied().filter(|b| *b != window.surface);
    let is_clipped = few && visible.clip(world, x, between, polygon, blockers);
    with_eye(world, (x, normal), sample ^ (u64::from(window.surface) << 20), sky, |eye, sky| {
        let look = Look { eye, surface: window.surface, number, front, wanted, width, times };
        if is_clipped {
            visible.pieces.iter().for_each(|piece| look.piece(piece, &mut sky.tint, found));
            return 0;
        }
        look.rays(polygon, sky, found)
    })
}

/// A point that looks at a window.
struct Look<'a> {
    eye: &'a Eye<'a>,
    surface: u32,
    /// Of the window.
    number: usize,
    front: bool,
    wanted: Wanted,
    width: f64,
    times: f64,
}

impl Look<'_> {
    /// Adds the light of a piece that is seen whole.
    fn piece(&self, piece: &Piece, tint: &mut Tint, found: &mut impl FnMut(Spot, f64, &Tint)) {
        if configuration_factor(&piece.polygon, self.eye.normal) < DARK || self.eye.is_shut(piece) {
            return;
        }
        self.eye.somewhere(&piece.polygon, self.width, &mut |direction, weight| {
            tint.reset();
            self.eye.at_panes(piece.panes(), direction, |pane, cosine| tint.pass(pane, cosine, 1.0));
            self.add(direction, weight, tint, found);
        });
    }

    /// Adds the light of a polygon with many blockers before it: a ray for each point.
    fn rays(&self, polygon: &[DVec3], sky: &mut SkyScratch, found: &mut impl FnMut(Spot, f64, &Tint)) -> u64 {
        let mut rays = 0;
        let (eye, target) = (self.eye, self.surface);
        eye.somewhere(polygon, self.width, &mut |direction, weight| {
            sky.tint.reset();
            if pass(eye.world, eye.speculars, (eye.x, direction), target, &mut sky.tint, &mut rays, |_| {}) {
                self.add(direction, weight, &sky.tint, found);
            }
        });
        rays
    }

    fn add(&self, direction: DVec3, weight: f64, tint: &Tint, found: &mut impl FnMut(Spot, f64, &Tint)) {
        let world = self.eye.world;
        let surface = &world.surfaces.list[self.surface as usize];
        let distance = -surface.height(self.eye.x) / surface.normal.dot(direction);
        let uv = surface.uv(self.eye.x + direction * distance);
        let kept = self.wanted.receiver.map_or(1.0, |(own, front)| {
            let receiver = &world.surfaces.list[own as usize];
            world.scatterer(own).map_or(1.0, |s| s.keeps(receiver, front, -direction))
        });
        let spot = world.panels().spot(world, (self.number, self.front), self.wanted.set, uv, -direction);
        found(spot, self.times * kept * weight, tint);
    }
}
