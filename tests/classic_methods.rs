//! The classic methods: form factors that close, solvers that agree, and failures that are told.

mod common;

use clerestory::measure::{self, Display, Method, Silent, SolveOptions};
use clerestory::mesh::PatchMesh;
use clerestory::scene::Scene;
use clerestory::solve::dense::{Shooting, Solver, System};
use clerestory::transport::World;
use clerestory::transport::form_factor::{Analytic, Discs, FormFactors, Hemicube, Work, sees_anything};
use common::{
    Build, Cover, assert_balanced, assert_near, assert_ratio, at, cube, diffuse, furnished, furnished_below, lit, lux,
    mirror, solve,
};
use glam::DVec3;

const SOLVERS: [Solver; 6] = [
    Solver::FullMatrix,
    Solver::Jacobi,
    Solver::GaussSeidel,
    Solver::Southwell,
    Solver::Overshooting,
    Solver::ConjugateGradients,
];

/// A mesh of a scene, patches of `size_m`.
fn mesh(world: &World, size_m: f64) -> PatchMesh {
    PatchMesh::uniform(&world.surfaces, size_m / world.surfaces.frame.size_m, |p| sees_anything(world, p))
}

/// Balanced analytic form factors.
fn analytic(world: &World, mesh: &PatchMesh) -> FormFactors {
    let mut factors = FormFactors::new(world, mesh, &Analytic::new(world, mesh));
    factors.balance(mesh, world, 0.05).expect("factors that close");
    factors
}

/// One band: every patch with its material's number as index into reflectances and exitances.
fn system(world: &World, mesh: &PatchMesh, rho: &[f64], emitted: &[f64]) -> System {
    let material = |p: &clerestory::mesh::Patch| world.surfaces.list[p.surface as usize].material;
    System {
        bands: 1,
        areas: mesh.list.iter().map(|p| p.area).collect(),
        rho: mesh.list.iter().map(|p| rho[material(p)]).collect(),
        emitted: mesh.list.iter().map(|p| if p.front { emitted[material(p)] } else { 0.0 }).collect(),
    }
}

/// The furnished room: materials grey, red, blue, lamp.
fn room() -> Scene {
    furnished().0
}

#[test]
fn rows_of_an_occluded_room_sum_to_one_before_any_balance() {
    // The lamp well below the ceiling: rows of patches in a narrow gap are a matter of their own.
    let world = World::new(&furnished_below(2.1).0);
    let mesh = mesh(&world, 0.8);
    let mut factors = FormFactors::new(&world, &mesh, &Analytic::new(&world, &mesh));
    assert!(factors.closed);
    // The outer quadrature stops at a change of 1e-3 of a factor, a few of which are partly blocked in each row.
    assert!(factors.closure_defect < 1e-3 && factors.worst_row.0 < 5e-3, "{factors:?}", factors = factors.worst_row);
    factors.balance(&mesh, &world, 0.05).expect("closes");
    for i in 0..factors.len() {
        let sum: f64 = (0..factors.len()).map(|j| factors.factor(i, j)).sum();
        assert_near(sum, 1.0, 1e-12, "row sum");
        for j in 0..factors.len() {
            let (there, back) = (factors.areas[i] * factors.factor(i, j), factors.areas[j] * factors.factor(j, i));
            assert_near(there, back, 1e-15, "reciprocity");
        }
    }
}

#[test]
fn every_solver_gives_the_same_answer() {
    let world = World::new(&room());
    let mesh = mesh(&world, 0.8);
    let factors = analytic(&world, &mesh);
    let system = system(&world, &mesh, &[0.7, 0.5, 0.3, 0.0], &[0.0, 0.0, 0.0, 3000.0]);
    let exact = system.solve(&factors, Solver::FullMatrix, 1e-9).expect("a solution");
    let largest = exact.radiosity.iter().copied().fold(0.0, f64::max);
    for solver in SOLVERS {
        let outcome = system.solve(&factors, solver, 1e-8).expect("a solution");
        for (b, e) in outcome.radiosity.iter().zip(&exact.radiosity) {
            assert!((b - e).abs() <= 1e-6 * largest, "{solver:?}: {b} against {e}");
        }
        let off = outcome.radiosity.iter().zip(&exact.radiosity).map(|(b, e)| (b - e).abs()).fold(0.0, f64::max);
        assert!(
            off <= outcome.bound * largest + 1e-9 * largest,
            "{solver:?}: off by {off:e}, bound {:e}",
            outcome.bound
        );
    }
}

