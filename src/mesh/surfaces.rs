//! Faces of the scene about a local origin, scaled to size one.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{contact, solid};
use crate::scene::Scene;

/// Where the program's frame lies in the scene: `x_m = centre_m + size_m · x`.
///
/// Everything after the reader works in units of the scene's own size, about its centre. Single precision is
/// then safe at any world offset, and no tolerance depends on the unit in which a scene was drawn. Points come to rest on
/// a decimal lattice, on which the numbers that people write lie already: the last bits that a far offset leaves of a
/// coordinate then change nothing, where else they would decide between equals, and a mesh with them.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Centre of the bounding box, metres.
    pub centre_m: DVec3,
    /// Diagonal of the bounding box, metres.
    pub size_m: f64,
    /// Cells of the lattice in a metre, a power of ten; its lowest corner, the centre from there and the diagonal in cells.
    cells: f64,
    low: DVec3,
    centre: DVec3,
    size: f64,
}

/// Decimals of the lattice below the leading digit of the scene's size, and at most.
const DECIMALS: std::ops::Range<i32> = 8..16;
/// Cells along the smallest gap between coordinates: no form factor may feel them.
const CELLS_OF_GAP: f64 = 1e6;
/// Coordinates nearer to each other than this, as a share of the largest, are the same.
const SAME: f64 = 1e-14;
/// Angle by which the lattice may turn a face.
const LATTICE_TURN: f64 = 1e-6;

impl Frame {
    fn around(points: impl Iterator<Item = DVec3> + Clone) -> Self {
        let low_m = points.clone().fold(DVec3::INFINITY, DVec3::min);
        let high_m = points.clone().fold(DVec3::NEG_INFINITY, DVec3::max);
        // The last bits of a size that is a power of ten must not tell its leading digit.
        let leading = (1.000_001 * (high_m - low_m).length()).log10().floor() as i32;
        let gap_m = smallest_gap(points, SAME * low_m.abs().max(high_m.abs()).max_element());
        let decimals =
            DECIMALS.into_iter().find(|k| 10f64.powi(k - leading) * gap_m >= CELLS_OF_GAP).unwrap_or(DECIMALS.end);
        let cells = 10f64.powi(decimals - leading);
        let low = (low_m * cells).round();
        let high = (high_m * cells).round() - low;
        let (centre, size) = (0.5 * high, high.length());
        Self { centre_m: (low + centre) / cells, size_m: size / cells, cells, low, centre, size }
    }

    /// Scene metres to the program's frame.
    #[must_use]
    pub fn to_local(&self, p: DVec3) -> DVec3 {
        ((p * self.cells).round() - self.low - self.centre) / self.size
    }

    /// The normal of a face from its vertices on the lattice; slivers, which the lattice may turn, keep their own.
    fn normal(&self, vertices: &[DVec3], own: DVec3) -> DVec3 {
        let from = vertices[0];
        let around: DVec3 = vertices.windows(2).map(|e| (e[0] - from).cross(e[1] - from)).sum();
        let normal = around.normalize_or(own);
        if normal.distance_squared(own) < LATTICE_TURN * LATTICE_TURN { normal } else { own }
    }

    /// Square metres per unit of area.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        self.size_m * self.size_m
    }
}

/// Smallest distance along an axis between coordinates that are not the same.
fn smallest_gap(points: impl Iterator<Item = DVec3> + Clone, same: f64) -> f64 {
    let along = |axis: usize| {
        let mut places: Vec<f64> = points.clone().map(|p| p[axis]).collect();
        places.sort_by(f64::total_cmp);
        places.windows(2).map(|w| w[1] - w[0]).filter(|gap| *gap > same).fold(f64::INFINITY, f64::min)
    };
    (0..3).map(along).fold(f64::INFINITY, f64::min)
}

/// Distance, in units of the scene's size, below which two things touch.
pub(crate) const TOUCH: f64 = 2e-6;

