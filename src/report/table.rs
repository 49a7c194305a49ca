//! CSV: tidy, UTF-8, units in the header, numbers that read back to the same bits, no comments.

use crate::error::{Error, ErrorKind, Result};
use crate::measure::{GridResult, Measurement, SensorResult, Status};
use crate::scene::{Axes, Scene};
use crate::spectrum::colour;

const ILLUMINANCE: [&str; 20] = [
    "grid",
    "point",
    "x_m",
    "y_m",
    "z_m",
    "nx",
    "ny",
    "nz",
    "area_m2",
    "status",
    "illuminance_lx",
    "error_lx",
    "direct_lx",
    "sun_lx",
    "sky_lx",
    "external_lx",
    "reflected_lx",
    "cie_x",
    "cie_y",
    "cct_K",
];

const SUMMARY: [&str; 15] = [
    "grid",
    "points",
    "ok",
    "covered",
    "inside",
    "mean_lx",
    "min_lx",
    "max_lx",
    "uniformity_U0",
    "median_error_lx",
    "max_error_lx",
    "holding",
    "holding_share",
    "daylight_factor_percent",
    "state",
];

const IRRADIANCE: [&str; 6] = ["grid", "point", "band_lo_nm", "band_hi_nm", "irradiance_W_m2_nm", "error_W_m2_nm"];

const GLARE: [&str; 6] = ["grid", "point", "background_cd_m2", "ugr", "ugr_error", "state"];

/// `glare.csv`: one line per eye, then one per eye in each state of the lights; no rating where no luminaire shines into it.
pub(super) fn glare(m: &Measurement) -> Result<Vec<u8>> {
    let mut table = Table::new(&GLARE)?;
    for g in &m.glare {
        let field = |v: f64| {
            let wrong = |e: NotFinite| format!("grid {:?}, point {}: a value is {}", g.grid, g.point, e.0);
            number(v).map_err(|e| Error::new(ErrorKind::Internal, wrong(e)))
        };
        let rated = |v: f64| g.ugr.map_or(Ok(String::new()), |_| field(v));
        let background = field(g.background_cd_m2)?;
        table.line(&[
            g.grid.clone(),
            g.point.to_string(),
            background,
            rated(g.ugr.unwrap_or(0.0))?,
            rated(g.error)?,
            g.state.clone(),
        ])?;
    }
    table.finish()
}

/// `illuminance.csv`: one line per sensor, in the user's order and axes; points count from 0.
pub(super) fn illuminance(scene: &Scene, m: &Measurement) -> Result<Vec<u8>> {
    let mut table = Table::new(&ILLUMINANCE)?;
    sensor_lines(&mut table, scene.axes, &m.grids, None)?;
    table.finish()
}

/// `states.csv`: the same in every state of the lights, whose name comes first.
pub(super) fn states(scene: &Scene, m: &Measurement) -> Result<Vec<u8>> {
    let header: Vec<&str> = std::iter::once("state").chain(ILLUMINANCE).collect();
    let mut table = Table::new(&header)?;
    for state in &m.states {
        sensor_lines(&mut table, scene.axes, &state.grids, Some(&state.name))?;
    }
    table.finish()
}

fn sensor_lines(table: &mut Table, axes: Axes, grids: &[GridResult], state: Option<&String>) -> Result<()> {
    for grid in grids {
        for (point, sensor) in grid.sensors.iter().enumerate() {
            let row = sensor_row(axes, sensor).map_err(|e| at(grid, point, &e))?;
            let names = state.into_iter().cloned().chain([grid.name.clone(), point.to_string()]);
            table.line(&names.chain(row).collect::<Vec<_>>())?;
        }
    }
    Ok(())
}

fn sensor_row(axes: Axes, s: &SensorResult) -> Checked<Vec<String>> {
    let mut row = Vec::with_capacity(ILLUMINANCE.len());
    let (p, n) = (axes.to_user(s.position), axes.to_user(s.normal));
    for v in [p.x, p.y, p.z, n.x, n.y, n.z] {
        row.push(number(v)?);
    }
    row.push(s.area_m2.map_or(Ok(String::new()), number)?);
    row.push(status(s.status).into());
    if s.status != Status::Ok {
        row.resize(ILLUMINANCE.len() - 2, String::new());
        return Ok(row);
    }
    let parts = [s.xyz[1], s.error_lx, s.direct_lx, s.sun_lx, s.sky_lx, s.external_lx, s.reflected_lx];
    for v in parts {
        row.push(number(v)?);
    }
    // X and Z have no column of their own, but must be as good.
    number(s.xyz[0])?;
    number(s.xyz[2])?;
    let xy = colour::xy(s.xyz);
    let cct = xy.and_then(colour::cct);
    row.push(xy.map_or(Ok(String::new()), |xy| number(xy[0]))?);
    row.push(xy.map_or(Ok(String::new()), |xy| number(xy[1]))?);
    row.push(cct.map_or(Ok(String::new()), |c| number(c.kelvin))?);
    Ok(row)
}

