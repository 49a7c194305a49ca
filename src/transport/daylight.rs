//! Direct light of sky and ground at a point.
//!
//! Nothing has to be declared an opening. The directions that a point looks to are divided into cells, each cell loses
//! the shadow of its blockers exactly ([`Visible`]), and the sky is integrated over what is left, with the panes that
//! stand before it. Cells with many blockers are divided further; at the last level rays take over. The sun's disc is a cone of
//! its own (`sunlight.rs`).

use glam::DVec3;

use super::caster::{MISS, Ray};
use super::chain::Tint;
use super::glass::Glazing;
use super::openings::Openings;
use super::optics::Optics;
use super::points::{Points, seed};
use super::specular::Speculars;
use super::spherical;
use super::visible::{Piece, Visible, cone_planes};
use super::world::{Kind, World};
use crate::light::{above_plane, configuration_factor};

/// Groups of light that daylight adds behind those of the emitters.
pub const DAYLIGHT_GROUPS: usize = 3;
/// Which of them is which.
pub const SKY: usize = 0;
/// The endless ground.
pub const GROUND: usize = 1;
/// The sun's disc.
pub const SUN: usize = 2;

/// Share of the whole sky below which a piece is rounding: a sealed room is dark.
const DARK: f64 = 1e-13;
/// Blockers in a cell before it is divided.
pub(super) const MAX_BLOCKERS: usize = 40;
/// Divisions of an octant: cells of about six degrees.
const MAX_DEPTH: u32 = 4;
/// Rays in a cell that is still too full.
const CELL_RAYS: u32 = 8;
/// Relative difference of two rules at which a triangle is not divided further, for points that are reported at a
/// tolerance of 1 %. It falls with the square of the tolerance: the finer rule errs by its power 1.5 or more.
const FINE_QUADRATURE: f64 = 0.001;
const QUADRATURE: f64 = 0.02;
/// Widest triangle that is read at its middle alone, radians: for elements, of which many are averaged. The rule errs by
/// about a twenty-fourth of the square of it, times the curvature of luminance and transmittance.
const ELEMENT_WIDTH: f64 = 0.25;
const QUADRATURE_DEPTH: u32 = 7;
/// See [`SkyScratch::panel_width`]: at a tolerance of 1 %, at least, on elements.
const FINE_PANEL: f64 = 0.015;
const LEAST_PANEL: f64 = 0.008;
const ELEMENT_PANEL: f64 = 0.35;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub(super) struct SkyScratch {
    pub(super) visible: Visible,
    pub(super) blockers: Vec<u32>,
    pub(super) planes: Vec<DVec3>,
    cover: Vec<DVec3>,
    cut: Vec<DVec3>,
    /// Where triangles are not divided further; `None` for elements.
    pub(super) limit: Option<f64>,
    /// Mirrors and panes in the bands of the run, where any is coloured.
    coloured: Option<Speculars>,
    pub(super) tint: Tint,
    /// Panes on the way to what was looked at last.
    pub(super) through: Vec<u32>,
}

impl SkyScratch {
    /// For points that are reported at a tolerance.
    pub(super) fn for_tolerance(tolerance: f64) -> Self {
        let limit = (FINE_QUADRATURE * (tolerance / 0.01).powi(2)).clamp(1e-5, QUADRATURE);
        Self { limit: Some(limit), ..Self::default() }
    }

    /// Widest piece of a window with a BSDF that one point stands for, radians: one patch is about 0.17 wide. One of many
    /// points on an element may take larger ones.
    pub(super) fn panel_width(&self) -> f64 {
        self.limit.map_or(ELEMENT_PANEL, |limit| FINE_PANEL * (limit / FINE_QUADRATURE).powf(0.25)).max(LEAST_PANEL)
    }

    pub(super) fn in_bands(mut self, optics: &Optics) -> Self {
        if optics.speculars.are_coloured() {
            self.coloured = Some(optics.speculars.clone());
            self.tint = Tint::new(optics.pad);
        }
        self
    }
}

/// Adds light of a group of daylight that came through a tint: to the factor of the group, or band by band behind the
/// factors of all (see [`Optics::columns`]). `out` begins with daylight's own groups.
pub fn deposit(out: &mut [f64], group: usize, value: f64, tint: &Tint) {
    if !tint.coloured {
        out[group] += value * f64::from(tint.scale);
        return;
    }
    let pad = tint.bands.len();
    let from = DAYLIGHT_GROUPS + group * pad;
    for (band, sum) in out[from..from + pad].iter_mut().enumerate() {
        *sum += value * f64::from(tint.share(band));
    }
}

