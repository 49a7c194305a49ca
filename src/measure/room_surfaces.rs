//! Mean illuminance and luminance of the surfaces of each material and each object, from the solution itself.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_1_PI, PI};

use super::adaptive::Task;
use super::appraisal::RoomSurface;
use super::gather::REPLICAS;
use super::solved::Solved;
use super::statement::student;
use crate::transport::{Kind, Optics};

/// One side of a material: all of it, or what of it is in an object. All come before the objects, in the scene's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Part {
    object: Option<usize>,
    material: usize,
    back: bool,
}

/// Sums over the elements of a part.
#[derive(Clone, Default)]
struct Sums {
    area: f64,
    /// Illuminance and reflected luminous exitance times area, by replica.
    light: [[f64; 2]; REPLICAS],
}

/// The surfaces of all opaque diffuse materials; `main` and `twin` are solutions of `optics` of one channel.
pub(super) fn surfaces(task: &Task<'_>, optics: &Optics, main: &Solved, twin: &Solved) -> Vec<RoomSurface> {
    let (fine, coarse) = (sums(task, optics, main), sums(task, optics, twin));
    let mut areas_m2 = BTreeMap::new();
    for f in &task.scene.faces {
        for object in [None, Some(f.object)] {
            *areas_m2.entry((object, f.material)).or_insert(0.0) += f.area_m2;
        }
    }
    let is_opaque = |p: &Part| !task.scene.materials[p.material].kind.lets_light_in();
    let asked = fine.iter().filter(|(p, s)| s.area > 0.0 && is_opaque(p));
    let nothing = Sums::default();
    asked
        .map(|(part, sums)| {
            let area_m2 = areas_m2.get(&(part.object, part.material)).copied().unwrap_or_default();
            room_surface(task, optics, (*part, area_m2), sums, coarse.get(part).unwrap_or(&nothing))
        })
        .collect()
}

fn room_surface(
    task: &Task<'_>,
    optics: &Optics,
    (part, area_m2): (Part, f64),
    fine: &Sums,
    coarse: &Sums,
) -> RoomSurface {
    let (material, front) = (&task.scene.materials[part.material], !part.back);
    let emission = material.emission.as_ref().filter(|e| front || e.two_sided);
    let own = emission.map_or(0.0, |e| e.radiance.luminous()) * f64::from(u8::from(!task.world.glowing()));
    let [luminance, luminance_error] = mean(fine, coarse, 1);
    let is_grey_enough = optics.rho(part.material, front)[..optics.bands.len()].iter().all(|r| *r > 0.0);
    let counts = is_grey_enough && !(task.world.glowing() && emission.is_some());
    RoomSurface {
        material: material.name.clone(),
        object: part.object.map(|o| task.scene.objects[o].clone()),
        front,
        area_m2,
        modelled_share: (fine.area * task.world.surfaces.frame.area_m2() / area_m2).min(1.0),
        illuminance_lx: counts.then(|| mean(fine, coarse, 0)),
        luminance_cd_m2: [FRAC_1_PI * luminance + own, luminance_error / PI],
    }
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

fn sums(task: &Task<'_>, optics: &Optics, solved: &Solved) -> BTreeMap<Part, Sums> {
    let mut all = BTreeMap::new();
    for (i, e) in solved.mesh.list().iter().enumerate() {
        if task.world.kind(e.surface) != Kind::Diffuse {
            continue;
        }
        let face = &task.scene.faces[e.surface as usize];
        let (rho, mut light) = (optics.rho(face.material, e.front), [[0.0; 2]; REPLICAS]);
        for (replica, bands) in solved.solution.of(i as u32).chunks_exact(optics.pad).enumerate() {
            for ((b, w), r) in bands.iter().zip(&optics.xyz[1]).zip(rho).filter(|(_, r)| **r > 0.0) {
                let y = f64::from(*b) * f64::from(*w) * e.area;
                light[replica][0] += y / f64::from(*r);
                light[replica][1] += y;
            }
        }
        for object in [None, Some(face.object)] {
            let part = Part { object, material: face.material, back: !e.front };
            let sums: &mut Sums = all.entry(part).or_default();
            sums.area += e.area;
            for (s, l) in sums.light.iter_mut().flatten().zip(light.iter().flatten()) {
                *s += l;
            }
        }
    }
    all
}
