//! The ray caster: slices of rays in, closest hits out, in the same order.

use glam::{DVec3, Vec3A};

use super::bvh::{EMPTY, LEAF, Tree, Triangle, WIDTH};
use super::kernel;
use crate::mesh::Surfaces;

/// A ray in the program's frame.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Start.
    pub origin: [f32; 3],
    /// Direction, of unit length.
    pub direction: [f32; 3],
    /// Nothing at or beyond this distance counts.
    pub t_max: f32,
}

impl Ray {
    /// A ray without an end.
    #[must_use]
    #[inline]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self::to(origin, direction, f32::INFINITY)
    }

    /// A ray that ends at `t_max`.
    #[must_use]
    #[inline]
    pub fn to(origin: DVec3, direction: DVec3, t_max: f32) -> Self {
        Self { origin: origin.as_vec3().to_array(), direction: direction.as_vec3().to_array(), t_max }
    }

    /// Where to it goes: a unit vector.
    #[must_use]
    #[inline]
    pub fn along(&self) -> DVec3 {
        DVec3::from_array(self.direction.map(f64::from))
    }

    /// The point at distance `t`.
    #[must_use]
    #[inline]
    pub fn at(&self, t: f32) -> DVec3 {
        let (o, d) = (self.origin.map(f64::from), self.direction.map(f64::from));
        DVec3::from_array(o) + DVec3::from_array(d) * f64::from(t)
    }
}

/// What a ray met first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance; `t_max` of the ray where it met nothing.
    pub t: f32,
    /// Index of the surface, or [`MISS`].
    pub surface: u32,
}

/// The surface of a ray that met nothing.
pub const MISS: u32 = EMPTY;

/// Rays that begin near each other and go anywhere, and what they met: cast in an order of like directions.
#[derive(Clone, Debug, Default)]
pub struct Bundle {
    /// The rays, in the caller's order.
    pub rays: Vec<Ray>,
    /// What each met.
    pub hits: Vec<Hit>,
    regions: Vec<u8>,
    /// Where each ray stands in the order of the regions.
    places: Vec<u32>,
    ordered: Vec<Ray>,
    met: Vec<Hit>,
}

impl Bundle {
    /// Casts the rays.
    pub fn cast(&mut self, caster: &Caster) {
        let Self { rays, hits, regions, places, ordered, met } = self;
        let nothing = Hit { t: 0.0, surface: MISS };
        let mut next = [0u32; REGIONS + 1];
        regions.clear();
        regions.extend(rays.iter().map(region));
        regions.iter().for_each(|r| next[usize::from(*r) + 1] += 1);
        (0..REGIONS).for_each(|r| next[r + 1] += next[r]);
        places.clear();
        ordered.clear();
        ordered.resize(rays.len(), Ray { origin: [0.0; 3], direction: [0.0; 3], t_max: 0.0 });
        for (ray, region) in rays.iter().zip(regions) {
            let place = &mut next[usize::from(*region)];
            ordered[*place as usize] = *ray;
            places.push(*place);
            *place += 1;
        }
        met.clear();
        met.resize(rays.len(), nothing);
        caster.closest_batch(ordered, met);
        hits.clear();
        hits.extend(places.iter().map(|place| met[*place as usize]));
    }
}

const REGIONS: usize = 32;

/// Region of the sphere in which a ray goes: the octant, and which of its axes are nearer than others.
fn region(ray: &Ray) -> u8 {
    let [x, y, z] = ray.direction;
    let octant = u8::from(x < 0.0) << 2 | u8::from(y < 0.0) << 1 | u8::from(z < 0.0);
    let (aside, along) = (u8::from(x.abs() < y.abs()), u8::from(x.abs().max(y.abs()) < z.abs()));
    octant << 2 | aside << 1 | along
}

/// Closest hits against the surfaces of a scene.
#[derive(Clone, Debug)]
pub struct Caster {
    tree: Tree,
}

