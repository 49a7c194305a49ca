//! False-colour maps of grids and views, with legend, isolines and axes.

use glam::DVec3;

use super::canvas::{Canvas, Colour, INK, LINE, Rect, WHITE, mixed, readable_on};
use super::legend;
use super::scale::{Scale, round_step, three_digits, with_step};
use super::table::Statistics;
use super::text::Font;
use crate::error::{Error, ErrorKind, Result};
use crate::measure::{GridResult, Status, ViewResult};
use crate::scene::{Axes, GridLayout, Scene};

/// Longer and least side of the plot, pixels.
const LONG_SIDE: usize = 900;
const LEAST_SIDE: usize = 60;
/// Least height of the colour bar, pixels.
const LEAST_BAR: usize = 300;
/// Empty border of the figure and gap between its parts, pixels.
const BORDER: usize = 24;
const GAP: usize = 10;

/// The map of a grid whose sensors lie in a raster.
pub(super) fn illuminance(scene: &Scene, grid: &GridResult) -> Result<Vec<u8>> {
    let field = Field::new(grid)?;
    let lit: Vec<f64> = field.cells.iter().filter_map(|c| c.value()).collect();
    let scale = Scale::illuminance(&lit);
    let (width, height) = field.plot_size();
    let map = Pixels::new(&field, width, height);
    let mut figure = Figure::new(&Contents {
        title: &grid.name,
        subtitle: &scene.title,
        notes: &grid_notes(grid),
        hatched: field.cells.contains(&Cell::Covered),
        plot: (width, height),
        axes: Some(field.axes(scene.axes)),
        scale: &scale,
        unit: "lx",
    });
    let (plot, canvas) = (figure.plot, &mut figure.canvas);
    for y in 0..height {
        for x in 0..width {
            let colour = match map.at(x, y) {
                Some(v) => scale.colour(v),
                None if field.at_pixel(x, y, width, height) == Cell::Covered => hatch(x, y),
                None => WHITE,
            };
            canvas.set(plot.left + x, plot.top + y, colour);
        }
    }
    draw_isolines(canvas, plot, &map, &scale);
    canvas.frame(plot, LINE);
    figure.canvas.into_png()
}

