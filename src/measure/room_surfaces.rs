//! Mean illuminance and luminance of the surfaces of each material, from the solution itself.

use std::f64::consts::{FRAC_1_PI, PI};

use super::adaptive::Task;
use super::appraisal::RoomSurface;
use super::gather::{REPLICAS, Solved};
use super::statement::student;
use crate::transport::{Kind, Optics};

/// Sums over the elements of one side of a material.
#[derive(Clone, Default)]
struct Sums {
    area: f64,
    /// Illuminance and reflected luminous exitance times area, by replica.
    light: [[f64; 2]; REPLICAS],
}

/// The surfaces of all opaque diffuse materials; `main` and `twin` are solutions of `optics` of one channel.
pub(super) fn surfaces(task: &Task<'_>, optics: &Optics, main: &Solved, twin: &Solved) -> Vec<RoomSurface> {
    let (fine, coarse) = (sums(task, optics, main), sums(task, optics, twin));
    let unit = task.world.surfaces.frame.area_m2();
    let mut all = Vec::new();
    for (m, material) in task.scene.materials.iter().enumerate() {
        let area: f64 = task.scene.faces.iter().filter(|f| f.material == m).map(|f| f.area_m2).sum();
        for front in [true, false] {
            let k = 2 * m + usize::from(front);
            if fine[k].area <= 0.0 || material.kind.is_translucent() {
                continue;
            }
            let emission = material.emission.as_ref().filter(|e| front || e.two_sided);
            let own = emission.map_or(0.0, |e| e.radiance.luminous()) * f64::from(u8::from(!task.world.glowing()));
            let [luminance, luminance_error] = mean(&fine[k], &coarse[k], 1);
            let is_grey_enough = optics.rho(m, front)[..optics.bands.len()].iter().all(|r| *r > 0.0);
            let counts = is_grey_enough && !(task.world.glowing() && emission.is_some());
            all.push(RoomSurface {
                material: material.name.clone(),
                front,
                area_m2: area,
                modelled_share: (fine[k].area * unit / area).min(1.0),
                illuminance_lx: counts.then(|| mean(&fine[k], &coarse[k], 0)),
                luminance_cd_m2: [FRAC_1_PI * luminance + own, luminance_error / PI],
            });
        }
    }
    all
}

/// Mean over the replicas, and its error: their noise, and the difference to a mesh twice as coarse.
fn mean(fine: &Sums, coarse: &Sums, which: usize) -> [f64; 2] {
    let of = |s: &Sums| -> Vec<f64> { s.light.iter().map(|l| l[which] / s.area.max(f64::MIN_POSITIVE)).collect() };
    let (values, others) = (of(fine), of(coarse));
    let count = REPLICAS as f64;
    let (mean, other) = (values.iter().sum::<f64>() / count, others.iter().sum::<f64>() / count);
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count * (count - 1.0));
    let hidden = if coarse.area > 0.0 { mean - other } else { mean };
    [mean, (student(count - 1.0).powi(2) * variance + hidden * hidden).sqrt()]
}

fn sums(task: &Task<'_>, optics: &Optics, solved: &Solved) -> Vec<Sums> {
    let mut all = vec![Sums::default(); 2 * task.scene.materials.len()];
    for (i, e) in solved.mesh.list().iter().enumerate() {
        if task.world.kind(e.surface) != Kind::Diffuse {
            continue;
        }
        let material = task.world.surfaces.list[e.surface as usize].material;
        let sums = &mut all[2 * material + usize::from(e.front)];
        sums.area += e.area;
        let rho = optics.rho(material, e.front);
        for (replica, bands) in solved.solution.of(i as u32).chunks_exact(optics.pad).enumerate() {
            for ((b, w), r) in bands.iter().zip(&optics.xyz[1]).zip(rho).filter(|(_, r)| **r > 0.0) {
                let y = f64::from(*b) * f64::from(*w) * e.area;
                sums.light[replica][0] += y / f64::from(*r);
                sums.light[replica][1] += y;
            }
        }
    }
    all
}
