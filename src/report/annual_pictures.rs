//! Pictures of a year: maps of its metrics, every hour of every day, the mean day of every month.

use super::canvas::{Canvas, LINE, Rect, readable_on};
use super::field::Field;
use super::figure::{Axis, Contents, Figure};
use super::map::{self, Words, lit};
use super::scale::{Scale, three_digits};
use super::text::Font;
use crate::annual::{GridMetrics, GridYear, PointMetrics, Year};
use crate::error::Result;
use crate::light::sun::days_in_month;
use crate::scene::{GridLayout, Scene};

/// Sides of a cell of the year's map, and of the months' table, pixels.
const DAY: (usize, usize) = (3, 22);
const MONTH: (usize, usize) = (76, 26);
const HOURS: usize = 24;
const MONTHS: [&str; 12] = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

/// A map of one metric.
struct MetricMap {
    /// Ending of the file's name.
    ending: &'static str,
    title: &'static str,
    unit: &'static str,
    value: fn(&PointMetrics) -> f64,
    note: fn(&GridMetrics) -> String,
}

const MAPS: [MetricMap; 3] = [
    MetricMap {
        ending: "_autonomy",
        title: "daylight autonomy, 300 lx",
        unit: "% of the hours of presence",
        value: |p| 100.0 * p.autonomy.value,
        note: |g| {
            let f = g.spatial_autonomy;
            format!("sDA300/50 {} % (±{} %)", three_digits(100.0 * f.value), three_digits(100.0 * f.error))
        },
    },
    MetricMap {
        ending: "_useful",
        title: "useful daylight, 300 to 3,000 lx",
        unit: "% of the hours of presence",
        value: |p| 100.0 * p.useful[2].value,
        note: |g| {
            let [below, some, useful, above] = g.mean.useful.map(|u| three_digits(100.0 * u.value));
            format!("mean: {useful} %   below 100 lx {below} %   100 to 300 lx {some} %   above 3,000 lx {above} %")
        },
    },
    MetricMap {
        ending: "_sunlight",
        title: "direct sun of 1,000 lx or more, blinds open",
        unit: "hours of presence",
        value: |p| p.sunlit_hours as f64,
        note: |g| format!("ASE1000,250 {} %", three_digits(100.0 * g.sunlight_exposure[0])),
    },
];

/// Endings of all pictures of a grid.
pub(super) const ENDINGS: [&str; 5] = ["_autonomy", "_useful", "_sunlight", "_year", "_months"];

/// All pictures of a grid: ending and bytes.
pub(super) fn pictures(scene: &Scene, year: &Year, grid: &GridYear) -> Result<Vec<(&'static str, Vec<u8>)>> {
    let mut pictures = Vec::new();
    let Some(metrics) = &grid.metrics.grid else { return Ok(pictures) };
    if matches!(grid.layout, GridLayout::Raster { .. }) {
        for m in &MAPS {
            pictures.push((m.ending, metric_map(scene, year, grid, metrics, m)?));
        }
    }
    let means = Means::of(year, grid);
    pictures.push(("_year", every_hour(year, grid, &means)?));
    pictures.push(("_months", months(year, grid, &means)?));
    Ok(pictures)
}

fn metric_map(scene: &Scene, year: &Year, grid: &GridYear, metrics: &GridMetrics, m: &MetricMap) -> Result<Vec<u8>> {
    let values: Vec<Option<f64>> = grid.metrics.points.iter().map(|p| p.as_ref().map(m.value)).collect();
    let field = Field::of(&grid.name, &grid.layout, &values)?;
    let scale = if m.unit.starts_with('%') { Scale::percent() } else { Scale::from_zero(&lit(&field)) };
    let notes = [(m.note)(metrics), format!("{}, {} hours of presence", year.weather, metrics.present_hours)];
    let title = format!("{}: {}", grid.name, m.title);
    map::draw(&field, &scale, &Words { title: &title, subtitle: &scene.title, notes: &notes, unit: m.unit }, scene.axes)
}

/// Mean illuminance of a grid in every hour of the weather, lx; dark hours are zero.
struct Means {
    lux: Vec<f64>,
}

