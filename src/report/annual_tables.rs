//! `metrics.csv` and `grid_metrics.csv`: what a year comes to, by point and by grid. Shares are in percent.

use super::table::{Checked, NotFinite, Table, number, status};
use crate::annual::{Figure, GridMetrics, GridYear, PointMetrics, Year};
use crate::error::{Error, ErrorKind, Result};
use crate::scene::Axes;

/// Figures with an error: name and unit, factor, and how to get them.
type Column = (&'static str, f64, fn(&PointMetrics) -> Figure);

/// Of a point, and in the mean of a grid.
pub(super) const FIGURES: [Column; 8] = [
    ("da300_percent", 100.0, |p| p.autonomy),
    ("cda300_percent", 100.0, |p| p.continuous_autonomy),
    ("udi_below_100_percent", 100.0, |p| p.useful[0]),
    ("udi_100_300_percent", 100.0, |p| p.useful[1]),
    ("udi_300_3000_percent", 100.0, |p| p.useful[2]),
    ("udi_above_3000_percent", 100.0, |p| p.useful[3]),
    ("annual_lx_h", 1.0, |p| p.annual_lx_h),
    ("half_of_daylight_hours_lx", 1.0, |p| p.half_of_daylight_lx),
];

/// A figure without an error of its own: its name and how to get it.
type Plain = (&'static str, fn(&PointMetrics) -> f64);

const PLACE: [&str; 10] = ["grid", "point", "x_m", "y_m", "z_m", "nx", "ny", "nz", "area_m2", "status"];
/// Figures without an error of their own: name, and how to get them.
pub(super) const OTHERS: [Plain; 7] = [
    ("sunlit_hours", |p| p.sunlit_hours as f64),
    ("daylight_factor_percent", |p| 100.0 * p.overcast.daylight_factor),
    ("sky_component_percent", |p| 100.0 * p.overcast.sky_component),
    ("probable_sunlight_percent", |p| 100.0 * p.probable_sunlight[0]),
    ("probable_sunlight_winter_percent", |p| 100.0 * p.probable_sunlight[1]),
    ("sunlight_1_february_h", |p| p.sunlight_h[0]),
    ("sunlight_21_march_h", |p| p.sunlight_h[1]),
];

/// Name of a figure's error.
fn error_name(name: &str) -> String {
    format!("{name}_error")
}

fn with_errors() -> impl Iterator<Item = String> {
    FIGURES.iter().flat_map(|(name, _, _)| [(*name).to_owned(), error_name(name)])
}

/// One line a point.
pub(super) fn points(axes: Axes, year: &Year) -> Result<Vec<u8>> {
    let names: Vec<String> =
        PLACE.map(String::from).into_iter().chain(with_errors()).chain(OTHERS.map(|o| o.0.to_owned())).collect();
    let header: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut table = Table::new(&header)?;
    for grid in &year.grids {
        for i in 0..grid.sensors.len() {
            let line = point(axes, grid, i, header.len()).map_err(|e| broken(grid, &e))?;
            table.line(&line)?;
        }
    }
    table.finish()
}

fn point(axes: Axes, grid: &GridYear, i: usize, columns: usize) -> Checked<Vec<String>> {
    let sensor = &grid.sensors[i];
    let (p, n) = (axes.to_user(sensor.position), axes.to_user(sensor.normal));
    let mut line = vec![grid.name.clone(), i.to_string()];
    for v in [p.x, p.y, p.z, n.x, n.y, n.z] {
        line.push(number(v)?);
    }
    line.push(sensor.area_m2.map_or(Ok(String::new()), number)?);
    line.push(status(grid.status[i]).into());
    if let Some(m) = &grid.metrics.points[i] {
        figures(m, &mut line)?;
    }
    line.resize(columns, String::new());
    Ok(line)
}

fn figures(m: &PointMetrics, line: &mut Vec<String>) -> Checked<()> {
    for (_, factor, of) in FIGURES {
        let figure = of(m);
        line.push(number(factor * figure.value)?);
        line.push(number(factor * figure.error)?);
    }
    for (_, of) in OTHERS {
        line.push(number(of(m))?);
    }
    Ok(())
}

const OF_GRID: [&str; 18] = [
    "sda300_50_percent",
    "sda300_50_percent_error",
    "ase1000_250_percent",
    "ase1000_at_least_250_percent",
    "leed_v41_option1_points",
    "en17037_hourly",
    "en17037_hourly_lowest",
    "en17037_daylight_factor",
    "breeam_mean_300_hours",
    "breeam_worst_90_hours",
    "breeam_hea01",
    "present_hours",
    "no_sky_percent",
    "equinox_300_3000_percent",
    "equinox_300_3000_percent_error",
    "equinox_9h_mean_lx",
    "equinox_15h_mean_lx",
    "leed_v41_option2_points",
];

/// One line a grid: its own figures, then the means of its points.
pub(super) fn grids(year: &Year) -> Result<Vec<u8>> {
    let names: Vec<String> = ["grid", "points"]
        .into_iter()
        .chain(OF_GRID)
        .map(String::from)
        .chain(with_errors())
        .chain(OTHERS.map(|o| o.0.to_owned()))
        .collect();
    let header: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut table = Table::new(&header)?;
    for grid in &year.grids {
        let seeing = grid.metrics.points.iter().flatten().count();
        let mut line = vec![grid.name.clone(), seeing.to_string()];
        if let Some(m) = &grid.metrics.grid {
            of_grid(m, &mut line).map_err(|e| broken(grid, &e))?;
        }
        line.resize(header.len(), String::new());
        table.line(&line)?;
    }
    table.finish()
}

fn of_grid(m: &GridMetrics, line: &mut Vec<String>) -> Checked<()> {
    let percent = |v: f64| number(100.0 * v);
    line.push(percent(m.spatial_autonomy.value)?);
    line.push(percent(m.spatial_autonomy.error)?);
    line.push(percent(m.sunlight_exposure[0])?);
    line.push(percent(m.sunlight_exposure[1])?);
    line.push(m.leed_points[0].to_string());
    line.push(m.en17037_hourly[0].name().into());
    line.push(m.en17037_hourly[1].name().into());
    line.push(m.en17037_factor.name().into());
    line.push(m.breeam_hours[0].to_string());
    line.push(m.breeam_hours[1].to_string());
    line.push(if m.breeam { "met" } else { "not met" }.into());
    line.push(m.present_hours.to_string());
    line.push(percent(m.no_sky)?);
    match &m.equinox {
        Some(e) => {
            line.push(percent(e.useful.value)?);
            line.push(percent(e.useful.error)?);
            line.push(number(e.mean_lx[0])?);
            line.push(number(e.mean_lx[1])?);
            line.push(e.leed_points.to_string());
        }
        None => line.resize(line.len() + 5, String::new()),
    }
    figures(&m.mean, line)
}

fn broken(grid: &GridYear, e: &NotFinite) -> Error {
    Error::new(ErrorKind::Internal, format!("grid {:?}: a metric is {}", grid.name, e.0))
}
