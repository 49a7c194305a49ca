//! Solvers in a cube that is nearly white.

use clerestory::mesh::PatchMesh;
use clerestory::solve::dense::{Shooting, Solver, System};
use clerestory::transport::World;
use clerestory::transport::form_factor::{self, Analytic, FormFactors, Work};
use glam::DVec3;

use super::common::{at, cube, lux, solve, within};
use super::{Outcome, Table};

/// Analytic factors times a gain.
struct Gained<'a> {
    inner: Analytic<'a>,
    gain: f64,
    noise: f64,
}

impl form_factor::Method for Gained<'_> {
    fn describe(&self) -> String {
        "analytic, disturbed".into()
    }

    fn row(&self, i: usize, row: &mut [f64], work: &mut Work) {
        self.inner.row(i, row, work);
        for (j, f) in row.iter_mut().enumerate() {
            let unit = (((i * 7919 + j * 104_729) as f64).sin() * 43_758.545).rem_euclid(1.0);
            *f *= self.gain + self.noise * 12f64.sqrt() * (unit - 0.5);
        }
    }
}

/// Largest error of a radiosity over the exact one.
fn off(b: &[f64], exact: &[f64]) -> f64 {
    b.iter().zip(exact).map(|(b, e)| (b - e).abs() / e).fold(0.0, f64::max)
}

pub(super) fn near_white(out: &mut Table) -> Outcome<()> {
    out.panel("Cube with a glowing ceiling, 96 patches", "1 - reflectance");
    let world = World::new(&cube(0.5).0);
    let mesh = PatchMesh::uniform(&world.surfaces, 0.25 / world.surfaces.frame.size_m, |p| p.front);
    let factors =
        |gain, noise| FormFactors::new(&world, &mesh, &Gained { inner: Analytic::new(&world, &mesh), gain, noise });
    let mut exact_factors = factors(1.0, 0.0);
    exact_factors.balance(&mesh, &world, 0.05)?;
    let (large, noisy) = (factors(1.01, 0.0), factors(1.0, 0.02));
    let mut mended = noisy.clone();
    mended.balance(&mesh, &world, 0.05)?;
    for absorbed in [0.5, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001] {
        let rho = 1.0 - absorbed;
        let system = System {
            bands: 1,
            areas: mesh.list.iter().map(|p| p.area).collect(),
            rho: vec![rho; mesh.list.len()],
            emitted: mesh.list.iter().map(|p| f64::from(u8::from(p.surface == 5))).collect(),
        };
        let exact = system.solve(&exact_factors, Solver::FullMatrix, 1e-9)?.radiosity;
        let by = |f: &FormFactors| system.solve(f, Solver::FullMatrix, 1e-9).ok().map(|o| off(&o.radiosity, &exact));
        out.draw("near white", absorbed, "rows 1 % too large", by(&large));
        out.draw("near white", absorbed, "2 % noise on each factor", by(&noisy));
        out.draw("near white", absorbed, "the same, balanced", by(&mended));
        let step = |solver| system.solve(&exact_factors, solver, 1e-5);
        for (name, solver) in [
            ("Jacobi, steps below 1e-5", Solver::Jacobi),
            ("conjugate gradients, residual 1e-5", Solver::ConjugateGradients),
        ] {
            let outcome = step(solver)?;
            out.draw("near white", absorbed, name, Some(off(&outcome.radiosity, &exact)));
            out.enter("near white", absorbed, &format!("{name}: stated bound"), Some(outcome.bound));
            out.enter("near white", absorbed, &format!("{name}: iterations"), Some(outcome.iterations as f64));
        }
        let mut state = Shooting::new(&system, &exact_factors, false);
        (0..20 * system.len()).for_each(|_| {
            state.shoot();
        });
        out.draw("near white", absorbed, "shooting, 20 shots a patch", Some(off(&state.displayed(false), &exact)));
        out.draw("near white", absorbed, "the same with the ambient term", Some(off(&state.displayed(true), &exact)));
        out.draw("near white", absorbed, "default at 2 %, points of all walls", Some(default(rho)));
    }
    Ok(())
}

/// Largest error of the default in the means over walls. In the mean over all walls a closed room has `E = Φ/(S (1 − ρ))`
/// (Sumpner 1892); the points are midpoints of 4 × 4 cells of each wall, which adds up to a thousandth.
fn default(rho: f64) -> f64 {
    let mut b = cube(rho);
    let place = |k: usize| (k as f64 + 0.5) / 4.0;
    let mut points = Vec::new();
    for k in 0..16 {
        let (s, t) = (place(k % 4), place(k / 4));
        points.extend([
            (at(0.0, s, t), DVec3::X),
            (at(1.0, s, t), -DVec3::X),
            (at(s, 0.0, t), DVec3::Y),
            (at(s, 1.0, t), -DVec3::Y),
            (at(s, t, 0.0), DVec3::Z),
            (at(s, t, 1.0), -DVec3::Z),
        ]);
    }
    b.points("walls", &points);
    let readings = lux(&solve(&b.0, &within(0.02)));
    let mean = readings.iter().sum::<f64>() / readings.len() as f64;
    (mean * 6.0 * (1.0 - rho) - 1.0).abs()
}