impl Caster {
    /// Builds the tree.
    #[must_use]
    pub fn new(surfaces: &Surfaces) -> Self {
        let mut triangles = Vec::new();
        for (i, s) in surfaces.list.iter().enumerate() {
            let v: Vec<Vec3A> = s.vertices.iter().map(|p| p.as_vec3a()).collect();
            triangles
                .extend((1..v.len() - 1).map(|k| Triangle { vertices: [v[0], v[k], v[k + 1]], surface: i as u32 }));
        }
        Self { tree: Tree::build(&triangles) }
    }

    /// Closest hits of a slice of rays, in order.
    ///
    /// # Panics
    ///
    /// When the slices differ in length.
    #[inline]
    pub fn closest_batch(&self, rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "a hit for every ray");
        kernel::closest(&self.tree, rays, hits);
    }

    /// Closest hit of one ray.
    #[must_use]
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Hit {
        let mut hit = [Hit { t: ray.t_max, surface: MISS }];
        kernel::closest(&self.tree, std::slice::from_ref(ray), &mut hit);
        hit[0]
    }

    /// The surfaces whose triangles' boxes touch a convex cone with apex `apex`, without repeats.
    ///
    /// `planes` are inward unit normals of planes through the apex, `ceiling` one more plane (inward normal, offset:
    /// `n · x ≥ offset`) that closes the cone. Returns `false` when there are more than `limit`.
    pub fn in_cone(
        &self,
        apex: DVec3,
        planes: &[DVec3],
        ceiling: (DVec3, f64),
        limit: usize,
        found: &mut Vec<u32>,
    ) -> bool {
        found.clear();
        let planes: smallplanes::Planes = smallplanes::Planes::new(apex, planes, ceiling);
        let mut stack = vec![0u32];
        while let Some(child) = stack.pop() {
            if child & LEAF != 0 {
                for s in self.tree.leaves[(child ^ LEAF) as usize].surface {
                    if s != EMPTY && !found.contains(&s) {
                        if found.len() == limit {
                            return false;
                        }
                        found.push(s);
                    }
                }
                continue;
            }
            let Some(node) = self.tree.nodes.get(child as usize) else { break };
            let touched = planes.touch(node);
            for lane in 0..WIDTH {
                if touched[lane] && node.child[lane] != EMPTY {
                    stack.push(node.child[lane]);
                }
            }
        }
        true
    }
}

mod smallplanes {
    use super::super::bvh::{Node, WIDTH};
    use glam::DVec3;

    /// Up to sixteen half-spaces `n · x ≥ offset`, with slack for single precision.
    pub(super) struct Planes {
        list: [([f32; 3], f32); 16],
        len: usize,
    }

    impl Planes {
        pub(super) fn new(apex: DVec3, planes: &[DVec3], ceiling: (DVec3, f64)) -> Self {
            let mut list = [([0.0; 3], 0.0); 16];
            let all = planes.iter().map(|n| (*n, n.dot(apex))).take(15).chain([ceiling]);
            let mut len = 0;
            for (n, d) in all {
                list[len] = (n.as_vec3().to_array(), d as f32 - 1e-6);
                len += 1;
            }
            Self { list, len }
        }

        /// Which boxes have a corner inside every half-space.
        #[inline]
        pub(super) fn touch(&self, node: &Node) -> [bool; WIDTH] {
            let mut inside = [true; WIDTH];
            for (n, d) in &self.list[..self.len] {
                let mut reach = [0.0f32; WIDTH];
                for axis in 0..3 {
                    let corner = if n[axis] > 0.0 { &node.high[axis] } else { &node.low[axis] };
                    for lane in 0..WIDTH {
                        reach[lane] += n[axis] * corner[lane];
                    }
                }
                for lane in 0..WIDTH {
                    inside[lane] &= reach[lane] >= *d;
                }
            }
            inside
        }
    }
}
