//! Direct light of sky, ground and sun at a point.
//!
//! Nothing has to be declared an opening. The directions that a point looks to are divided into cells, each cell loses
//! the shadow of its blockers exactly ([`Visible`]), and the sky is integrated over what is left, with the panes that
//! stand before it. Cells with many blockers are divided further; at the last level rays take over. The sun is a disc of
//! its own, clipped in the same way: penumbras are exact.

use glam::DVec3;

use super::caster::{MISS, Ray};
use super::points::{Points, seed};
use super::visible::{Piece, Visible, cone_planes};
use super::world::{Kind, World};
use crate::light::{above_plane, configuration_factor, sun};

/// Groups of light that daylight adds behind those of the emitters.
pub const DAYLIGHT_GROUPS: usize = 3;
/// Which of them is which.
pub const SKY: usize = 0;
/// The endless ground.
pub const GROUND: usize = 1;
/// The sun's disc.
pub const SUN: usize = 2;

/// Blockers in a cell before it is divided.
const MAX_BLOCKERS: usize = 40;
/// Divisions of an octant: cells of about six degrees.
const MAX_DEPTH: u32 = 4;
/// Rays in a cell that is still too full, and over the sun's disc.
const CELL_RAYS: u32 = 8;
const SUN_RAYS: u32 = 64;
/// Relative difference of two rules at which a triangle is not divided further, for points that are reported at a
/// tolerance of 1 %. It falls with the square of the tolerance: the finer rule errs by its power 1.5 or more.
const FINE_QUADRATURE: f64 = 0.001;
const QUADRATURE: f64 = 0.02;
/// Widest triangle that is read at its middle alone, radians: for elements, of which many are averaged. The rule errs by
/// about a twenty-fourth of the square of it, times the curvature of luminance and transmittance.
const ELEMENT_WIDTH: f64 = 0.25;
/// Cosine between corners of a triangle that is divided in any case: seven points are too few for so wide a view.
const WIDE: f64 = 0.8;
const QUADRATURE_DEPTH: u32 = 7;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub(super) struct SkyScratch {
    visible: Visible,
    blockers: Vec<u32>,
    planes: Vec<DVec3>,
    cover: Vec<DVec3>,
    cut: Vec<DVec3>,
    /// Where triangles are not divided further; `None` for elements.
    limit: Option<f64>,
}

impl SkyScratch {
    /// For points that are reported at a tolerance.
    pub(super) fn for_tolerance(tolerance: f64) -> Self {
        let limit = (FINE_QUADRATURE * (tolerance / 0.01).powi(2)).clamp(1e-5, QUADRATURE);
        Self { limit: Some(limit), ..Self::default() }
    }
}

/// What becomes of the parts of sky and ground that a point sees.
trait Receiver {
    /// A piece that is seen whole.
    fn piece(&mut self, eye: &Eye<'_>, piece: &Piece, group: usize);
    /// A direction that chance chose: what is left of its light, and its share of the projected solid angle, sr.
    fn ray(&mut self, eye: &Eye<'_>, direction: DVec3, left: f64, weight: f64, group: usize);
}

/// Sums of all light of sky and ground.
struct Totals<'a> {
    out: &'a mut [f64],
    limit: Option<f64>,
}

impl Receiver for Totals<'_> {
    fn piece(&mut self, eye: &Eye<'_>, piece: &Piece, group: usize) {
        self.out[group] += eye.integrate(piece, group, self.limit);
    }

    fn ray(&mut self, eye: &Eye<'_>, direction: DVec3, left: f64, weight: f64, group: usize) {
        self.out[group] += left * weight * eye.luminance(group, direction);
    }
}

/// Directions in which a point sees sky or ground, none of them standing for more than `width` radians across.
struct Directions<'a> {
    width: f64,
    count: u64,
    visit: &'a mut dyn FnMut(DVec3, f64),
}

