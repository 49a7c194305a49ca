//! The colour bar.

use super::canvas::{Canvas, INK, LINE, Rect};
use super::scale::Scale;
use super::text::Font;

/// Width of the bar and gap to its labels, pixels.
const BAR: usize = 30;
const TICK: usize = 6;
const GAP: usize = 6;

/// Width of the bar with its labels, pixels.
pub(super) fn width(scale: &Scale, unit: &str) -> usize {
    let labels = scale.ticks.iter().map(|&v| Font::Body.width(&scale.label(v)));
    let labels = labels.max().unwrap_or(0) + BAR + TICK + GAP;
    labels.max(Font::Body.width(unit))
}

/// Draws the bar from `top` over `height`, its unit above it.
pub(super) fn draw(canvas: &mut Canvas, scale: &Scale, unit: &str, (left, top): (usize, usize), height: usize) {
    let bar = Rect { left, top, width: BAR, height };
    for y in 0..height {
        let place = 1.0 - (y as f64 + 0.5) / height as f64;
        let row = Rect { top: top + y, height: 1, ..bar };
        canvas.fill(row, scale.colour_at(place), 1.0);
    }
    canvas.frame(bar, LINE);
    canvas.text(left, top.saturating_sub(Font::Body.height() + 8), unit, Font::Body, INK);
    for &v in &scale.ticks {
        let y = top + ((1.0 - scale.place(v)) * height as f64).round() as usize;
        for x in 0..TICK {
            canvas.set(bar.right() + x, y, LINE);
        }
        canvas.text(
            bar.right() + TICK + GAP,
            y.saturating_sub(Font::Body.height() / 2),
            &scale.label(v),
            Font::Body,
            INK,
        );
    }
}
