//! One mesh, its form factors and its solution by one of the classic methods.

use glam::DVec2;
use rayon::prelude::*;

use super::super::adaptive::Task;
use super::super::options::Method;
use crate::error::{Error, Result};
use crate::mesh::{Linear, Patch, PatchMesh, Patches};
use crate::scene::MaterialKind;
use crate::solve::dense::{OnDemand, Shooting, Solver, System};
use crate::transport::World;
use crate::transport::form_factor::{self, Analytic, Discs, FormFactors, Hemicube, is_closed, sees_anything};

/// Most patches: the matrix of so many takes 128 MB.
pub(super) const MOST_PATCHES: usize = 4000;
/// Discs along each side of a source.
const DISCS: usize = 4;
/// Largest defect of a row sum that is balanced away: of exact factors, and of the two approximate methods.
pub(super) const LARGEST_EXACT: f64 = 0.05;
const LARGEST_APPROXIMATE: f64 = 0.5;
/// Shots between two looks at what is unshot.
const LOOK: usize = 8;

/// A solved mesh.
#[derive(Debug)]
pub(super) struct Level {
    /// Side of a patch aimed at, in the program's frame.
    pub(super) size: f64,
    pub(super) mesh: Box<dyn Patches>,
    pub(super) system: System,
    pub(super) solved: Solved,
}

/// What came of it.
#[derive(Debug)]
pub(super) struct Solved {
    /// Radiosity to gather from, patch by patch, band fastest.
    pub(super) radiosity: Vec<f64>,
    /// What a matrix tells; absent where none was made.
    pub(super) matrix: Option<Matrix>,
    /// The ambient term in use, band by band; zero for a full solution.
    pub(super) ambient: Vec<f64>,
    /// Relative error that the solver may have left.
    pub(super) iteration: f64,
    /// For the record: how it was solved, and from which form factors.
    pub(super) solver: String,
    pub(super) closure: String,
    pub(super) iterations: usize,
    pub(super) rays: u64,
    pub(super) factors: u64,
    /// Links of a hierarchy.
    pub(super) links: Option<u64>,
}

/// What a matrix of form factors tells beside the radiosities.
#[derive(Debug)]
pub(super) struct Matrix {
    /// Irradiance of every patch, whole and from emitters alone.
    pub(super) irradiance: Vec<f64>,
    pub(super) direct: Vec<f64>,
    /// Share of each patch's light that leaves the scene.
    pub(super) open: Vec<f64>,
}

impl Level {
    /// How the value at a point of a surface's side is made of those of patches: linear between them, or of one alone.
    pub(super) fn shown(&self, surface: usize, front: bool, uv: DVec2, linear: bool) -> Option<Linear> {
        let mesh = self.mesh.as_ref();
        if linear { Linear::at(mesh, surface, front, uv) } else { Linear::flat(mesh, surface, front, uv) }
    }

    /// Meshes, connects and solves; patches of about `size`, in the program's frame.
    pub(super) fn solve(task: &Task<'_>, size: f64, accuracy: f64) -> Result<Self> {
        let world = task.world;
        let whole = PatchMesh::uniform(&world.surfaces, size, |_| true);
        if whole.list.len() > 4 * MOST_PATCHES {
            return Err(too_many(whole.list.len()));
        }
        let kept: Vec<bool> = whole.list.par_iter().map(|p| sees_anything(world, p)).collect();
        let mut next = kept.iter();
        let mesh = PatchMesh::uniform(&world.surfaces, size, |_| next.next().copied().unwrap_or(false));
        if mesh.list.len() > MOST_PATCHES {
            return Err(too_many(mesh.list.len()));
        }
        let system = system(task, &mesh.list);
        let exact = |solver| by_matrix(task, &mesh, &system, &Analytic::new(world, &mesh), solver, accuracy);
        let solved = match task.options.method {
            Method::Progressive => progressive(task, &mesh, &system),
            Method::Hemicube => {
                let method = hemicube(world, &mesh, size);
                by_matrix(task, &mesh, &system, &method, Solver::GaussSeidel, accuracy)?
            }
            Method::Discs => {
                let method = discs(world, &mesh);
                by_matrix(task, &mesh, &system, &method, Solver::Southwell, accuracy)?
            }
            Method::FullMatrix => exact(Solver::FullMatrix)?,
            Method::Gathering => exact(Solver::GaussSeidel)?,
            Method::Shooting => exact(Solver::Southwell)?,
            Method::ConjugateGradients | Method::Hierarchical | Method::Auto | Method::PathTracing => {
                exact(Solver::ConjugateGradients)?
            }
        };
        Ok(Self { size, mesh: Box::new(mesh), system, solved })
    }
}

/// Hemicubes with ten pixels across a patch of a size that is seen from across the room.
pub(super) fn hemicube<'a>(world: &'a World, mesh: &'a dyn Patches, size: f64) -> Hemicube<'a> {
    let resolution = ((20.0 / size).clamp(50.0, 400.0) as usize).next_multiple_of(2);
    Hemicube { world, mesh, resolution }
}

/// Discs for every source.
pub(super) fn discs<'a>(world: &'a World, mesh: &'a dyn Patches) -> Discs<'a> {
    Discs { world, mesh, per_side: DISCS }
}