fn grid_notes(grid: &GridResult) -> Vec<String> {
    let Some(v) = Statistics::of(grid).values else {
        return vec!["no point of this grid can be lit".into()];
    };
    let uniformity = v
        .uniformity()
        .map_or(String::new(), |u| format!("   U0 {}", three_digits(u)));
    vec![
        format!(
            "mean {} lx   min {} lx   max {} lx{uniformity}",
            three_digits(v.mean_lx),
            three_digits(v.min_lx),
            three_digits(v.max_lx)
        ),
        format!(
            "median error ±{} lx (95 %)",
            three_digits(v.median_error_lx)
        ),
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

/// What a figure shows.
struct Contents<'a> {
    title: &'a str,
    subtitle: &'a str,
    notes: &'a [String],
    /// Does the legend need the hatching?
    hatched: bool,
    /// Size of the plot, pixels.
    plot: (usize, usize),
    axes: Option<[Axis; 2]>,
    scale: &'a Scale,
    unit: &'a str,
}

/// A figure with everything but the plot itself.
struct Figure {
    canvas: Canvas,
    plot: Rect,
}

const HATCHED_NOTE: &str = "covered, or inside a solid";

impl Figure {
    fn new(c: &Contents<'_>) -> Self {
        let (line, title_line) = (Font::Body.height() + 6, Font::Title.height() + 6);
        let subtitle = if c.subtitle == c.title {
            ""
        } else {
            c.subtitle
        };
        let head = title_line + if subtitle.is_empty() { 0 } else { line };
        let (left_axis, bottom_axis) = axis_room(c);
        let unit_room = Font::Body.height() + GAP;
        let plot = Rect {
            left: BORDER + left_axis,
            top: BORDER + head + unit_room,
            width: c.plot.0,
            height: c.plot.1,
        };
        let bar_left = plot.right() + 2 * GAP + GAP;
        let bar_height = plot.height.max(LEAST_BAR);
        let notes = c.notes.iter().map(|n| Font::Body.width(n)).max();
        let hatched = usize::from(c.hatched) * (Font::Body.width(HATCHED_NOTE) + line);
        let notes_right = BORDER + notes.unwrap_or(0).max(hatched);
        let width = (bar_left + legend::width(c.scale, c.unit)).max(notes_right) + BORDER;
        let bar_bottom = plot.top + bar_height + Font::Body.height() / 2;
        // Short notes go beside a bar that is taller than the plot.
        let under_bar = notes_right + GAP > bar_left;
        let plot_bottom = plot.bottom() + bottom_axis;
        let notes_top = GAP
            + if under_bar {
                plot_bottom.max(bar_bottom)
            } else {
                plot_bottom
            };
        let lines = c.notes.len() + usize::from(c.hatched);
        let height = (notes_top + lines * line).max(bar_bottom) + BORDER;
        let mut canvas = Canvas::new(width, height);
        let room = width - 2 * BORDER;
        let title = Font::Title.fit(c.title, room);
        canvas.text(BORDER, BORDER, &title, Font::Title, INK);
        let subtitle = Font::Body.fit(subtitle, room);
        canvas.text(BORDER, BORDER + title_line, &subtitle, Font::Body, LINE);
        legend::draw(
            &mut canvas,
            c.scale,
            c.unit,
            (bar_left, plot.top),
            bar_height,
        );
        for (i, note) in c.notes.iter().enumerate() {
            canvas.text(BORDER, notes_top + i * line, note, Font::Body, INK);
        }
        if c.hatched {
            draw_hatched_note(&mut canvas, notes_top + c.notes.len() * line);
        }
        if let Some([u, v]) = &c.axes {
            draw_u_axis(&mut canvas, plot, u);
            draw_v_axis(&mut canvas, plot, v);
        }
        Self { canvas, plot }
    }
}

fn draw_hatched_note(canvas: &mut Canvas, top: usize) {
    let side = Font::Body.height() - 4;
    let sample = Rect {
        left: BORDER,
        top: top + 2,
        width: side,
        height: side,
    };
    for y in 0..side {
        for x in 0..side {
            canvas.set(sample.left + x, sample.top + y, hatch(x, y));
        }
    }
    canvas.frame(sample, LINE);
    canvas.text(BORDER + side + GAP, top, HATCHED_NOTE, Font::Body, INK);
}

/// Grey with diagonals.
fn hatch(x: usize, y: usize) -> Colour {
    if (x + y) % 10 < 2 { [150; 3] } else { [222; 3] }
}

/// A direction of a map: coordinates from `start` over `length`, rising or falling, metres.
#[derive(Clone, Debug, PartialEq)]
struct Axis {
    name: &'static str,
    start: f64,
    sign: f64,
    length: f64,
}

impl Axis {
    /// The user's own axis where the side runs along one, the way along the side elsewhere.
    fn new(axes: Axes, origin: DVec3, side: DVec3, elsewhere: &'static str) -> Self {
        let (origin, side) = (axes.to_user(origin), axes.to_user(side));
        let length = side.length();
        let along = (0..3).find(|&c| side[c].abs() > (1.0 - 1e-9) * length);
        match along {
            Some(c) => Self {
                name: ["x", "y", "z"][c],
                start: origin[c],
                sign: side[c].signum(),
                length,
            },
            None => Self {
                name: elsewhere,
                start: 0.0,
                sign: 1.0,
                length,
            },
        }
    }

    fn label(&self) -> String {
        format!("{} [m]", self.name)
    }

    /// Places in pixels from the start and their texts: as many as have room, two at least where that can be.
    fn ticks(&self, pixels: usize) -> Vec<(usize, String)> {
        /// Least distances of ticks to try.
        const ROOM: [f64; 4] = [90.0, 60.0, 40.0, 32.0];
        if !(self.length > 0.0 && self.length.is_finite() && self.start.is_finite()) {
            return Vec::new();
        }
        let steps = ROOM.map(|room| round_step(self.length * room / pixels as f64));
        let tried = steps.map(|step| self.ticks_at(step, pixels));
        let enough = tried.iter().find(|t| t.len() >= 2);
        let most = || tried.iter().max_by_key(|t| t.len());
        enough.or_else(most).cloned().unwrap_or_default()
    }

    fn ticks_at(&self, step: f64, pixels: usize) -> Vec<(usize, String)> {
        let end = self.start + self.sign * self.length;
        let (lo, hi) = (self.start.min(end), self.start.max(end));
        let (first, last) = ((lo / step - 1e-6).ceil(), (hi / step + 1e-6).floor());
        let count = (last - first + 1.0).clamp(0.0, 100.0) as usize;
        (0..count)
            .map(|i| {
                let v = (first + i as f64) * step;
                let way = (v - self.start) * self.sign / self.length;
                let place = (way * pixels as f64).round().max(0.0) as usize;
                (place.min(pixels), with_step(v, step))
            })
            .collect()
    }
}

/// Length of a tick and gap to its label, pixels.
const TICK: usize = 6;

/// Room for the labels left of and below the plot.
fn axis_room(c: &Contents<'_>) -> (usize, usize) {
    let Some([_, v]) = &c.axes else {
        return (0, 0);
    };
    let labels = v.ticks(c.plot.1);
    let widest = labels.iter().map(|t| Font::Body.width(&t.1)).max();
    let line = Font::Body.height();
    (
        line + GAP + widest.unwrap_or(0) + 2 * TICK,
        2 * line + 2 * TICK + GAP,
    )
}

fn draw_u_axis(canvas: &mut Canvas, plot: Rect, axis: &Axis) {
    for (place, text) in axis.ticks(plot.width) {
        let x = plot.left + place;
        for y in 0..TICK {
            canvas.set(x, plot.bottom() + y, LINE);
        }
        let left = x.saturating_sub(Font::Body.width(&text) / 2);
        canvas.text(left, plot.bottom() + 2 * TICK, &text, Font::Body, INK);
    }
    let label = axis.label();
    let left = (plot.left + plot.width / 2).saturating_sub(Font::Body.width(&label) / 2);
    let top = plot.bottom() + 2 * TICK + Font::Body.height() + 4;
    canvas.text(left, top, &label, Font::Body, INK);
}

fn draw_v_axis(canvas: &mut Canvas, plot: Rect, axis: &Axis) {
    for (place, text) in axis.ticks(plot.height) {
        let y = plot.bottom() - place;
        for x in 1..=TICK {
            canvas.set(plot.left - x, y, LINE);
        }
        let left = (plot.left - 2 * TICK).saturating_sub(Font::Body.width(&text));
        let top = y.saturating_sub(Font::Body.height() / 2);
        canvas.text(left, top, &text, Font::Body, INK);
    }
    let label = axis.label();
    let bottom = plot.top + plot.height / 2 + Font::Body.width(&label) / 2;
    canvas.text_up(BORDER, bottom, &label, Font::Body, INK);
}

/// What a cell of a raster holds.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cell {
    /// Illuminance, lx.
    Lit(f64),
    /// A sensor that lies on a surface beneath something, or in a solid.
    Covered,
    /// No sensor.
    Empty,
}

