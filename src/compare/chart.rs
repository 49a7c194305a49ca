//! The chart of a comparison: computed over measured, point by point.

use std::fmt::Write;

use super::{Comparison, Reading};

/// Width and height of a panel and the room about it, pixels.
const PANEL: f64 = 360.0;
const ROOM: f64 = 60.0;

/// One panel for each quantity; both errors are drawn as bars.
#[must_use]
pub fn svg(comparisons: &[Comparison]) -> String {
    let wide = PANEL + 2.0 * ROOM;
    let mut text = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='{:.0}' height='{wide:.0}' font-family='sans-serif' \
         font-size='13'>\n<rect width='100%' height='100%' fill='white'/>\n",
        wide * comparisons.len() as f64
    );
    for (k, c) in comparisons.iter().enumerate() {
        panel(&mut text, c, wide * k as f64 + ROOM);
    }
    text + "</svg>\n"
}

fn panel(text: &mut String, c: &Comparison, left: f64) {
    let ends = |r: &Reading| [r.value - r.error, r.value + r.error];
    let all = || c.pairs.iter().flat_map(|p| [ends(&p.measured), ends(&p.computed)]).flatten();
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    let span = (high - low).max(f64::MIN_POSITIVE);
    let (x, y) = (|v: f64| left + (v - low) / span * PANEL, |v: f64| ROOM + (high - v) / span * PANEL);
    let line = |text: &mut String, from: (f64, f64), to: (f64, f64), colour: &str| {
        let _ = writeln!(
            text,
            "<line x1='{:.1}' y1='{:.1}' x2='{:.1}' y2='{:.1}' stroke='{colour}'/>",
            from.0, from.1, to.0, to.1
        );
    };
    line(text, (x(low), y(low)), (x(high), y(high)), "#999");
    line(text, (x(low), y(low)), (x(high), y(low)), "#000");
    line(text, (x(low), y(low)), (x(low), y(high)), "#000");
    for p in &c.pairs {
        let (m, v) = (&p.measured, &p.computed);
        line(text, (x(ends(m)[0]), y(v.value)), (x(ends(m)[1]), y(v.value)), "#9bd");
        line(text, (x(m.value), y(ends(v)[0])), (x(m.value), y(ends(v)[1])), "#9bd");
        let _ = writeln!(
            text,
            "<circle cx='{:.1}' cy='{:.1}' r='2.5' fill='#2a6fb0'><title>{} {}</title></circle>",
            x(m.value),
            y(v.value),
            p.grid.replace('&', "&amp;").replace('<', "&lt;"),
            p.point
        );
    }
    let name = c.quantity.column();
    let (middle, bottom) = (left + 0.5 * PANEL, ROOM + PANEL);
    let _ = writeln!(
        text,
        "<text x='{middle:.0}' y='{:.0}' text-anchor='middle'>{name}: computed over measured, {} points</text>\n\
         <text x='{left:.0}' y='{:.0}'>{low:.4}</text>\n<text x='{:.0}' y='{:.0}' text-anchor='end'>{high:.4}</text>",
        ROOM - 14.0,
        c.points,
        bottom + 18.0,
        left + PANEL,
        bottom + 18.0
    );
}