pub(super) fn status(status: Status) -> &'static str {
    match status {
        Status::Ok => "ok",
        Status::Covered => "covered",
        Status::Inside => "inside",
    }
}

/// Figures of a grid over its ok points.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Statistics {
    pub(super) ok: usize,
    pub(super) covered: usize,
    pub(super) inside: usize,
    /// Nothing where no point is ok.
    pub(super) values: Option<Values>,
    /// Points whose stated error is inside the tolerance.
    pub(super) holding: usize,
}

/// Illuminances in lx.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Values {
    /// By area where all points have one.
    pub(super) mean_lx: f64,
    pub(super) min_lx: f64,
    pub(super) max_lx: f64,
    pub(super) median_error_lx: f64,
    pub(super) max_error_lx: f64,
}

impl Values {
    /// U0 = min/mean; nothing in the dark.
    pub(super) fn uniformity(&self) -> Option<f64> {
        (self.mean_lx > 0.0).then(|| self.min_lx / self.mean_lx)
    }

    /// Mean illuminance over that of an unobstructed horizontal plane; nothing unless a sky is the only light.
    pub(super) fn daylight_factor_percent(&self, outdoor_lx: Option<f64>) -> Option<f64> {
        outdoor_lx.map(|outdoor| 100.0 * self.mean_lx / outdoor)
    }
}

impl Statistics {
    pub(super) fn of(grid: &GridResult) -> Self {
        let count = |s: Status| grid.sensors.iter().filter(|r| r.status == s).count();
        Self {
            ok: count(Status::Ok),
            covered: count(Status::Covered),
            inside: count(Status::Inside),
            values: values(grid),
            holding: grid.holding,
        }
    }

    /// Share of the ok points that hold the tolerance; nothing where no point is ok.
    pub(super) fn holding_share(&self) -> Option<f64> {
        (self.ok > 0).then(|| self.holding as f64 / self.ok as f64)
    }
}

fn values(grid: &GridResult) -> Option<Values> {
    let ok: Vec<&SensorResult> = grid.sensors.iter().filter(|s| s.status == Status::Ok).collect();
    let by_area = ok.iter().all(|s| s.area_m2.is_some_and(|a| a > 0.0));
    let weight = |s: &SensorResult| {
        if by_area { s.area_m2.unwrap_or(1.0) } else { 1.0 }
    };
    let whole: f64 = ok.iter().map(|s| weight(s)).sum();
    let sum: f64 = ok.iter().map(|s| weight(s) * s.xyz[1]).sum();
    let mut errors: Vec<f64> = ok.iter().map(|s| s.error_lx).collect();
    errors.sort_by(f64::total_cmp);
    Some(Values {
        mean_lx: sum / whole,
        min_lx: ok.iter().map(|s| s.xyz[1]).reduce(f64::min)?,
        max_lx: ok.iter().map(|s| s.xyz[1]).reduce(f64::max)?,
        median_error_lx: median(&errors)?,
        max_error_lx: *errors.last()?,
    })
}

/// Of sorted numbers.
fn median(sorted: &[f64]) -> Option<f64> {
    let upper = *sorted.get(sorted.len() / 2)?;
    if sorted.len() % 2 == 1 {
        return Some(upper);
    }
    Some(0.5 * (sorted[sorted.len() / 2 - 1] + upper))
}