impl Receiver for Directions<'_> {
    fn piece(&mut self, eye: &Eye<'_>, piece: &Piece, _: usize) {
        eye.points(&piece.polygon, self.width, &mut |[a, b, c], weight| {
            // Anywhere in the triangle: on the whole, as much falls to each side of a border as lies there.
            self.count += 1;
            let chance = seed(&[eye.sample, self.count]);
            let (u, v) = (unit(chance >> 32), unit(chance & 0xFFFF_FFFF));
            let root = u.sqrt();
            let direction = (a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v)).normalize();
            let panes = piece.panes();
            let left = if panes.is_empty() { 1.0 } else { eye.passed(panes, direction) };
            (self.visit)(direction, weight * left);
        });
    }

    fn ray(&mut self, _: &Eye<'_>, direction: DVec3, left: f64, weight: f64, _: usize) {
        (self.visit)(direction, left * weight);
    }
}

/// What looks where: a point with its normal, and the seed of the rays it may need.
struct Eye<'a> {
    world: &'a World,
    x: DVec3,
    normal: DVec3,
    sample: u64,
}

/// Adds the factors of sky, ground and sun at a point to `out` (three numbers): irradiance per unit of the sky's
/// horizontal irradiance, of the ground's exitance, of the sun's irradiance face on. Returns rays that chance chose.
pub(super) fn daylight(
    world: &World,
    (x, normal): (DVec3, DVec3),
    sample: u64,
    parts: Parts,
    s: &mut SkyScratch,
    out: &mut [f64],
) -> u64 {
    let Some(light) = world.daylight() else { return 0 };
    let eye = Eye { world, x, normal, sample };
    let mut rays = 0;
    if parts == Parts::All {
        let wanted = (light.sky.is_some(), light.ground_reflectance > 0.0);
        let limit = s.limit;
        rays += eye.look(wanted, s, &mut Totals { out, limit });
    }
    rays + eye.sun(s, &mut out[SUN])
}

/// Tells `visit` the directions in which a point sees sky and ground, finer than `width` radians, each with its projected
/// solid angle times what panes leave of it, sr. Returns rays that chance chose.
pub fn visible_directions(
    world: &World,
    (x, normal): (DVec3, DVec3),
    sample: u64,
    width: f64,
    scratch: &mut super::DirectScratch,
    visit: &mut dyn FnMut(DVec3, f64),
) -> u64 {
    Eye { world, x, normal, sample }.look((true, true), &mut scratch.sky, &mut Directions { width, count: 0, visit })
}

/// Share of the sun's disc about `direction` that a point sees, times its cosine and what panes leave: irradiance per unit
/// of the irradiance face on.
pub fn sun_factor(
    world: &World,
    (x, normal): (DVec3, DVec3),
    direction: DVec3,
    sample: u64,
    scratch: &mut super::DirectScratch,
) -> f64 {
    let mut out = 0.0;
    scratch.rays += Eye { world, x, normal, sample }.sun_at(direction, &mut scratch.sky, &mut out);
    out
}

/// Which of the three lights are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parts {
    All,
    Sun,
}