fn by_matrix(
    task: &Task<'_>,
    mesh: &PatchMesh,
    system: &System,
    method: &dyn form_factor::Method,
    solver: Solver,
    accuracy: f64,
) -> Result<Solved> {
    let mut factors = FormFactors::new(task.world, mesh, method);
    let approximate = matches!(task.options.method, Method::Hemicube | Method::Discs);
    let (closure, worst) = (factors.closure_defect, factors.worst_row.0);
    factors.balance(mesh, task.world, if approximate { LARGEST_APPROXIMATE } else { LARGEST_EXACT })?;
    let outcome = system.solve(&factors, solver, accuracy)?;
    let direct = system.irradiance(&factors, &system.emitted);
    let stays = |i: usize| factors.exchange_row(i).iter().sum::<f64>() / factors.areas[i];
    Ok(Solved {
        solver: format!(
            "{}, {} {}: residual {:.1e}, unshot {:.1e} of the flux, error of the solution at most {:.1e}",
            name(solver),
            outcome.iterations,
            unit(solver),
            outcome.residual,
            outcome.unshot,
            outcome.bound
        ),
        closure: format!(
            "{}; before the balance, rows off by {closure:.1e} (RMS), {worst:.1e} (worst), reciprocity by {:.1e}",
            method.describe(),
            factors.reciprocity_defect
        ),
        iterations: outcome.iterations,
        rays: factors.rays,
        factors: factors.factors,
        links: None,
        ambient: vec![0.0; system.bands],
        iteration: outcome.bound,
        radiosity: outcome.radiosity,
        matrix: Some(Matrix {
            irradiance: outcome.irradiance,
            direct,
            open: (0..factors.len()).map(|i| 1.0 - stays(i)).collect(),
        }),
    })
}

/// Shoots, working out rows of form factors as they are needed, until the ambient term may stand for the rest.
fn progressive(task: &Task<'_>, mesh: &PatchMesh, system: &System) -> Solved {
    let analytic = Analytic::new(task.world, mesh);
    let rows = OnDemand::new(&analytic, &system.areas, is_closed(task.world, mesh));
    let mut state = Shooting::new(system, rows, false);
    loop {
        let enough = match task.options.shots {
            Some(most) => state.shots() as u64 >= most,
            None => state.shots().is_multiple_of(LOOK) && state.unshot() < task.options.tolerance,
        };
        if enough || state.shoot().is_none() {
            break;
        }
    }
    Solved {
        solver: format!(
            "progressive refinement, {} shots: {:.1e} of the flux unshot, in the ambient term",
            state.shots(),
            state.unshot()
        ),
        closure: "analytic rows of the patches that shot".into(),
        iterations: state.shots(),
        rays: state.rows().rays,
        factors: state.rows().factors,
        links: None,
        ambient: state.ambient(),
        iteration: 0.0,
        radiosity: state.displayed(true),
        matrix: None,
    }
}

fn name(solver: Solver) -> &'static str {
    match solver {
        Solver::FullMatrix => "Gaussian elimination",
        Solver::Jacobi => "Jacobi gathering",
        Solver::GaussSeidel => "Gauss-Seidel gathering",
        Solver::Southwell => "Southwell shooting",
        Solver::Overshooting => "overshooting",
        Solver::ConjugateGradients => "conjugate gradients",
    }
}

fn unit(solver: Solver) -> &'static str {
    match solver {
        Solver::FullMatrix => "bands eliminated",
        Solver::Jacobi | Solver::GaussSeidel => "sweeps",
        Solver::Southwell | Solver::Overshooting => "sweeps of shots",
        Solver::ConjugateGradients => "products",
    }
}

fn too_many(patches: usize) -> Error {
    Error::unsupported(format!("{patches} patches; the classic methods take at most {MOST_PATCHES}"))
        .mend("use fewer --patches, or the default method, which makes only what it needs")
}

/// Reflectances and exitances of the patches.
pub(super) fn system(task: &Task<'_>, patches: &[Patch]) -> System {
    let bands = &task.optics.bands;
    let materials: Vec<[Vec<f64>; 3]> = task
        .scene
        .materials
        .iter()
        .map(|m| {
            let [back, front] = match &m.kind {
                MaterialKind::Diffuse { front, back } => [back, front].map(|r| bands.reflectance(r)),
                _ => [vec![0.0; bands.len()], vec![0.0; bands.len()]],
            };
            let radiance = m.emission.as_ref().map_or(vec![0.0; bands.len()], |e| bands.radiance(&e.radiance));
            [back, front, radiance.iter().map(|l| l * std::f64::consts::PI).collect()]
        })
        .collect();
    let mut system = System { bands: bands.len(), areas: Vec::new(), rho: Vec::new(), emitted: Vec::new() };
    for p in patches {
        let m = &materials[task.world.surfaces.list[p.surface as usize].material];
        system.areas.push(p.area);
        system.rho.extend(&m[usize::from(p.front)]);
        match task.world.group(p.surface, p.front) {
            Some(_) => system.emitted.extend(&m[2]),
            None => system.emitted.extend(std::iter::repeat_n(0.0, bands.len())),
        }
    }
    system
}
