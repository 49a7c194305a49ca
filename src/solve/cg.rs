//! Conjugate gradients on the symmetrised system (Hestenes and Stiefel 1952), eight bands abreast.
//!
//! With `y = √(ρA) E` the system `B = ρ (D + A⁻¹ X B)` becomes `(I − S X S) y = √(ρA) D`, `S = √(ρ/A)`, symmetric and
//! positive definite for `ρ < 1`; `B = S y` needs no division by a reflectance.

use super::balance::Exchange;
use crate::mesh::Elements;
use crate::transport::{Optics, Rows, World};

/// Bands in a block.
pub const LANES: usize = 8;
type Lanes = [f64; LANES];
const MAX_PRODUCTS: usize = 400;

/// One block of bands of one replica.
#[derive(Debug)]
pub struct Block<'a> {
    /// Geometry.
    pub world: &'a World,
    /// Materials.
    pub optics: &'a Optics,
    /// Elements.
    pub mesh: &'a Elements,
    /// Rows, for the direct light.
    pub rows: &'a Rows,
    /// Which replica.
    pub replica: usize,
    /// Its matrix.
    pub exchange: &'a Exchange,
    /// Which block of eight bands.
    pub block: usize,
}

/// What came out of one block.
#[derive(Clone, Debug)]
pub struct BlockResult {
    /// Radiosity by element.
    pub radiosity: Vec<[f32; LANES]>,
    /// Flux absorbed by elements.
    pub absorbed: Lanes,
    /// Flux that left the scene after reflection.
    pub escaped: Lanes,
    /// Flux lost at mirrors and panes after reflection.
    pub lost: Lanes,
    /// Products with the matrix.
    pub products: usize,
    /// Largest relative residual of a band.
    pub residual: f64,
}

