//! A point source so close to an element that places on it would miss its light.
//!
//! The illuminance under a point at height `h` is `I / h²` on a spot as wide as `h`. Its flux on the element is that of the
//! solid angle that the element fills, however near: `∫ I dω`, from directions in place of places.

use glam::DVec3;

use super::direct::DirectScratch;
use super::hung::passed;
use super::points::Points;
use super::spherical;
use super::world::World;
use crate::light::{Luminaire, Shape};

/// Distance to a polygon's middle over its radius below which a point is close.
const CLOSE: f64 = 2.0;
/// Cosine of the widest piece that one direction stands for.
const WIDE: f64 = 0.9;

/// Is a luminaire a point that lies close before a polygon, but not on its skin?
pub(super) fn is_close(l: &Luminaire, polygon: &[DVec3], normal: DVec3, skin: f64) -> bool {
    let middle = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
    let reach = polygon.iter().map(|p| p.distance_squared(middle)).fold(0.0, f64::max);
    matches!(l.shape, Shape::Point)
        && l.position.distance_squared(middle) < CLOSE * CLOSE * reach
        && normal.dot(l.position - polygon[0]) > skin
}

/// Mean illuminance of a convex polygon by a point source close to it, lx; `sample` seeds the directions.
pub(super) fn mean_lx(
    world: &World,
    l: &Luminaire,
    (polygon, area): (&[DVec3], f64),
    normal: DVec3,
    sample: u64,
    s: &mut DirectScratch,
) -> f64 {
    let height = normal.dot(l.position - polygon[0]);
    let directions: Vec<DVec3> = polygon.iter().map(|p| (*p - l.position).normalize()).collect();
    let points = Points::new(sample);
    let (mut lumens, mut count) = (0.0, 0);
    for corner in directions.windows(2).skip(1) {
        spherical::parts([directions[0], corner[0], corner[1]], WIDE, &mut |triangle, solid_angle| {
            let (direction, _) = spherical::anywhere(triangle, points.pair(count, 0));
            count += 1;
            let light = solid_angle * l.intensity(direction);
            if light > 0.0 {
                let place = l.position - direction * (height / normal.dot(direction));
                let place = world.lift(place, normal);
                lumens += light * passed(world, place, l.position - place, -l.axes.z_axis, s);
            }
        });
    }
    lumens / (area * world.surfaces.frame.area_m2())
}
