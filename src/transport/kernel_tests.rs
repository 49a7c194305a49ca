//! Rays against triangles: packets, single rays and every triangle by itself.

use glam::{DVec3, Vec3A};

use super::super::bvh::Triangle;
use super::super::points::Points;
use super::*;

/// Numbers in `[0, 1)` that do not repeat.
struct Draw {
    points: Points,
    next: u32,
}

impl Draw {
    fn new(seed: u64) -> Self {
        Self { points: Points::new(seed), next: 0 }
    }

    fn three(&mut self) -> Vec3A {
        self.next += 1;
        Vec3A::from_array([0, 1, 2].map(|d| self.points.get(self.next, d) as f32))
    }
}

/// A room about the unit cube, triangles of all sizes in it, and a lattice of walls that share edges and planes.
fn scene(seed: u64, loose: usize) -> Vec<Triangle> {
    let mut draw = Draw::new(seed);
    let mut triangles = Vec::new();
    let mut quad = |a: Vec3A, u: Vec3A, v: Vec3A| {
        let surface = triangles.len() as u32 / 2;
        triangles.push(Triangle { vertices: [a, a + u, a + u + v], surface });
        triangles.push(Triangle { vertices: [a, a + u + v, a + v], surface });
    };
    for (u, v, w) in [(Vec3A::X, Vec3A::Y, Vec3A::Z), (Vec3A::Y, Vec3A::Z, Vec3A::X), (Vec3A::Z, Vec3A::X, Vec3A::Y)] {
        quad(Vec3A::ZERO, u, v);
        quad(w, u, v);
        for k in 0..4 {
            quad(0.5 * w + 0.25 * k as f32 * u, 0.25 * u, 0.5 * v);
        }
    }
    for k in 0..loose {
        let (a, u, v) = (draw.three(), draw.three() - 0.5, draw.three() - 0.5);
        let size = 0.4 * draw.three().x.powi(3);
        let vertices = [a, a + size * u, a + size * v];
        let surface = 30 + k as u32;
        triangles.push(Triangle { vertices, surface });
        if k % 10 == 0 {
            // Another surface in the same place, and a triangle without a face.
            triangles.push(Triangle { vertices, surface: 9_000 - k as u32 });
            triangles.push(Triangle { vertices: [a, a, a + u], surface });
        }
    }
    triangles
}

/// Rays that strain the tests, in no order, with what coherent packets see among them.
fn rays(triangles: &[Triangle], seed: u64) -> Vec<Ray> {
    let mut draw = Draw::new(seed);
    let mut rays = Vec::new();
    let mut add = |origin: Vec3A, direction: Vec3A, t_max: f32| {
        rays.push(Ray { origin: origin.to_array(), direction: direction.to_array(), t_max });
    };
    let infinity = f32::INFINITY;
    for k in 0..400 {
        let t = &triangles[(k * 7) % triangles.len()];
        let [a, b, c] = t.vertices;
        let (from, w) = (draw.three(), draw.three());
        let aim = |to: Vec3A| (to - from).normalize_or(Vec3A::X);
        let on = a + w.x * (1.0 - w.y) * (b - a) + w.x * w.y * (c - a);
        let anywhere = (draw.three() - 0.5).normalize_or(Vec3A::Y);
        add(from, anywhere, infinity);
        // Along the axes, with noughts of both signs, from the middle of walls that rays of other axes lie in.
        for axis in 0..3 {
            let mut d = Vec3A::splat(if k % 2 == 0 { 0.0 } else { -0.0 });
            d[axis] = if k % 3 == 0 { -1.0 } else { 1.0 };
            add(from, d, infinity);
            add((from * 4.0).round() / 4.0, d, infinity);
            d[(axis + 1) % 3] = 1e-38;
            add(from, d.normalize(), infinity);
        }
        // Through vertices and edges, and from there.
        add(from, aim(a), infinity);
        add(from, aim(a.midpoint(b)), infinity);
        add(from, aim(a + w.x * (c - a)), infinity);
        add(a, anywhere, infinity);
        add(a.midpoint(c), anywhere, infinity);
        // From a surface, and along its plane.
        add(on, anywhere, infinity);
        add(on, (b - a).normalize_or(Vec3A::Z), infinity);
        add(on - 2.0 * (c - on), (c - on).normalize_or(Vec3A::Z), infinity);
        // Ends: just before, at and beyond what is met; none; at once.
        let distance = from.distance(on);
        for t_max in [distance * 0.999_999, distance, distance * 1.000_001, 0.0, 1e-30, f32::MAX] {
            add(from, aim(on), t_max);
        }
        // From far away.
        add(from - 1e4 * anywhere, anywhere, infinity);
        add(from - 1e7 * anywhere, anywhere, infinity);
        // No direction, and no place.
        add(from, Vec3A::ZERO, infinity);
        add(Vec3A::NAN, anywhere, infinity);
        add(from, Vec3A::NAN, infinity);
        add(Vec3A::INFINITY, anywhere, infinity);
        // Neighbours, as tiles are.
        for i in 0..16 {
            let to = on + 0.05 * Vec3A::new((i % 4) as f32, (i / 4) as f32, 0.0);
            add(from, aim(to), if i == 5 { 0.1 } else { infinity });
        }
    }
    rays
}