#[test]
fn a_furnace_reaches_emission_over_one_minus_rho_by_every_solver() {
    let world = World::new(&cube(0.5).0);
    let mesh = mesh(&world, 0.5);
    let factors = analytic(&world, &mesh);
    for rho in [0.1, 0.5, 0.9, 0.99] {
        let mut system = system(&world, &mesh, &[rho; 2], &[0.0; 2]);
        system.emitted.fill(1.0);
        for solver in SOLVERS {
            let outcome = system.solve(&factors, solver, 1e-9).expect("a solution");
            for b in &outcome.radiosity {
                // A residual of 1e-9 is amplified by 1/(1 − ρ) at most; shooters hold as much unshot, over and over.
                assert_ratio(*b, 1.0 / (1.0 - rho), 2e-9 / (1.0 - rho), &format!("{solver:?} at {rho}"));
            }
        }
    }
}

#[test]
fn conjugate_gradients_hardly_notice_a_bright_room() {
    let world = World::new(&room());
    let mesh = mesh(&world, 0.8);
    let factors = analytic(&world, &mesh);
    let iterations = |rho: f64, solver| {
        let system = system(&world, &mesh, &[rho, rho, rho, 0.0], &[0.0, 0.0, 0.0, 1.0]);
        system.solve(&factors, solver, 1e-6).expect("a solution").iterations
    };
    assert!(iterations(0.99, Solver::ConjugateGradients) <= 30);
    // The slowest part falls by the factor ρ(1 − lamp's share) a sweep.
    assert!(iterations(0.99, Solver::Jacobi) > 5 * iterations(0.99, Solver::ConjugateGradients));
}

#[test]
fn a_closed_room_that_absorbs_nothing_is_refused() {
    let world = World::new(&cube(0.5).0);
    let mesh = mesh(&world, 1.0);
    let factors = analytic(&world, &mesh);
    let system = system(&world, &mesh, &[1.0; 2], &[1.0; 2]);
    let error = system.solve(&factors, Solver::ConjugateGradients, 1e-6).expect_err("no solution");
    assert!(error.to_string().contains("never goes away"), "{error}");
}

#[test]
fn the_ambient_term_brings_every_picture_nearer() {
    let mut b = Build::new();
    let wall = b.material(diffuse("wall", 0.6));
    let lamp = b.material(lit(diffuse("lamp", 0.0), 1.0));
    b.room(DVec3::ZERO, at(6.0, 5.0, 3.0), [wall; 6]);
    b.lamp(at(1.5, 2.5, 2.9), 0.8, lamp).lamp(at(4.5, 2.5, 2.9), 0.8, lamp);
    let world = World::new(&b.0);
    let mesh = mesh(&world, 1.0);
    let factors = analytic(&world, &mesh);
    let system = system(&world, &mesh, &[0.6, 0.0], &[0.0, 1.0]);
    let truth = system.solve(&factors, Solver::FullMatrix, 1e-9).expect("a solution").radiosity;
    let walls: Vec<usize> = (0..system.len()).filter(|i| system.rho[*i] > 0.0).collect();
    let off = |shown: &[f64]| walls.iter().map(|&i| system.areas[i] * (shown[i] - truth[i]).powi(2)).sum::<f64>();
    let mut state = Shooting::new(&system, &factors, false);
    let mut unshot = state.unshot();
    for step in 0..system.len() {
        let (with, without) = (off(&state.displayed(true)), off(&state.displayed(false)));
        assert!(with < without, "after {step} shots: {with:e} against {without:e}");
        state.shoot();
        assert!(state.unshot() <= unshot * (1.0 + 1e-12), "unshot flux grew");
        unshot = state.unshot();
    }
}