/// `summary.csv`: one line per grid, then one per grid in each state of the lights; empty where there is nothing to say.
pub(super) fn summary(m: &Measurement) -> Result<Vec<u8>> {
    let mut table = Table::new(&SUMMARY)?;
    let of_states = m.states.iter().flat_map(|s| s.grids.iter().map(|g| (g, s.name.clone())));
    for (grid, state) in m.grids.iter().map(|g| (g, String::new())).chain(of_states) {
        let s = Statistics::of(grid);
        let optional = |v: Option<f64>| match v {
            Some(v) => number(v).map_err(|e| at_grid(grid, &e)),
            None => Ok(String::new()),
        };
        let v = s.values.as_ref();
        table.line(&[
            grid.name.clone(),
            grid.sensors.len().to_string(),
            s.ok.to_string(),
            s.covered.to_string(),
            s.inside.to_string(),
            optional(v.map(|v| v.mean_lx))?,
            optional(v.map(|v| v.min_lx))?,
            optional(v.map(|v| v.max_lx))?,
            optional(v.and_then(Values::uniformity))?,
            optional(v.map(|v| v.median_error_lx))?,
            optional(v.map(|v| v.max_error_lx))?,
            s.holding.to_string(),
            optional(s.holding_share())?,
            optional(v.and_then(|v| v.daylight_factor_percent(m.outdoor_lx)))?,
            state,
        ])?;
    }
    table.finish()
}

/// `irradiance.csv`: one line per ok sensor and band.
pub(super) fn irradiance(m: &Measurement) -> Result<Vec<u8>> {
    let mut table = Table::new(&IRRADIANCE)?;
    for grid in &m.grids {
        for (point, sensor) in grid.sensors.iter().enumerate() {
            if sensor.status != Status::Ok {
                continue;
            }
            for ((lo, hi), value) in m.bands.limits_nm().iter().zip(&sensor.spectral) {
                let field = |v: f64| number(v).map_err(|e| at(grid, point, &e));
                table.line(&[
                    grid.name.clone(),
                    point.to_string(),
                    field(*lo)?,
                    field(*hi)?,
                    field(value.irradiance)?,
                    field(value.error)?,
                ])?;
            }
        }
    }
    table.finish()
}

/// A value that must not be written.
#[derive(Debug)]
pub(super) struct NotFinite(pub(super) f64);

pub(super) type Checked<T> = std::result::Result<T, NotFinite>;

/// The shortest text that reads back to the same number.
pub(super) fn number(v: f64) -> Checked<String> {
    if !v.is_finite() {
        return Err(NotFinite(v));
    }
    let size = v.abs();
    Ok(if size == 0.0 {
        "0".into()
    } else if (1e-5..1e16).contains(&size) {
        format!("{v}")
    } else {
        format!("{v:e}")
    })
}

pub(super) fn at(grid: &GridResult, point: usize, e: &NotFinite) -> Error {
    Error::new(ErrorKind::Internal, format!("grid {:?}, point {point}: a value is {}", grid.name, e.0))
}

fn at_grid(grid: &GridResult, e: &NotFinite) -> Error {
    Error::new(ErrorKind::Internal, format!("grid {:?}: a value is {}", grid.name, e.0))
}

/// A CSV file in memory.
pub(super) struct Table(csv::Writer<Vec<u8>>);

impl Table {
    pub(super) fn new(header: &[&str]) -> Result<Self> {
        let mut table = Self(csv::Writer::from_writer(Vec::new()));
        table.0.write_record(header).map_err(broken)?;
        Ok(table)
    }

    pub(super) fn line(&mut self, fields: &[String]) -> Result<()> {
        self.0.write_record(fields).map_err(broken)
    }

    pub(super) fn finish(self) -> Result<Vec<u8>> {
        self.0.into_inner().map_err(|e| Error::new(ErrorKind::Internal, format!("a table: {e}")))
    }
}

#[expect(clippy::needless_pass_by_value, reason = "the shape of map_err")]
fn broken(e: csv::Error) -> Error {
    Error::new(ErrorKind::Internal, format!("a table: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_read_back_to_the_same_bits() {
        assert_eq!(number(500.0).unwrap(), "500");
        assert_eq!(number(-0.0).unwrap(), "0");
        assert_eq!(number(0.1).unwrap(), "0.1");
        for v in [1e-300, 1.0 / 3.0, 123_456.789, 1e20, -5e-6] {
            assert_eq!(number(v).unwrap().parse::<f64>().unwrap(), v);
        }
        assert!(number(f64::NAN).is_err());
        assert!(number(f64::INFINITY).is_err());
    }

    #[test]
    fn the_median_of_an_even_count_is_the_middle() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0]), Some(3.0));
        assert_eq!(median(&[1.0, 2.0, 4.0, 9.0]), Some(3.0));
    }
}
