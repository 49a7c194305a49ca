//! Direct light of luminaires: the luminous shape that a point sees, exactly clipped, with the intensity of each direction.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::direct::{DirectScratch, FEW_RAYS, MANY_RAYS, MAX_BLOCKERS, ROUGH_RAYS, transmittance_to};
use super::points::Points;
use super::visible::cone_planes;
use super::world::{Kind, World};
use crate::light::{Luminaire, LuminousFace, Shape, above_plane, configuration_factor};
use crate::mesh::sample_polygon;

/// Radius of a piece over its distance up to which its middle and corners tell its light: for points reported (0.1 % of a
/// cos³ panel at half its width), for elements.
const FINE: f64 = 0.125;
const COARSE: f64 = 0.5;
/// Halvings of a piece, at most.
const MAX_HALVINGS: u32 = 14;
/// Points of a line over its length in units of the distance.
const LINE_POINTS: f64 = 6.0;
/// No surface.
const NONE: usize = usize::MAX;

/// Illuminance of one luminaire at a point with a normal, lx; `sample` seeds the shadow rays where they are needed.
pub(super) fn luminaire_lx(
    world: &World,
    l: &Luminaire,
    x: DVec3,
    normal: DVec3,
    sample: u64,
    s: &mut DirectScratch,
) -> f64 {
    if !l.corners.iter().any(|c| normal.dot(*c - x) > 0.0) {
        return 0.0;
    }
    let unit = 1.0 / world.surfaces.frame.area_m2();
    unit * match &l.shape {
        Shape::Point => from_point(world, l, l.position, x, normal, s),
        Shape::Line([from, to]) => {
            let near = (0.5 * (*from + *to) - x).length().max(1e-9);
            let count = (LINE_POINTS * from.distance(*to) / near).ceil().clamp(1.0, 64.0) as u32;
            let place = |k: u32| from.lerp(*to, (f64::from(k) + 0.5) / f64::from(count));
            (0..count).map(|k| from_point(world, l, place(k), x, normal, s)).sum::<f64>() / f64::from(count)
        }
        Shape::Faces(faces) => faces
            .iter()
            .enumerate()
            .map(|(k, f)| from_face(world, (l, f), x, normal, sample ^ ((k as u64) << 24), s))
            .sum(),
    }
}

/// `I cos θ / r²`, shadowed; per square of the frame's unit.
fn from_point(world: &World, l: &Luminaire, place: DVec3, x: DVec3, normal: DVec3, s: &mut DirectScratch) -> f64 {
    let d = place - x;
    let cosine = normal.dot(d);
    if cosine <= 0.0 {
        return 0.0;
    }
    let light = l.intensity(-d) * cosine / d.length().powi(3);
    if light > 0.0 { light * passed(world, x, d, -l.axes.z_axis, s) } else { 0.0 }
}

/// What is left of light from `x + d` at `x`. A luminaire may lie in the plane of its ceiling, which must not shade it: the
/// shadow ray ends a skin's thickness `out` of it.
pub(super) fn passed(world: &World, x: DVec3, d: DVec3, out: DVec3, s: &mut DirectScratch) -> f64 {
    transmittance_to(world, x, d + out * world.skin(), NONE, s)
}

fn from_face(
    world: &World,
    (l, face): (&Luminaire, &LuminousFace),
    x: DVec3,
    normal: DVec3,
    sample: u64,
    s: &mut DirectScratch,
) -> f64 {
    let emitter = face.surface.normal;
    let height = face.surface.height(x);
    if height <= 1e-9 {
        return 0.0; // behind the face or in its plane
    }
    s.whole.clear();
    s.whole.extend(face.hull.iter().map(|v| *v - x));
    above_plane(&s.whole, normal, 0.0, &mut s.polygon);
    if s.polygon.len() < 3 {
        return 0.0;
    }
    // Only what lies between the point and the face's plane can block.
    let between = (emitter, -height * (1.0 - 1e-9));
    if s.hidden_again(world, x, between) {
        return 0.0;
    }
    cone_planes(&s.polygon, &mut s.planes);
    let ceiling = (emitter, emitter.dot(face.surface.vertices[0]));
    let all = s.planes.len() <= 15 && world.caster.in_cone(x, &s.planes, ceiling, MAX_BLOCKERS, &mut s.blockers);
    let few = all && !s.blockers.iter().any(|b| world.kind(*b) == Kind::Glass);
    s.whole.clear();
    s.whole.extend(face.surface.vertices.iter().map(|v| *v - x));
    above_plane(&s.whole, normal, 0.0, &mut s.polygon);
    if s.polygon.len() < 3 {
        return 0.0;
    }
    s.factors += 1;
    let close = if s.is_one_of_many { COARSE } else { FINE };
    if few && s.visible.clip(world, x, between, &s.polygon, s.blockers.iter().copied()) {
        s.remember();
        return s.visible.pieces.iter().map(|p| light_of(l, &p.polygon, normal, close, MAX_HALVINGS)).sum();
    }
    let whole = light_of(l, &s.polygon, normal, close, MAX_HALVINGS);
    if whole > 0.0 { whole * visible_share(world, (l, face), x, normal, sample, s) } else { 0.0 }
}

