//! Materials and solvers: black, white, nearly white, unlike, coupled.

use clerestory::error::ErrorKind;
use clerestory::measure::{Display, Measurement, Method, SolveOptions};
use clerestory::mesh::PatchMesh;
use clerestory::solve::dense::{Shooting, Solver, System};
use clerestory::transport::World;
use clerestory::transport::form_factor::{self, Analytic, FormFactors, Work};
use glam::DVec3;

use super::common::{
    self, Build, assert_near, assert_ratio, at, cube, diffuse, joined_by_a_hole, lit, lux, mirror, only, refusal,
    solve, within,
};
use super::tools::{irradiance, square};

#[test]
fn black_surfaces_need_no_iteration() {
    let mut b = cube(0.0);
    b.level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 3);
    let m = solve(&b.0, &within(0.05));
    let ceiling = square(at(0.0, 0.0, 1.0), DVec3::Y, DVec3::X);
    for s in only(&m) {
        assert_eq!(s.reflected_lx, 0.0);
        assert_ratio(s.xyz[1], irradiance(s.position, DVec3::Z, &ceiling), 2e-5, "direct light"); // the skin of the floor
    }
    let products = m.record.counts.iter().find(|c| c.0 == "products").expect("counted").1;
    assert!(products <= 1, "{products} products");
}

#[test]
fn a_closed_room_that_reflects_everything_is_refused() {
    let mut b = cube(1.0);
    b.level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 2);
    let error = refusal(&b.0);
    assert_eq!(error.kind(), ErrorKind::Impossible);
    assert!(error.to_string().contains("reflects everything"), "{error}");
}

/// Share of the light entering one end of a slot of gap 1 and length `length` between endless walls that leaves at
/// the other end. Mirrors at both sides make the walls endless; the entrance is a black lamp.
fn slot(length: f64, rho: f64, tolerance: f64) -> (Measurement, f64) {
    let mut b = Build::new();
    let wall = b.material(diffuse("wall", rho));
    let lamp = b.material(lit(diffuse("entry", 0.0), 1.0));
    let side = b.material(mirror(1.0));
    let wide = 4.0;
    let (x, y, z) = (DVec3::X * length, DVec3::Y * wide, DVec3::Z);
    b.rectangle(DVec3::ZERO, x, y, wall).rectangle(z, y, x, wall);
    b.rectangle(DVec3::ZERO, z, x, side).rectangle(y, x, z, side);
    b.rectangle(DVec3::ZERO, y, z, lamp);
    let points: Vec<(DVec3, DVec3)> =
        (0..8).map(|k| (at(length, wide * 0.5, (f64::from(k) + 0.5) / 8.0), -DVec3::X)).collect();
    b.points("exit", &points);
    let m = solve(&b.0, &within(tolerance));
    let share = m.ledger.escaped[0] / m.ledger.emitted[0];
    (m, share)
}

#[test]
fn open_slots_pass_their_known_share_of_light_even_with_perfect_walls() {
    // Integral equation of the slot by product integration; ρ = 1 is Clausing's problem of 1932.
    for (length, rho, share) in [
        (2.0, 0.5, 0.310_425_1),
        (2.0, 0.8, 0.410_533_9),
        (2.0, 1.0, 0.542_057_8),
        (10.0, 0.5, 0.055_591_1),
        (10.0, 1.0, 0.240_557_2),
    ] {
        let (m, found) = slot(length, rho, 0.02);
        common::assert_balanced(&m);
        // The exit's mean over eight points, and the flux in the balance: two ways to the same number. A midpoint
        // rule of eight is good to 1e-3 here.
        let mean = lux(&m).iter().sum::<f64>() / 8.0;
        let error = only(&m).iter().map(|s| s.error_lx).sum::<f64>() / 8.0;
        assert_near(mean, share, error + 1e-3 * share, &format!("length {length}, ρ {rho}: at the exit"));
        let sampling = m.ledger.sampling_error[0] / m.ledger.emitted[0];
        assert_near(found, share, sampling.max(0.02 * share), &format!("length {length}, ρ {rho}: in the balance"));
    }
}

