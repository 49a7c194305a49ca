//! Boxes with one patch a face against exact algebra, where the values lie beside the source.
//!
//! Needs the folder `shared` next to the repository.

mod common;

use std::path::PathBuf;

use clerestory::mesh::PatchMesh;
use clerestory::solve::dense::{Solver, System};
use clerestory::transport::World;
use clerestory::transport::form_factor::{Analytic, FormFactors};
use common::{Build, at, diffuse};
use glam::DVec3;
use serde_json::Value;

const FACES: [&str; 6] = ["x0", "x1", "y0", "y1", "floor", "ceiling"];

#[test]
fn lumped_boxes_match_to_a_billionth() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/validation-reference/radiosity.json");
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return;
    };
    let file: Value = serde_json::from_str(&text).expect("JSON");
    let lumped = |c: &&Value| c["id"].as_str().is_some_and(|id| id.starts_with("lumped"));
    let mut compared = 0;
    for case in file["cases"].as_array().expect("cases").iter().filter(lumped) {
        let side = |k: usize| case["inputs"]["dims"][k].as_f64().expect("a number");
        let mut b = Build::new();
        let materials = FACES.map(|f| b.material(diffuse(f, 0.5)));
        b.room(DVec3::ZERO, at(side(0), side(1), side(2)), materials);
        let world = World::new(&b.0);
        let mesh = PatchMesh::uniform(&world.surfaces, 10.0, |p| p.front);
        let mut factors = FormFactors::new(&world, &mesh, &Analytic::new(&world, &mesh));
        factors.balance(&mesh, &world, 0.05).expect("a closed box");
        for (band, values) in case["result"].as_object().expect("bands") {
            let field = |key: &str| FACES.map(|f| values[key][f].as_f64().expect("a number")).to_vec();
            let system = System { bands: 1, areas: factors.areas.clone(), rho: field("rho"), emitted: field("E") };
            let outcome = system.solve(&factors, Solver::FullMatrix, 1e-9).expect("a solution");
            let (b, h) = (field("B"), field("H"));
            for k in 0..6 {
                for (value, exact) in [(outcome.radiosity[k], b[k]), (outcome.irradiance[k], h[k])] {
                    assert!((value - exact).abs() <= 1e-9 * exact, "{band} {}: {value} against {exact}", FACES[k]);
                }
                compared += 1;
            }
        }
    }
    assert!(compared >= 18, "{compared}");
}