/// Light of a piece of a luminous face seen from the origin, without blockers: its exact configuration factor times the
/// mean luminance towards the origin, halved until that is smooth over it.
fn light_of(l: &Luminaire, piece: &[DVec3], normal: DVec3, close: f64, halvings: u32) -> f64 {
    let middle = piece.iter().copied().sum::<DVec3>() / piece.len() as f64;
    let reach = piece.iter().map(|v| v.distance(middle)).fold(0.0, f64::max);
    if halvings == 0 || reach <= close * middle.length() {
        let factor = configuration_factor(piece, normal);
        return if factor > 0.0 { PI * factor * luminance(l, piece, middle, normal) } else { 0.0 };
    }
    let across = longest_side(piece);
    let offset = across.dot(middle);
    let mut half = Vec::with_capacity(piece.len() + 1);
    let mut sum = 0.0;
    for side in [1.0, -1.0] {
        above_plane(piece, across * side, offset * side, &mut half);
        if half.len() >= 3 {
            sum += light_of(l, &half, normal, close, halvings - 1);
        }
    }
    sum
}

fn longest_side(piece: &[DVec3]) -> DVec3 {
    let sides = (0..piece.len()).map(|k| piece[(k + 1) % piece.len()] - piece[k]);
    // The first of equal sides, whatever the last bits say.
    sides.fold(DVec3::ZERO, |best, e| if e.length_squared() > best.length_squared() * (1.0 + 1e-9) { e } else { best })
}

/// Mean luminance of a piece towards the origin, from its middle and its corners, each with the kernel of a small area there.
///
/// Corners weigh `(2 + cos(2π/n))/6` together: exact for quadratics over a triangle, a parallelogram and a regular polygon.
fn luminance(l: &Luminaire, piece: &[DVec3], middle: DVec3, normal: DVec3) -> f64 {
    let n = piece.len() as f64;
    let corners = (2.0 + (TAU / n).cos()) / 6.0;
    let (mut light, mut area) = (0.0, 0.0);
    for (p, weight) in piece.iter().map(|v| (*v, corners / n)).chain([(middle, 1.0 - corners)]) {
        let r = p.length();
        let kernel = weight * normal.dot(p).max(0.0) / (r * r * r);
        if kernel > 0.0 {
            light += kernel * l.intensity(-p);
            area += kernel * l.projected_area(-p) / r;
        }
    }
    if area > 0.0 { light / area } else { 0.0 }
}

/// Share of a face's light that reaches the point, by shadow rays weighted with what each place sends.
fn visible_share(
    world: &World,
    (l, face): (&Luminaire, &LuminousFace),
    x: DVec3,
    normal: DVec3,
    sample: u64,
    s: &mut DirectScratch,
) -> f64 {
    let points = Points::new(sample);
    let surface = &face.surface;
    let (few, many) = if s.is_one_of_many { (ROUGH_RAYS, ROUGH_RAYS) } else { (FEW_RAYS, MANY_RAYS) };
    let (mut seen, mut all) = (0.0, 0.0);
    let mut count = few;
    let mut k = 0;
    while k < count {
        let (a, b) = points.pair(k, 0);
        let d = surface.point(sample_polygon(&surface.outline, a, b)) - x;
        let area = l.projected_area(-d);
        let cosines = normal.dot(d).max(0.0) * -surface.normal.dot(d);
        if area > 0.0 && cosines > 0.0 {
            let weight = l.intensity(-d) * cosines / (area * d.length().powi(3));
            if weight > 0.0 {
                all += weight;
                seen += weight * passed(world, x, d, surface.normal, s);
            }
        }
        k += 1;
        if k == few && seen > 0.0 && seen < all {
            count = many;
        }
    }
    if all > 0.0 { seen / all } else { 0.0 }
}

