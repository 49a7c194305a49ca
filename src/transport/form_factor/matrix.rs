//! All form factors of a mesh, made reciprocal and closed together.

use rayon::prelude::*;

use super::hemicube::patch_hit;
use super::{Method, Work};
use crate::error::{Error, Result};
use crate::mesh::{Patch, Patches, sample_polygon};
use crate::transport::caster::Ray;
use crate::transport::points::{Points, seed};
use crate::transport::{World, cosine_direction, visible_factor};

/// Rays from each patch that look for an opening.
const LOOKS: u32 = 128;
/// Sweeps of the balance, at most, and the relative defect at which it ends.
const SWEEPS: usize = 200;
const BALANCED: f64 = 1e-13;

/// The exchange areas `A_i F_ij` of a mesh, and what was done to make them consistent.
#[derive(Clone, Debug)]
pub struct FormFactors {
    /// Areas of the patches, in the program's frame.
    pub areas: Vec<f64>,
    /// `A_i F_ij`, row by row; symmetric.
    exchange: Vec<f64>,
    /// Does no light leave the scene?
    pub closed: bool,
    /// Root mean square, by area, of the relative defect of the row sums before the balance (closed scenes).
    pub closure_defect: f64,
    /// The largest, and the patch that has it.
    pub worst_row: (f64, usize),
    /// `‖X − Xᵀ‖/‖X‖` of the raw exchange areas, in the Frobenius norm.
    pub reciprocity_defect: f64,
    /// Rays cast.
    pub rays: u64,
    /// Form factors worked out.
    pub factors: u64,
}

impl FormFactors {
    /// Works out all form factors of a mesh.
    #[must_use]
    pub fn new(world: &World, mesh: &dyn Patches, method: &dyn Method) -> Self {
        let n = mesh.list().len();
        let mut exchange = vec![0.0; n * n];
        let areas: Vec<f64> = mesh.list().iter().map(|p| p.area).collect();
        let symmetric = n > 0 && method.exchange(0, 0, &mut Work::default()).is_some();
        let counts: Vec<(u64, u64)> = exchange
            .par_chunks_mut(n.max(1))
            .enumerate()
            .with_max_len(1)
            .map_init(Work::default, |work, (i, row)| {
                let before = (work.all_rays(), work.all_factors());
                if symmetric {
                    for j in i + 1..n {
                        row[j] = method.exchange(i, j, work).unwrap_or(0.0);
                    }
                } else {
                    method.row(i, row, work);
                    row.iter_mut().for_each(|f| *f *= areas[i]);
                }
                (work.all_rays() - before.0, work.all_factors() - before.1)
            })
            .collect();
        let mut result = Self {
            areas,
            exchange,
            closed: is_closed(world, mesh),
            closure_defect: 0.0,
            worst_row: (0.0, 0),
            reciprocity_defect: 0.0,
            rays: counts.iter().map(|c| c.0).sum::<u64>() + n as u64 * u64::from(LOOKS),
            factors: counts.iter().map(|c| c.1).sum(),
        };
        result.reciprocity_defect = result.symmetrise(symmetric);
        result.find_defects();
        result
    }

    /// Number of patches.
    #[must_use]
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// No patches?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Exchange areas of patch `i` with all: divided by its area, its form factors.
    #[must_use]
    pub fn exchange_row(&self, i: usize) -> &[f64] {
        let n = self.len();
        &self.exchange[i * n..(i + 1) * n]
    }

    /// The form factor `F_ij`.
    #[must_use]
    pub fn factor(&self, i: usize, j: usize) -> f64 {
        self.exchange_row(i)[j] / self.areas[i]
    }

    /// Replaces the upper triangle's mirror, or both by their mean; returns the defect.
    fn symmetrise(&mut self, upper_only: bool) -> f64 {
        let n = self.len();
        let (mut difference, mut all) = (0.0, 0.0);
        for i in 0..n {
            for j in i + 1..n {
                let (up, down) = (self.exchange[i * n + j], self.exchange[j * n + i]);
                let value = if upper_only { up } else { 0.5 * (up + down) };
                difference += if upper_only { 0.0 } else { 2.0 * (up - down).powi(2) };
                all += 2.0 * value * value;
                self.exchange[i * n + j] = value;
                self.exchange[j * n + i] = value;
            }
        }
        if all > 0.0 { (difference / all).sqrt() } else { 0.0 }
    }

    fn find_defects(&mut self) {
        let (mut sum, mut total) = (0.0, 0.0);
        for i in 0..self.len() {
            let ratio = self.exchange_row(i).iter().sum::<f64>() / self.areas[i];
            // Of an open scene only too much can be told.
            let defect = if self.closed { ratio - 1.0 } else { (ratio - 1.0).max(0.0) };
            sum += self.areas[i] * defect * defect;
            total += self.areas[i];
            if defect.abs() > self.worst_row.0 {
                self.worst_row = (defect.abs(), i);
            }
        }
        self.closure_defect = if total > 0.0 { (sum / total).sqrt() } else { 0.0 };
    }

