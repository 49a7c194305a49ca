//! One stage at a time: rays and direct light in the Cornell box, in a hall of 20,000 triangles and in a town of a million.

mod common;

use std::f64::consts::TAU;
use std::path::Path;
use std::time::Duration;

use clerestory::scene::{Build, Emission, Material, MaterialKind, Scene, load};
use clerestory::spectrum::{SpectralValue, Spectrum};
use clerestory::transport::caster::{Bundle, Hit, MISS, Ray};
use clerestory::transport::points::Points;
use clerestory::transport::{DirectScratch, World, cosine_direction, direct};
use common::timed;
use glam::DVec3;
use obvhs::BvhBuildParams;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::RayHit;
use obvhs::triangle::Triangle;
use rayon::prelude::*;

/// Side of the coherent raster.
const RASTER: usize = 1024;
const RAYS: usize = RASTER * RASTER;
/// Times that all rays are cast: the clock of processor time ticks a hundred times a second.
const PASSES: usize = 8;
/// Rays of a hemisphere.
const HEMISPHERE: usize = 256;
/// Rays handed over at once.
const BATCH: usize = 64;
const POINTS: u32 = 100_000;

fn main() {
    let cornell = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/cornell/points.toml");
    let room = load(&cornell).expect("the shipped scene is sound");
    println!("Rays: closest hit, on one thread, batches of {BATCH}. Direct: exact clipping, all lamps, per point.");
    let hall = boxes(DVec3::new(40.0, 20.0, 8.0), 1660, 0.3);
    let town = boxes(DVec3::new(400.0, 200.0, 12.0), 83_400, 0.6);
    for (name, scene) in [("Cornell box", room), ("hall", hall), ("town", town)] {
        let triangles: usize = scene.faces.iter().map(|f| f.vertices.len() - 2).sum();
        let (world, took) = timed(|| World::new(&scene));
        println!("{name}: {triangles} triangles, {} lamps, built in {:.3} s", world.emitters.list.len(), took.wall_s);
        let peer = Peer::new(&world);
        peer.compare("coherent rays", &world, &coherent(&world));
        bundles(&world);
        peer.compare("incoherent rays", &world, &incoherent(&world));
        two_threads(&world);
        light(&world);
    }
}

/// The scene in the well-kept crate `obvhs`: an eight-wide tree with compressed nodes, single rays.
struct Peer {
    tree: CwBvh,
    triangles: Vec<Triangle>,
}

impl Peer {
    fn new(world: &World) -> Self {
        let surfaces = world.surfaces.list.iter();
        let fan = surfaces.flat_map(|s| (1..s.vertices.len() - 1).map(|k| [0, k, k + 1].map(|v| s.vertices[v])));
        let fan = fan.map(|t| t.map(|p| p.as_vec3a().to_array().into()));
        let mut triangles: Vec<Triangle> = fan.map(|[v0, v1, v2]| Triangle { v0, v1, v2 }).collect();
        let tree = build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
        triangles = tree.primitive_indices.iter().map(|k| triangles[*k as usize]).collect();
        Self { tree, triangles }
    }

    /// Both cast the same rays.
    fn compare(&self, name: &str, world: &World, rays: &[Ray]) {
        let mut hits = [Hit { t: 0.0, surface: MISS }; BATCH];
        let (met, took) = timed(|| {
            let mut met = 0;
            for batch in (0..PASSES).flat_map(|_| rays.chunks(BATCH)) {
                world.caster.closest_batch(batch, &mut hits[..batch.len()]);
                met += hits[..batch.len()].iter().filter(|h| h.surface != MISS).count();
            }
            met
        });
        let (peer_met, peer_took) = timed(|| (0..PASSES).map(|_| self.cast(rays)).sum::<usize>());
        let cast = (PASSES * rays.len()) as f64;
        println!(
            "  {name:<16} {:>8.2} M rays a second of processor time ({:.2} of wall time), {:.1} % hit; \
             obvhs {:.2} M, {:.1} %: {:.1} times as fast",
            cast / took.cpu_s / 1e6,
            cast / took.wall_s / 1e6,
            100.0 * met as f64 / cast,
            cast / peer_took.cpu_s / 1e6,
            100.0 * peer_met as f64 / cast,
            peer_took.cpu_s / took.cpu_s
        );
    }

    fn cast(&self, rays: &[Ray]) -> usize {
        let meets = |ray: &&Ray| {
            let ray = obvhs::ray::Ray::new(ray.origin.into(), ray.direction.into(), 0.0, f32::INFINITY);
            self.tree.ray_traverse(ray, &mut RayHit::none(), |ray, k| self.triangles[k].intersect(ray))
        };
        rays.iter().filter(meets).count()
    }
}

/// Hemispheres of rays from places anywhere.
fn bundles(world: &World) {
    let (low, high) = bounds(world);
    let (places, rays) = (Points::new(9), Points::new(10));
    let mut bundle = Bundle::default();
    let hemispheres: Vec<Vec<Ray>> = (0..(RAYS / HEMISPHERE) as u32)
        .map(|i| {
            let at = low + (high - low) * DVec3::from_array([0, 1, 2].map(|d| places.get(i, d)));
            let ray = |k| {
                let (a, b) = rays.pair(k, 0);
                Ray::new(at, cosine_direction(DVec3::Z, a, b))
            };
            (0..HEMISPHERE as u32).map(ray).collect()
        })
        .collect();
    let (met, took) = timed(|| {
        let mut met = 0;
        for rays in (0..PASSES).flat_map(|_| &hemispheres) {
            bundle.rays.clone_from(rays);
            bundle.cast(&world.caster);
            met += bundle.hits.iter().filter(|h| h.surface != MISS).count();
        }
        met
    });
    println!(
        "  hemispheres      {:>8.2} M rays a second of processor time, put in order; {:.0} % hit",
        (PASSES * RAYS) as f64 / took.cpu_s / 1e6,
        100.0 * met as f64 / (PASSES * RAYS) as f64
    );
}