/// Illuminance at a point with a normal by one place of a luminaire's shape, lx: an unbiased estimate where `a` and `b`
/// are even random numbers.
#[must_use]
pub fn one_place_lx(
    world: &World,
    l: &Luminaire,
    x: DVec3,
    normal: DVec3,
    (a, b): (f64, f64),
    s: &mut DirectScratch,
) -> f64 {
    let (place, face_normal, area) = l.place(a, b);
    let d = place - x;
    let mut cosines = normal.dot(d);
    if cosines <= 0.0 {
        return 0.0;
    }
    let r = d.length();
    // The share of the intensity that a small area there gives: A cos θ / Σ A cos θ.
    if let Some(face_normal) = face_normal {
        let projected = l.projected_area(-d);
        cosines *= if projected > 0.0 { area * (-face_normal.dot(d)).max(0.0) / projected } else { 0.0 };
    }
    let light = l.intensity(-d) * cosines / (r * r * r);
    if light <= 0.0 {
        return 0.0;
    }
    light * passed(world, x, d, face_normal.unwrap_or(-l.axes.z_axis), s) / world.surfaces.frame.area_m2()
}

/// Places of a luminaire that an eye looks at.
const LOOKS: u32 = 64;

/// A luminaire as an eye sees it: its luminance, cd/m², and the solid angle of what is seen of it, sr; `None` for points and
/// lines, and where nothing of it shines here.
#[must_use]
pub fn luminaire_in_sight(world: &World, l: &Luminaire, eye: DVec3, s: &mut DirectScratch) -> Option<(f64, f64)> {
    let towards = eye - l.position;
    let area = l.projected_area(towards) / towards.length() * world.surfaces.frame.area_m2();
    let luminance = if area > 0.0 { l.intensity(towards) / area } else { 0.0 };
    if luminance <= 0.0 {
        return None;
    }
    let points = Points::new(0);
    let mut solid_angle = 0.0;
    for k in 0..LOOKS {
        let (a, b) = points.pair(k, 0);
        let (place, Some(normal), all) = l.place(a, b) else { return None };
        let d = place - eye;
        let cosine = -normal.dot(d);
        if cosine > 0.0 && passed(world, eye, d, normal, s) > 0.0 {
            solid_angle += all * cosine / (d.length().powi(3) * f64::from(LOOKS));
        }
    }
    (solid_angle > 0.0).then_some((luminance, solid_angle))
}

impl World {
    /// What a ray sees of luminaires before `t_max`: the group, and π times the luminance per lumen's spectrum.
    #[must_use]
    pub fn luminaire_seen(&self, from: DVec3, direction: DVec3, t_max: f64) -> Option<(usize, f64)> {
        let mut nearest = t_max;
        let mut seen = None;
        for l in &self.emitters.luminaires {
            let Shape::Faces(faces) = &l.shape else { continue };
            for face in faces {
                let slope = face.surface.normal.dot(direction);
                let t = -face.surface.height(from) / slope;
                if slope < 0.0 && t > 0.0 && t <= nearest * (1.0 + 1e-6) && holds(&face.surface, from + direction * t) {
                    nearest = t;
                    let area = l.projected_area(-direction) * self.surfaces.frame.area_m2();
                    seen = Some((l.group, PI * l.intensity(-direction) / area));
                }
            }
        }
        seen
    }
}

/// Does a point of a face's plane lie in it?
fn holds(surface: &crate::mesh::Surface, p: DVec3) -> bool {
    let uv = surface.uv(p);
    let n = surface.outline.len();
    (0..n).all(|k| (surface.outline[(k + 1) % n] - surface.outline[k]).perp_dot(uv - surface.outline[k]) >= 0.0)
}
