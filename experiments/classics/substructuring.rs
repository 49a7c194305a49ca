//! A5: patches send, elements receive: the error of a gather for the price of M·N factors.

use std::time::Instant;

use clerestory::mesh::PatchMesh;
use clerestory::solve::dense::Solver;
use clerestory::transport::World;
use clerestory::transport::form_factor::{Analytic, Work};
use rayon::prelude::*;

use super::{Outcome, Table, analytic, furnished_room, mesh, system};

const RHO: [f64; 3] = [0.6, 0.5, 0.0];
const EMITTED: [f64; 3] = [0.0, 0.0, 1.0];
/// Side of the patches, m.
const SIZE: f64 = 0.8;

fn radiosity(world: &World, mesh: &PatchMesh) -> Outcome<Vec<f64>> {
    let factors = analytic(world, mesh)?;
    Ok(system(world, &mesh.list, &RHO, &EMITTED).solve(&factors, Solver::ConjugateGradients, 1e-8)?.radiosity)
}

/// Irradiance of every element from the patches.
fn gathered(world: &World, patches: &PatchMesh, sent: &[f64], elements: &PatchMesh) -> Vec<f64> {
    let analytic = Analytic::new(world, patches);
    elements
        .list
        .par_iter()
        .map_init(Work::default, |work, e| {
            sent.iter().enumerate().map(|(j, b)| b * analytic.between(e, j, work)).sum::<f64>() / e.area
        })
        .collect()
}

pub(super) fn run(out: &mut Table) -> Outcome<()> {
    let world = furnished_room();
    let patches = mesh(&world, SIZE);
    let sent = radiosity(&world, &patches)?;
    // The truth at the elements: gathered from a mesh twice as fine.
    let fine = mesh(&world, SIZE / 2.0);
    let fine_sent = radiosity(&world, &fine)?;
    for parts in [2, 4] {
        let elements = patches.elements(&world.surfaces, parts);
        let truth = gathered(&world, &fine, &fine_sent, &elements);
        let received = gathered(&world, &patches, &sent, &elements);
        let analytic = Analytic::new(&world, &patches);
        let at_centres: Vec<f64> = elements
            .list
            .par_iter()
            .map_init(Work::default, |work, e| {
                let x = world.lift(e.centre, e.normal);
                sent.iter().enumerate().map(|(j, b)| b * analytic.at_point(x, e.normal, j, work)).sum::<f64>()
            })
            .collect();
        let factors = system(&world, &patches.list, &RHO, &EMITTED);
        let of_patches = factors.irradiance(&super::analytic(&world, &patches)?, &sent);
        let flat: Vec<f64> = elements
            .list
            .iter()
            .map(|e| patches.under(&world.surfaces, e).map_or(0.0, |i| of_patches[i as usize]))
            .collect();
        let area: f64 = elements.list.iter().map(|e| e.area).sum();
        let mean = elements.list.iter().zip(&truth).map(|(e, t)| e.area * t).sum::<f64>() / area;
        let rms = |field: &[f64]| {
            let sum: f64 =
                elements.list.iter().zip(field.iter().zip(&truth)).map(|(e, (f, t))| e.area * (f - t).powi(2)).sum();
            100.0 * (sum / area).sqrt() / mean
        };
        let name = |what: &str| format!("patches {SIZE} m, elements 1/{parts}: {what}, RMS %");
        out.enter("A5", &name("flat patches"), rms(&flat), "");
        out.enter("A5", &name("elements"), rms(&received), "a third of the patches' or less");
        out.enter("A5", &name("gather at the elements' centres"), rms(&at_centres), "elements within 25 %");
    }
    cost(&world, out);
    Ok(())
}

/// How time goes with M·N.
fn cost(world: &World, out: &mut Table) {
    let mut logs = Vec::new();
    for (size, parts) in [(1.5, 1), (1.0, 1), (1.0, 2), (0.8, 2), (0.6, 2)] {
        let patches = mesh(world, size);
        let elements = patches.elements(&world.surfaces, parts);
        let start = Instant::now();
        gathered(world, &patches, &vec![1.0; patches.list.len()], &elements);
        let product = (patches.list.len() * elements.list.len()) as f64;
        logs.push([product.ln(), start.elapsed().as_secs_f64().ln()]);
    }
    let n = logs.len() as f64;
    let mean = [0, 1].map(|k| logs.iter().map(|l| l[k]).sum::<f64>() / n);
    let slope = logs.iter().map(|l| (l[0] - mean[0]) * (l[1] - mean[1])).sum::<f64>()
        / logs.iter().map(|l| (l[0] - mean[0]).powi(2)).sum::<f64>();
    out.enter("A5", "time against M N: slope in logarithms", slope, "0.9 to 1.1");
}