impl Cell {
    fn value(self) -> Option<f64> {
        match self {
            Self::Lit(v) => Some(v),
            _ => None,
        }
    }
}

/// A raster of illuminances.
struct Field {
    origin: DVec3,
    u: DVec3,
    v: DVec3,
    nu: usize,
    nv: usize,
    cells: Vec<Cell>,
    /// The values with a rim of one cell, and with the unlit cells beside lit ones continued: what to
    /// interpolate between.
    continued: Vec<Option<f64>>,
}

impl Field {
    fn new(grid: &GridResult) -> Result<Self> {
        let wrong =
            |what: &str| Error::new(ErrorKind::Internal, format!("grid {:?}: {what}", grid.name));
        let GridLayout::Raster {
            origin,
            u,
            v,
            nu,
            nv,
            index,
        } = &grid.layout
        else {
            return Err(wrong("its points lie in no raster"));
        };
        if index.len() != nu * nv || index.is_empty() {
            return Err(wrong("its raster has not one entry per cell"));
        }
        let cell = |i: &Option<usize>| {
            let Some(i) = *i else {
                return Ok(Cell::Empty);
            };
            let s = grid
                .sensors
                .get(i)
                .ok_or_else(|| wrong("its raster points to a sensor that is not there"))?;
            Ok(match s.status {
                Status::Ok if !s.xyz[1].is_finite() => {
                    return Err(wrong(&format!("point {i} is not finite")));
                }
                Status::Ok => Cell::Lit(s.xyz[1]),
                Status::Covered | Status::Inside => Cell::Covered,
            })
        };
        let cells: Vec<Cell> = index.iter().map(cell).collect::<Result<_>>()?;
        Ok(Self {
            origin: *origin,
            u: *u,
            v: *v,
            nu: *nu,
            nv: *nv,
            continued: continued(&cells, *nu, *nv),
            cells,
        })
    }

