//! Whole rooms: gaps, plates, pinholes, tiny lamps.

use clerestory::measure::{Method, SolveOptions};
use glam::DVec3;

use super::common::{Build, at, diffuse, joined_by_a_hole, lit, lux, only, solve, within};
use super::{Outcome, Table};

pub(super) fn run(out: &mut Table) -> Outcome<()> {
    plates(out);
    pinhole(out);
    tiny_lamp(out);
    Ok(())
}

fn classic(method: Method, patches: u32) -> SolveOptions {
    SolveOptions { method, patches: Some(patches), ..SolveOptions::default() }
}

/// Open plates: the share absorbed, 0.0476890 by quadrature of the integral equation.
fn plates(out: &mut Table) {
    let mut b = Build::new();
    let (below, above) = (b.material(lit(diffuse("below", 0.8), 1.0)), b.material(diffuse("above", 0.8)));
    b.rectangle(DVec3::ZERO, DVec3::X, DVec3::Y, below).rectangle(DVec3::Z, DVec3::Y, DVec3::X, above);
    for patches in [1, 2, 4, 8] {
        let l = solve(&b.0, &classic(Method::ConjugateGradients, patches)).ledger;
        let open = (l.absorbed[0] + l.escaped[0]) / l.emitted[0] - 1.0;
        out.enter(
            "open plates",
            f64::from(patches),
            "conjugate gradients: absorbed",
            Some(l.absorbed[0] / l.emitted[0] / 0.047_689 - 1.0),
        );
        out.enter("open plates", f64::from(patches), "conjugate gradients: balance open by", Some(open));
    }
    b.level("below", DVec3::ZERO, at(1.0, 1.0, 0.0), 5);
    let l = solve(&b.0, &within(0.01)).ledger;
    out.enter("open plates", 0.01, "default at 1 %: absorbed", Some(l.absorbed[0] / l.emitted[0] / 0.047_689 - 1.0));
    out.enter(
        "open plates",
        0.01,
        "default at 1 %: balance open by",
        Some((l.absorbed[0] + l.escaped[0]) / l.emitted[0] - 1.0),
    );
}

/// Two cubes of reflectance 0.9 joined by a hole: the dark one against the full matrix, and what was stated.
fn pinhole(out: &mut Table) {
    for side in [0.1, 0.03, 0.01] {
        let mut b = joined_by_a_hole(0.9, side);
        b.level("behind", at(1.2, 0.2, 0.5), at(1.8, 0.8, 0.5), 2);
        let exact = lux(&solve(&b.0, &classic(Method::FullMatrix, 6)));
        let runs = [
            ("gathering", classic(Method::Gathering, 6)),
            ("shooting", classic(Method::Shooting, 6)),
            ("conjugate gradients", classic(Method::ConjugateGradients, 6)),
            ("default at 5 %", within(0.05)),
        ];
        for (name, options) in runs {
            let m = solve(&b.0, &options);
            let pairs = || only(&m).iter().zip(&exact);
            let worst = pairs().map(|(s, e)| (s.xyz[1] / e - 1.0).abs()).fold(0.0, f64::max);
            let stated = pairs().map(|(s, e)| s.error_lx / e).fold(0.0, f64::max);
            out.enter("pinhole", side, name, Some(worst));
            out.enter("pinhole", side, &format!("{name}: stated"), Some(stated));
        }
    }
}

/// Lamps of one flux and any size, seen from ten metres: the direct light below against a point source.
fn tiny_lamp(out: &mut Table) {
    for side in [1.0, 0.1, 0.01, 1e-3] {
        let mut b = Build::new();
        let (wall, lamp) =
            (b.material(diffuse("wall", 0.5)), b.material(lit(diffuse("lamp", 0.0), 1000.0 / (side * side))));
        b.room(DVec3::ZERO, at(10.0, 10.0, 10.0), [wall; 6]).lamp(at(5.0, 5.0, 9.99), side, lamp);
        b.points("below", &[(at(5.0, 5.0, 0.0), DVec3::Z)]);
        let m = solve(&b.0, &within(0.05));
        let point = 1000.0 / (std::f64::consts::PI * 9.99f64.powi(2));
        out.enter(
            "tiny lamp",
            side,
            "default at 5 %, direct light against a point",
            Some(only(&m)[0].direct_lx / point - 1.0),
        );
    }
}