impl Eye<'_> {
    /// Looks at sky and ground, as wanted, octant by octant.
    fn look(&self, (sky, ground): (bool, bool), s: &mut SkyScratch, out: &mut impl Receiver) -> u64 {
        let mut rays = 0;
        for octant in 0..8u64 {
            let sign = |bit: u64| if octant >> bit & 1 == 1 { -1.0 } else { 1.0 };
            let below = sign(2) < 0.0;
            if !(if below { ground } else { sky }) {
                continue;
            }
            let corners = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
            let mut polygon = Vec::with_capacity(4);
            above_plane(&corners, self.normal, 0.0, &mut polygon);
            if polygon.len() >= 3 {
                rays += self.cell(&polygon, if below { GROUND } else { SKY }, (0, octant), s, out);
            }
        }
        rays
    }

    fn cell(
        &self,
        polygon: &[DVec3],
        group: usize,
        (depth, path): (u32, u64),
        s: &mut SkyScratch,
        out: &mut impl Receiver,
    ) -> u64 {
        if self.is_covered(polygon, s) {
            return 0;
        }
        cone_planes(polygon, &mut s.planes);
        let ceiling = (self.normal, self.normal.dot(self.x));
        let few = self.world.caster.in_cone(self.x, &s.planes, ceiling, MAX_BLOCKERS, &mut s.blockers);
        if few {
            // Large blockers first: most of a room's pieces are gone after one or two.
            let list = &self.world.surfaces.list;
            s.blockers.sort_unstable_by(|a, b| {
                list[*b as usize].area.total_cmp(&list[*a as usize].area).then_with(|| a.cmp(b))
            });
            if s.visible.clip(self.world, self.x, (self.normal, 1e-9), polygon, s.blockers.iter().copied()) {
                s.visible.pieces.iter().for_each(|piece| out.piece(self, piece, group));
                return 0;
            }
        }
        if depth == MAX_DEPTH {
            return self.sampled(polygon, group, path, out);
        }
        let mut rays = 0;
        for (k, part) in divide(polygon).iter().enumerate() {
            rays += self.cell(part, group, (depth + 1, path * 8 + k as u64 + 1), s, out);
        }
        rays
    }

    /// Does the surface in the middle of the cell hide all of it?
    fn is_covered(&self, polygon: &[DVec3], s: &mut SkyScratch) -> bool {
        let middle = polygon.iter().map(|p| p.normalize()).sum::<DVec3>().normalize();
        let hit = self.world.caster.closest(&Ray::new(self.x, middle));
        if hit.surface == MISS || self.world.kind(hit.surface) == Kind::Glass {
            return false;
        }
        s.cut.clear();
        s.cut.extend(self.world.surfaces.list[hit.surface as usize].vertices.iter().map(|v| *v - self.x));
        cone_planes(&s.cut, &mut s.cover);
        polygon.iter().all(|p| s.cover.iter().all(|n| n.dot(*p) >= -1e-12))
    }

    /// Share of light left by the panes of a piece, in a direction.
    fn passed(&self, panes: &[u32], direction: DVec3) -> f64 {
        panes
            .iter()
            .map(|p| {
                let cosine = self.world.surfaces.list[*p as usize].normal.dot(direction).abs();
                self.world.pane(*p).map_or(0.0, |pane| pane.transmittance(cosine))
            })
            .product()
    }

    /// Luminance of a direction per unit of its group.
    fn luminance(&self, group: usize, direction: DVec3) -> f64 {
        if group == GROUND {
            return std::f64::consts::FRAC_1_PI;
        }
        self.world.daylight().and_then(|d| d.sky).map_or(0.0, |sky| sky.luminance(direction))
    }

    fn integrate(&self, piece: &Piece, group: usize, limit: Option<f64>) -> f64 {
        let is_flat = group == GROUND || self.world.daylight().and_then(|d| d.sky).is_some_and(|s| s.is_uniform());
        if is_flat && piece.panes().is_empty() {
            return configuration_factor(&piece.polygon, self.normal);
        }
        let Some(limit) = limit else {
            let mut sum = 0.0;
            self.points(&piece.polygon, ELEMENT_WIDTH, &mut |[a, b, c], weight| {
                let direction = (a + b + c).normalize();
                sum += weight * self.passed(piece.panes(), direction) * self.luminance(group, direction);
            });
            return sum;
        };
        let f = |p: DVec3| {
            let squared = p.length_squared();
            let length = squared.sqrt();
            let direction = p / length;
            let light = self.luminance(group, direction) * self.passed(piece.panes(), direction);
            light * self.normal.dot(direction).max(0.0) / (squared * length)
        };
        let first = piece.polygon[0];
        piece
            .polygon
            .windows(2)
            .skip(1)
            .map(|e| {
                let triangle = [first, e[0], e[1]];
                let volume = first.dot(e[0].cross(e[1])).abs();
                volume * triangle_integral(&f, triangle, limit, QUADRATURE_DEPTH)
            })
            .sum()
    }

    /// Divides a cone into spherical triangles finer than `width` radians, each with its projected solid angle, sr.
    fn points(&self, polygon: &[DVec3], width: f64, visit: &mut impl FnMut([DVec3; 3], f64)) {
        let first = polygon[0].normalize();
        let least = width.cos();
        for e in polygon.windows(2).skip(1) {
            self.triangle([first, e[0].normalize(), e[1].normalize()], least, visit);
        }
    }

    /// The same within a spherical triangle: its longest side is halved until it is short enough.
    fn triangle(&self, [a, b, c]: [DVec3; 3], least: f64, visit: &mut impl FnMut([DVec3; 3], f64)) {
        let (ab, bc, ca) = (a.dot(b), b.dot(c), c.dot(a));
        if ab.min(bc).min(ca) < least {
            let (p, q, r) = if ab <= bc && ab <= ca {
                (a, b, c)
            } else if bc <= ca {
                (b, c, a)
            } else {
                (c, a, b)
            };
            let middle = (p + q).normalize();
            self.triangle([p, middle, r], least, visit);
            self.triangle([middle, q, r], least, visit);
            return;
        }
        // tan Ω/2 by van Oosterom and Strackee 1983; small, so that two terms of the arc tangent are enough.
        let half = a.dot(b.cross(c)).abs() / (1.0 + ab + bc + ca);
        let solid_angle = 2.0 * half * (1.0 - half * half / 3.0);
        let cosine = self.normal.dot(a + b + c).max(0.0) / (a + b + c).length();
        visit([a, b, c], solid_angle * cosine);
    }

    /// A cell with too many blockers: well-spread rays.
    fn sampled(&self, polygon: &[DVec3], group: usize, path: u64, out: &mut impl Receiver) -> u64 {
        let points = Points::new(seed(&[self.sample, path]));
        let mut rays = 0;
        let first = polygon[0];
        for e in polygon.windows(2).skip(1) {
            let volume = first.dot(e[0].cross(e[1])).abs();
            for k in 0..CELL_RAYS {
                let (a, b) = points.pair(k, 0);
                let root = b.sqrt();
                let p = first + ((e[0] - first) * (1.0 - a) + (e[1] - first) * a) * root;
                let (squared, direction) = (p.length_squared(), p.normalize());
                let weight = 0.5 * volume * self.normal.dot(direction).max(0.0) / (squared * squared.sqrt());
                let left = transmittance_out(self.world, self.x, direction, &mut rays);
                out.ray(self, direction, left, weight / f64::from(CELL_RAYS), group);
            }
        }
        rays
    }

    fn sun(&self, s: &mut SkyScratch, out: &mut f64) -> u64 {
        self.world.daylight().and_then(|d| d.sun).map_or(0, |direction| self.sun_at(direction, s, out))
    }

    fn sun_at(&self, direction: DVec3, s: &mut SkyScratch, out: &mut f64) -> u64 {
        let disc = sun::disc(direction);
        let face_on = configuration_factor(&disc, direction);
        let mut above = Vec::with_capacity(16);
        let mut polygon = Vec::with_capacity(16);
        above_plane(&disc, self.normal, 0.0, &mut above);
        above_plane(&above, DVec3::Z, 0.0, &mut polygon);
        if polygon.len() < 3 {
            return 0;
        }
        cone_planes(&polygon, &mut s.planes);
        let ceiling = (self.normal, self.normal.dot(self.x));
        let few = self.world.caster.in_cone(self.x, &s.planes, ceiling, MAX_BLOCKERS, &mut s.blockers);
        if few && s.visible.clip(self.world, self.x, (self.normal, 1e-9), &polygon, s.blockers.iter().copied()) {
            for piece in &s.visible.pieces {
                let passed = self.passed(piece.panes(), direction);
                *out += passed * configuration_factor(&piece.polygon, self.normal) / face_on;
            }
            return 0;
        }
        let points = Points::new(seed(&[self.sample, 99]));
        let mut rays = 0;
        let share: f64 = (0..SUN_RAYS)
            .map(|k| {
                let (a, b) = points.pair(k, 0);
                transmittance_out(self.world, self.x, sun_direction(&disc, a, b), &mut rays)
            })
            .sum();
        *out += share / f64::from(SUN_RAYS) * configuration_factor(&polygon, self.normal) / face_on;
        rays
    }
}