fn cast<L: Lanes>(tree: &Tree, rays: &[Ray]) -> Vec<Hit> {
    let mut hits = vec![Hit { t: 0.0, surface: 0 }; rays.len()];
    let (packets, rest) = rays.as_chunks::<PACKET>();
    let (to, last) = hits.split_at_mut(packets.len() * PACKET);
    packets_by::<L>(tree, packets, to.as_chunks_mut::<PACKET>().0);
    singles_by::<L>(tree, rest, last);
    hits
}

fn bits(hits: &[Hit]) -> Vec<(u32, u32)> {
    hits.iter().map(|h| (h.t.to_bits(), h.surface)).collect()
}

#[test]
fn packets_and_single_rays_meet_the_same_to_the_last_bit() {
    for (seed, loose) in [(1, 0), (2, 30), (3, 700), (4, 8_000)] {
        let triangles = scene(seed, loose);
        let tree = Tree::build(&triangles);
        let rays = rays(&triangles, 10 + seed);
        let singly: Vec<Hit> = rays.iter().flat_map(|r| cast::<Plain>(&tree, std::slice::from_ref(r))).collect();
        assert_eq!(bits(&cast::<Plain>(&tree, &rays)), bits(&singly), "packets of {loose}");
        // The order in which rays are handed over decides about their packets, and nothing else.
        for stride in [7, 193] {
            let place = |k: usize| k * stride % rays.len();
            let shuffled: Vec<Ray> = (0..rays.len()).map(|k| rays[place(k)]).collect();
            let expected: Vec<Hit> = (0..rays.len()).map(|k| singly[place(k)]).collect();
            assert_eq!(bits(&cast::<Plain>(&tree, &shuffled)), bits(&expected), "{loose} in steps of {stride}");
        }
        // What the machine has.
        let mut hits = singly.clone();
        closest(&tree, &rays, &mut hits);
        assert_eq!(bits(&hits), bits(&singly), "packets by wide instructions, {loose}");
        for (ray, hit) in rays.iter().zip(&mut hits) {
            closest(&tree, std::slice::from_ref(ray), std::slice::from_mut(hit));
        }
        assert_eq!(bits(&hits), bits(&singly), "single rays by wide instructions, {loose}");
    }
}

/// Distance along a ray in double precision, with how clearly it is met or missed: the least share of a corner.
fn exact(ray: &Ray, triangle: &Triangle) -> Option<(f64, f64)> {
    let (o, d) = (DVec3::from(ray.origin.map(f64::from)), DVec3::from(ray.direction.map(f64::from)));
    let [a, b, c] = triangle.vertices.map(|v| v.as_dvec3());
    let normal = (b - a).cross(c - a);
    let steep = normal.dot(d);
    if steep.abs() < 1e-9 * normal.length() {
        return None;
    }
    let t = normal.dot(a - o) / steep;
    let p = o + d * t;
    let share = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) / normal.length_squared();
    Some((t, share(a, b).min(share(b, c)).min(share(c, a))))
}

