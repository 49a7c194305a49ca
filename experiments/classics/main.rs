//! The acceptance experiments of the classic radiosity systems: each number beside its target.
//!
//! `cargo run --release --example classics` prints the tables and writes them, with a picture, into this folder.

mod gathering_and_shooting;
mod goral_1984;
mod hemicube_and_discs;
mod hierarchical;
mod substructuring;

use std::fmt::Write;
use std::path::PathBuf;

use clerestory::mesh::{Patch, PatchMesh};
use clerestory::scene::{Axes, Face, Material, MaterialKind, Scene};
use clerestory::solve::dense::System;
use clerestory::spectrum::{BandMode, SpectralValue};
use clerestory::transport::World;
use clerestory::transport::form_factor::{Analytic, FormFactors, sees_anything};
use glam::DVec3;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Outcome<()> {
    let mut out = Table::default();
    goral_1984::run(&mut out)?;
    hemicube_and_discs::run(&mut out);
    substructuring::run(&mut out)?;
    gathering_and_shooting::run(&mut out)?;
    hierarchical::run(&mut out)?;
    std::fs::write(folder().join("results.csv"), &out.csv)?;
    Ok(())
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("experiments/classics")
}

/// Numbers with their targets, printed and kept as CSV.
struct Table {
    csv: String,
}

impl Default for Table {
    fn default() -> Self {
        Self { csv: "experiment,quantity,measured,target\n".into() }
    }
}

impl Table {
    /// Enters a number; the target in words, empty where there is none.
    fn enter(&mut self, experiment: &str, quantity: &str, measured: f64, target: &str) {
        println!("{experiment:<4} {quantity:<62} {measured:>12.5}   {target}");
        // Writing to a string cannot fail.
        let _ = writeln!(self.csv, "{experiment},\"{quantity}\",{measured},\"{target}\"");
    }
}

/// A scene of boxes and rectangles; materials are numbers.
struct Build {
    scene: Scene,
}

impl Build {
    fn new(materials: usize) -> Self {
        let material = |k: usize| Material {
            name: format!("m{k}"),
            kind: MaterialKind::Diffuse { front: SpectralValue::Grey(0.5), back: SpectralValue::Grey(0.5) },
            emission: None,
            outside: false,
        };
        Self {
            scene: Scene {
                title: "experiment".into(),
                faces: Vec::new(),
                objects: vec!["thing".into()],
                materials: (0..materials).map(material).collect(),
                bands: BandMode::Grey,
                grids: Vec::new(),
                views: Vec::new(),
                daytime: None,
                luminaires: Vec::new(),
                modelling: Vec::new(),
                requirements: Vec::new(),
                power: None,
                states: Vec::new(),
                observers: Vec::new(),
                occupancy: Default::default(),
                blinds: Vec::new(),
                axes: Axes::ZUp,
                inputs: Vec::new(),
                warnings: Vec::new(),
            },
        }
    }

    /// A rectangle that looks along `u × v`.
    fn rectangle(&mut self, corner: DVec3, u: DVec3, v: DVec3, material: usize) {
        let normal = u.cross(v);
        self.scene.faces.push(Face {
            vertices: vec![corner, corner + u, corner + u + v, corner + v],
            normal: normal.normalize(),
            area_m2: normal.length(),
            material,
            object: 0,
        });
    }

    /// A box: x0, x1, y0, y1, bottom, top; looking in or out.
    fn cuboid(&mut self, low: DVec3, high: DVec3, materials: [usize; 6], inward: bool) {
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|a| a * (high - low).dot(a));
        let sides = [(low, y, z), (low + x, z, y), (low, z, x), (low + y, x, z), (low, x, y), (low + z, y, x)];
        for ((corner, u, v), m) in sides.into_iter().zip(materials) {
            let (u, v) = if inward { (u, v) } else { (v, u) };
            self.rectangle(corner, u, v, m);
        }
    }
}

/// The room of several experiments: 6 × 5 × 3 m, three boxes, two lamps; materials walls, boxes, lamps.
fn furnished_room() -> World {
    World::new(&furnished_scene())
}

fn furnished_scene() -> Scene {
    let mut b = Build::new(3);
    b.cuboid(DVec3::ZERO, DVec3::new(6.0, 5.0, 3.0), [0; 6], true);
    for (x, y, w, d, h) in [(0.8, 0.6, 1.0, 0.8, 1.2), (3.6, 2.8, 1.2, 1.0, 0.8), (4.4, 0.4, 0.6, 0.6, 1.8)] {
        b.cuboid(DVec3::new(x, y, 0.0), DVec3::new(x + w, y + d, h), [1; 6], false);
    }
    for x in [1.5, 4.5] {
        b.rectangle(DVec3::new(x - 0.4, 2.1, 2.9), DVec3::new(0.0, 0.8, 0.0), DVec3::new(0.8, 0.0, 0.0), 2);
    }
    b.scene
}

/// Patches of a size that see anything.
fn mesh(world: &World, size_m: f64) -> PatchMesh {
    PatchMesh::uniform(&world.surfaces, size_m / world.surfaces.frame.size_m, |p| sees_anything(world, p))
}

/// Balanced analytic form factors.
fn analytic(world: &World, mesh: &PatchMesh) -> Outcome<FormFactors> {
    let mut factors = FormFactors::new(world, mesh, &Analytic::new(world, mesh));
    factors.balance(mesh, world, 0.05)?;
    Ok(factors)
}

fn material(world: &World, p: &Patch) -> usize {
    world.surfaces.list[p.surface as usize].material
}

/// One band; reflectance and exitance by material, light from fronts alone.
fn system(world: &World, patches: &[Patch], rho: &[f64], emitted: &[f64]) -> System {
    System {
        bands: 1,
        areas: patches.iter().map(|p| p.area).collect(),
        rho: patches.iter().map(|p| rho[material(world, p)]).collect(),
        emitted: patches.iter().map(|p| if p.front { emitted[material(world, p)] } else { 0.0 }).collect(),
    }
}
