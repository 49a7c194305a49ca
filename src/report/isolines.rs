//! Isolines with their labels.

use super::canvas::{Canvas, Colour, Rect, readable_on};
use super::field::Field;
use super::scale::Scale;
use super::text::Font;

/// Gap between labels, pixels.
const GAP: usize = 20;

/// A field in the pixels of the plot.
pub(super) struct Pixels {
    width: usize,
    height: usize,
    /// NaN where nothing is lit.
    value: Vec<f64>,
    /// Levels that are not above the value.
    band: Vec<u8>,
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
    /// A field, with its bands between `levels`, which rise.
    pub(super) fn new(field: &Field, (width, height): (usize, usize), levels: &[f64]) -> Self {
        let mut value = Vec::with_capacity(width * height);
        let columns = field.columns(width);
        for row in field.rows(height) {
            value.extend(field.interpolated(&columns, &row));
        }
        let band = value.iter().map(|v| levels.iter().map(|l| u8::from(l <= v)).sum()).collect();
        Self { width, height, value, band }
    }

    pub(super) fn at(&self, x: usize, y: usize) -> Option<f64> {
        let v = self.value[y * self.width + x];
        (!v.is_nan()).then_some(v)
    }

    /// Places where a level lies between a pixel and its four neighbours; none at the rim, where the field is level.
    fn crossed(&self) -> impl Iterator<Item = (usize, usize)> {
        let Self { width, height, band, .. } = self;
        (1..height.saturating_sub(1)).flat_map(move |y| {
            (1..width.saturating_sub(1)).map(move |x| (x, y)).filter(move |(x, y)| {
                let k = y * width + x;
                let own = band[k];
                band[k - 1] != own || band[k + 1] != own || band[k - width] != own || band[k + width] != own
            })
        })
    }

    /// By central differences, within the rim; nothing beside what is not lit.
    fn slope(&self, x: usize, y: usize) -> Option<Slope> {
        let value = self.at(x, y)?;
        let (left, right) = (self.at(x - 1, y)?, self.at(x + 1, y)?);
        let (above, below) = (self.at(x, y - 1)?, self.at(x, y + 1)?);
        let around = [left, right, above, below];
        let range = (around.into_iter().fold(value, f64::min), around.into_iter().fold(value, f64::max));
        let slope = Slope { value, x: 0.5 * (right - left), y: 0.5 * (below - above), range };
        (slope.steepness() > 1e-9 * slope.value.abs()).then_some(slope)
    }
}

/// Half the width of an isoline, pixels.
const HALF_LINE: f64 = 0.75;
/// How much an isoline stands out.
const LINE_COVER: f64 = 0.8;

/// Isolines nearer to each other than this, pixels, have no label there.
const CROWDED: f64 = 12.0;

pub(super) fn draw_isolines(canvas: &mut Canvas, plot: Rect, map: &Pixels, scale: &Scale) {
    let mut on_line: Vec<Vec<Candidate>> = vec![Vec::new(); scale.ticks.len()];
    for (x, y) in map.crossed() {
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

fn draw_labels(canvas: &mut Canvas, plot: Rect, map: &Pixels, scale: &Scale, on_line: &[Vec<Candidate>]) {
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
fn best_spot(map: &Pixels, line: &[Candidate], text: &str, placed: &[Rect], own: &[Rect]) -> Option<Rect> {
    let (width, height) = (Font::Label.width(text) + 2 * RIM, Font::Label.height() + RIM);
    let diagonal = (map.width as f64).hypot(map.height as f64);
    let mut best: Option<(f64, Rect)> = None;
    for &Candidate { x, y, across } in line.iter().step_by(3) {
        let (Some(left), Some(top)) = (x.checked_sub(width / 2), y.checked_sub(height / 2)) else {
            continue;
        };
        let spot = Rect { left, top, width, height };
        if placed.iter().any(|p| p.near(&spot, GAP)) || !is_lit(map, &spot) {
            continue;
        }
        let apart = placed.iter().map(|p| distance(p, &spot));
        let from_own = own.iter().map(|p| distance(p, &spot)).fold(diagonal, f64::min);
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
    let middle = |r: &Rect| (r.left as f64 + 0.5 * r.width as f64, r.top as f64 + 0.5 * r.height as f64);
    let ((ax, ay), (bx, by)) = (middle(a), middle(b));
    (ax - bx).hypot(ay - by)
}

/// Does the rectangle, with a little air, lie in the lit part of the plot?
fn is_lit(map: &Pixels, r: &Rect) -> bool {
    let air = 4;
    if r.left < air || r.top < air || r.right() + air >= map.width || r.bottom() + air >= map.height {
        return false;
    }
    let (w, h) = (r.width + 2 * air, r.height + 2 * air);
    (0..=8).all(|i| (0..=3).all(|j| map.at(r.left - air + i * w / 8, r.top - air + j * h / 3).is_some()))
}

fn draw_label(canvas: &mut Canvas, plot: Rect, spot: Rect, text: &str, colour: Colour) {
    let ink = readable_on(colour);
    let on_canvas = Rect { left: plot.left + spot.left, top: plot.top + spot.top, ..spot };
    canvas.fill(on_canvas, colour, 0.85);
    canvas.text(on_canvas.left + RIM, on_canvas.top + RIM / 2, text, Font::Label, ink);
}