/// What becomes of the parts of sky and ground that a point sees.
trait Receiver {
    /// A piece that is seen whole.
    fn piece(&mut self, eye: &Eye<'_>, piece: &Piece, group: usize, tint: &mut Tint);
    /// A direction that chance chose, with its share of the projected solid angle, sr; and the panes on the way.
    fn ray(&mut self, eye: &Eye<'_>, direction: DVec3, panes: (&Tint, &[u32]), weight: f64, group: usize);
}

/// Sums of all light of sky and ground.
struct Totals<'a> {
    out: &'a mut [f64],
    limit: Option<f64>,
}

impl Receiver for Totals<'_> {
    fn piece(&mut self, eye: &Eye<'_>, piece: &Piece, group: usize, tint: &mut Tint) {
        eye.integrate(piece, group, self.limit, tint, self.out);
    }

    fn ray(&mut self, eye: &Eye<'_>, direction: DVec3, (tint, _): (&Tint, &[u32]), weight: f64, group: usize) {
        deposit(self.out, group, weight * eye.luminance(group, direction), tint);
    }
}

/// Directions in which a point sees sky or ground, none of them standing for more than `width` radians across.
struct Directions<'a> {
    width: f64,
    count: u64,
    visit: &'a mut dyn FnMut(Seen<'_>),
    /// Where pieces of the sky are kept.
    openings: Option<&'a mut Openings>,
    planes: Vec<DVec3>,
}

/// A direction in which a point sees sky or ground.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Unit vector.
    pub direction: DVec3,
    /// Projected solid angle that it stands for, sr, with the cosine of the middle of its cone.
    pub weight: f64,
    /// Solid angle that it stands for, sr, unbiased: of the direction itself in place of the cone.
    pub solid_angle: f64,
    /// What panes leave.
    pub tint: &'a Tint,
    /// Their surfaces.
    pub panes: &'a [u32],
}

impl Receiver for Directions<'_> {
    fn piece(&mut self, eye: &Eye<'_>, piece: &Piece, group: usize, tint: &mut Tint) {
        if eye.is_shut(piece) || configuration_factor(&piece.polygon, eye.normal) < DARK {
            return;
        }
        if let Some(openings) = self.openings.as_mut().filter(|_| group == SKY) {
            openings.keep(piece, &mut self.planes);
        }
        let panes = piece.panes();
        eye.points(&piece.polygon, self.width, &mut |[a, b, c], weight| {
            self.count += 1;
            let (direction, solid_angle) = eye.anywhere([a, b, c], self.count);
            tint.reset();
            eye.at_panes(panes, direction, |pane, cosine| tint.pass(pane, cosine, 1.0));
            (self.visit)(Seen { direction, weight, solid_angle, tint, panes });
        });
    }

    fn ray(&mut self, eye: &Eye<'_>, direction: DVec3, (tint, panes): (&Tint, &[u32]), weight: f64, group: usize) {
        if let Some(openings) = self.openings.as_mut().filter(|_| group == SKY) {
            openings.give_up();
        }
        let solid_angle = if weight > 0.0 { weight / eye.normal.dot(direction) } else { 0.0 };
        (self.visit)(Seen { direction, weight, solid_angle, tint, panes });
    }
}

/// What looks where: a point with its normal, and the seed of the rays it may need.
pub(super) struct Eye<'a> {
    pub(super) world: &'a World,
    pub(super) speculars: &'a Speculars,
    pub(super) x: DVec3,
    pub(super) normal: DVec3,
    pub(super) sample: u64,
}

/// Adds the factors of sky, ground and sun at a point to `out` (three numbers, and what came by coloured panes, see
/// [`deposit`]): irradiance per unit of the sky's horizontal irradiance, of the ground's exitance, of the sun's irradiance
/// face on. Returns rays that chance chose.
pub(super) fn daylight(
    world: &World,
    (x, normal): (DVec3, DVec3),
    sample: u64,
    parts: Parts,
    s: &mut SkyScratch,
    out: &mut [f64],
) -> u64 {
    let Some(light) = world.daylight() else { return 0 };
    with_eye(world, (x, normal), sample, s, |eye, s| {
        let mut rays = 0;
        if parts == Parts::All {
            let wanted = (light.sky.is_some(), light.ground_reflectance > 0.0);
            let limit = s.limit;
            rays += eye.look(wanted, s, &mut Totals { out, limit });
        }
        rays + eye.sun(s, out) + eye.mirrored_sun(s, out)
    })
}