    /// Makes every row sum what it must be and keeps reciprocity (symmetric Sinkhorn scaling): one in a closed scene, at
    /// most one in an open scene.
    ///
    /// # Errors
    ///
    /// When some row is off by more than `largest`: that is no rounding but a leak, a patch inside a solid, or a method
    /// too coarse for the scene.
    pub fn balance(&mut self, mesh: &dyn Patches, world: &World, largest: f64) -> Result<()> {
        let (worst, i) = self.worst_row;
        if worst > largest {
            return Err(too_far_off(world, &mesh.list()[i], worst, largest));
        }
        let n = self.len();
        let mut scale = vec![1.0; n];
        for _ in 0..SWEEPS {
            let mut defect = 0.0f64;
            for i in 0..n {
                let row = &self.exchange[i * n..(i + 1) * n];
                let sum: f64 = scale[i] * row.iter().zip(&scale).map(|(x, d)| x * d).sum::<f64>();
                let wanted = if self.closed { self.areas[i] } else { sum.min(self.areas[i]) };
                if sum > 0.0 {
                    defect = defect.max((sum / wanted - 1.0).abs());
                    scale[i] *= (wanted / sum).sqrt();
                }
            }
            if defect < BALANCED {
                break;
            }
        }
        for (i, row) in self.exchange.chunks_exact_mut(n.max(1)).enumerate() {
            row.iter_mut().zip(&scale).for_each(|(x, d)| *x *= scale[i] * d);
        }
        Ok(())
    }
}

/// The refusal to balance a patch whose form factors are off by more than `largest`.
#[must_use]
pub fn too_far_off(world: &World, patch: &Patch, off: f64, largest: f64) -> Error {
    let at = patch.centre * world.surfaces.frame.size_m + world.surfaces.frame.centre_m;
    Error::impossible(format!(
        "the form factors of the patch about ({:.3}, {:.3}, {:.3}) m sum to a value that is off by {:.1} %; more than {:.0} % is not mended",
        at.x, at.y, at.z, 100.0 * off, 100.0 * largest
    ))
    .mend("use more patches or a finer form factor method; if it stays, `clerestory check` looks for leaks")
}

/// Does every ray from every patch land on a patch?
#[must_use]
pub fn is_closed(world: &World, mesh: &dyn Patches) -> bool {
    mesh.list().par_iter().enumerate().all(|(i, p)| {
        looks(world, p, i as u64, LOOKS).all(|ray| patch_hit(world, mesh, &ray, &world.caster.closest(&ray)).is_some())
    })
}

/// Share of well-spread rays from each patch that land on a patch: what its row of form factors sums to, to about one over
/// the number of rays.
#[must_use]
pub fn staying_shares(world: &World, mesh: &dyn Patches, rays: u32) -> Vec<f64> {
    let share = |(i, p): (usize, &Patch)| {
        let stays = |ray: &Ray| patch_hit(world, mesh, ray, &world.caster.closest(ray)).is_some();
        looks(world, p, i as u64, rays).filter(stays).count() as f64 / f64::from(rays)
    };
    mesh.list().par_iter().enumerate().map(share).collect()
}

/// Well-spread rays from a patch.
fn looks<'a>(world: &'a World, p: &'a Patch, stream: u64, count: u32) -> impl Iterator<Item = Ray> + 'a {
    let points = Points::new(seed(&[11, stream]));
    let surface = &world.surfaces.list[p.surface as usize];
    (0..count).map(move |k| {
        let ((a, b), (c, d)) = (points.pair(k, 0), points.pair(k, 2));
        let start = world.lift(surface.point(sample_polygon(&p.outline, a, b)), p.normal);
        Ray::new(start, cosine_direction(p.normal, c, d))
    })
}

/// Does a patch see any surface, or an emitter, and is it not inside a solid or beneath something that stands on it?
#[must_use]
pub fn sees_anything(world: &World, p: &Patch) -> bool {
    let (mut seen, mut buried) = (0, 0);
    for ray in looks(world, p, 0, LOOKS) {
        let hit = world.caster.closest(&ray);
        if let Some(s) = world.surfaces.list.get(hit.surface as usize) {
            let d = glam::DVec3::from_array(ray.direction.map(f64::from));
            buried += u32::from(s.solid && s.normal.dot(d) > 0.0);
            seen += 1;
        }
    }
    if seen > 0 || world.group(p.surface, p.front).is_some() {
        return 2 * buried <= LOOKS;
    }
    let x = world.lift(p.centre, p.normal);
    let mut scratch = super::DirectScratch::default();
    world.emitters.list.iter().any(|e| visible_factor(world, e, x, p.normal, 0, &mut scratch) > 0.0)
}
