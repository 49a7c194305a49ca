//! The frame of a map: title, axes, colour bar, notes.

use glam::DVec3;

use super::canvas::{Canvas, Colour, INK, LINE, Rect};
use super::legend;
use super::scale::{Scale, round_step, with_step};
use super::text::Font;
use crate::scene::Axes;

/// Least height of the colour bar, pixels.
const LEAST_BAR: usize = 300;
/// Empty border of the figure and gap between its parts, pixels.
const BORDER: usize = 24;
const GAP: usize = 10;

/// What a figure shows.
pub(super) struct Contents<'a> {
    pub(super) title: &'a str,
    pub(super) subtitle: &'a str,
    pub(super) notes: &'a [String],
    /// Does the legend need the hatching?
    pub(super) hatched: bool,
    /// Size of the plot, pixels.
    pub(super) plot: (usize, usize),
    pub(super) axes: Option<[Axis; 2]>,
    pub(super) scale: &'a Scale,
    pub(super) unit: &'a str,
}

/// A figure with everything but the plot itself.
pub(super) struct Figure {
    pub(super) canvas: Canvas,
    pub(super) plot: Rect,
}

const HATCHED_NOTE: &str = "covered, or inside a solid";

impl Figure {
    pub(super) fn new(c: &Contents<'_>) -> Self {
        let (line, title_line) = (Font::Body.height() + 6, Font::Title.height() + 6);
        let subtitle = if c.subtitle == c.title { "" } else { c.subtitle };
        let head = title_line + if subtitle.is_empty() { 0 } else { line };
        let (left_axis, bottom_axis) = axis_room(c);
        let unit_room = Font::Body.height() + GAP;
        let plot = Rect { left: BORDER + left_axis, top: BORDER + head + unit_room, width: c.plot.0, height: c.plot.1 };
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
        let notes_top = GAP + if under_bar { plot_bottom.max(bar_bottom) } else { plot_bottom };
        let lines = c.notes.len() + usize::from(c.hatched);
        let height = (notes_top + lines * line).max(bar_bottom) + BORDER;
        let mut canvas = Canvas::new(width, height);
        let room = width - 2 * BORDER;
        let title = Font::Title.fit(c.title, room);
        canvas.text(BORDER, BORDER, &title, Font::Title, INK);
        let subtitle = Font::Body.fit(subtitle, room);
        canvas.text(BORDER, BORDER + title_line, &subtitle, Font::Body, LINE);
        legend::draw(&mut canvas, c.scale, c.unit, (bar_left, plot.top), bar_height);
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
    let sample = Rect { left: BORDER, top: top + 2, width: side, height: side };
    for y in 0..side {
        for x in 0..side {
            canvas.set(sample.left + x, sample.top + y, hatch(x, y));
        }
    }
    canvas.frame(sample, LINE);
    canvas.text(BORDER + side + GAP, top, HATCHED_NOTE, Font::Body, INK);
}

/// Grey with diagonals.
pub(super) fn hatch(x: usize, y: usize) -> Colour {
    if (x + y) % 10 < 2 { [150; 3] } else { [222; 3] }
}

/// A direction of a map: coordinates from `start` over `length`, rising or falling.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// Name with unit.
    label: String,
    /// Ticks of its own in place of round numbers.
    named: Vec<(f64, String)>,
    start: f64,
    sign: f64,
    length: f64,
}

impl Axis {
    /// The user's own axis where the side runs along one, the way along the side elsewhere.
    pub(super) fn new(axes: Axes, origin: DVec3, side: DVec3, elsewhere: &'static str) -> Self {
        let (origin, side) = (axes.to_user(origin), axes.to_user(side));
        let length = side.length();
        let along = (0..3).find(|&c| side[c].abs() > (1.0 - 1e-9) * length);
        match along {
            Some(c) => Self::metres(["x", "y", "z"][c], origin[c], side[c].signum(), length),
            None => Self::metres(elsewhere, 0.0, 1.0, length),
        }
    }

    fn metres(name: &str, start: f64, sign: f64, length: f64) -> Self {
        Self { label: format!("{name} [m]"), named: Vec::new(), start, sign, length }
    }

    /// An axis with named places.
    pub(super) fn named(label: &str, length: f64, named: Vec<(f64, String)>) -> Self {
        Self { label: label.to_owned(), named, start: 0.0, sign: 1.0, length }
    }

    /// Places in pixels from the start and their texts: as many as have room, two at least where that can be.
    fn ticks(&self, pixels: usize) -> Vec<(usize, String)> {
        /// Least distances of ticks to try.
        const ROOM: [f64; 4] = [90.0, 60.0, 40.0, 32.0];
        if !(self.length > 0.0 && self.length.is_finite() && self.start.is_finite()) {
            return Vec::new();
        }
        if !self.named.is_empty() {
            let place = |at: f64| (at / self.length * pixels as f64).round() as usize;
            return self.named.iter().map(|(at, text)| (place(*at), text.clone())).collect();
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
    (line + GAP + widest.unwrap_or(0) + 2 * TICK, 2 * line + 2 * TICK + GAP)
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
    let label = &axis.label;
    let left = (plot.left + plot.width / 2).saturating_sub(Font::Body.width(label) / 2);
    let top = plot.bottom() + 2 * TICK + Font::Body.height() + 4;
    canvas.text(left, top, label, Font::Body, INK);
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
    let label = &axis.label;
    let bottom = plot.top + plot.height / 2 + Font::Body.width(label) / 2;
    canvas.text_up(BORDER, bottom, label, Font::Body, INK);
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
        assert_eq!((a.label.as_str(), a.start, a.sign, a.length), ("z [m]", -2.0, -1.0, 4.0));
        assert_eq!(axis(DVec3::new(1.0, 1.0, 0.0)).label, "along u [m]");
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let a = Axis::metres("x", 0.25, 1.0, 3.5);
        let ticks = a.ticks(700);
        assert_eq!(ticks[0], (50, "0.5".into()));
        assert!(ticks.iter().all(|t| t.0 <= 700));
        let back = Axis { sign: -1.0, ..a };
        assert_eq!(back.ticks(700)[0].1, "-3.0");
    }
}