#[test]
fn a_room_behind_a_small_hole_is_judged_honestly() {
    let (rho, side) = (0.9, 0.1);
    let mut b = joined_by_a_hole(rho, side);
    b.level("behind", at(1.0, 0.0, 0.0), at(2.0, 1.0, 0.0), 3);
    b.points("hole", &[(at(1.0, 0.5, 0.5), -DVec3::X), (at(1.0, 0.5, 0.5), DVec3::X)]);
    let m = solve(&b.0, &within(0.05));
    let [into, back] = [0, 1].map(|k| &m.grids[1].sensors[k]);
    // What enters, minus what goes back, is absorbed behind the hole: (1 − ρ) of the mean there times the wall.
    let area = side * side;
    let entering = area * (into.xyz[1] - back.xyz[1]) / ((1.0 - rho) * (6.0 - area));
    let slack = area * (into.error_lx + back.error_lx) / ((1.0 - rho) * (6.0 - area));
    let behind = &m.grids[0].sensors;
    let mean = behind.iter().map(|s| s.xyz[1]).sum::<f64>() / behind.len() as f64;
    let error = behind.iter().map(|s| s.error_lx).sum::<f64>() / behind.len() as f64;
    // The floor's mean against that of all walls: the hole's beam crosses the room to the far wall, so the floor is a
    // little darker than the mean at ρ = 0.9.
    assert_near(mean, entering, error + slack + 0.1 * entering, "mean behind the hole");
}

/// A mesh of the fronts of a scene, patches of `size_m`.
fn fronts(world: &World, size_m: f64) -> PatchMesh {
    PatchMesh::uniform(&world.surfaces, size_m / world.surfaces.frame.size_m, |p| p.front)
}

/// Analytic factors, each times a gain that depends on the pair.
struct Gained<'a, G> {
    inner: Analytic<'a>,
    gain: G,
}

impl<G: Fn(usize, usize) -> f64 + Sync> form_factor::Method for Gained<'_, G> {
    fn describe(&self) -> String {
        "analytic with a gain".into()
    }

    fn row(&self, i: usize, row: &mut [f64], work: &mut Work) {
        self.inner.row(i, row, work);
        row.iter_mut().enumerate().for_each(|(j, f)| *f *= (self.gain)(i, j));
    }
}

fn gained(world: &World, mesh: &PatchMesh, gain: impl Fn(usize, usize) -> f64 + Sync) -> FormFactors {
    FormFactors::new(world, mesh, &Gained { inner: Analytic::new(world, mesh), gain })
}

/// One reflectance, the last surface (a ceiling) emitting 1.
fn ceiling_emits(world: &World, mesh: &PatchMesh, rho: f64) -> System {
    let last = world.surfaces.list.len() as u32 - 1;
    System {
        bands: 1,
        areas: mesh.list.iter().map(|p| p.area).collect(),
        rho: vec![rho; mesh.list.len()],
        emitted: mesh.list.iter().map(|p| f64::from(u8::from(p.surface == last))).collect(),
    }
}

fn mean(system: &System, values: &[f64]) -> f64 {
    let sum: f64 = system.areas.iter().zip(values).map(|(a, v)| a * v).sum();
    sum / system.areas.iter().sum::<f64>()
}

#[test]
fn noise_of_form_factors_is_balanced_away() {
    let world = World::new(&cube(0.9).0);
    let mesh = fronts(&world, 0.25);
    let system = ceiling_emits(&world, &mesh, 0.9);
    let solve = |f: &FormFactors| system.solve(f, Solver::FullMatrix, 1e-9).expect("a solution").radiosity;
    let exact = solve(&gained(&world, &mesh, |_, _| 1.0));
    let off = |b: &[f64]| b.iter().zip(&exact).map(|(b, e)| (b - e).abs() / e).fold(0.0, f64::max);
    // Uniform noise of 2 % standard deviation, the same in every run.
    let unit = |i: usize, j: usize| (((i * 7919 + j * 104_729) as f64).sin() * 43_758.545).rem_euclid(1.0);
    let mut noisy = gained(&world, &mesh, |i, j| 1.0 + 0.02 * 12f64.sqrt() * (unit(i, j) - 0.5));
    let raw = off(&solve(&noisy));
    noisy.balance(&mesh, &world, 0.05).expect("little to mend");
    let mended = off(&solve(&noisy));
    // Rows of 80 factors are off by 2 %/√(2·80) or so, which 1/(1 − ρ) makes ten times as much; without it, what is left
    // is of the size of that itself.
    assert!(mended < 0.004 && mended < 0.5 * raw, "{raw} before, {mended} after");
}

