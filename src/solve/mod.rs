//! The linear system `B = ρ (D + F B)`, all bands at once.
//!
//! In: [`Rows`] and [`Optics`]. Out: [`Solution`]. The sampled rows are first balanced so that flux is conserved
//! ([`Exchange`]), then solved by a Krylov method ([`Block`]): a number of products that hardly grows as the
//! reflectance goes to one.

mod bicgstab;
mod columns;
pub mod dense;
mod exchange;
pub mod hierarchical;
mod scattering;

use rayon::prelude::*;

pub use bicgstab::{Block, BlockResult, LANES, Lanes};
pub use columns::Columns;
pub use exchange::Exchange;

use crate::error::{Error, Result};
use crate::mesh::Elements;
use crate::transport::{Optics, Rows, Target, World};

/// Radiosity of every element, and where the light went.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Radiosity that is reflected, W/(m² nm): `[element][replica][band]`, bands padded. Emission is apart, except where
    /// [`World::glowing`].
    pub radiosity: Vec<f32>,
    /// Number of replicas.
    pub replicas: usize,
    /// Padded number of bands.
    pub pad: usize,
    /// Flux absorbed on elements, per replica and band, in W/nm per unit of the program's area.
    pub absorbed: Vec<Vec<f64>>,
    /// Flux that leaves the scene after reflection, likewise.
    pub escaped: Vec<Vec<f64>>,
    /// Flux that mirrors and panes absorb between diffuse surfaces, likewise.
    pub lost: Vec<Vec<f64>>,
    /// Products with the matrix that the slowest band needed.
    pub products: usize,
    /// Largest relative residual over bands and replicas.
    pub residual: f64,
    /// Largest correction that balancing made to a set of elements, `|c − 1|`.
    pub balance: f64,
}

impl Solution {
    /// Radiosity of an element, all replicas: `replicas` vectors of `pad` bands.
    #[must_use]
    #[inline]
    pub fn of(&self, element: u32) -> &[f32] {
        let n = self.replicas * self.pad;
        &self.radiosity[element as usize * n..(element as usize + 1) * n]
    }
}

/// Solves all bands of all replicas to the relative residual `accuracy`.
///
/// # Errors
///
/// When no finite solution exists: nothing absorbs and nothing escapes in some band.
pub fn solve(world: &World, optics: &Optics, mesh: &Elements, rows: &Rows, accuracy: f64) -> Result<Solution> {
    let n = mesh.len();
    let replicas = rows.replicas.len();
    let exchanges = exchanges(world, optics, mesh, rows, accuracy)?;
    let blocks = optics.pad / LANES;
    let results: Vec<BlockResult> = (0..replicas * blocks)
        .into_par_iter()
        .map(|task| {
            let (r, block) = (task / blocks, task % blocks);
            let (exchange, other) = (&exchanges[r], &exchanges[(r + 1) % replicas]);
            Block { world, optics, mesh, rows, replica: r, exchange, other, block }.solve(accuracy)
        })
        .collect();
    let mut solution = Solution {
        radiosity: vec![0.0; n * replicas * optics.pad],
        replicas,
        pad: optics.pad,
        absorbed: vec![vec![0.0; optics.pad]; replicas],
        escaped: vec![vec![0.0; optics.pad]; replicas],
        lost: vec![vec![0.0; optics.pad]; replicas],
        products: 0,
        residual: 0.0,
        balance: exchanges.iter().map(|e| e.correction).fold(0.0, f64::max),
    };
    for (task, result) in results.into_iter().enumerate() {
        solution.enter(task / blocks, task % blocks, &result);
    }
    Ok(solution)
}

impl Solution {
    fn enter(&mut self, replica: usize, block: usize, result: &BlockResult) {
        let stride = self.replicas * self.pad;
        let at = replica * self.pad + block * LANES;
        for (row, values) in self.radiosity.chunks_exact_mut(stride).zip(&result.radiosity) {
            row[at..at + LANES].copy_from_slice(values);
        }
        for lane in 0..LANES {
            let band = block * LANES + lane;
            self.absorbed[replica][band] = result.absorbed[lane];
            self.escaped[replica][band] = result.escaped[lane];
            self.lost[replica][band] = result.lost[lane];
        }
        self.products = self.products.max(result.products);
        self.residual = self.residual.max(result.residual);
    }
}

/// The matrices of all replicas, balanced for a residual of `accuracy`.
fn exchanges(world: &World, optics: &Optics, mesh: &Elements, rows: &Rows, accuracy: f64) -> Result<Vec<Exchange>> {
    let replicas = rows.replicas.len();
    let closure = (1e-1 * accuracy).clamp(1e-10, 1e-5);
    let mut exchanges: Vec<Exchange> = (0..replicas).into_par_iter().map(|r| Exchange::new(mesh, rows, r)).collect();
    let sends: Vec<Vec<f64>> = (0..replicas).map(|r| closed_by_others(&exchanges, r)).collect();
    exchanges.par_iter_mut().zip(&sends).for_each(|(e, sends)| e.balance(mesh, sends, closure));
    check_finite(world, optics, mesh, &exchanges)?;
    Ok(exchanges)
}

/// Mean closed share of each element over the replicas other than one.
fn closed_by_others(exchanges: &[Exchange], replica: usize) -> Vec<f64> {
    let others: Vec<&Exchange> =
        exchanges.iter().enumerate().filter(|(r, _)| *r != replica || exchanges.len() == 1).map(|(_, e)| e).collect();
    let share = 1.0 / others.len() as f64;
    (0..exchanges[replica].closed.len()).map(|i| others.iter().map(|e| e.closed[i]).sum::<f64>() * share).collect()
}

fn check_finite(world: &World, optics: &Optics, mesh: &Elements, exchanges: &[Exchange]) -> Result<()> {
    let leaks = exchanges.iter().any(|e| e.is_open());
    if leaks || mesh.is_empty() {
        return Ok(());
    }
    for band in 0..optics.bands.len() {
        let absorbs = mesh
            .list()
            .iter()
            .map(|e| (world.surfaces.list[e.surface as usize].material, e.front))
            .any(|(material, front)| optics.rho(material, front)[band] + optics.tau(material)[band] < 1.0);
        if !absorbs {
            return Err(Error::impossible(format!(
                "the room is closed and every surface in it reflects everything in band {} of {}: the light never goes away",
                band + 1,
                optics.bands.len()
            ))
            .mend("give at least one surface a reflectance below 1, or open the room"));
        }
    }
    Ok(())
}

/// Does anything of a row leave the scene or get lost?
fn is_open(target: Target) -> bool {
    matches!(target, Target::Escaped | Target::Lost)
}
