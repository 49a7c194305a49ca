//! A7: all solvers agree, and how many products each needs. A8: progressive refinement with the ambient term.

use clerestory::measure::{self, Method, Silent, SolveOptions};
use clerestory::report;
use clerestory::scene::{Emission, MaterialKind, Projection, View};
use clerestory::solve::dense::{Shooting, Solver};
use clerestory::spectrum::{SpectralValue, illuminant};
use glam::DVec3;

use super::{Outcome, Table, analytic, furnished_room, furnished_scene, mesh, system};

/// Side of the patches, m.
const SIZE: f64 = 0.6;

pub(super) fn run(out: &mut Table) -> Outcome<()> {
    let world = furnished_room();
    let mesh = mesh(&world, SIZE);
    let factors = analytic(&world, &mesh)?;
    out.enter("A7", "patches", factors.len() as f64, "");
    let columns: [(f64, [&str; 5]); 6] = [
        (0.3, ["7", "5", "5", "-", "6"]),
        (0.5, ["14", "8", "8", "-", "8"]),
        (0.8, ["47", "25", "25", "-", "13"]),
        (0.9, ["106", "54", "54", "-", "16"]),
        (0.95, ["230", "116", "117", "-", "19"]),
        (0.99, ["1293", "648", "649", "-", "22"]),
    ];
    for (rho, targets) in columns {
        // Uniform reflectance, the lamps' too.
        let system = system(&world, &mesh.list, &[rho; 3], &[0.0, 0.0, 1.0]);
        let exact = system.solve(&factors, Solver::FullMatrix, 1e-9)?;
        let largest = exact.radiosity.iter().copied().fold(0.0, f64::max);
        let solvers =
            [Solver::Jacobi, Solver::GaussSeidel, Solver::Southwell, Solver::Overshooting, Solver::ConjugateGradients];
        for (solver, target) in solvers.into_iter().zip(targets) {
            // The others stop by their last change, which at high reflectance is far below the error.
            let wanted = if solver == Solver::ConjugateGradients { 1e-6 } else { 1e-6 * (1.0 - rho) };
            let outcome = system.solve(&factors, solver, wanted)?;
            let off = outcome.radiosity.iter().zip(&exact.radiosity).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            out.enter(
                "A7",
                &format!("{solver:?} at {rho}: sweeps or products to 1e-6"),
                outcome.iterations as f64,
                target,
            );
            out.enter(
                "A7",
                &format!("{solver:?} at {rho}: largest difference, x 1e-6"),
                1e6 * off / largest,
                "at most 1",
            );
        }
    }
    progressive(out)
}

fn progressive(out: &mut Table) -> Outcome<()> {
    let world = furnished_room();
    let mesh = mesh(&world, 0.65);
    let factors = analytic(&world, &mesh)?;
    let system = system(&world, &mesh.list, &[0.6, 0.5, 0.0], &[0.0, 0.0, 1.0]);
    let truth = system.solve(&factors, Solver::ConjugateGradients, 1e-9)?.radiosity;
    // Lamps shine as they should from the start: surfaces that reflect are compared.
    let lit: Vec<usize> = (0..system.len()).filter(|i| system.rho[*i] > 0.0).collect();
    let area: f64 = lit.iter().map(|&i| system.areas[i]).sum();
    let mean = lit.iter().map(|&i| system.areas[i] * truth[i]).sum::<f64>() / area;
    let off = |b: &[f64]| {
        let sum: f64 = lit.iter().map(|&i| system.areas[i] * (b[i] - truth[i]).powi(2)).sum();
        100.0 * (sum / area).sqrt() / mean
    };
    let n = system.len();
    let per_lamp = (0..n).filter(|i| system.emitted[*i] > 0.0).count() / 2;
    let stops = [
        (0, "ambient only", "45 (107)"),
        (per_lamp, "one lamp shot", "28 (81)"),
        (2 * per_lamp, "two lamps shot", "8.8 (60)"),
        (2 * per_lamp + 24, "and 24 shots", "5.9 (55)"),
        (2 * per_lamp + 100, "and 100 shots", "3.5 (47)"),
        (2 * per_lamp + n, "and n shots", "1.5 (20)"),
        (2 * per_lamp + 2 * n, "and 2n shots", "0.6 (7.2)"),
    ];
    let mut state = Shooting::new(&system, &factors, false);
    let (mut worse, mut log) = (0, String::from("shots,rms_with_ambient,rms_without,unshot\n"));
    for step in 0..=2 * per_lamp + 2 * n {
        let (with, without) = (off(&state.displayed(true)), off(&state.displayed(false)));
        log.push_str(&format!("{step},{},{},{}\n", with / 100.0, without / 100.0, state.unshot()));
        worse += usize::from(step <= n && with > without);
        for (_, name, target) in stops.iter().filter(|s| s.0 == step) {
            out.enter("A8", &format!("{name}: RMS % with the ambient term"), with, target);
            out.enter("A8", &format!("{name}: RMS % without"), without, "in brackets above");
        }
        state.shoot();
    }
    out.enter("A8", "steps up to n shots at which the ambient term did harm", worse as f64, "0");
    std::fs::write(super::folder().join("progressive.csv"), log)?;
    strip()
}

/// The five pictures on the way, in one exposure, side by side.
fn strip() -> Outcome<()> {
    let mut scene = furnished_scene();
    for (m, rho) in scene.materials.iter_mut().zip([0.6, 0.5, 0.0]) {
        m.kind = MaterialKind::Diffuse { front: SpectralValue::Grey(rho), back: SpectralValue::Grey(rho) };
    }
    scene.materials[2].emission =
        Some(Emission { radiance: illuminant("D65").ok_or("no D65")?, two_sided: false, group: None });
    scene.views.push(View {
        name: "room".into(),
        position: DVec3::new(0.3, 4.7, 1.7),
        direction: DVec3::new(1.0, -0.75, -0.15).normalize(),
        up: DVec3::new(0.12, -0.09, 1.25).normalize(),
        projection: Projection::Perspective { horizontal: 85f64.to_radians(), vertical: 69f64.to_radians() },
        width: 240,
        height: 180,
    });
    let options =
        SolveOptions { method: Method::Progressive, patches: Some(16), stages: true, ..SolveOptions::default() };
    let measurement = measure::solve(&scene, &options, &Silent)?;
    let folder = tempfile::tempdir()?;
    report::write_stages(folder.path(), &scene, &measurement)?;
    std::fs::copy(folder.path().join("room_strip.png"), super::folder().join("progressive.png"))?;
    Ok(())
}
