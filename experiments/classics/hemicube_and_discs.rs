//! A4: the hemicube's error by patch and resolution. A12: ray-traced discs against the exact factor.

use std::f64::consts::TAU;

use clerestory::mesh::PatchMesh;
use clerestory::transport::World;
use clerestory::transport::form_factor::{Analytic, Discs, FormFactors, Hemicube, Work};
use clerestory::transport::points::Points;
use glam::DVec3;

use super::{Build, Table};

const POSES: u32 = 120;
/// Distance of the patch.
const DISTANCE: f64 = 2.0;

pub(super) fn run(out: &mut Table) {
    closure(out);
    single_patches(out);
    aliasing(out);
    for (name, corner, u, v) in [
        ("parallel", DVec3::new(0.0, 0.0, 1.0), DVec3::Y, DVec3::X),
        ("perpendicular", DVec3::ZERO, DVec3::Y, DVec3::Z),
    ] {
        discs(out, name, corner, u, v);
    }
}

fn closure(out: &mut Table) {
    let mut b = Build::new(1);
    b.cuboid(DVec3::ZERO, DVec3::ONE, [0; 6], true);
    let world = World::new(&b.scene);
    let mesh = PatchMesh::uniform(&world.surfaces, 1.0, |p| p.front);
    for (resolution, target) in [(50, "2e-4"), (100, "5e-5")] {
        let factors = FormFactors::new(&world, &mesh, &Hemicube { world: &world, mesh: &mesh, resolution });
        out.enter(
            "A4",
            &format!("hemicube of {resolution}: closure defect, x 1e-4"),
            1e4 * factors.worst_row.0,
            target,
        );
    }
}

/// A patch of a size at a place, seen from the origin that looks up; what the hemicube and the exact formula say.
fn seen(size: f64, centre: DVec3, facing: DVec3, turn: DVec3, resolution: usize) -> [f64; 2] {
    let mut b = Build::new(1);
    let (u, v) = facing.any_orthonormal_pair();
    b.rectangle(centre - (u + v) * (0.5 * size), u * size, v * size, 0);
    b.rectangle(DVec3::new(-9.0, -9.0, -0.1), DVec3::X * 1e-3, DVec3::Y * 1e-3, 0); // gives the scene its size
    let world = World::new(&b.scene);
    let mesh = PatchMesh::uniform(&world.surfaces, 1.0, |p| p.front);
    let mut row = vec![0.0; mesh.list.len()];
    let mut work = Work::default();
    let x = world.surfaces.frame.to_local(DVec3::ZERO);
    Hemicube { world: &world, mesh: &mesh, resolution }.at_point(x, DVec3::Z, turn, &mut row, &mut work);
    [row[0], Analytic::new(&world, &mesh).at_point(x, DVec3::Z, 0, &mut work)]
}

fn single_patches(out: &mut Table) {
    let targets: [(usize, [&str; 4]); 5] = [
        (50, ["0.9", "4.8", "27", "165"]),
        (100, ["0.28", "2.5", "8.7", "54"]),
        (150, ["0.17", "1.0", "4.9", "29"]),
        (256, ["0.09", "0.37", "2.1", "14"]),
        (512, ["0.02", "0.13", "0.9", "-"]),
    ];
    for (resolution, target) in targets {
        for (size, target) in [1.0, 0.3, 0.1, 0.03].into_iter().zip(target) {
            let (mut square, mut missed) = (0.0, 0);
            for pose in 0..POSES {
                let points = Points::new(3);
                let direction = |k: u32, steepest: f64| {
                    let (a, b) = points.pair(pose, k);
                    // Uniform in solid angle down to `steepest`.
                    let z = 1.0 - a * (1.0 - steepest);
                    let r = (1.0 - z * z).sqrt();
                    DVec3::new(r * (TAU * b).cos(), r * (TAU * b).sin(), z)
                };
                // Steepest so that F = 0.56 A/(π 4) in the mean, as in the target's set-up.
                let to = direction(0, 0.5);
                let tilt = direction(2, 0.5);
                let (u, v) = to.any_orthonormal_pair();
                let facing = -(u * tilt.x + v * tilt.y + to * tilt.z);
                let turn = (TAU * points.get(pose, 4)).sin_cos();
                let [found, exact] = seen(size, to * DISTANCE, facing, DVec3::new(turn.1, turn.0, 0.0), resolution);
                square += (found / exact - 1.0).powi(2);
                missed += u32::from(found == 0.0);
            }
            let rms = 100.0 * (square / f64::from(POSES)).sqrt();
            out.enter("A4", &format!("hemicube of {resolution}, patch {size} at 2: RMS error %"), rms, target);
            if resolution <= 100 && size < 0.05 {
                let share = 100.0 * f64::from(missed) / f64::from(POSES);
                out.enter(
                    "A4",
                    &format!("hemicube of {resolution}, patch {size} at 2: missed %"),
                    share,
                    if resolution == 50 { "70" } else { "16" },
                );
            }
        }
    }
}

/// A lamp 0.1 wide moved by fractions of a pixel.
fn aliasing(out: &mut Table) {
    let pixel = DISTANCE * 2.0 / 50.0;
    let values: Vec<[f64; 2]> = (0..40)
        .map(|k| {
            let x = DVec3::new(pixel * f64::from(k) / 20.0, 0.3 * pixel, DISTANCE);
            seen(0.1, x, -DVec3::Z, DVec3::X, 50)
        })
        .collect();
    for (k, name, target) in [(0, "hemicube of 50", "> 20"), (1, "exact clipping", "< 2")] {
        let list = || values.iter().map(|v| v[k]);
        let spread = list().fold(0.0, f64::max) - list().fold(f64::INFINITY, f64::min);
        let mean = list().sum::<f64>() / values.len() as f64;
        out.enter(
            "A4",
            &format!("lamp of 0.1 moved by fractions of a pixel, {name}: peak to peak %"),
            100.0 * spread / mean,
            target,
        );
    }
}

fn discs(out: &mut Table, name: &str, corner: DVec3, u: DVec3, v: DVec3) {
    for distance in [0.1, 0.3, 1.0, 3.0, 10.0] {
        let mut b = Build::new(1);
        b.rectangle(DVec3::ZERO, DVec3::X, DVec3::Y, 0);
        let shift = if name == "parallel" { DVec3::Z * (distance - 1.0) } else { -DVec3::X * distance };
        b.rectangle(corner + shift, u, v, 0);
        let world = World::new(&b.scene);
        let mesh = PatchMesh::uniform(&world.surfaces, 10.0, |p| p.front);
        let x = world.lift(mesh.list[0].centre, DVec3::Z);
        let mut work = Work::default();
        let exact = Analytic::new(&world, &mesh).at_point(x, DVec3::Z, 1, &mut work);
        for per_side in [1, 2, 4, 8] {
            let found = Discs { world: &world, mesh: &mesh, per_side }.at_point(x, DVec3::Z, &mesh.list[1], &mut work);
            let quantity = format!("{name} squares at {distance}, {} discs: error %", per_side * per_side);
            out.enter("A12", &quantity, 100.0 * (found / exact - 1.0), "");
        }
    }
}