#[test]
fn hemicubes_close_but_miss_what_is_narrower_than_a_pixel() {
    let world = World::new(&cube(0.5).0);
    let mesh = mesh(&world, 1.0);
    for (resolution, limit) in [(50, 3e-4), (100, 1.5e-4)] {
        let factors = FormFactors::new(&world, &mesh, &Hemicube { world: &world, mesh: &mesh, resolution });
        // Sums of all pixels: 1 + 2.2e-4 and 1 + 5.4e-5; a ray in ten thousand may slip through an edge.
        assert!(factors.worst_row.0 <= limit, "{resolution}: {:e}", factors.worst_row.0);
    }
    // A lamp 1/20 of a pixel wide, halfway between the middles of pixels at resolution 50.
    let mut b = Build::new();
    let grey = b.material(diffuse("grey", 0.5));
    let (x, side) = (1.0 / 50.0, 2e-3);
    b.rectangle(at(-1.0, -1.0, 0.0), at(2.0, 0.0, 0.0), at(0.0, 2.0, 0.0), grey);
    b.lamp(at(2.0 * x, 2.0 * x, 1.0), side, grey);
    let world = World::new(&b.0);
    let mesh = PatchMesh::uniform(&world.surfaces, 1.0, |p| p.front);
    let mut row = vec![0.0; 2];
    let mut work = Work::default();
    let centre = world.surfaces.frame.to_local(DVec3::ZERO);
    Hemicube { world: &world, mesh: &mesh, resolution: 50 }.at_point(centre, DVec3::Z, DVec3::X, &mut row, &mut work);
    let exact = Analytic::new(&world, &mesh).at_point(centre, DVec3::Z, 1, &mut work);
    assert!(exact > 1e-6 && row[1] == 0.0, "{exact} {}", row[1]);
}

#[test]
fn discs_near_the_exact_factor_as_they_shrink() {
    // Perpendicular squares, a side apart.
    let mut b = Build::new();
    let grey = b.material(diffuse("grey", 0.5));
    b.rectangle(DVec3::ZERO, at(1.0, 0.0, 0.0), at(0.0, 1.0, 0.0), grey);
    b.rectangle(at(-1.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(0.0, 0.0, 1.0), grey);
    let world = World::new(&b.0);
    let mesh = PatchMesh::uniform(&world.surfaces, 10.0, |p| p.front);
    let mut work = Work::default();
    let x = world.lift(mesh.list[0].centre, DVec3::Z);
    let exact = Analytic::new(&world, &mesh).at_point(x, DVec3::Z, 1, &mut work);
    let error = |per_side| {
        let discs = Discs { world: &world, mesh: &mesh, per_side };
        (discs.at_point(x, DVec3::Z, &mesh.list[1], &mut Work::default()) - exact).abs() / exact
    };
    // The area of a disc in the denominator and the midpoint rule are both off by the order of that area.
    let [two, four, eight] = [2, 4, 8].map(error);
    assert!(two < 0.2 && four < two / 3.0 && eight < four / 3.0, "{two} {four} {eight}");
}

#[test]
fn a_defect_too_large_is_refused_with_its_place() {
    let world = World::new(&room());
    let mesh = mesh(&world, 0.8);
    let mut factors = FormFactors::new(&world, &mesh, &Hemicube { world: &world, mesh: &mesh, resolution: 4 });
    let error = factors.balance(&mesh, &world, 0.05).expect_err("too coarse");
    assert!(error.to_string().contains("form factors of the patch about"), "{error}");
}

fn by(method: Method, patches: Option<u32>) -> SolveOptions {
    SolveOptions { method, patches, ..SolveOptions::default() }
}

/// All but the default and the reference.
fn classic() -> &'static [Method] {
    &Method::ALL[2..]
}