    /// Width and height in pixels, in proportion to the sides unless one is very short.
    fn plot_size(&self) -> (usize, usize) {
        let (u, v) = (self.u.length(), self.v.length());
        let long = u.max(v);
        let side = |s: f64| ((LONG_SIDE as f64 * s / long).round() as usize).max(LEAST_SIDE);
        (side(u), side(v))
    }

    fn axes(&self, axes: Axes) -> [Axis; 2] {
        [
            Axis::new(axes, self.origin, self.u, "along u"),
            Axis::new(axes, self.origin, self.v, "along v"),
        ]
    }

    /// Place in cells: (0, 0) is the middle of the cell at the origin, v points up.
    fn place(&self, x: usize, y: usize, width: usize, height: usize) -> (f64, f64) {
        let a = (x as f64 + 0.5) / width as f64 * self.nu as f64 - 0.5;
        let b = (1.0 - (y as f64 + 0.5) / height as f64) * self.nv as f64 - 0.5;
        (a, b)
    }

    fn cell(&self, i: i64, j: i64) -> Cell {
        let i = i.clamp(0, self.nu as i64 - 1) as usize;
        let j = j.clamp(0, self.nv as i64 - 1) as usize;
        self.cells[j * self.nu + i]
    }

    fn at_pixel(&self, x: usize, y: usize, width: usize, height: usize) -> Cell {
        let (a, b) = self.place(x, y, width, height);
        self.cell(a.round() as i64, b.round() as i64)
    }

    /// Value at a place in a lit cell: bilinear between the middles of the cells around it.
    fn interpolated(&self, a: f64, b: f64) -> Option<f64> {
        self.cell(a.round() as i64, b.round() as i64).value()?;
        let (i, j) = (a.floor(), b.floor());
        let (s, t) = (a - i, b - j);
        // The rim shifts the numbers by one.
        let at = |di: f64, dj: f64| {
            let (i, j) = ((i + di + 1.0) as usize, (j + dj + 1.0) as usize);
            self.continued.get(j * (self.nu + 2) + i).copied().flatten()
        };
        let corners = [
            (at(0.0, 0.0), (1.0 - s) * (1.0 - t)),
            (at(1.0, 0.0), s * (1.0 - t)),
            (at(0.0, 1.0), (1.0 - s) * t),
            (at(1.0, 1.0), s * t),
        ];
        let known = corners.iter().filter_map(|(v, w)| v.map(|v| (v, w)));
        let (sum, weight) = known.fold((0.0, 0.0), |(s, n), (v, w)| (s + w * v, n + w));
        (weight > 0.0).then(|| sum / weight)
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
fn with_neighbours(
    values: &[Option<f64>],
    width: usize,
    guess: impl Fn(f64, Option<f64>) -> f64,
) -> Vec<Option<f64>> {
    let (width, height) = (width as i64, (values.len() / width) as i64);
    let at = |i: i64, j: i64| {
        let inside = (0..width).contains(&i) && (0..height).contains(&j);
        inside.then(|| values[(j * width + i) as usize]).flatten()
    };
    let fill = |i: i64, j: i64| {
        let ways = [(1, 0), (-1, 0), (0, 1), (0, -1)];
        let guesses = ways
            .into_iter()
            .filter_map(|(di, dj)| Some(guess(at(i + di, j + dj)?, at(i + 2 * di, j + 2 * dj))));
        let (sum, count) = guesses.fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
        (count > 0.0).then(|| sum / count)
    };
    (0..values.len() as i64)
        .map(|k| values[k as usize].or_else(|| fill(k % width, k / width)))
        .collect()
}

/// A field in the pixels of the plot.
struct Pixels {
    width: usize,
    height: usize,
    /// NaN where nothing is lit.
    value: Vec<f64>,
}

/// Value and slope per pixel.
struct Slope {
    value: f64,
    x: f64,
    y: f64,
    /// Least and largest value of the pixel and its four neighbours.
    range: (f64, f64),
}

impl Slope {
    fn steepness(&self) -> f64 {
        self.x.hypot(self.y)
    }

    /// Distance of a level's isoline, pixels; far where the level is not crossed nearby, as at a step.
    fn distance(&self, level: f64) -> f64 {
        if level < self.range.0 || level > self.range.1 {
            return f64::INFINITY;
        }
        (self.value - level).abs() / self.steepness()
    }
}

impl Pixels {
    fn new(field: &Field, width: usize, height: usize) -> Self {
        let mut value = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let (a, b) = field.place(x, y, width, height);
                value.push(field.interpolated(a, b).unwrap_or(f64::NAN));
            }
        }
        Self {
            width,
            height,
            value,
        }
    }