#[test]
fn an_open_scene_is_not_filled_up_with_light() {
    let mut b = cube(0.9);
    b.0.faces.remove(0);
    let world = World::new(&b.0);
    let mesh = fronts(&world, 0.5);
    let raw = gained(&world, &mesh, |_, _| 1.0);
    let mut balanced = raw.clone();
    balanced.balance(&mesh, &world, 0.05).expect("nothing to mend");
    assert!(!raw.closed);
    for i in 0..raw.len() {
        for j in 0..raw.len() {
            assert_near(balanced.factor(i, j), raw.factor(i, j), 1e-12, "factor");
        }
    }
}

#[test]
fn rows_that_are_too_large_are_balanced_or_refused() {
    let world = World::new(&cube(0.9).0);
    let mesh = fronts(&world, 1.0);
    let mut factors = gained(&world, &mesh, |_, _| 1.01);
    let solve = |f: &FormFactors, rho: f64| ceiling_emits(&world, &mesh, rho).solve(f, Solver::FullMatrix, 1e-9);
    // Unbalanced: (1/6)/(1 − 1.01 ρ), where (1/6)/(1 − ρ) is right: a tenth too much at 0.9, negative at 0.995.
    let system = ceiling_emits(&world, &mesh, 0.9);
    let raw = solve(&factors, 0.9).expect("it is finite").radiosity;
    assert_ratio(mean(&system, &raw), 1.0 / 6.0 / (1.0 - 0.909), 1e-9, "unbalanced");
    let error = solve(&factors, 0.995).expect_err("it would grow").to_string();
    assert!(error.contains("would grow at every reflection") && error.contains("1.01"), "{error}");
    factors.balance(&mesh, &world, 0.05).expect("one per cent");
    for rho in [0.9, 0.98, 0.99, 0.995] {
        let b = solve(&factors, rho).expect("a solution").radiosity;
        assert_ratio(mean(&system, &b), 1.0 / 6.0 / (1.0 - rho), 1e-9, &format!("balanced, ρ = {rho}"));
    }
}

#[test]
fn near_white_rooms_are_solved_to_the_stated_bound() {
    let world = World::new(&cube(0.9).0);
    let mesh = fronts(&world, 0.5);
    let mut factors = gained(&world, &mesh, |_, _| 1.0);
    factors.balance(&mesh, &world, 0.05).expect("closes");
    for rho in [0.99, 0.999, 0.9999] {
        let system = ceiling_emits(&world, &mesh, rho);
        let exact = system.solve(&factors, Solver::FullMatrix, 1e-9).expect("a solution").radiosity;
        let largest = exact.iter().copied().fold(0.0, f64::max);
        for solver in [Solver::Jacobi, Solver::GaussSeidel, Solver::Overshooting, Solver::ConjugateGradients] {
            let outcome = system.solve(&factors, solver, 1e-3 * (1.0 - rho)).expect("a solution");
            let off = outcome.radiosity.iter().zip(&exact).map(|(b, e)| (b - e).abs()).fold(0.0, f64::max) / largest;
            // Elimination itself is good to rounding over 1 − ρ.
            assert!(
                off <= outcome.bound + 1e-15 / (1.0 - rho),
                "{solver:?} at {rho}: {off:e}, bound {:e}",
                outcome.bound
            );
            assert!(
                outcome.bound < 0.1 || (rho > 0.999 && solver == Solver::Jacobi),
                "{solver:?} at {rho}: bound {:e}",
                outcome.bound
            );
        }
        let iterations =
            system.solve(&factors, Solver::ConjugateGradients, 1e-6 * (1.0 - rho)).expect("solved").iterations;
        assert!(iterations <= 20, "{iterations} products at {rho}");
    }
}