/// What a second thread adds.
fn two_threads(world: &World) {
    let rays = incoherent(world);
    let took = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        let cast = |rays: &[Ray]| {
            let mut hits = vec![Hit { t: 0.0, surface: MISS }; rays.len()];
            world.caster.closest_batch(rays, &mut hits);
            hits.len()
        };
        timed(|| pool.install(|| rays.par_chunks(1 << 12).map(cast).sum::<usize>())).1.wall_s
    });
    println!("  two threads      {:>8.2} times as fast as one", took[0] / took[1]);
}

/// A camera's rays from the middle of the scene, tile by tile.
fn coherent(world: &World) -> Vec<Ray> {
    const TILE: usize = 8;
    let (low, high) = bounds(world);
    let (eye, side) = (0.5 * (low + high), 1.2 / RASTER as f64);
    let mut rays = Vec::with_capacity(RAYS);
    for tile in 0..RAYS / (TILE * TILE) {
        let (tx, ty) = (tile % (RASTER / TILE) * TILE, tile / (RASTER / TILE) * TILE);
        for k in 0..TILE * TILE {
            let (x, y) = ((tx + k % TILE) as f64, (ty + k / TILE) as f64);
            rays.push(Ray::new(eye, DVec3::new(1.0, x * side - 0.6, y * side - 0.6).normalize()));
        }
    }
    rays
}

/// From anywhere to anywhere.
fn incoherent(world: &World) -> Vec<Ray> {
    let (low, high) = bounds(world);
    let points = Points::new(7);
    let ray = |i: u32| {
        let [x, y, z, a, b] = [0, 1, 2, 3, 4].map(|d| points.get(i, d));
        let (height, around) = (2.0 * a - 1.0, TAU * b);
        let across = (1.0 - height * height).sqrt();
        let direction = DVec3::new(across * around.cos(), across * around.sin(), height);
        Ray::new(low + (high - low) * DVec3::new(x, y, z), direction)
    };
    // Neighbours in the sequence lie far apart.
    (0..RAYS as u32).map(ray).collect()
}

fn light(world: &World) {
    let (low, high) = bounds(world);
    let points = Points::new(11);
    let mut scratch = DirectScratch::default();
    let mut out = vec![0.0; world.emitters.groups()];
    let ((), took) = timed(|| {
        for i in 0..POINTS {
            let (a, b) = points.pair(i, 0);
            let place = DVec3::new(a, b, 0.05 + 0.5 * points.get(i, 2));
            out.fill(0.0);
            direct(world, low + (high - low) * place, DVec3::Z, u64::from(i), &mut scratch, &mut out);
        }
    });
    let each = |n: u64| n as f64 / f64::from(POINTS);
    println!(
        "  direct light     {:>8.2} us of processor time a point: {:.2} lamps in front, {:.2} shadow rays",
        1e6 * took.cpu_s / f64::from(POINTS),
        each(scratch.factors),
        each(scratch.rays)
    );
}

fn bounds(world: &World) -> (DVec3, DVec3) {
    let vertices = || world.surfaces.list.iter().flat_map(|s| s.vertices.iter().copied());
    let (low, high) = (vertices().fold(DVec3::INFINITY, DVec3::min), vertices().fold(DVec3::NEG_INFINITY, DVec3::max));
    let rim = 0.01 * (high - low);
    (low + rim, high - rim)
}

/// A hall of a size in metres, with eight lamps and turned boxes up to twice `big` wide.
fn boxes(size: DVec3, count: u32, big: f64) -> Scene {
    let grey = |v: f64| MaterialKind::Diffuse { front: SpectralValue::Grey(v), back: SpectralValue::Grey(v) };
    let lamp = Emission { radiance: Spectrum::constant(1.0), two_sided: false, group: None };
    let mut build = Build::new();
    let walls = build.material(Material { name: "grey".into(), kind: grey(0.5), emission: None, outside: false });
    let lamp = build.material(Material { name: "lamp".into(), kind: grey(0.0), emission: Some(lamp), outside: false });
    build.room(DVec3::ZERO, size, [walls; 6]);
    for k in 0..8 {
        let place = DVec3::new(0.125 + 0.25 * f64::from(k / 2), 0.25 + 0.5 * f64::from(k % 2), 1.0);
        build.lamp(size * place - 0.1 * DVec3::Z, 1.2, lamp);
    }
    let points = Points::new(3);
    for i in 0..count {
        let [x, y, z, a, b, c, turn] = [0, 1, 2, 3, 4, 5, 6].map(|d| points.get(i, d));
        let low = DVec3::new(1.0, 1.0, 0.8);
        let centre = low + (size - 2.0 * low - DVec3::Z) * DVec3::new(x, y, z * z);
        let half = DVec3::splat(0.05) + big * DVec3::new(a, b, c);
        cuboid(centre, half, TAU * turn).iter().for_each(|v| {
            build.face(v, walls);
        });
    }
    build.0
}

/// Six quads that look outward.
fn cuboid(centre: DVec3, half: DVec3, turn: f64) -> [Vec<DVec3>; 6] {
    let (sine, cosine) = turn.sin_cos();
    let corner = |i: usize| {
        let s = |bit: usize, h: f64| if i & bit == 0 { -h } else { h };
        let (x, y) = (s(1, half.x), s(2, half.y));
        centre + DVec3::new(cosine * x - sine * y, sine * x + cosine * y, s(4, half.z))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    quads.map(|q| q.map(corner).to_vec())
}