/// Looks from a point, through coloured panes where the buffers know the bands.
pub(super) fn with_eye<R>(
    world: &World,
    (x, normal): (DVec3, DVec3),
    sample: u64,
    s: &mut SkyScratch,
    look: impl FnOnce(&Eye<'_>, &mut SkyScratch) -> R,
) -> R {
    let coloured = s.coloured.take();
    let eye = Eye { world, speculars: coloured.as_ref().unwrap_or(world.greys()), x, normal, sample };
    let found = look(&eye, s);
    s.coloured = coloured;
    found
}

/// Tells `visit` the directions in which a point sees sky and ground, finer than `width` radians, and keeps the `openings`
/// to the sky where these are wanted. Returns rays that chance chose.
pub fn visible_directions(
    world: &World,
    (x, normal): (DVec3, DVec3),
    sample: u64,
    (width, openings): (f64, Option<&mut Openings>),
    scratch: &mut super::DirectScratch,
    visit: &mut dyn FnMut(Seen<'_>),
) -> u64 {
    with_eye(world, (x, normal), sample, &mut scratch.sky, |eye, s| {
        eye.look((true, true), s, &mut Directions { width, count: 0, visit, openings, planes: Vec::new() })
    })
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
            if s.visible.clip(self.world, self.x, (self.normal, 0.0), polygon, s.blockers.iter().copied()) {
                let SkyScratch { visible, tint, .. } = s;
                visible.pieces.iter().for_each(|piece| out.piece(self, piece, group, tint));
                return 0;
            }
        }
        if depth == MAX_DEPTH {
            return self.sampled(polygon, group, path, s, out);
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

    /// What the panes of a piece leave of light in a direction; `each` is told of every pane and the cosine there.
    pub(super) fn at_panes(&self, panes: &[u32], direction: DVec3, mut each: impl FnMut(&Glazing, f64)) {
        for p in panes {
            let cosine = self.world.surfaces.list[*p as usize].normal.dot(direction).abs();
            if let Some(pane) = self.speculars.pane(self.world, *p) {
                each(pane, cosine);
            }
        }
    }

    /// Mean share left by the panes of a piece.
    fn passed(&self, panes: &[u32], direction: DVec3) -> f64 {
        let mut left = 1.0;
        self.at_panes(panes, direction, |pane, cosine| left *= pane.mean(cosine).passed);
        left
    }

    /// Light through the panes of a piece.
    pub(super) fn enter(
        &self,
        panes: &[u32],
        direction: DVec3,
        (group, value): (usize, f64),
        tint: &mut Tint,
        out: &mut [f64],
    ) {
        tint.reset();
        self.at_panes(panes, direction, |pane, cosine| tint.pass(pane, cosine, 1.0));
        deposit(out, group, value, tint);
    }

    /// Does a coloured pane stand before the piece that lets nothing by?
    pub(super) fn is_shut(&self, piece: &Piece) -> bool {
        piece.panes().iter().any(|p| self.speculars.pane(self.world, *p).is_none())
    }

    /// Luminance of a direction per unit of its group.
    fn luminance(&self, group: usize, direction: DVec3) -> f64 {
        if group == GROUND {
            return std::f64::consts::FRAC_1_PI;
        }
        self.world.daylight().and_then(|d| d.sky).map_or(0.0, |sky| sky.luminance(direction))
    }

    /// Sums the light of a piece, finely where a limit is set.
    fn integrate(&self, piece: &Piece, group: usize, limit: Option<f64>, tint: &mut Tint, out: &mut [f64]) {
        let is_flat = group == GROUND || self.world.daylight().and_then(|d| d.sky).is_some_and(|s| s.is_uniform());
        if is_flat && piece.panes().is_empty() {
            let seen = configuration_factor(&piece.polygon, self.normal);
            out[group] += if seen < DARK { 0.0 } else { seen };
            return;
        }
        if self.is_shut(piece) || configuration_factor(&piece.polygon, self.normal) < DARK {
            return;
        }
        let is_grey = piece.panes().iter().all(|p| self.speculars.pane(self.world, *p).is_some_and(Glazing::is_grey));
        let Some(limit) = limit else {
            self.points(&piece.polygon, ELEMENT_WIDTH, &mut |[a, b, c], weight| {
                let direction = (a + b + c).normalize();
                let value = weight * self.luminance(group, direction);
                if is_grey {
                    out[group] += value * self.passed(piece.panes(), direction);
                } else {
                    self.enter(piece.panes(), direction, (group, value), tint, out);
                }
            });
            return;
        };
        let light = |p: DVec3| {
            let squared = p.length_squared();
            let length = squared.sqrt();
            let direction = p / length;
            self.luminance(group, direction) * self.normal.dot(direction).max(0.0) / (squared * length)
        };
        let left = |p: DVec3| light(p) * self.passed(piece.panes(), p.normalize());
        // The fan begins at the highest corner: clipping begins where rounding likes.
        let n = piece.polygon.len();
        let high = |k: &usize| self.normal.dot(piece.polygon[*k].normalize());
        let top = (0..n).max_by(|a, b| high(a).total_cmp(&high(b))).unwrap_or(0);
        let corner = |k: usize| piece.polygon[(top + k) % n];
        let first = corner(0);
        for k in 1..n - 1 {
            let triangle = [first, corner(k), corner(k + 1)];
            let volume = first.dot(triangle[1].cross(triangle[2])).abs();
            spherical::triangle_nodes(
                &left,
                triangle,
                (limit, QUADRATURE_DEPTH),
                0.5 * volume,
                &mut |p, weight, value| {
                    if is_grey {
                        out[group] += weight * value;
                    } else {
                        self.enter(piece.panes(), p.normalize(), (group, weight * light(p)), tint, out);
                    }
                },
            );
        }
    }

    /// Divides a cone into spherical triangles finer than `width` radians, each with its projected solid angle, sr.
    pub(super) fn points(&self, polygon: &[DVec3], width: f64, visit: &mut impl FnMut([DVec3; 3], f64)) {
        let first = polygon[0].normalize();
        let least = width.cos();
        for e in polygon.windows(2).skip(1) {
            let triangle = [first, e[0].normalize(), e[1].normalize()];
            spherical::parts(triangle, least, &mut |[a, b, c], solid_angle| {
                let cosine = self.normal.dot(a + b + c).max(0.0) / (a + b + c).length();
                visit([a, b, c], solid_angle * cosine);
            });
        }
    }

    /// A direction anywhere in a triangle, see [`spherical::anywhere`].
    fn anywhere(&self, triangle: [DVec3; 3], number: u64) -> (DVec3, f64) {
        let chance = seed(&[self.sample, number]);
        spherical::anywhere(triangle, (unit(chance >> 32), unit(chance & 0xFFFF_FFFF)))
    }

    /// Directions anywhere in the triangles of a cone, each with the projected solid angle that it stands for, sr.
    pub(super) fn somewhere(&self, polygon: &[DVec3], width: f64, visit: &mut impl FnMut(DVec3, f64)) {
        let mut count = 0;
        self.points(polygon, width, &mut |triangle, _| {
            count += 1;
            let (direction, solid_angle) = self.anywhere(triangle, count);
            visit(direction, solid_angle * self.normal.dot(direction).max(0.0));
        });
    }

    /// A cell with too many blockers: well-spread rays.
    fn sampled(&self, polygon: &[DVec3], group: usize, path: u64, s: &mut SkyScratch, out: &mut impl Receiver) -> u64 {
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
                s.tint.reset();
                s.through.clear();
                let each = |pane| s.through.push(pane);
                if pass(self.world, self.speculars, (self.x, direction), MISS, &mut s.tint, &mut rays, each) {
                    out.ray(self, direction, (&s.tint, &s.through), weight / f64::from(CELL_RAYS), group);
                }
            }
        }
        rays
    }
}

