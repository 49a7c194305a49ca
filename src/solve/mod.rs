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
use exchange::Openings;

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

/// How much is solved at once. It decides speed and memory, no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Abreast {
    /// All replicas and blocks of bands.
    All,
    /// One replica after the other: elements are many enough to keep the threads busy.
    Replica,
    /// One block of bands after the other: least memory.
    Block,
}

/// Elements from which on one replica is solved after the other.
const MANY_ELEMENTS: usize = 1 << 15;

impl Abreast {
    /// The fastest for a number of elements.
    #[must_use]
    pub fn fastest(elements: usize) -> Self {
        if elements < MANY_ELEMENTS { Self::All } else { Self::Replica }
    }
}

/// Bytes that an element takes while its mesh is solved, beside its solution; with `rays` in each of the `replicas`.
#[must_use]
pub fn bytes_to_solve((replicas, rays): (usize, usize), pad: usize, abreast: Abreast, threads: usize) -> usize {
    let blocks = pad / LANES;
    let (matrices, systems) = match abreast {
        Abreast::All => (replicas, replicas * blocks),
        Abreast::Replica => (1, blocks.min(threads)),
        Abreast::Block => (1, 1),
    };
    let openings = replicas * size_of::<f64>();
    openings + matrices * Exchange::bytes_per_element(rays) + systems * Block::bytes_per_element()
}

/// Solves all bands of all replicas to the relative residual `accuracy`.
///
/// # Errors
///
/// When no finite solution exists: nothing absorbs and nothing escapes in some band.
pub fn solve(
    world: &World,
    optics: &Optics,
    mesh: &Elements,
    rows: &Rows,
    (accuracy, abreast): (f64, Abreast),
) -> Result<Solution> {
    let n = mesh.len();
    let replicas = rows.replicas.len();
    let openings = openings(world, optics, mesh, rows)?;
    let one = |replica: usize, enter: &mut dyn FnMut(usize, &BlockResult)| -> f64 {
        let exchange = Exchange::balanced(mesh, rows, (&openings, replica), closure(accuracy));
        let exits = &openings[(replica + 1) % replicas].exits;
        let solve =
            |block| Block { world, optics, mesh, rows, replica, exchange: &exchange, exits, block }.solve(accuracy);
        let blocks = 0..optics.pad / LANES;
        if abreast == Abreast::Block {
            blocks.for_each(|block| enter(block, &solve(block)));
        } else {
            let results: Vec<BlockResult> = blocks.into_par_iter().map(solve).collect();
            results.iter().enumerate().for_each(|(block, result)| enter(block, result));
        }
        exchange.correction
    };
    let mut solution = Solution {
        radiosity: vec![0.0; n * replicas * optics.pad],
        replicas,
        pad: optics.pad,
        absorbed: vec![vec![0.0; optics.pad]; replicas],
        escaped: vec![vec![0.0; optics.pad]; replicas],
        lost: vec![vec![0.0; optics.pad]; replicas],
        products: 0,
        residual: 0.0,
        balance: 0.0,
    };
    if abreast == Abreast::All {
        let kept = |replica| {
            let mut results = Vec::new();
            let balance = one(replica, &mut |block, result| results.push((block, result.clone())));
            (balance, results)
        };
        let all: Vec<(f64, Vec<(usize, BlockResult)>)> = (0..replicas).into_par_iter().map(kept).collect();
        for (replica, (balance, results)) in all.into_iter().enumerate() {
            solution.balance = solution.balance.max(balance);
            results.iter().for_each(|(block, result)| solution.enter(replica, *block, result));
        }
    } else {
        for replica in 0..replicas {
            let balance = one(replica, &mut |block, result| solution.enter(replica, block, result));
            solution.balance = solution.balance.max(balance);
        }
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
    let openings = openings(world, optics, mesh, rows)?;
    let balanced = |r| Exchange::balanced(mesh, rows, (&openings, r), closure(accuracy));
    Ok((0..openings.len()).into_par_iter().map(balanced).collect())
}

/// Defect of closure for a residual of `accuracy`.
fn closure(accuracy: f64) -> f64 {
    (1e-1 * accuracy).clamp(1e-10, 1e-5)
}

/// What the rays of each replica saw closed and open.
fn openings(world: &World, optics: &Optics, mesh: &Elements, rows: &Rows) -> Result<Vec<Openings>> {
    let openings: Vec<Openings> =
        (0..rows.replicas.len()).into_par_iter().map(|replica| Openings::new(rows, replica)).collect();
    check_finite(world, optics, mesh, &openings)?;
    Ok(openings)
}

fn check_finite(world: &World, optics: &Optics, mesh: &Elements, openings: &[Openings]) -> Result<()> {
    let leaks = openings.iter().any(|o| !o.exits.is_empty());
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