#[test]
fn every_solver_leaves_black_rooms_to_their_lamps() {
    let world = World::new(&cube(0.0).0);
    let mesh = fronts(&world, 0.5);
    let mut factors = gained(&world, &mesh, |_, _| 1.0);
    factors.balance(&mesh, &world, 0.05).expect("closes");
    let system = ceiling_emits(&world, &mesh, 0.0);
    for solver in [
        Solver::FullMatrix,
        Solver::Jacobi,
        Solver::GaussSeidel,
        Solver::Southwell,
        Solver::Overshooting,
        Solver::ConjugateGradients,
    ] {
        let outcome = system.solve(&factors, solver, 1e-9).expect("a solution");
        assert_eq!(outcome.radiosity, system.emitted, "{solver:?}");
        assert!(outcome.irradiance.iter().all(|h| h.is_finite()), "{solver:?}");
    }
}

#[test]
fn light_is_conserved_at_every_shot() {
    for open in [false, true] {
        let mut b = cube(0.5);
        if open {
            b.0.faces.remove(0);
        }
        let world = World::new(&b.0);
        let mesh = fronts(&world, 0.5);
        let mut factors = gained(&world, &mesh, |_, _| 1.0);
        factors.balance(&mesh, &world, 0.05).expect("closes");
        let system = ceiling_emits(&world, &mesh, 0.7);
        let exact = system.solve(&factors, Solver::FullMatrix, 1e-9).expect("a solution").radiosity;
        let n = system.len();
        let emitted: f64 = system.emitted_flux()[0];
        let escapes = |i: usize| 1.0 - factors.exchange_row(i).iter().sum::<f64>() / system.areas[i];
        let mut state = Shooting::new(&system, &factors, false);
        let (mut shot, mut escaped) = (vec![0.0; n], 0.0);
        for step in 0..3 * n {
            let before = state.displayed(false);
            let i = state.shoot().expect("there is more to shoot");
            let given = before[i] - shot[i];
            shot[i] = before[i];
            escaped += given * system.areas[i] * escapes(i);
            let now = state.displayed(false);
            let absorbed: f64 = (0..n).map(|k| system.areas[k] * (now[k] - system.emitted[k]) * (0.3 / 0.7)).sum();
            let unshot = state.unshot() * emitted;
            assert_near(
                absorbed + escaped + unshot,
                emitted,
                1e-12 * emitted,
                &format!("open: {open}, after {step} shots"),
            );
            // What is unshot can raise the flux of all patches by its own over 1 − ρ, and no more.
            let missing: f64 = (0..n).map(|k| system.areas[k] * (exact[k] - now[k])).sum();
            assert!(missing >= -1e-12 && missing <= unshot / 0.3 + 1e-12, "{missing} missing, {unshot} unshot");
        }
    }
}

#[test]
fn what_is_not_shot_is_labelled() {
    let mut b = cube(0.7);
    b.level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 2);
    let options =
        SolveOptions { method: Method::Progressive, patches: Some(2), shots: Some(2), ..SolveOptions::default() };
    let m = solve(&b.0, &options);
    assert!(m.record.left_out.iter().any(|l| l.what.contains("not shot")), "{:?}", m.record.left_out);
    let truth = solve(&b.0, &within(0.02));
    for (s, t) in only(&m).iter().zip(only(&truth)) {
        assert_near(s.xyz[1], t.xyz[1], s.error_lx + t.error_lx, "two shots and an ambient term");
    }
}

