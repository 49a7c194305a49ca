//! Lamps that an element cannot see at all: found once for the element, not at each of its places.

use glam::{DVec2, DVec3};

use super::caster::{MISS, Ray};
use super::visible::Visible;
use super::world::{Kind, World};
use crate::mesh::Surface;

/// Distance from a plane, in units of the scene's size, below which a point lies in it.
const TOUCH: f64 = 1e-9;

/// Surfaces in one plane that together hide a lamp, at most: the parts of a wall about its doors.
const MAX_PARTS: usize = 6;

/// Do opaque surfaces in one plane hide `target`, the corners of a convex body on a surface of its own or on none, from every point of the convex polygon `from`? They are looked for by
/// rays from its middle.
///
/// Where a plane parts two convex polygons, every line between them goes through it within the hull of the places where
/// the lines between their vertices do: that hull has to be covered.
pub(super) fn hidden(
    world: &World,
    from: &[DVec3],
    normal: DVec3,
    target: (&[DVec3], usize),
    visible: &mut Visible,
    rays: &mut u64,
) -> bool {
    let middle = |p: &[DVec3]| p.iter().copied().sum::<DVec3>() / p.len() as f64;
    let x = world.lift(middle(from), normal);
    let mut way = middle(target.0) - x;
    let mut parts: Vec<u32> = Vec::new();
    let mut shadow: Vec<DVec3> = Vec::new();
    while parts.len() < MAX_PARTS {
        let distance = way.length();
        *rays += 1;
        // A little beyond, for the later ones aim at the plane itself.
        let reach = if parts.is_empty() { 1.0 - 1e-6 } else { 1.0 + 1e-4 };
        let hit = world.caster.closest(&Ray::to(x, way / distance, (distance * reach) as f32));
        let opaque = hit.surface != MISS && world.kind(hit.surface) != Kind::Glass;
        if !opaque || hit.surface as usize == target.1 || parts.contains(&hit.surface) {
            return false;
        }
        let part = &world.surfaces.list[hit.surface as usize];
        if let Some(first) = parts.first() {
            let first = &world.surfaces.list[*first as usize];
            if !part.vertices.iter().all(|v| first.height(*v).abs() < TOUCH) {
                return false;
            }
        } else if let Some(outline) = shadow_of(part, from, target.0) {
            shadow = outline.iter().map(|uv| part.point(*uv) - x).collect();
        } else {
            return false;
        }
        parts.push(hit.surface);
        let anything = (normal, f64::NEG_INFINITY);
        if !visible.clip(world, x, anything, &shadow, parts.iter().copied()) {
            return false;
        }
        let Some(piece) = visible.pieces.first() else { return true };
        way = middle(&piece.polygon);
    }
    false
}

/// Hull, in the plane of a surface that parts two convex polygons, of all lines between them.
fn shadow_of(plane: &Surface, from: &[DVec3], to: &[DVec3]) -> Option<Vec<DVec2>> {
    let mut places = Vec::with_capacity(from.len() * to.len());
    for p in from {
        for q in to {
            let (a, b) = (plane.height(*p), plane.height(*q));
            if a.abs() < TOUCH || b.abs() < TOUCH || (a > 0.0) == (b > 0.0) {
                return None;
            }
            places.push(plane.uv(p.lerp(*q, a / (a - b))));
        }
    }
    let hull = convex_hull(places);
    (hull.len() >= 3).then_some(hull)
}

/// Counter-clockwise (Andrew 1979).
fn convex_hull(mut places: Vec<DVec2>) -> Vec<DVec2> {
    places.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |places: &mut dyn Iterator<Item = &DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for p in places {
            while let [.., a, b] = chain[..] {
                if (b - a).perp_dot(*p - a) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut places.iter());
    hull.extend(half(&mut places.iter().rev()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::polygon_area;

    #[test]
    fn the_hull_goes_around_all_places() {
        let places = [(0.0, 0.0), (1.0, 0.0), (0.5, 0.4), (1.0, 1.0), (0.0, 1.0), (0.5, 0.0)];
        let hull = convex_hull(places.map(|(x, y)| DVec2::new(x, y)).to_vec());
        assert_eq!(hull.len(), 4);
        assert!((polygon_area(&hull) - 1.0).abs() < 1e-15);
    }
}