/// A room of 4 × 3 × 2.5 m with a lamp that hangs low and a box on the floor.
fn hanging() -> Build {
    let mut b = Build::new();
    let wall = b.material(diffuse("wall", 0.6));
    let lamp = b.material(lit(diffuse("lamp", 0.0), 3000.0));
    b.room(DVec3::ZERO, at(4.0, 3.0, 2.5), [wall; 6]);
    b.block(at(2.4, 1.1, 0.0), at(3.1, 1.9, 1.0), wall);
    b.lamp(at(1.5, 1.5, 1.9), 1.0, lamp);
    b
}

#[test]
fn every_method_states_an_error_that_holds_the_truth() {
    let mut b = hanging();
    b.level("high", at(0.2, 0.2, 1.3), at(3.8, 2.8, 1.3), 5);
    let truth = solve(&b.0, &common::within(0.02));
    for method in classic().iter().copied() {
        let m = solve(&b.0, &by(method, Some(6)));
        let mut cover = Cover::default();
        cover.enter_pair(&m.grids[0], &truth.grids[0], method.name());
        cover.assert();
        if method != Method::Progressive {
            assert_balanced(&m);
        }
    }
}

#[test]
fn a_lamp_close_to_the_ceiling_is_too_near_for_discs() {
    // The back of the lamp sees the ceiling at a twentieth of its side.
    let mut b = furnished();
    b.level("high", at(0.4, 0.4, 1.6), at(3.6, 2.6, 1.6), 2);
    let error = measure::solve(&b.0, &by(Method::Discs, Some(4)), &Silent).expect_err("too near");
    assert!(error.to_string().contains("finer form factor method"), "{error}");
}

#[test]
fn a_tolerance_chooses_the_patches() {
    let mut b = furnished();
    b.level("high", at(0.4, 0.4, 1.6), at(3.6, 2.6, 1.6), 3);
    let m = solve(&b.0, &SolveOptions { tolerance: 0.1, ..by(Method::ConjugateGradients, None) });
    common::assert_holding(&m);
}

#[test]
fn a_gather_beats_interpolation_and_that_beats_flat_patches() {
    let mut b = cube(0.6);
    let n = 18;
    let place = |k: usize| (k as f64 + 0.5) / n as f64;
    let points: Vec<(DVec3, DVec3)> = (0..n * n).map(|k| (at(0.0, place(k % n), place(k / n)), DVec3::X)).collect();
    b.points("wall", &points);
    let truth = lux(&solve(&b.0, &by(Method::ConjugateGradients, Some(16))));
    let off = |display| {
        let shown = lux(&solve(&b.0, &SolveOptions { display, ..by(Method::ConjugateGradients, Some(4)) }));
        shown.iter().zip(&truth).map(|(a, t)| (a - t).powi(2)).sum::<f64>().sqrt()
    };
    let [flat, bilinear, gather] = [Display::Constant, Display::Bilinear, Display::Gather].map(off);
    assert!(gather < 0.5 * bilinear && bilinear < 0.7 * flat, "{flat} {bilinear} {gather}");
}

#[test]
fn mirrors_are_refused_by_the_classic_methods() {
    let mut b = cube(0.5);
    let shiny = b.material(mirror(0.9));
    b.rectangle(at(0.3, 0.3, 0.5), at(0.2, 0.0, 0.0), at(0.0, 0.2, 0.0), shiny);
    for method in classic().iter().copied() {
        let error = measure::solve(&b.0, &by(method, None), &Silent).expect_err("a mirror");
        assert!(error.to_string().contains("mirrors or glass"), "{error}");
    }
}

#[test]
fn too_many_patches_are_refused_before_they_are_made() {
    let error = measure::solve(&cube(0.5).0, &by(Method::Gathering, Some(200)), &Silent).expect_err("too many");
    assert!(error.to_string().contains("at most"), "{error}");
}

#[test]
fn threads_do_not_move_a_bit() {
    let mut b = hanging();
    b.level("high", at(0.4, 0.4, 1.3), at(3.6, 2.6, 1.3), 3);
    let run = |threads, method| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| lux(&solve(&b.0, &by(method, Some(4)))))
    };
    for method in classic().iter().copied() {
        assert_eq!(run(1, method), run(3, method), "{}", method.name());
    }
}
