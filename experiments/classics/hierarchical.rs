//! A15: hierarchical radiosity: links against elements, and error against links beside a uniform mesh.

use std::time::Instant;

use clerestory::mesh::{Patch, PatchMesh, Patches};
use clerestory::solve::dense::Solver;
use clerestory::solve::hierarchical::{self, Refinement, Solved};
use clerestory::transport::World;
use clerestory::transport::form_factor::{Analytic, Work};
use glam::DVec3;
use rayon::prelude::*;

use super::{Build, Outcome, Table, analytic, furnished_room, mesh, system};

const RHO: [f64; 3] = [0.6, 0.5, 0.0];
const EMITTED: [f64; 3] = [0.0, 0.0, 1.0];

/// Two unit squares that face each other at a distance; one emits.
fn squares(distance_m: f64) -> World {
    let mut b = Build::new(3);
    b.rectangle(DVec3::ZERO, DVec3::X, DVec3::Y, 0);
    b.rectangle(DVec3::Z * distance_m, DVec3::Y, DVec3::X, 2);
    World::new(&b.scene)
}

fn refined(world: &World, finest_m: f64, allowed: f64) -> Outcome<Solved> {
    let finest = finest_m / world.surfaces.frame.size_m;
    let paint = |patches: &[Patch]| system(world, patches, &RHO, &EMITTED);
    Ok(hierarchical::solve(world, &paint, Refinement { finest, allowed }, 0.05, 1e-9)?)
}

/// Largest share of the emitted flux that is neither absorbed nor gone.
fn open_balance(s: &Solved) -> f64 {
    let sum = |f: &dyn Fn(usize) -> f64| (0..s.system.len()).map(|i| s.system.areas[i] * f(i)).sum::<f64>();
    let stays = s.hierarchy.row_sums();
    let emitted = sum(&|i| s.system.emitted[i]);
    let absorbed = sum(&|i| (1.0 - s.system.rho[i]) * s.outcome.irradiance[i]);
    let escaped = sum(&|i| (1.0 - stays[i]) * s.outcome.radiosity[i]);
    (1.0 - (absorbed + escaped) / emitted).abs()
}

pub(super) fn run(out: &mut Table) -> Outcome<()> {
    let args: Vec<f64> = std::env::args().skip(1).map(|a| a.parse().unwrap()).collect();
    let room = furnished_room();
    if args[0] == 0.0 {
        let w = squares(args[1]);
        for k in 2..args[3] as i32 {
            let start = Instant::now();
            let s = refined(&w, 0.5f64.powi(k) , args[2])?;
            let n = s.system.len();
            println!("squares k {k} n {n} links {} ratio {:.2} rounds {} rays {} factors {} closure {:.1e} t {:.2}", s.hierarchy.links(), s.hierarchy.links() as f64 / n as f64, s.hierarchy.rounds, s.hierarchy.rays, s.hierarchy.factors, open_balance(&s), start.elapsed().as_secs_f64());
        }
    }
    if args[0] == 1.0 {
        for k in 0..args[3] as i32 {
            let start = Instant::now();
            let s = refined(&room, args[1] * 0.5f64.powi(k) , args[2])?;
            let n = s.system.len();
            println!("room k {k} n {n} links {} ratio {:.2} rounds {} rays {} factors {} closure {:.1e} worst {:.1e} rms {:.1e} t {:.2}", s.hierarchy.links(), s.hierarchy.links() as f64 / n as f64, s.hierarchy.rounds, s.hierarchy.rays, s.hierarchy.factors, open_balance(&s), s.hierarchy.worst_root.0, s.hierarchy.closure_defect, start.elapsed().as_secs_f64());
        }
    }
    if args[0] == 2.0 { errors(&room, out, args[1], args[2], args[3] as i32)?; }
    Ok(())
}

fn errors(world: &World, _out: &mut Table, c: f64, p: f64, most: i32) -> Outcome<()> {
    let fine = mesh(world, 0.4);
    let truth_b = uniform(world, &fine)?;
    let points = mesh(world, 0.21);
    let at = |mesh: &dyn Patches, b: &[f64]| -> Vec<f64> {
        let analytic = Analytic::new(world, mesh);
        points.list.par_iter().map_init(Work::default, |work, e| {
            let x = world.lift(e.centre, e.normal);
            (0..b.len()).filter(|j| b[*j] > 0.0).map(|j| b[j] * analytic.at_point(x, e.normal, j, work)).sum::<f64>()
        }).collect()
    };
    let truth = at(&fine, &truth_b.1);
    let area: f64 = points.list.iter().map(|e| e.area).sum();
    let mean = points.list.iter().zip(&truth).map(|(e, t)| e.area * t).sum::<f64>() / area;
    let rms = |field: &[f64]| {
        let sum: f64 = points.list.iter().zip(field.iter().zip(&truth)).map(|(e, (f, t))| e.area * (f - t).powi(2)).sum();
        100.0 * (sum / area).sqrt() / mean
    };
    let flat = |mesh: &dyn Patches, h: &[f64]| -> Vec<f64> {
        points.list.iter().map(|e| mesh.find(e.surface as usize, e.front, world.surfaces.list[e.surface as usize].uv(e.centre)).map_or(0.0, |i| h[i as usize])).collect()
    };
    if std::env::args().count()<6 {for size in [1.6, 1.2, 0.8, 0.6] {
        let start = Instant::now();
        let m = mesh(world, size);
        let (pairs, b, h) = uniform(world, &m)?;
        let t = start.elapsed().as_secs_f64();
        println!("uniform {size} n {} pairs {pairs} flat {:.2} gather {:.2} t {t:.2}", m.list.len(), rms(&flat(&m, &h)), rms(&at(&m, &b)));
    }
    }
    for k in 0..most {
        let n = 4.0 * 2f64.powi(k);
        let start = Instant::now();
        let s = refined(world, 6.0 / n, c / n.powf(p))?;
        let t = start.elapsed().as_secs_f64();
        println!("hier {n} n {} links {} flat {:.2} gather {:.2} t {t:.2} rounds {} closure {:.1e} worst {:.1e} rms {:.1e}", s.system.len(), s.hierarchy.links(), rms(&flat(&s.hierarchy.tree, &s.outcome.irradiance)), rms(&at(&s.hierarchy.tree, &s.outcome.radiosity)), s.hierarchy.rounds, open_balance(&s), s.hierarchy.worst_root.0, s.hierarchy.closure_defect);
    }
    Ok(())
}

/// Pairs that exchange anything, radiosities and irradiances of a uniform mesh.
fn uniform(world: &World, mesh: &PatchMesh) -> Outcome<(usize, Vec<f64>, Vec<f64>)> {
    let factors = analytic(world, mesh)?;
    let pairs = (0..factors.len()).map(|i| factors.exchange_row(i)[..i].iter().filter(|x| **x > 0.0).count()).sum();
    let solved = system(world, &mesh.list, &RHO, &EMITTED).solve(&factors, Solver::ConjugateGradients, 1e-9)?;
    Ok((pairs, solved.radiosity, solved.irradiance))
}