    fn at(&self, x: usize, y: usize) -> Option<f64> {
        let v = self.value[y * self.width + x];
        (!v.is_nan()).then_some(v)
    }

    /// By central differences; nothing at the rim and where the field is level.
    fn slope(&self, x: usize, y: usize) -> Option<Slope> {
        if x == 0 || y == 0 || x + 1 >= self.width || y + 1 >= self.height {
            return None;
        }
        let value = self.at(x, y)?;
        let (left, right) = (self.at(x - 1, y)?, self.at(x + 1, y)?);
        let (above, below) = (self.at(x, y - 1)?, self.at(x, y + 1)?);
        let around = [left, right, above, below];
        let slope = Slope {
            value,
            x: 0.5 * (right - left),
            y: 0.5 * (below - above),
            range: (
                around.into_iter().fold(value, f64::min),
                around.into_iter().fold(value, f64::max),
            ),
        };
        (slope.steepness() > 1e-9 * slope.value.abs()).then_some(slope)
    }
}

/// Half the width of an isoline, pixels.
const HALF_LINE: f64 = 0.75;
/// How much an isoline stands out.
const LINE_COVER: f64 = 0.8;

/// Isolines nearer to each other than this, pixels, have no label there.
const CROWDED: f64 = 12.0;

fn draw_isolines(canvas: &mut Canvas, plot: Rect, map: &Pixels, scale: &Scale) {
    let mut on_line: Vec<Vec<Candidate>> = vec![Vec::new(); scale.ticks.len()];
    for (x, y) in (0..map.height).flat_map(|y| (0..map.width).map(move |x| (x, y))) {
        let Some(slope) = map.slope(x, y) else {
            continue;
        };
        for (k, level) in scale.ticks.iter().enumerate() {
            let distance = slope.distance(*level);
            let cover = (HALF_LINE + 0.5 - distance).clamp(0.0, 1.0);
            if cover <= 0.0 {
                continue;
            }
            let ink = readable_on(scale.colour(slope.value));
            canvas.blend(plot.left + x, plot.top + y, ink, LINE_COVER * cover);
            let next = if k > 0 { k - 1 } else { k + 1 };
            let gap = (scale.ticks[next.min(scale.ticks.len() - 1)] - level).abs();
            if distance < 0.5 && gap > CROWDED * slope.steepness() {
                let across = slope.y.abs() / slope.steepness();
                on_line[k].push(Candidate { x, y, across });
            }
        }
    }
    draw_labels(canvas, plot, map, scale, &on_line);
}

/// A pixel on an isoline where its label might stand.
#[derive(Clone, Debug)]
struct Candidate {
    x: usize,
    y: usize,
    /// 1 where the line runs across the page, 0 where it runs up: across is easiest to label.
    across: f64,
}

/// Isolines shorter than this many pixels have no label, longer ones have two.
const SHORT_LINE: usize = 60;
const LONG_LINE: usize = 700;

fn draw_labels(
    canvas: &mut Canvas,
    plot: Rect,
    map: &Pixels,
    scale: &Scale,
    on_line: &[Vec<Candidate>],
) {
    let mut placed: Vec<Rect> = Vec::new();
    for (level, line) in scale.ticks.iter().zip(on_line) {
        let wanted = usize::from(line.len() > SHORT_LINE) + usize::from(line.len() > LONG_LINE);
        let text = scale.label(*level);
        let mut own: Vec<Rect> = Vec::new();
        for _ in 0..wanted {
            let Some(spot) = best_spot(map, line, &text, &placed, &own) else {
                break;
            };
            draw_label(canvas, plot, spot, &text, scale.colour(*level));
            placed.push(spot);
            own.push(spot);
        }
    }
}

