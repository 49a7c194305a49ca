//! One scene, many lights: the same system for any number of right-hand sides, eight at a time.

use super::bicgstab::{LANES, Lanes, System};
use super::exchange::Exchange;
use crate::error::Result;
use crate::mesh::Elements;
use crate::transport::{Optics, Rows, World};

/// The balanced matrices of a scene, ready for light of any kind.
#[derive(Debug)]
pub struct Columns {
    exchanges: Vec<Exchange>,
    /// Reflectance of each element and each tint, by band.
    rho: Vec<Vec<f64>>,
    tints: Vec<Vec<f64>>,
    accuracy: f64,
}

impl Columns {
    /// Balances the rows for solutions to the relative residual `accuracy`.
    ///
    /// # Errors
    /// When no finite solution exists: nothing absorbs and nothing escapes in some band.
    pub fn new(world: &World, optics: &Optics, mesh: &Elements, rows: &Rows, accuracy: f64) -> Result<Self> {
        let exchanges = super::exchanges(world, optics, mesh, rows, accuracy)?;
        let material = |surface: u32| world.surfaces.list[surface as usize].material;
        let rho = |band: usize| {
            let of = |e: &crate::mesh::Element| f64::from(optics.rho(material(e.surface), e.front)[band]);
            mesh.list().iter().map(of).collect()
        };
        let tint = |band: usize| rows.tints.iter().map(|t| f64::from(t[band])).collect();
        let bands = 0..optics.bands.len();
        Ok(Self { exchanges, rho: bands.clone().map(rho).collect(), tints: bands.map(tint).collect(), accuracy })
    }

    /// Radiosity of every element in one replica and one band, for eight fields of direct irradiance.
    #[must_use]
    pub fn solve(&self, replica: usize, band: usize, direct: &[Lanes]) -> Vec<Lanes> {
        let spread = |values: &[f64]| values.iter().map(|v| [*v; LANES]).collect::<Vec<Lanes>>();
        let (rho, tints) = (spread(&self.rho[band]), spread(&self.tints[band]));
        let source: Vec<Lanes> = direct.iter().zip(&rho).map(|(d, r)| std::array::from_fn(|l| d[l] * r[l])).collect();
        System { exchange: &self.exchanges[replica], rho: &rho, tints: &tints }.solve(&source, self.accuracy).0
    }
}