#[test]
fn every_room_behind_a_pinhole_is_solved_to_its_own_scale() {
    // Two cubes of 0.9 joined by a hole of 1 cm: two slow modes, and one room thousands of times as dark.
    let (rho, side) = (0.9, 0.01);
    let mut b = joined_by_a_hole(rho, side);
    b.level("behind", at(1.2, 0.2, 0.5), at(1.8, 0.8, 0.5), 2);
    let by = |method| solve(&b.0, &SolveOptions { method, patches: Some(3), ..SolveOptions::default() });
    let exact = by(Method::FullMatrix);
    for method in [Method::ConjugateGradients, Method::Gathering, Method::Shooting] {
        for (s, e) in only(&by(method)).iter().zip(only(&exact)) {
            // The same matrix: only the solver differs. A thousandth of the tolerance of 5 % is its share.
            assert_ratio(s.xyz[1], e.xyz[1], 0.05e-2, &format!("{} behind the hole", method.name()));
        }
    }
}

/// Readings at points of a wall that a lamp on the floor grazes: steep at its foot, and continued to the corner.
fn on_a_grazed_wall(points: &[(DVec3, DVec3)], patches: u32, display: Display) -> Vec<f64> {
    let mut b = cube(0.0);
    b.0.materials[1].emission = None;
    let lamp = b.material(lit(diffuse("lamp", 0.0), 1000.0));
    b.rectangle(at(0.3, 0.3, 1e-3), DVec3::X * 0.4, DVec3::Y * 0.4, lamp);
    b.points("wall", points);
    let method = Method::ConjugateGradients;
    lux(&solve(&b.0, &SolveOptions { method, patches: Some(patches), display, ..SolveOptions::default() }))
}

#[test]
fn interpolated_values_are_never_negative() {
    let points: Vec<(DVec3, DVec3)> = (0..60).map(|k| (at(0.0, 0.5, (f64::from(k) + 0.5) / 60.0), DVec3::X)).collect();
    for patches in [2, 3, 5, 8] {
        for e in on_a_grazed_wall(&points, patches, Display::Bilinear) {
            assert!((0.0..1000.0).contains(&e), "{patches} patches: {e} lx");
        }
    }
}

#[test]
fn interpolation_keeps_the_flux_of_every_patch() {
    for patches in [2u32, 3, 5] {
        // The middles of a patch's quarters: their mean is that of all that is linear in each of them.
        let place = |k: u32| (f64::from(k) + 0.5) / f64::from(2 * patches);
        let cells: Vec<[u32; 2]> = (0..patches * patches).map(|k| [2 * (k % patches), 2 * (k / patches)]).collect();
        let points: Vec<(DVec3, DVec3)> = cells
            .iter()
            .flat_map(|[i, j]| [(*i, *j), (i + 1, *j), (*i, j + 1), (i + 1, j + 1)])
            .map(|(i, j)| (at(0.0, place(i), place(j)), DVec3::X))
            .collect();
        let flat = on_a_grazed_wall(&points, patches, Display::Constant);
        let linear = on_a_grazed_wall(&points, patches, Display::Bilinear);
        assert!(flat.iter().zip(&linear).any(|(f, l)| (f - l).abs() > 0.1 * f), "{patches} patches are all flat");
        for (flat, linear) in flat.chunks_exact(4).zip(linear.chunks_exact(4)) {
            assert_ratio(linear.iter().sum::<f64>() / 4.0, flat[0], 1e-6, &format!("{patches} patches"));
        }
    }
}

#[test]
fn the_classic_methods_scale_with_the_light() {
    let run = |exitance: f64| {
        let mut b = cube(0.5);
        b.0.materials[1].emission = Some(common::white(exitance));
        b.level("floor", DVec3::ZERO, at(1.0, 1.0, 0.0), 2);
        let by = |method| lux(&solve(&b.0, &SolveOptions { method, patches: Some(3), ..SolveOptions::default() }));
        [Method::FullMatrix, Method::Gathering, Method::Shooting, Method::ConjugateGradients, Method::Progressive]
            .map(by)
    };
    let one = run(1.0);
    for exitance in [1e-30, 1e30] {
        for (scaled, plain) in run(exitance).iter().flatten().zip(one.iter().flatten()) {
            // Direct light is kept in single precision.
            assert_ratio(scaled / exitance, *plain, 1e-6, &format!("{exitance:e}"));
        }
    }
}