/// Empty rim of a label, pixels.
const RIM: usize = 3;

/// The rectangle, in the plot, in which a label stands best; nothing where there is no room.
fn best_spot(
    map: &Pixels,
    line: &[Candidate],
    text: &str,
    placed: &[Rect],
    own: &[Rect],
) -> Option<Rect> {
    let (width, height) = (
        Font::Label.width(text) + 2 * RIM,
        Font::Label.height() + RIM,
    );
    let diagonal = (map.width as f64).hypot(map.height as f64);
    let mut best: Option<(f64, Rect)> = None;
    for &Candidate { x, y, across } in line.iter().step_by(3) {
        let (Some(left), Some(top)) = (x.checked_sub(width / 2), y.checked_sub(height / 2)) else {
            continue;
        };
        let spot = Rect {
            left,
            top,
            width,
            height,
        };
        if placed.iter().any(|p| p.near(&spot, 2 * GAP)) || !is_lit(map, &spot) {
            continue;
        }
        let apart = placed.iter().map(|p| distance(p, &spot));
        let from_own = own
            .iter()
            .map(|p| distance(p, &spot))
            .fold(diagonal, f64::min);
        if !own.is_empty() && from_own < 0.35 * diagonal {
            continue;
        }
        let apart = apart.fold(0.3 * diagonal, f64::min) / (0.3 * diagonal);
        let score = across + 0.6 * apart;
        if best.is_none_or(|(least, _)| score > least) {
            best = Some((score, spot));
        }
    }
    best.map(|b| b.1)
}

fn distance(a: &Rect, b: &Rect) -> f64 {
    let middle = |r: &Rect| {
        (
            r.left as f64 + 0.5 * r.width as f64,
            r.top as f64 + 0.5 * r.height as f64,
        )
    };
    let ((ax, ay), (bx, by)) = (middle(a), middle(b));
    (ax - bx).hypot(ay - by)
}

/// Does the rectangle, with a little air, lie in the lit part of the plot?
fn is_lit(map: &Pixels, r: &Rect) -> bool {
    let air = 4;
    if r.left < air || r.top < air || r.right() + air >= map.width || r.bottom() + air >= map.height
    {
        return false;
    }
    let (w, h) = (r.width + 2 * air, r.height + 2 * air);
    (0..=8).all(|i| {
        (0..=3).all(|j| {
            map.at(r.left - air + i * w / 8, r.top - air + j * h / 3)
                .is_some()
        })
    })
}

fn draw_label(canvas: &mut Canvas, plot: Rect, spot: Rect, text: &str, colour: Colour) {
    let ink = readable_on(colour);
    let on_canvas = Rect {
        left: plot.left + spot.left,
        top: plot.top + spot.top,
        ..spot
    };
    canvas.fill(on_canvas, mixed(colour, ink, 0.0), 0.85);
    canvas.text(
        on_canvas.left + RIM,
        on_canvas.top + RIM / 2,
        text,
        Font::Label,
        ink,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(side: DVec3) -> Axis {
        Axis::new(Axes::YUp, DVec3::new(1.0, 2.0, 3.0), side, "along u")
    }

    #[test]
    fn axes_carry_the_users_names_and_directions() {
        // y-up: the user's z is minus the program's y.
        let a = axis(DVec3::new(0.0, 4.0, 0.0));
        assert_eq!((a.name, a.start, a.sign, a.length), ("z", -2.0, -1.0, 4.0));
        assert_eq!(axis(DVec3::new(1.0, 1.0, 0.0)).name, "along u");
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let a = Axis {
            name: "x",
            start: 0.25,
            sign: 1.0,
            length: 3.5,
        };
        let ticks = a.ticks(700);
        assert_eq!(ticks[0], (50, "0.5".into()));
        assert!(ticks.iter().all(|t| t.0 <= 700));
        let back = Axis { sign: -1.0, ..a };
        assert_eq!(back.ticks(700)[0].1, "-3.0");
    }
}