/// A convex planar polygon with axes of its own.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Vertices, counter-clockwise seen from the front.
    pub vertices: Vec<DVec3>,
    /// Unit normal of the front.
    pub normal: DVec3,
    /// Corner of the bounding rectangle in the surface's plane.
    pub origin: DVec3,
    /// Unit axes in the plane; `u × v = normal`.
    pub axes: [DVec3; 2],
    /// The vertices in (u, v) from `origin`; all coordinates are at least zero.
    pub outline: Vec<DVec2>,
    /// Sides of the bounding rectangle.
    pub extent: DVec2,
    /// Area.
    pub area: f64,
    /// Index of the material.
    pub material: usize,
    /// Its back is the inside of a closed solid, which no light reaches.
    pub solid: bool,
    /// Segments in (u, v) along which something stands on this surface or goes through it.
    pub cuts: Vec<[DVec2; 2]>,
}

impl Surface {
    /// A polygon with axes along its longest side.
    pub(crate) fn new(vertices: Vec<DVec3>, normal: DVec3, material: usize) -> Self {
        let n = vertices.len();
        let longest = (0..n).map(|k| vertices[(k + 1) % n] - vertices[k]).fold(DVec3::ZERO, |best, e| {
            // The first of equal edges, whatever the last bits say.
            if e.length_squared() > best.length_squared() * (1.0 + 1e-9) { e } else { best }
        });
        let u = (longest - normal * longest.dot(normal)).normalize_or(normal.any_orthonormal_vector());
        let v = normal.cross(u);
        let flat: Vec<DVec2> = vertices.iter().map(|p| DVec2::new(p.dot(u), p.dot(v))).collect();
        let low = flat.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = flat.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let outline: Vec<DVec2> = flat.iter().map(|p| *p - low).collect();
        let origin = u * low.x + v * low.y + normal * vertices[0].dot(normal);
        Self {
            area: super::polygon_area(&outline),
            vertices,
            normal,
            origin,
            axes: [u, v],
            outline,
            extent: high - low,
            material,
            solid: false,
            cuts: Vec::new(),
        }
    }

    /// A point of the plane from its (u, v).
    #[must_use]
    pub fn point(&self, uv: DVec2) -> DVec3 {
        self.origin + self.axes[0] * uv.x + self.axes[1] * uv.y
    }

    /// The (u, v) of a point, projected onto the plane.
    #[must_use]
    pub fn uv(&self, p: DVec3) -> DVec2 {
        let d = p - self.origin;
        DVec2::new(d.dot(self.axes[0]), d.dot(self.axes[1]))
    }

    /// Signed distance of a point from the plane, positive in front.
    #[must_use]
    pub fn height(&self, p: DVec3) -> f64 {
        (p - self.origin).dot(self.normal)
    }

    /// Normal of the chosen side.
    #[must_use]
    pub fn side_normal(&self, front: bool) -> DVec3 {
        if front { self.normal } else { -self.normal }
    }
}

/// All surfaces of a scene.
#[derive(Clone, Debug)]
pub struct Surfaces {
    /// Where the frame lies.
    pub frame: Frame,
    /// The surfaces, in the order of the scene's faces.
    pub list: Vec<Surface>,
}

impl Surfaces {
    /// Cells along the two sides of every surface, of about `size`.
    pub(super) fn cells(&self, size: f64) -> Vec<[usize; 2]> {
        let count = |side: f64| ((side / size - 1e-6).ceil().clamp(1.0, 32_000.0)) as usize;
        self.list.iter().map(|s| [count(s.extent.x), count(s.extent.y)]).collect()
    }

    /// Moves the scene to its own centre and size, and finds solids and contact lines.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let frame = Frame::around(scene.faces.iter().flat_map(|f| f.vertices.iter().copied()));
        let mut list: Vec<Surface> = scene
            .faces
            .par_iter()
            .map(|f| {
                let vertices: Vec<DVec3> = f.vertices.iter().map(|p| frame.to_local(*p)).collect();
                let normal = frame.normal(&vertices, f.normal);
                Surface::new(vertices, normal, f.material)
            })
            .collect();
        let neighbours = contact::neighbours(&list);
        contact::find_cuts(&mut list, &neighbours);
        let lets_light_in = |material: usize| scene.materials[material].kind.lets_light_in();
        solid::mark_solids(&mut list, &neighbours, lets_light_in);
        Self { frame, list }
    }
}
