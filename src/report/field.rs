//! A raster of illuminances, and what lies between its points.

use glam::DVec3;

use super::figure::Axis;
use super::map::LONG_SIDE;
use super::units::Units;
use crate::error::{Error, ErrorKind, Result};
use crate::measure::{GridResult, SensorResult, Status};
use crate::scene::{Axes, GridLayout};

/// Least side of a plot, pixels.
const LEAST_SIDE: usize = 60;

/// What a cell of a raster holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cell {
    /// The value.
    Lit(f64),
    /// A sensor that lies on a surface beneath something, or in a solid.
    Covered,
    /// No sensor.
    Empty,
}

impl Cell {
    pub(super) fn value(self) -> Option<f64> {
        match self {
            Self::Lit(v) => Some(v),
            _ => None,
        }
    }
}

/// A raster of illuminances.
pub(super) struct Field {
    origin: DVec3,
    u: DVec3,
    v: DVec3,
    nu: usize,
    nv: usize,
    pub(super) cells: Vec<Cell>,
    /// The values with a rim of one cell, and with the unlit cells beside lit ones continued: what to
    /// interpolate between.
    continued: Vec<Option<f64>>,
}

impl Field {
    pub(super) fn new(grid: &GridResult, units: Units) -> Result<Self> {
        let value = |s: &SensorResult| (s.status == Status::Ok).then_some(s.xyz[1] / units.lux());
        let values: Vec<Option<f64>> = grid.sensors.iter().map(value).collect();
        Self::of(&grid.name, &grid.layout, &values)
    }

    /// Of any quantity, by sensor; nothing where the sensor sees nothing.
    pub(super) fn of(name: &str, layout: &GridLayout, values: &[Option<f64>]) -> Result<Self> {
        let wrong = |what: &str| Error::new(ErrorKind::Internal, format!("grid {name:?}: {what}"));
        let GridLayout::Raster { origin, u, v, nu, nv, index } = layout else {
            return Err(wrong("its points lie in no raster"));
        };
        if index.len() != nu * nv || index.is_empty() {
            return Err(wrong("its raster has not one entry per cell"));
        }
        let cell = |i: &Option<usize>| {
            let Some(i) = *i else {
                return Ok(Cell::Empty);
            };
            match values.get(i) {
                None => Err(wrong("its raster points to a sensor that is not there")),
                Some(Some(v)) if !v.is_finite() => Err(wrong(&format!("point {i} is not finite"))),
                Some(Some(v)) => Ok(Cell::Lit(*v)),
                Some(None) => Ok(Cell::Covered),
            }
        };
        let cells: Vec<Cell> = index.iter().map(cell).collect::<Result<_>>()?;
        Ok(Self { origin: *origin, u: *u, v: *v, nu: *nu, nv: *nv, continued: continued(&cells, *nu, *nv), cells })
    }

    /// Width and height in pixels, in proportion to the sides unless one is very short.
    pub(super) fn plot_size(&self) -> (usize, usize) {
        let (u, v) = (self.u.length(), self.v.length());
        let long = u.max(v);
        let side = |s: f64| ((LONG_SIDE as f64 * s / long).round() as usize).max(LEAST_SIDE);
        (side(u), side(v))
    }

    pub(super) fn axes(&self, axes: Axes) -> [Axis; 2] {
        [Axis::new(axes, self.origin, self.u, "along u"), Axis::new(axes, self.origin, self.v, "along v")]
    }

    /// Where each column of pixels lies among the cells.
    pub(super) fn columns(&self, width: usize) -> Vec<Between> {
        (0..width).map(|x| Between::new((x as f64 + 0.5) / width as f64, self.nu)).collect()
    }

    /// Where each row of pixels lies among the cells; v points up.
    pub(super) fn rows(&self, height: usize) -> Vec<Between> {
        (0..height).map(|y| Between::new(1.0 - (y as f64 + 0.5) / height as f64, self.nv)).collect()
    }