/// A whole number below 2^32 as a share of one.
fn unit(number: u64) -> f64 {
    number as f64 / 4_294_967_296.0
}

/// A direction to the sun's disc from a point of the unit square.
#[must_use]
pub fn sun_direction(disc: &[DVec3], a: f64, b: f64) -> DVec3 {
    let centre = disc.iter().sum::<DVec3>() / disc.len() as f64;
    let place = a * disc.len() as f64;
    let k = (place as usize).min(disc.len() - 1);
    let (p, q) = (disc[k] - centre, disc[(k + 1) % disc.len()] - centre);
    let across = place - k as f64;
    (centre + (p * (1.0 - across) + q * across) * b.sqrt()).normalize()
}

/// What is left of light that comes from outside along `−direction`: clear panes attenuate, all else blocks.
pub fn transmittance_out(world: &World, x: DVec3, direction: DVec3, rays: &mut u64) -> f64 {
    let mut start = x;
    let mut left = 1.0;
    for _ in 0..16 {
        let ray = Ray::new(start, direction);
        let hit = world.caster.closest(&ray);
        *rays += 1;
        if hit.surface == MISS {
            return left;
        }
        let Some(pane) = world.pane(hit.surface) else { return 0.0 };
        let cosine = world.surfaces.list[hit.surface as usize].normal.dot(direction).abs();
        left *= pane.transmittance(cosine);
        start = ray.at(hit.t) + direction * world.skin();
    }
    0.0
}

