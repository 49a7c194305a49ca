//! Scenes put together in memory: rooms, boxes, lamps, points.

use glam::DVec3;

use super::{Axes, Face, Grid, GridLayout, Material, Receiver, Scene, Sensor};
use crate::spectrum::BandMode;

/// A scene in the making. Lengths are metres, z points up; faces are counter-clockwise seen from their front.
#[derive(Clone, Debug)]
pub struct Build(pub Scene);

impl Default for Build {
    fn default() -> Self {
        Self::new()
    }
}

impl Build {
    /// Nothing yet; one photometric band.
    #[must_use]
    pub fn new() -> Self {
        Self(Scene {
            title: "scene".into(),
            faces: Vec::new(),
            objects: vec!["thing".into()],
            materials: Vec::new(),
            bands: BandMode::Grey,
            grids: Vec::new(),
            views: Vec::new(),
            daytime: None,
            luminaires: Vec::new(),
            observers: Vec::new(),
            modelling: Vec::new(),
            requirements: Vec::new(),
            power: None,
            states: Vec::new(),
            occupancy: Default::default(),
            blinds: Vec::new(),
            axes: Axes::ZUp,
            inputs: Vec::new(),
            warnings: Vec::new(),
        })
    }

    /// Adds a material and answers its number.
    pub fn material(&mut self, material: Material) -> usize {
        self.0.materials.push(material);
        self.0.materials.len() - 1
    }

    /// Gauss's rule of eight points on each axis of each face of a box from the origin: face, place, normal, area that it
    /// stands for.
    #[must_use]
    pub fn on_faces(size: DVec3) -> Vec<(usize, DVec3, DVec3, f64)> {
        let half = [
            (0.019_855_072, 0.050_614_268),
            (0.101_666_761, 0.111_190_517),
            (0.237_233_795, 0.156_853_323),
            (0.408_282_679, 0.181_341_892),
        ];
        let rule: Vec<(f64, f64)> = half.iter().flat_map(|(x, w)| [(*x, *w), (1.0 - x, *w)]).collect();
        let mut all = Vec::new();
        for (axis, high) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let normal = DVec3::AXES[axis] * if high { -1.0 } else { 1.0 };
            for (a, wa) in &rule {
                for (b, wb) in &rule {
                    let mut p = DVec3::ZERO;
                    p[axis] = if high { size[axis] } else { 0.0 };
                    p[u] = a * size[u];
                    p[v] = b * size[v];
                    all.push((2 * axis + usize::from(high), p, normal, wa * wb * size[u] * size[v]));
                }
            }
        }
        all
    }

    /// Adds a convex polygon.
    pub fn face(&mut self, vertices: &[DVec3], material: usize) -> &mut Self {
        self.0.faces.push(Face::new(vertices, material));
        self
    }

    /// Adds a rectangle from a corner and two sides; its front looks along `u × v`.
    pub fn rectangle(&mut self, corner: DVec3, u: DVec3, v: DVec3, material: usize) -> &mut Self {
        self.face(&[corner, corner + u, corner + u + v, corner + v], material)
    }

    /// Adds a closed box that is looked at from inside: x0, x1, y0, y1, floor, ceiling.
    pub fn room(&mut self, low: DVec3, high: DVec3, materials: [usize; 6]) -> &mut Self {
        for (mut vertices, m) in box_sides(low, high).into_iter().zip(materials) {
            vertices.reverse();
            self.face(&vertices, m);
        }
        self
    }

    /// Adds a solid box.
    pub fn block(&mut self, low: DVec3, high: DVec3, material: usize) -> &mut Self {
        self.block_of(low, high, [material; 6])
    }

    /// Adds a solid box with a material for each side: x0, x1, y0, y1, bottom, top.
    pub fn block_of(&mut self, low: DVec3, high: DVec3, materials: [usize; 6]) -> &mut Self {
        for (vertices, m) in box_sides(low, high).into_iter().zip(materials) {
            self.face(&vertices, m);
        }
        self
    }

    /// Adds a square lamp that looks down.
    pub fn lamp(&mut self, centre: DVec3, side: f64, material: usize) -> &mut Self {
        let corner = centre - DVec3::new(0.5 * side, 0.5 * side, 0.0);
        self.rectangle(corner, DVec3::Y * side, DVec3::X * side, material)
    }

    /// Adds a grid of single points with their normals.
    pub fn points(&mut self, name: &str, points: &[(DVec3, DVec3)]) -> &mut Self {
        let sensor = |&(position, n): &(DVec3, DVec3)| Sensor { position, normal: n.normalize(), area_m2: None };
        let sensors = points.iter().map(sensor).collect();
        self.0.grids.push(Grid { name: name.into(), sensors, layout: GridLayout::Points, receiver: Receiver::Plane });
        self
    }

    /// Adds `n × n` points that look up, in the middles of the cells of a rectangle at the height of `low`.
    pub fn level(&mut self, name: &str, low: DVec3, high: DVec3, n: usize) -> &mut Self {
        let place = |k: usize| (k as f64 + 0.5) / n as f64;
        let point = |k: usize| {
            let (i, j) = (place(k % n), place(k / n));
            DVec3::new(low.x + (high.x - low.x) * i, low.y + (high.y - low.y) * j, low.z)
        };
        let points: Vec<(DVec3, DVec3)> = (0..n * n).map(|k| (point(k), DVec3::Z)).collect();
        self.points(name, &points)
    }

    /// Sets the bands.
    pub fn bands(&mut self, bands: BandMode) -> &mut Self {
        self.0.bands = bands;
        self
    }
}

impl Face {
    /// From its vertices; area and normal by Newell's sum.
    #[must_use]
    pub fn new(vertices: &[DVec3], material: usize) -> Self {
        let n = vertices.len();
        let sum: DVec3 = (0..n).map(|k| (vertices[k] - vertices[0]).cross(vertices[(k + 1) % n] - vertices[0])).sum();
        Self {
            vertices: vertices.to_vec(),
            normal: sum.normalize_or_zero(),
            area_m2: 0.5 * sum.length(),
            material,
            object: 0,
        }
    }
}

/// Sides of a box with normals that look out: x0, x1, y0, y1, bottom, top.
fn box_sides(a: DVec3, b: DVec3) -> [Vec<DVec3>; 6] {
    let p = |i: usize, j: usize, k: usize| DVec3::new([a.x, b.x][i], [a.y, b.y][j], [a.z, b.z][k]);
    [
        vec![p(0, 0, 0), p(0, 0, 1), p(0, 1, 1), p(0, 1, 0)],
        vec![p(1, 0, 0), p(1, 1, 0), p(1, 1, 1), p(1, 0, 1)],
        vec![p(0, 0, 0), p(1, 0, 0), p(1, 0, 1), p(0, 0, 1)],
        vec![p(0, 1, 0), p(0, 1, 1), p(1, 1, 1), p(1, 1, 0)],
        vec![p(0, 0, 0), p(0, 1, 0), p(1, 1, 0), p(1, 0, 0)],
        vec![p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1)],
    ]
}