/// A whole number below 2^32 as a share of one.
fn unit(number: u64) -> f64 {
    number as f64 / 4_294_967_296.0
}

/// Does light come from outside to `x` along `−direction`? What panes on the way leave of it multiplies `tint`; all else
/// blocks.
pub fn pass_out(
    world: &World,
    speculars: &Speculars,
    x: DVec3,
    direction: DVec3,
    tint: &mut Tint,
    rays: &mut u64,
) -> bool {
    pass(world, speculars, (x, direction), MISS, tint, rays, |_| {})
}

/// The same from a surface, or from outside where that is [`MISS`]; `each` is told of every pane on the way.
pub(super) fn pass(
    world: &World,
    speculars: &Speculars,
    (x, direction): (DVec3, DVec3),
    source: u32,
    tint: &mut Tint,
    rays: &mut u64,
    mut each: impl FnMut(u32),
) -> bool {
    let mut start = x;
    for _ in 0..16 {
        let ray = Ray::new(start, direction);
        let hit = world.caster.closest(&ray);
        *rays += 1;
        if hit.surface == source {
            return true;
        }
        if hit.surface == MISS {
            return false;
        }
        let Some(pane) = speculars.pane(world, hit.surface) else { return false };
        let cosine = world.surfaces.list[hit.surface as usize].normal.dot(direction).abs();
        tint.pass(pane, cosine, 1.0);
        each(hit.surface);
        start = ray.at(hit.t) + direction * world.skin();
    }
    false
}

/// Smaller cones that make up one: triangles of a polygon, quarters of a triangle.
fn divide(polygon: &[DVec3]) -> Vec<Vec<DVec3>> {
    if let [a, b, c] = *polygon {
        let (ab, bc, ca) = ((a + b).normalize(), (b + c).normalize(), (c + a).normalize());
        return vec![vec![a, ab, ca], vec![ab, b, bc], vec![ca, bc, c], vec![ab, bc, ca]];
    }
    polygon.windows(2).skip(1).map(|e| vec![polygon[0], e[0], e[1]]).collect()
}
