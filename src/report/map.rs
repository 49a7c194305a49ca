//! False-colour maps of grids and views.

use super::canvas::{LINE, WHITE};
use super::field::{Cell, Field};
use super::figure::{Contents, Figure, hatch};
use super::isolines::{Pixels, draw_isolines};
use super::scale::{Scale, three_digits};
use super::table::Statistics;
use super::units::Units;
use crate::error::Result;
use crate::measure::{GridResult, ViewResult};
use crate::scene::{Axes, Scene};

/// Longer side of a plot, pixels; pictures are at least as large.
pub(super) const LONG_SIDE: usize = 900;

/// The map of a grid whose sensors lie in a raster.
pub(super) fn illuminance(scene: &Scene, grid: &GridResult, units: Units) -> Result<Vec<u8>> {
    let field = Field::new(grid, units)?;
    let scale = Scale::illuminance(&lit(&field));
    let words =
        Words { title: &grid.name, subtitle: &scene.title, notes: &grid_notes(grid, units), unit: units.name() };
    draw(&field, &scale, &words, scene.axes)
}

/// Values of the cells that have one.
pub(super) fn lit(field: &Field) -> Vec<f64> {
    field.cells.iter().filter_map(|c| c.value()).collect()
}

/// What is written about a map.
pub(super) struct Words<'a> {
    pub(super) title: &'a str,
    pub(super) subtitle: &'a str,
    pub(super) notes: &'a [String],
    pub(super) unit: &'a str,
}

/// A false-colour map with isolines.
pub(super) fn draw(field: &Field, scale: &Scale, words: &Words<'_>, axes: Axes) -> Result<Vec<u8>> {
    let (width, height) = field.plot_size();
    let map = Pixels::new(field, (width, height), &scale.ticks);
    let mut figure = Figure::new(&Contents {
        title: words.title,
        subtitle: words.subtitle,
        notes: words.notes,
        hatched: field.cells.contains(&Cell::Covered),
        plot: (width, height),
        axes: Some(field.axes(axes)),
        scale,
        unit: words.unit,
    });
    let (plot, canvas) = (figure.plot, &mut figure.canvas);
    let columns = field.columns(width);
    for (y, row) in field.rows(height).iter().enumerate() {
        for (x, column) in columns.iter().enumerate() {
            let colour = match map.at(x, y) {
                Some(v) => scale.colour(v),
                None if field.cell(column, row) == Cell::Covered => hatch(x, y),
                None => WHITE,
            };
            canvas.set(plot.left + x, plot.top + y, colour);
        }
    }
    draw_isolines(canvas, plot, &map, scale);
    canvas.frame(plot, LINE);
    figure.canvas.into_png()
}

fn grid_notes(grid: &GridResult, units: Units) -> Vec<String> {
    let Some(v) = Statistics::of(grid).values else {
        return vec!["no point of this grid can be lit".into()];
    };
    let (unit, told) = (units.name(), |lux: f64| three_digits(lux / units.lux()));
    let uniformity = v.uniformity().map_or(String::new(), |u| format!("   U0 {}", three_digits(u)));
    vec![
        format!(
            "mean {} {unit}   min {} {unit}   max {} {unit}{uniformity}",
            told(v.mean_lx),
            told(v.min_lx),
            told(v.max_lx)
        ),
        format!("median error ±{} {unit} (95 %)", told(v.median_error_lx)),
    ]
}

/// The luminances of a view, logarithmic.
pub(super) fn luminance(scene: &Scene, result: &ViewResult) -> Result<Vec<u8>> {
    let view = &result.view;
    let values: Vec<f64> = result.xyz.iter().map(|p| f64::from(p[1])).collect();
    let scale = Scale::luminance(&values);
    // Whole multiples keep the pixels square and sharp.
    let zoom = LONG_SIDE.div_ceil(view.width.max(view.height));
    let mut figure = Figure::new(&Contents {
        title: &view.name,
        subtitle: &scene.title,
        notes: &view_notes(result, &values),
        hatched: false,
        plot: (zoom * view.width, zoom * view.height),
        axes: None,
        scale: &scale,
        unit: "cd/m²",
    });
    let plot = figure.plot;
    for y in 0..plot.height {
        for x in 0..plot.width {
            let v = values[y / zoom * view.width + x / zoom];
            let colour = if v > 0.0 { scale.colour(v) } else { [0; 3] };
            figure.canvas.set(plot.left + x, plot.top + y, colour);
        }
    }
    figure.canvas.frame(plot, LINE);
    figure.canvas.into_png()
}

fn view_notes(result: &ViewResult, values: &[f64]) -> Vec<String> {
    let min = values.iter().copied().fold(f64::INFINITY, f64::min);
    let max = values.iter().copied().fold(0.0, f64::max);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let percent = |v: f64| three_digits(100.0 * v);
    let error = if result.error_median.is_finite() && result.error_p95.is_finite() {
        format!(
            "error on diffuse surfaces (95 %): median ±{} %, 95th percentile ±{} %",
            percent(result.error_median),
            percent(result.error_p95)
        )
    } else {
        "no diffuse surface in this view".into()
    };
    let range = format!(
        "mean {} cd/m²   min {} cd/m²   max {} cd/m²",
        three_digits(mean),
        three_digits(min),
        three_digits(max)
    );
    vec![range, error]
}
