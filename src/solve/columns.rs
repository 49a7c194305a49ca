//! One scene, many lights: the same system for any number of right-hand sides, eight at a time.

use super::bicgstab::{LANES, Lanes, System};
use super::exchange::Exchange;
use super::scattering::Scattering;
use crate::error::Result;
use crate::mesh::Elements;
use crate::transport::{Optics, Rows, World};

/// The balanced matrices of a scene, ready for light of any kind.
#[derive(Debug)]
pub struct Columns {
    exchanges: Vec<Exchange>,
    /// What the elements do with light, by band.
    scattering: Vec<Scattering>,
    /// Each tint, by band.
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
        let scattering = |band: usize| Scattering::new(world, optics, mesh, |bands| [f64::from(bands[band]); LANES]);
        let tint = |band: usize| rows.tints.iter().map(|t| f64::from(t[band])).collect();
        let bands = 0..optics.bands.len();
        let scattering = bands.clone().map(scattering).collect();
        Ok(Self { exchanges, scattering, tints: bands.map(tint).collect(), accuracy })
    }

    /// Radiosity of every element in one replica and one band, for eight fields of direct irradiance.
    #[must_use]
    pub fn solve(&self, replica: usize, band: usize, direct: &[Lanes]) -> Vec<Lanes> {
        let tints: Vec<Lanes> = self.tints[band].iter().map(|t| [*t; LANES]).collect();
        let scattering = &self.scattering[band];
        let mut source = direct.to_vec();
        scattering.act(&mut source);
        System { exchange: &self.exchanges[replica], scattering, tints: &tints }.solve(source, self.accuracy).0
    }
}