/// Smaller cones that make up one: triangles of a polygon, quarters of a triangle.
fn divide(polygon: &[DVec3]) -> Vec<Vec<DVec3>> {
    if let [a, b, c] = *polygon {
        let (ab, bc, ca) = ((a + b).normalize(), (b + c).normalize(), (c + a).normalize());
        return vec![vec![a, ab, ca], vec![ab, b, bc], vec![ca, bc, c], vec![ab, bc, ca]];
    }
    polygon.windows(2).skip(1).map(|e| vec![polygon[0], e[0], e[1]]).collect()
}

/// Seven points of a triangle, exact to the fifth degree (Radon 1948): weight, and the place between the corners.
const RULE: [(f64, [f64; 3]); 7] = {
    const A: f64 = 0.470_142_064_105_115_1;
    const B: f64 = 0.101_286_507_323_456_34;
    const WA: f64 = 0.132_394_152_788_506_2;
    const WB: f64 = 0.125_939_180_544_827_15;
    [
        (0.225, [1.0 / 3.0; 3]),
        (WA, [A, A, 1.0 - 2.0 * A]),
        (WA, [A, 1.0 - 2.0 * A, A]),
        (WA, [1.0 - 2.0 * A, A, A]),
        (WB, [B, B, 1.0 - 2.0 * B]),
        (WB, [B, 1.0 - 2.0 * B, B]),
        (WB, [1.0 - 2.0 * B, B, B]),
    ]
};

/// Half the mean of `f` over a triangle, divided in four until two rules of first degree come near to that of the fifth:
/// the error of the latter is then far smaller.
fn triangle_integral(f: &impl Fn(DVec3) -> f64, [a, b, c]: [DVec3; 3], limit: f64, depth: u32) -> f64 {
    let values = RULE.map(|(w, [x, y, z])| (w, f(a * x + b * y + c * z)));
    let fine: f64 = values.iter().map(|(w, v)| w * v).sum();
    let mean = |part: &[(f64, f64)]| part.iter().map(|(_, v)| v).sum::<f64>() / 3.0;
    let off = (mean(&values[1..4]) - fine).abs().max((mean(&values[4..]) - fine).abs());
    let is_wide = a.dot(b).min(b.dot(c)).min(c.dot(a))
        < WIDE * a.length_squared().min(b.length_squared()).min(c.length_squared());
    if depth == 0 || (off <= limit * fine && !is_wide) {
        return 0.5 * fine;
    }
    let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
    let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
    0.25 * parts.map(|t| triangle_integral(f, t, limit, depth - 1)).iter().sum::<f64>()
}