impl Block<'_> {
    /// Solves to a relative residual of `accuracy` in every band.
    #[must_use]
    pub fn solve(&self, accuracy: f64) -> BlockResult {
        let n = self.mesh.len();
        let tints = self.tints();
        let direct = self.direct(&tints);
        let rho: Vec<&[f32]> = self
            .mesh
            .list()
            .iter()
            .map(|e| self.lanes(self.optics.rho(self.world.surfaces.list[e.surface as usize].material, e.front)))
            .collect();
        let area = &self.exchange.area;
        let scale: Vec<Lanes> = (0..n)
            .map(|i| std::array::from_fn(|l| if area[i] > 0.0 { (f64::from(rho[i][l]) / area[i]).sqrt() } else { 0.0 }))
            .collect();
        let source: Vec<Lanes> =
            (0..n).map(|i| std::array::from_fn(|l| scale[i][l] * area[i] * direct[i][l])).collect();
        let (y, products, residual) = self.conjugate_gradients(&scale, &source, &tints, accuracy);
        let radiosity: Vec<Lanes> = (0..n).map(|i| std::array::from_fn(|l| scale[i][l] * y[i][l])).collect();
        let mut result = BlockResult {
            radiosity: radiosity.iter().map(|b| b.map(|x| x as f32)).collect(),
            absorbed: [0.0; LANES],
            escaped: [0.0; LANES],
            lost: [0.0; LANES],
            products,
            residual,
        };
        self.account(&radiosity, &direct, &rho, &tints, &mut result);
        result
    }

    fn lanes<'b>(&self, bands: &'b [f32]) -> &'b [f32] {
        &bands[self.block * LANES..(self.block + 1) * LANES]
    }

    fn tints(&self) -> Vec<Lanes> {
        self.rows.tints.iter().map(|t| std::array::from_fn(|l| f64::from(self.lanes(t)[l]))).collect()
    }

    /// Mean direct irradiance of every element.
    fn direct(&self, tints: &[Lanes]) -> Vec<Lanes> {
        let groups = self.rows.groups;
        let replica = &self.rows.replicas[self.replica];
        let exitance: Vec<&[f32]> = self.optics.exitance.iter().map(|m| self.lanes(m)).collect();
        let mut direct: Vec<Lanes> = (0..self.mesh.len())
            .map(|i| {
                let mut d = [0.0; LANES];
                for (factor, m) in replica.direct[i * groups..(i + 1) * groups].iter().zip(&exitance) {
                    for l in 0..LANES {
                        d[l] += f64::from(*factor) * f64::from(m[l]);
                    }
                }
                d
            })
            .collect();
        let per_ray = 1.0 / self.rows.rays as f64;
        for (i, group, weight, tint) in &replica.mirrored {
            let (d, m) = (&mut direct[*i as usize], exitance[*group as usize]);
            for l in 0..LANES {
                d[l] += per_ray * f64::from(*weight) * tints[*tint as usize][l] * f64::from(m[l]);
            }
        }
        direct
    }

    fn conjugate_gradients(
        &self,
        scale: &[Lanes],
        source: &[Lanes],
        tints: &[Lanes],
        accuracy: f64,
    ) -> (Vec<Lanes>, usize, f64) {
        let n = source.len();
        let mut y = vec![[0.0; LANES]; n];
        let mut r = source.to_vec();
        let mut p = r.clone();
        let mut scaled = vec![[0.0; LANES]; n];
        let mut q = vec![[0.0; LANES]; n];
        let whole = dot(&r, &r);
        let mut rr = whole;
        let mut products = 0;
        let relative = |rr: &Lanes| {
            (0..LANES).map(|l| if whole[l] > 0.0 { (rr[l] / whole[l]).sqrt() } else { 0.0 }).fold(0.0, f64::max)
        };
        while relative(&rr) > accuracy && products < MAX_PRODUCTS {
            for i in 0..n {
                scaled[i] = std::array::from_fn(|l| scale[i][l] * p[i][l]);
            }
            self.exchange.product(&scaled, tints, &mut q);
            for i in 0..n {
                q[i] = std::array::from_fn(|l| p[i][l] - scale[i][l] * q[i][l]);
            }
            products += 1;
            let pq = dot(&p, &q);
            let alpha: Lanes = std::array::from_fn(|l| if pq[l] > 0.0 { rr[l] / pq[l] } else { 0.0 });
            for i in 0..n {
                for l in 0..LANES {
                    y[i][l] += alpha[l] * p[i][l];
                    r[i][l] -= alpha[l] * q[i][l];
                }
            }
            let next = dot(&r, &r);
            let beta: Lanes = std::array::from_fn(|l| if rr[l] > 0.0 { next[l] / rr[l] } else { 0.0 });
            for i in 0..n {
                p[i] = std::array::from_fn(|l| r[i][l] + beta[l] * p[i][l]);
            }
            rr = next;
        }
        let residual = relative(&rr);
        (y, products, residual)
    }

    /// Sums what is absorbed and what escapes, each on its own.
    fn account(
        &self,
        radiosity: &[Lanes],
        direct: &[Lanes],
        rho: &[&[f32]],
        tints: &[Lanes],
        result: &mut BlockResult,
    ) {
        let mut arriving = vec![[0.0; LANES]; radiosity.len()];
        self.exchange.product(radiosity, tints, &mut arriving);
        for (i, b) in radiosity.iter().enumerate() {
            let area = self.exchange.area[i];
            for l in 0..LANES {
                let irradiated = area * direct[i][l] + arriving[i][l];
                result.absorbed[l] += (1.0 - f64::from(rho[i][l])) * irradiated;
            }
            for (share, tint, escaped) in &self.exchange.exits[i] {
                let sum = if *escaped { &mut result.escaped } else { &mut result.lost };
                for l in 0..LANES {
                    sum[l] += area * f64::from(*share) * tints[*tint as usize][l] * b[l];
                }
            }
        }
    }
}

fn dot(a: &[Lanes], b: &[Lanes]) -> Lanes {
    let mut sum = [0.0; LANES];
    for (x, y) in a.iter().zip(b) {
        for l in 0..LANES {
            sum[l] += x[l] * y[l];
        }
    }
    sum
}