    pub(super) fn cell(&self, column: &Between, row: &Between) -> Cell {
        self.cells[row.nearest * self.nu + column.nearest]
    }

    /// Values along a row of pixels: bilinear between the middles of the cells around each; NaN where no cell is lit.
    pub(super) fn interpolated<'a>(
        &'a self,
        columns: &'a [Between],
        row: &'a Between,
    ) -> impl Iterator<Item = f64> + 'a {
        let above = self.nu + 2;
        let line = &self.continued[row.rimmed * above..][..2 * above];
        // By column of cells: what both its ends add to sum and weight.
        let ends: Vec<(f64, f64)> = (0..above)
            .map(|k| {
                let part = |v: Option<f64>, w: f64| v.map_or((0.0, 0.0), |v| (w * v, w));
                let (low, high) = (part(line[k], 1.0 - row.share), part(line[k + above], row.share));
                (low.0 + high.0, low.1 + high.1)
            })
            .collect();
        columns.iter().map(move |column| {
            let (s, [a, b]) = (column.share, [ends[column.rimmed], ends[column.rimmed + 1]]);
            let (sum, weight) = ((1.0 - s) * a.0 + s * b.0, (1.0 - s) * a.1 + s * b.1);
            if weight > 0.0 && self.cell(column, row).value().is_some() { sum / weight } else { f64::NAN }
        })
    }
}

/// A place between the middles of cells, along one side.
pub(super) struct Between {
    /// The cell that it lies in.
    nearest: usize,
    /// The cell before it, counted with the rim.
    rimmed: usize,
    /// How far it lies on the way to the next.
    share: f64,
}

impl Between {
    /// For a share of the side and the number of its cells.
    fn new(along: f64, cells: usize) -> Self {
        let place = along * cells as f64 - 0.5;
        let before = place.floor();
        let nearest = (place.round().max(0.0) as usize).min(cells - 1);
        Self { nearest, rimmed: (before + 1.0) as usize, share: place - before }
    }
}

/// The values of the lit cells with a rim of one cell; the rim and the unlit cells beside lit ones continue
/// the slope, so that isolines run straight to the edge.
fn continued(cells: &[Cell], nu: usize, nv: usize) -> Vec<Option<f64>> {
    let width = nu + 2;
    let mut lit = vec![None; width * (nv + 2)];
    for (k, cell) in cells.iter().enumerate() {
        lit[(k / nu + 1) * width + k % nu + 1] = cell.value();
    }
    let beside = with_neighbours(&lit, width, |near, far| match far {
        // A slope is continued with care: half the value more or less at most.
        Some(far) => (2.0 * near - far).clamp(0.5 * near, 1.5 * near),
        None => near,
    });
    // Corners touch no lit cell: they lie between two continued ones.
    with_neighbours(&beside, width, |near, _| near)
}

/// Fills each empty cell with the mean, over the full cells beside it, of what `guess` makes of that cell and
/// the one behind it.
fn with_neighbours(values: &[Option<f64>], width: usize, guess: impl Fn(f64, Option<f64>) -> f64) -> Vec<Option<f64>> {
    let (width, height) = (width as i64, (values.len() / width) as i64);
    let at = |i: i64, j: i64| {
        let inside = (0..width).contains(&i) && (0..height).contains(&j);
        inside.then(|| values[(j * width + i) as usize]).flatten()
    };
    let fill = |i: i64, j: i64| {
        let ways = [(1, 0), (-1, 0), (0, 1), (0, -1)];
        let guesses =
            ways.into_iter().filter_map(|(di, dj)| Some(guess(at(i + di, j + dj)?, at(i + 2 * di, j + 2 * dj))));
        let (sum, count) = guesses.fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
        (count > 0.0).then(|| sum / count)
    };
    (0..values.len() as i64).map(|k| values[k as usize].or_else(|| fill(k % width, k / width))).collect()
}
