//! Sensors made ready: snapped to the surface they lie on, and told whether they can see anything.

use glam::DVec3;

use super::receiver::Facing;
use super::result::Status;
use crate::scene::{Receiver, Sensor};
use crate::transport::caster::{MISS, Ray};
use crate::transport::points::Points;
use crate::transport::{World, cosine_direction};

/// Distance, in units of the scene's size, within which a sensor lies on a surface.
const ON_SURFACE: f64 = 1e-5;
/// Height of the eye, in units of the scene's size: a sensor on the floor of a wide site must not float above it. Eight
/// times what single precision leaves of a place.
const EYE: f64 = 5e-7;
/// Rays that look whether a point is inside a solid.
const LOOKS: u32 = 16;

/// A sensor in the program's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    /// Where rays start.
    pub(super) position: DVec3,
    /// Where light is measured that needs no ray.
    pub(super) eye: DVec3,
    /// Normal of a plane, the vertical for bodies.
    pub(super) normal: DVec3,
    pub(super) facing: Facing,
    pub(super) status: Status,
}

impl Probe {
    pub(super) fn new(world: &World, sensor: &Sensor, receiver: Receiver) -> Self {
        let normal = if receiver == Receiver::Plane { sensor.normal } else { DVec3::Z };
        let facing = Facing::new(receiver, sensor.normal);
        let mut position = world.surfaces.frame.to_local(sensor.position);
        let mut eye = position;
        let on = surface_below(world, position, normal);
        if let Some((surface, front)) = on {
            let s = &world.surfaces.list[surface];
            let foot = s.point(s.uv(position));
            position = world.lift(foot, s.side_normal(front));
            eye = foot + s.side_normal(front) * EYE;
        }
        let status = match (hidden(world, position, normal), on) {
            (false, _) => Status::Ok,
            (true, Some(_)) => Status::Covered,
            (true, None) => Status::Inside,
        };
        Self { position, eye, normal, facing, status }
    }
}

/// The surface that a point lies on with the given normal, and which side faces that way.
pub(super) fn surface_below(world: &World, p: DVec3, normal: DVec3) -> Option<(usize, bool)> {
    let ray = Ray::to(p + normal * ON_SURFACE, -normal, (2.0 * ON_SURFACE) as f32);
    let hit = world.caster.closest(&ray);
    if hit.surface == MISS {
        return None;
    }
    let cosine = world.surfaces.list[hit.surface as usize].normal.dot(normal);
    (cosine.abs() > 0.9999).then_some((hit.surface as usize, cosine > 0.0))
}

/// Do most rays meet the inside of a solid first?
pub(super) fn hidden(world: &World, p: DVec3, normal: DVec3) -> bool {
    let points = Points::new(0);
    let inside = (0..LOOKS).filter(|k| {
        let (a, b) = points.pair(*k, 0);
        let direction = cosine_direction(normal, a, b);
        let hit = world.caster.closest(&Ray::new(p, direction));
        hit.surface != MISS && {
            let s = &world.surfaces.list[hit.surface as usize];
            s.solid && s.normal.dot(direction) > 0.0
        }
    });
    inside.count() as u32 * 2 > LOOKS
}