#[test]
fn open_plates_lose_what_they_do_not_absorb_to_rounding() {
    let mut b = Build::new();
    let below = b.material(lit(diffuse("below", 0.8), 1.0));
    let above = b.material(diffuse("above", 0.8));
    b.rectangle(DVec3::ZERO, DVec3::X, DVec3::Y, below).rectangle(DVec3::Z, DVec3::Y, DVec3::X, above);
    let share = |patches| {
        let options = SolveOptions {
            method: Method::ConjugateGradients,
            patches: Some(patches),
            tolerance: 1e-4,
            ..SolveOptions::default()
        };
        let l = solve(&b.0, &options).ledger;
        assert_ratio(l.absorbed[0] + l.escaped[0], l.emitted[0], 1e-6, "the balance");
        l.absorbed[0] / l.emitted[0]
    };
    // 0.0476890 by quadrature of the integral equation; flat patches near it with the square of their size.
    let off = [2, 4, 8].map(|n| (share(n) - 0.047_689_0).abs());
    assert!(off[1] < off[0] / 3.0 && off[2] < off[1] / 3.0 && off[2] < 1e-4, "{off:?}");
}

#[test]
fn a_tube_with_perfect_walls_passes_clausings_share() {
    // A prism of 48 sides with the section of a tube of radius 1; its length is 1.
    let n = 48;
    let corner = std::f64::consts::TAU / f64::from(n);
    let r = (corner / corner.sin()).sqrt();
    let point = |k: i32, z: f64| at(r * (corner * f64::from(k)).cos(), r * (corner * f64::from(k)).sin(), z);
    let mut b = Build::new();
    let (wall, lamp) = (b.material(diffuse("wall", 1.0)), b.material(lit(diffuse("entry", 0.0), 1.0)));
    for k in 0..n {
        b.face(&[point(k, 0.0), point(k, 1.0), point(k + 1, 1.0), point(k + 1, 0.0)], wall);
    }
    b.face(&(0..n).map(|k| point(k, 0.0)).collect::<Vec<_>>(), lamp);
    // The exit is asked, else nobody needs the walls.
    let points: Vec<(DVec3, DVec3)> = (0..12).map(|k| (point(4 * k, 1.0) * at(0.7, 0.7, 1.0), -DVec3::Z)).collect();
    b.points("exit", &points);
    let m = solve(&b.0, &within(0.02));
    common::assert_balanced(&m);
    let share = m.ledger.escaped[0] / m.ledger.emitted[0];
    let sampling = m.ledger.sampling_error[0] / m.ledger.emitted[0];
    // Clausing 1932; a prism of n sides is longer round by 1/n², which is less than a thousandth.
    assert_near(share, 0.671_983_9, sampling.max(1e-3) + 1e-3, "length = radius");
}

#[test]
fn a_small_fierce_lamp_does_not_hide_the_walls_from_the_solver() {
    let mut b = Build::new();
    let (wall, lamp) = (b.material(diffuse("wall", 0.8)), b.material(lit(diffuse("lamp", 0.0), 1e8)));
    b.room(DVec3::ZERO, at(4.0, 3.0, 2.5), [wall; 6]).lamp(at(2.0, 1.5, 2.4), 1e-3, lamp);
    b.level("floor", at(0.5, 0.5, 0.0), at(3.5, 2.5, 0.0), 2);
    let by = |method| solve(&b.0, &SolveOptions { method, patches: Some(4), ..SolveOptions::default() });
    let exact = by(Method::FullMatrix);
    for method in [Method::Gathering, Method::Shooting, Method::ConjugateGradients] {
        let m = by(method);
        common::assert_balanced(&m);
        for (s, e) in only(&m).iter().zip(only(&exact)) {
            assert_ratio(s.xyz[1], e.xyz[1], 0.05e-2, method.name());
        }
    }
}
