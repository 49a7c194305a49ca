//! A result against measured values at its points.
//!
//! In: the `illuminance.csv` of a run, its `irradiance.csv` where faces have a colour, and a table of measured values with
//! their uncertainties. Out: [`Comparison`]s, one
//! for each quantity that was measured.

mod chart;
mod face;
mod read;

use serde::Serialize;

pub use chart::svg;
pub use face::{BandIrradiance, face_xyz};
pub use read::{Computed, measured, result};

/// What can be measured at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Illuminance, lx.
    Illuminance,
    /// Luminance of the face at the point, cd/m².
    Luminance,
    /// Chromaticity x (CIE 1931), of the face where its reflectance is told, of the light that arrives otherwise.
    CieX,
    /// Chromaticity y (CIE 1931), likewise.
    CieY,
}

impl Quantity {
    /// All of them, in the order of the report.
    pub const ALL: [Self; 4] = [Self::Illuminance, Self::Luminance, Self::CieX, Self::CieY];

    /// The column that holds it, in the result as in the measured table.
    #[must_use]
    pub fn column(self) -> &'static str {
        match self {
            Self::Illuminance => "illuminance_lx",
            Self::Luminance => "luminance_cd_m2",
            Self::CieX => "cie_x",
            Self::CieY => "cie_y",
        }
    }

    /// The column of its uncertainty in the measured table.
    #[must_use]
    pub fn uncertainty_column(self) -> &'static str {
        match self {
            Self::Illuminance => "uncertainty_lx",
            Self::Luminance => "uncertainty_cd_m2",
            Self::CieX | Self::CieY => "uncertainty_xy",
        }
    }

    /// Are differences told as shares of the measured value?
    #[must_use]
    pub fn is_relative(self) -> bool {
        matches!(self, Self::Illuminance | Self::Luminance)
    }
}

/// A value with the half-width of its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// In the unit of its quantity.
    pub value: f64,
    /// The same.
    pub error: f64,
}

/// Both readings of a point.
#[derive(Clone, Debug, Serialize)]
pub struct Pair {
    /// Name of the grid.
    pub grid: String,
    /// Number of the point in it, from 0.
    pub point: usize,
    /// What was measured.
    pub measured: Reading,
    /// What was computed.
    pub computed: Reading,
}

/// How a quantity compares over all points at which it was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Which quantity.
    pub quantity: Quantity,
    /// Number of points.
    pub points: usize,
    /// Mean of computed less measured; of illuminance and luminance as a share of the measured value.
    pub bias: f64,
    /// Root of the mean square of the same.
    pub rms: f64,
    /// Largest of the same, without its sign.
    pub worst: f64,
    /// Share of the points whose difference is within the root of the sum of both errors' squares.
    pub share_inside: f64,
    /// The points.
    pub pairs: Vec<Pair>,
}

impl Comparison {
    /// Of pairs; `None` where there is none.
    #[must_use]
    pub fn of(quantity: Quantity, pairs: Vec<Pair>) -> Option<Self> {
        if pairs.is_empty() {
            return None;
        }
        let n = pairs.len() as f64;
        let off = |p: &Pair| {
            let plain = p.computed.value - p.measured.value;
            if quantity.is_relative() { plain / p.measured.value } else { plain }
        };
        let inside =
            |p: &&Pair| (p.computed.value - p.measured.value).abs() <= p.computed.error.hypot(p.measured.error);
        Some(Self {
            quantity,
            points: pairs.len(),
            bias: pairs.iter().map(off).sum::<f64>() / n,
            rms: (pairs.iter().map(|p| off(p).powi(2)).sum::<f64>() / n).sqrt(),
            worst: pairs.iter().map(|p| off(p).abs()).fold(0.0, f64::max),
            share_inside: pairs.iter().filter(inside).count() as f64 / n,
            pairs,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bias_and_spread_are_told_apart() {
        let pair = |measured: f64, computed: f64| Pair {
            grid: "g".into(),
            point: 0,
            measured: Reading { value: measured, error: 3.0 },
            computed: Reading { value: computed, error: 4.0 },
        };
        // 2 % too much on average, 3 % to either side; the combined uncertainty is 5 lx of 100.
        let c = Comparison::of(Quantity::Illuminance, vec![pair(100.0, 105.0), pair(100.0, 99.0)]).unwrap();
        assert!((c.bias - 0.02).abs() < 1e-12 && (c.rms - (0.0026f64 / 2.0).sqrt()).abs() < 1e-12, "{c:?}");
        assert_eq!((c.share_inside, c.points), (1.0, 2));
        let c = Comparison::of(Quantity::Illuminance, vec![pair(100.0, 105.1), pair(100.0, 99.0)]).unwrap();
        assert_eq!(c.share_inside, 0.5);
        assert!(Comparison::of(Quantity::CieX, Vec::new()).is_none());
    }
}