impl Means {
    fn of(year: &Year, grid: &GridYear) -> Self {
        let mut lux = vec![0.0; year.climate.total];
        let points: Vec<usize> = (0..grid.sensors.len()).filter(|i| grid.metrics.points[*i].is_some()).collect();
        let area = |i: usize| grid.sensors[i].area_m2.unwrap_or(1.0);
        let whole: f64 = points.iter().map(|i| area(*i)).sum();
        for i in points {
            for (hour, v) in year.climate.hours.iter().zip(grid.series.of(i)) {
                lux[hour.index] += f64::from(*v) * area(i) / whole;
            }
        }
        Self { lux }
    }

    fn scale(&self) -> Scale {
        Scale::of_year(&self.lux)
    }
}

/// Days of each month of a year of so many hours.
fn month_lengths(hours: usize) -> [usize; 12] {
    let year = if hours > 8760 { 2000 } else { 2001 };
    std::array::from_fn(|m| days_in_month(year, m as u32 + 1) as usize)
}

fn hour_axis() -> Axis {
    Axis::named("hour", HOURS as f64, (0..=HOURS).step_by(3).map(|h| (h as f64, h.to_string())).collect())
}

fn fill(canvas: &mut Canvas, (left, top): (usize, usize), (width, height): (usize, usize), scale: &Scale, lux: f64) {
    let colour = if lux > 0.0 { scale.colour(lux) } else { [0; 3] };
    canvas.fill(Rect { left, top, width, height }, colour, 1.0);
}

/// Every hour of every day.
fn every_hour(year: &Year, grid: &GridYear, means: &Means) -> Result<Vec<u8>> {
    let days = year.climate.total / HOURS;
    let scale = means.scale();
    let mut first = 0;
    let names = month_lengths(year.climate.total).into_iter().zip(MONTHS).map(|(length, name)| {
        let middle = first as f64 + 0.5 * length as f64;
        first += length;
        (middle, name.to_owned())
    });
    let mut figure = Figure::new(&Contents {
        title: &format!("{}: mean illuminance, hour by hour", grid.name),
        subtitle: &format!("{}, standard time", year.weather),
        notes: &[],
        hatched: false,
        plot: (DAY.0 * days, DAY.1 * HOURS),
        axes: Some([Axis::named("", days as f64, names.collect()), hour_axis()]),
        scale: &scale,
        unit: "lx",
    });
    let plot = figure.plot;
    for (index, lux) in means.lux.iter().take(days * HOURS).enumerate() {
        let at = (plot.left + DAY.0 * (index / HOURS), plot.bottom() - DAY.1 * (index % HOURS + 1));
        fill(&mut figure.canvas, at, DAY, &scale, *lux);
    }
    figure.canvas.frame(plot, LINE);
    figure.canvas.into_png()
}

/// The mean day of every month.
fn months(year: &Year, grid: &GridYear, means: &Means) -> Result<Vec<u8>> {
    let scale = means.scale();
    let names = MONTHS.iter().enumerate().map(|(m, name)| (m as f64 + 0.5, (*name).to_owned()));
    let mut figure = Figure::new(&Contents {
        title: &format!("{}: mean day of every month, lx", grid.name),
        subtitle: &format!("{}, standard time", year.weather),
        notes: &[],
        hatched: false,
        plot: (MONTH.0 * 12, MONTH.1 * HOURS),
        axes: Some([Axis::named("", 12.0, names.collect()), hour_axis()]),
        scale: &scale,
        unit: "lx",
    });
    let plot = figure.plot;
    let mut first = 0;
    for (month, days) in month_lengths(year.climate.total).into_iter().enumerate() {
        for hour in 0..HOURS {
            let of_day = |d: usize| means.lux.get((first + d) * HOURS + hour).copied().unwrap_or(0.0);
            let mean = (0..days).map(of_day).sum::<f64>() / days as f64;
            let at = (plot.left + MONTH.0 * month, plot.bottom() - MONTH.1 * (hour + 1));
            fill(&mut figure.canvas, at, MONTH, &scale, mean);
            if mean >= 0.5 {
                let text = format!("{mean:.0}");
                let left = at.0 + (MONTH.0 - Font::Label.width(&text)) / 2;
                let top = at.1 + (MONTH.1 - Font::Label.height()) / 2;
                figure.canvas.text(left, top, &text, Font::Label, readable_on(scale.colour(mean)));
            }
        }
        first += days;
    }
    figure.canvas.frame(plot, LINE);
    figure.canvas.into_png()
}
