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
/// Longest side of the room.
const LONGEST_M: f64 = 6.0;
/// Time after which no finer room is tried.
const LONG_S: f64 = 20.0;

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
    for distance_m in [0.2, 0.1, 0.05, 0.025] {
        let s = refined(&squares(distance_m), 1e-3, 0.01)?;
        growth(out, &format!("squares {distance_m} m apart, links within 0.01"), &s);
    }
    let room = furnished_room();
    for patches in [8.0, 16.0, 32.0, 64.0] {
        let s = refined(&room, LONGEST_M / patches, 0.02)?;
        growth(out, &format!("room, finest 1/{patches}, links within 0.02"), &s);
    }
    for patches in [16.0, 32.0, 64.0, 128.0, 256.0f64] {
        let start = Instant::now();
        let s = refined(&room, LONGEST_M / patches, 0.5 / patches.powf(0.75))?;
        growth(out, &format!("room, finest 1/{patches}, links within 0.5 (1/{patches})^0.75"), &s);
        if start.elapsed().as_secs_f64() > LONG_S {
            break;
        }
    }
    errors(out, &room)
}

fn growth(out: &mut Table, name: &str, s: &Solved) {
    let (links, elements) = (s.hierarchy.links() as f64, s.system.len() as f64);
    out.enter("A15", &format!("{name}: elements"), elements, "1e3 to 1e5");
    out.enter("A15", &format!("{name}: links per element"), links / elements, "constant within 30 %");
    out.enter("A15", &format!("{name}: energy balance open by, x 1e-6"), 1e6 * open_balance(s), "at most 1");
}

/// Error of the irradiance at points all over the room: patches' own values, and gathers at the points.
fn errors(out: &mut Table, room: &World) -> Outcome<()> {
    let fine = mesh(room, 0.4);
    let points = mesh(room, 0.21);
    let gathered = |mesh: &dyn Patches, sent: &[f64]| -> Vec<f64> {
        let analytic = Analytic::new(room, mesh);
        let factors = |work: &mut Work, e: &Patch| {
            let x = room.lift(e.centre, e.normal);
            sent.iter().enumerate().map(|(j, b)| b * analytic.at_point(x, e.normal, j, work)).sum::<f64>()
        };
        points.list.par_iter().map_init(Work::default, factors).collect()
    };
    let truth = gathered(&fine, &uniform(room, &fine)?.1);
    let weigh = |f: &dyn Fn(usize) -> f64| points.list.iter().enumerate().map(|(k, e)| e.area * f(k)).sum::<f64>();
    let mean = weigh(&|k| truth[k]) / weigh(&|_| 1.0);
    let rms = |field: &[f64]| 100.0 * (weigh(&|k| (field[k] - truth[k]).powi(2)) / weigh(&|_| 1.0)).sqrt() / mean;
    let flat = |mesh: &dyn Patches, h: &[f64]| -> Vec<f64> {
        let uv = |e: &Patch| room.surfaces.list[e.surface as usize].uv(e.centre);
        let under = |e: &Patch| mesh.find(e.surface as usize, e.front, uv(e));
        points.list.iter().map(|e| under(e).map_or(0.0, |i| h[i as usize])).collect()
    };
    let mut enter = |name: &str, exchanges: usize, mesh: &dyn Patches, b: &[f64], h: &[f64]| {
        out.enter("A15", &format!("{name}: exchanges"), exchanges as f64, "");
        out.enter("A15", &format!("{name}: flat, RMS %"), rms(&flat(mesh, h)), "links below pairs at equal numbers");
        out.enter("A15", &format!("{name}: gather, RMS %"), rms(&gathered(mesh, b)), "links below pairs");
    };
    for size_m in [1.6, 1.2, 0.8, 0.6] {
        let mesh = mesh(room, size_m);
        let (pairs, b, h) = uniform(room, &mesh)?;
        enter(&format!("room, uniform patches of {size_m} m"), pairs, &mesh, &b, &h);
    }
    for patches in [4.0, 8.0, 12.0, 16.0f64] {
        let s = refined(room, LONGEST_M / patches, 0.7 / patches.powf(1.5))?;
        let (links, o) = (s.hierarchy.links(), &s.outcome);
        enter(&format!("room, hierarchy of {patches}"), links, &s.hierarchy.tree, &o.radiosity, &o.irradiance);
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
