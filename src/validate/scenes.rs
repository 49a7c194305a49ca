//! Scenes of the cases, put together in memory.

use std::f64::consts::PI;
use std::path::PathBuf;

use glam::DVec3;

use crate::Result;
use crate::measure::{self, Measurement, Silent, SolveOptions};
use crate::scene::{
    Amount, Axes, Daytime, Emission, Face, Grid, GridLayout, LuminaireRow, Material, MaterialKind, Panes, Placed,
    Receiver, Scene, Sensor, SkyName,
};
use crate::spectrum::{BandMode, SpectralValue, Spectrum};

/// A scene in the making; one photometric band, light of equal energy.
#[derive(Debug)]
pub(super) struct Build(pub(super) Scene);

impl Build {
    pub(super) fn new() -> Self {
        Self(Scene {
            title: "validation".into(),
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

    pub(super) fn material(&mut self, kind: MaterialKind, emission: Option<Emission>) -> usize {
        let name = format!("material {}", self.0.materials.len());
        self.0.materials.push(Material { name, kind, emission, outside: false });
        self.0.materials.len() - 1
    }

    /// A Lambertian material with an exitance of its own, lm/m².
    pub(super) fn paint(&mut self, reflectance: f64, exitance_lm_m2: f64) -> usize {
        let rho = SpectralValue::Grey(reflectance);
        let per_unit = PI * Spectrum::constant(1.0).luminous();
        let radiance = Spectrum::constant(exitance_lm_m2 / per_unit);
        let emission = (exitance_lm_m2 > 0.0).then_some(Emission { radiance, two_sided: false, group: None });
        self.material(MaterialKind::Diffuse { front: rho.clone(), back: rho }, emission)
    }

    /// One uncoated pane of a transmittance at normal incidence.
    pub(super) fn pane(&mut self, transmittance: f64) -> usize {
        let panes = Panes::Alike { count: 1, transmittance: SpectralValue::Grey(transmittance) };
        self.material(MaterialKind::Glass { panes, refractive_index: 1.52 }, None)
    }

    /// A convex polygon, counter-clockwise seen from its front.
    pub(super) fn face(&mut self, vertices: &[DVec3], material: usize) {
        self.0.faces.push(face(vertices, material));
    }

    /// A rectangle from a corner and two sides; its front looks along `u × v`.
    pub(super) fn rectangle(&mut self, corner: DVec3, u: DVec3, v: DVec3, material: usize) {
        self.face(&[corner, corner + u, corner + u + v, corner + v], material);
    }

    /// A closed box looked at from inside: x0, x1, y0, y1, floor, ceiling.
    pub(super) fn room(&mut self, low: DVec3, high: DVec3, materials: [usize; 6]) {
        for (mut vertices, m) in box_sides(low, high).into_iter().zip(materials) {
            vertices.reverse();
            self.face(&vertices, m);
        }
    }

    /// A solid box.
    pub(super) fn block(&mut self, low: DVec3, high: DVec3, material: usize) {
        for vertices in box_sides(low, high) {
            self.face(&vertices, material);
        }
    }

    /// Points with their normals, as a grid.
    pub(super) fn points(&mut self, points: &[(DVec3, DVec3)]) {
        let sensor = |&(position, n): &(DVec3, DVec3)| Sensor { position, normal: n.normalize(), area_m2: None };
        let sensors = points.iter().map(sensor).collect();
        let name = format!("points {}", self.0.grids.len());
        self.0.grids.push(Grid { name, sensors, layout: GridLayout::Points, receiver: Receiver::Plane });
    }

    /// Hangs a photometric file, aimed down.
    pub(super) fn hang(&mut self, file: Vec<u8>, position: DVec3) {
        self.0.luminaires.push(LuminaireRow::aimed_down(file, vec![position]));
    }

    /// A sky of 10,000 lx without its sun; type 16 is CIE's older overcast sky.
    pub(super) fn sky(&mut self, number: u8, sun_deg: (f64, f64), ground_reflectance: f64) {
        let placed = |value| Placed { value, line: 0 };
        let model = if number == 16 { SkyName::Overcast } else { SkyName::Cie(number) };
        self.0.daytime = Some(Daytime {
            file: PathBuf::from("validation.toml"),
            model: Placed { value: model, line: 0 },
            diffuse: Some(placed(Amount::Lux(1e4))),
            direct: None,
            sun_deg: Some(Placed { value: sun_deg, line: 0 }),
            site: None,
            spectrum: Spectrum::constant(1.0),
            sun_spectrum: Spectrum::constant(1.0),
            ground_reflectance,
            north_deg: 0.0,
        });
    }

    /// Solves it with the method that the program would choose.
    pub(super) fn solve(&self, tolerance: f64) -> Result<Measurement> {
        self.solve_by(&SolveOptions { tolerance, ..SolveOptions::default() })
    }

    pub(super) fn solve_by(&self, options: &SolveOptions) -> Result<Measurement> {
        measure::solve(&self.0, options, &Silent)
    }
}

/// A face from its vertices; area and normal by Newell's sum.
pub(super) fn face(vertices: &[DVec3], material: usize) -> Face {
    let n = vertices.len();
    let sum: DVec3 = (0..n).map(|k| (vertices[k] - vertices[0]).cross(vertices[(k + 1) % n] - vertices[0])).sum();
    Face {
        vertices: vertices.to_vec(),
        normal: sum.normalize_or_zero(),
        area_m2: 0.5 * sum.length(),
        material,
        object: 0,
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

/// Gauss's rule of eight points on each axis of each face of a box from the origin: face, place, normal, area that it
/// stands for.
pub(super) fn on_faces(size: DVec3) -> Vec<(usize, DVec3, DVec3, f64)> {
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

/// A photometric file of one plane, LM-63-2002; sizes of the opening as it has them (width, length, height, m).
pub(super) fn axial(sizes: &str, vertical_deg: &[f64], candela: impl Fn(f64) -> f64) -> Vec<u8> {
    let join = |list: Vec<f64>| list.iter().map(f64::to_string).collect::<Vec<_>>().join("\n");
    format!(
        "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {} 1 1 2 {sizes}\n1 1 0\n{}\n0\n{}\n",
        vertical_deg.len(),
        join(vertical_deg.to_vec()),
        join(vertical_deg.iter().map(|v| candela(*v)).collect())
    )
    .into_bytes()
}

/// 0 to 90 degrees in half degrees.
pub(super) fn half_degrees() -> Vec<f64> {
    (0..=180).map(|k| 0.5 * f64::from(k)).collect()
}
