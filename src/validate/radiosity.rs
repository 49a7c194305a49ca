//! Interreflection: furnaces, one patch a face, and boxes known by quadrature.

use glam::DVec3;

use super::References;
use super::form_factors::opposite;
use super::references::Row;
use super::scenes::Build;
use super::sheet::{Sheet, exact, known};
use crate::Result;
use crate::measure::{Method, SolveOptions};
use crate::mesh::PatchMesh;
use crate::solve::dense::{Solver, System};
use crate::spectrum::colour::{apply, inverse};
use crate::transport::World;
use crate::transport::form_factor::{Analytic, FormFactors};

/// Relative error that we claim for one patch a face: factors are exact, the system is solved to 1e-10.
const LUMPED: f64 = 1e-9;
/// Tolerance at which boxes are solved.
const TOLERANCE: f64 = 0.02;

pub(super) fn run(references: &References, sheet: &mut Sheet) -> Result<()> {
    furnaces(sheet)?;
    lumped(sheet)?;
    for b in boxes(references)? {
        sheet.topic("illuminance in a closed box", BOX_SOURCE, "lx");
        let m = b.build.solve(TOLERANCE)?;
        for (i, (s, truth)) in m.grids[0].sensors.iter().zip(&b.truth).enumerate() {
            sheet.sensor(format!("{} point {i}", b.name), known(truth.0, truth.1), s, 0.0);
        }
    }
    Ok(())
}

const BOX_SOURCE: &str = "constant elements with exact factors on two graded meshes, extrapolated";

/// A closed box of Lambertian walls, with its exact illuminances.
#[derive(Debug)]
pub(super) struct KnownBox {
    pub(super) name: String,
    pub(super) build: Build,
    /// Illuminance and its uncertainty, lx.
    pub(super) truth: Vec<(f64, f64)>,
}

/// The boxes of the reference table.
pub(super) fn boxes(references: &References) -> Result<Vec<KnownBox>> {
    let rows = references.rows("boxes.csv")?;
    let name = |r: &Row| -> Result<String> { Ok(format!("{} {}", r.text("box")?, r.text("band")?)) };
    let mut list: Vec<KnownBox> = Vec::new();
    let mut points: Vec<(DVec3, DVec3)> = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        let this = name(row)?;
        if list.last().is_none_or(|b| b.name != this) {
            let (rho, exitance) = (row.numbers::<6>("reflectance")?, row.numbers::<6>("exitance_lm_m2")?);
            let mut build = Build::new();
            let materials = std::array::from_fn(|k| build.paint(rho[k], exitance[k]));
            build.room(DVec3::ZERO, row.point("size_m")?, materials);
            list.push(KnownBox { name: this.clone(), build, truth: Vec::new() });
        }
        points.push((row.point("point_m")?, row.point("normal")?));
        let ends = rows.get(i + 1).map(name).transpose()?.is_none_or(|next| next != this);
        if let Some(last) = list.last_mut() {
            last.truth.push((row.number("illuminance_lx")?, row.number("uncertainty_lx")?));
            if ends {
                last.build.points("points", &std::mem::take(&mut points));
            }
        }
    }
    Ok(list)
}

/// A closed box in which every surface emits what it does not reflect: 1000 lx everywhere.
pub(super) fn furnace(size: DVec3, origin: DVec3, rho: [f64; 6]) -> Build {
    let mut b = Build::new();
    let materials = rho.map(|r| b.paint(r, 1000.0 * (1.0 - r)));
    b.room(origin, origin + size, materials);
    let place = |x: f64, y: f64, z: f64| origin + size * DVec3::new(x, y, z);
    b.points(
        "points",
        &[
            (place(0.5, 0.5, 0.5), DVec3::Z),
            (place(0.2, 0.7, 0.1), DVec3::new(1.0, -1.0, 0.5)),
            (place(0.9, 0.05, 0.8), DVec3::NEG_Z),
        ],
    );
    b
}

fn furnaces(sheet: &mut Sheet) -> Result<()> {
    let source = "closed form: E = M / (1 - rho) where all surfaces emit and reflect alike";
    sheet.topic("a furnace has one illuminance everywhere", source, "lx");
    for rho in [0.0, 0.3, 0.5, 0.8, 0.9, 0.95] {
        let m = furnace(DVec3::new(4.0, 3.0, 2.7), DVec3::ZERO, [rho; 6]).solve(TOLERANCE)?;
        for (i, s) in m.grids[0].sensors.iter().enumerate() {
            sheet.sensor(format!("reflectance {rho}, point {i}"), known(1000.0, ROUNDING_LX), s, 0.0);
        }
    }
    let mixed = [0.1, 0.9, 0.5, 0.3, 0.7, 0.8];
    sheet.topic("a furnace of six paints has one illuminance", "closed form: M_i = (1 - rho_i) E", "lx");
    for method in Method::ALL {
        let paths = (method == Method::PathTracing).then_some(4096);
        let options = SolveOptions { method, paths, tolerance: 0.05, ..SolveOptions::default() };
        let m = furnace(DVec3::new(4.0, 3.0, 2.7), DVec3::ZERO, mixed).solve_by(&options)?;
        for (i, s) in m.grids[0].sensors.iter().enumerate() {
            sheet.sensor(format!("{}, point {i}", method.name()), known(1000.0, ROUNDING_LX), s, 0.0);
        }
    }
    Ok(())
}

/// Rays and rows are in 32 bits: 1e-5 of the 1000 lx of a furnace, where no noise hides it.
const ROUNDING_LX: f64 = 0.02;

/// A unit cube with one patch a face: radiosity of ceiling, floor and walls by elimination in three unknowns.
fn lumped(sheet: &mut Sheet) -> Result<()> {
    let source = "algebra in three unknowns with Howell C-11";
    sheet.topic("radiosity of a cube with one patch a face and a luminous ceiling", source, "lm/m²");
    let across = opposite(1.0, 1.0);
    let beside = 0.25 * (1.0 - across);
    for rho in [0.2, 0.5, 0.8] {
        // Rows: ceiling, floor, walls.
        let system = [
            [1.0, -rho * across, -4.0 * rho * beside],
            [-rho * across, 1.0, -4.0 * rho * beside],
            [-rho * beside, -rho * beside, 1.0 - rho * (across + 2.0 * beside)],
        ];
        let truth = apply(&inverse(&system), [1.0, 0.0, 0.0]);
        let mut b = Build::new();
        let wall = b.paint(rho, 0.0);
        b.room(DVec3::ZERO, DVec3::ONE, [wall; 6]);
        let world = World::new(&b.0);
        let mesh = PatchMesh::uniform(&world.surfaces, 10.0, |p| p.front);
        let mut factors = FormFactors::new(&world, &mesh, &Analytic::new(&world, &mesh));
        factors.balance(&mesh, &world, 0.05)?;
        let emitted = vec![0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let system = System { bands: 1, areas: factors.areas.clone(), rho: vec![rho; 6], emitted };
        for (name, solver) in [
            ("full matrix", Solver::FullMatrix),
            ("Gauss-Seidel", Solver::GaussSeidel),
            ("Southwell", Solver::Southwell),
            ("conjugate gradients", Solver::ConjugateGradients),
        ] {
            let found = system.solve(&factors, solver, 1e-11)?;
            for (part, patch, truth) in [("ceiling", 5, truth[0]), ("floor", 4, truth[1]), ("walls", 0, truth[2])] {
                let value = found.radiosity[patch];
                sheet.equal(format!("{name}, reflectance {rho}, {part}"), exact(truth), value, LUMPED * value);
            }
        }
    }
    Ok(())
}