#[test]
fn the_closest_hit_is_the_nearest_of_all_triangles() {
    let triangles = scene(5, 700);
    let tree = Tree::build(&triangles);
    let mut draw = Draw::new(6);
    let rays: Vec<Ray> = (0..4_096)
        .map(|_| {
            let (origin, direction) = (draw.three(), (draw.three() - 0.5).normalize());
            Ray { origin: origin.to_array(), direction: direction.to_array(), t_max: f32::INFINITY }
        })
        .collect();
    let mut hits = cast::<Plain>(&tree, &rays);
    closest(&tree, &rays, &mut hits);
    let mut told = 0;
    for (ray, hit) in rays.iter().zip(&hits) {
        let met: Vec<(f64, f64, u32)> =
            triangles.iter().filter_map(|t| exact(ray, t).map(|(at, share)| (at, share, t.surface))).collect();
        // Corners are known to 2^-24 of the unit cube, shares of the smallest triangles' to some thousandths.
        let near_edge = met.iter().any(|(at, share, _)| *at > -1e-3 && share.abs() < 1e-2);
        let ahead = met.iter().filter(|(at, share, _)| *share > 0.0 && *at > 0.0);
        let (t, _, _) = ahead.clone().copied().min_by(|a, b| a.0.total_cmp(&b.0)).expect("the room is closed");
        let nearest: Vec<u32> = ahead.filter(|(at, _, _)| *at < t + 1e-4).map(|(_, _, surface)| *surface).collect();
        if near_edge || t < 1e-4 {
            continue;
        }
        told += 1;
        assert!((f64::from(hit.t) - t).abs() < 1e-4, "{ray:?}: {hit:?} in place of {t}");
        assert!(nearest.contains(&hit.surface), "{ray:?}: {hit:?} in place of {nearest:?} at {t}");
    }
    assert!(told > 500, "only {told} rays are clear of all edges");
}

#[test]
fn of_surfaces_in_one_place_the_first_is_met() {
    let triangles = scene(7, 300);
    let reversed: Vec<Triangle> = triangles.iter().rev().copied().collect();
    let (one, other) = (Tree::build(&triangles), Tree::build(&reversed));
    let mut twice = 0;
    for first in triangles.iter().filter(|t| t.surface >= 30 && t.surface < 330 && (t.surface - 30) % 10 == 0) {
        let [a, b, c] = first.vertices;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        if a == b || normal == Vec3A::ZERO {
            continue;
        }
        let from = (a + b + c) / 3.0 + 1e-3 * normal;
        let ray = Ray { origin: from.to_array(), direction: (-normal).to_array(), t_max: 2e-3 };
        let hits = [cast::<Plain>(&one, &[ray])[0], cast::<Plain>(&other, &[ray])[0]];
        twice += u32::from(hits[0].surface == first.surface);
        assert!(hits[0].surface < 400, "the second of two in {ray:?}");
        assert_eq!(bits(&hits[..1]), bits(&hits[1..]));
    }
    assert!(twice > 20, "{twice} of 30");
}

#[test]
fn no_ray_slips_between_triangles_that_share_an_edge() {
    let triangles = scene(8, 0);
    let tree = Tree::build(&triangles);
    let rays = rays(&triangles, 9);
    let inside = |r: &&Ray| {
        r.origin.iter().all(|x| *x > 0.0 && *x < 1.0)
            && r.t_max == f32::INFINITY
            && (Vec3A::from(r.direction).length() - 1.0).abs() < 1e-3
    };
    let rays: Vec<Ray> = rays.iter().filter(inside).copied().collect();
    assert!(rays.len() > 5_000);
    assert!(cast::<Plain>(&tree, &rays).iter().all(|h| h.surface != EMPTY), "the room is closed");
}
