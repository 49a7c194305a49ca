//! Panels with logarithmic axes, and the styles of the curves in them.

use glam::DVec2;

use super::canvas::{Colour, INK, LINE};
use super::drawing::{Anchor, Drawing, Mark};
use super::text::Font;

const GRID: Colour = [226; 3];

/// Colours that stay apart for colour-blind eyes (after Okabe and Ito 2008) and the forms that go with them.
const STYLES: [(Colour, Mark); 12] = [
    ([213, 94, 0], Mark::Circle),
    ([0, 114, 178], Mark::Square),
    ([0, 158, 115], Mark::Diamond),
    ([204, 121, 167], Mark::Up),
    ([86, 180, 233], Mark::Down),
    ([148, 103, 25], Mark::Circle),
    ([120, 94, 240], Mark::Square),
    ([90, 90, 90], Mark::Diamond),
    ([200, 160, 0], Mark::Up),
    ([100, 140, 17], Mark::Down),
    ([160, 30, 60], Mark::Square),
    ([30, 60, 120], Mark::Up),
];

/// Colour and form of one of many: beyond the last colour they come again with other forms.
pub(super) fn style(number: usize) -> (Colour, Mark) {
    let n = STYLES.len();
    (STYLES[number % n].0, STYLES[(number + number / n) % n].1)
}

/// A panel with logarithmic axes.
pub(super) struct Panel {
    pub(super) low: DVec2,
    pub(super) high: DVec2,
    /// Decimal logarithms at its lower left and upper right corner.
    pub(super) from: DVec2,
    pub(super) to: DVec2,
}

impl Panel {
    pub(super) fn new([low, high]: [DVec2; 2], values: &[[f64; 2]]) -> Self {
        let logs =
            || values.iter().filter(|v| v[0] > 0.0 && v[1] > 0.0).map(|v| DVec2::new(v[0].log10(), v[1].log10()));
        let (from, to) = logs().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let (from, to) = if from.is_finite() { (from, to) } else { (DVec2::splat(-1.0), DVec2::ZERO) };
        let air = ((to - from) * 0.05).max(DVec2::splat(0.15));
        Self { low, high, from: from - air, to: to + air }
    }

    pub(super) fn place(&self, x: f64, y: f64) -> DVec2 {
        let share = (DVec2::new(x.log10(), y.log10()) - self.from) / (self.to - self.from);
        DVec2::new(
            self.low.x + share.x * (self.high.x - self.low.x),
            self.high.y - share.y * (self.high.y - self.low.y),
        )
    }

    /// Values 1, 2 and 5 of each decade in sight of one axis.
    fn ticks(&self, axis: usize) -> Vec<f64> {
        let (from, to) = (self.from[axis], self.to[axis]);
        let fine = to - from < 2.6;
        (from.floor() as i32..=to.ceil() as i32)
            .flat_map(|d| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(d)))
            .filter(|v| (from..=to).contains(&v.log10()))
            .filter(|v| fine || (v.log10() - v.log10().round()).abs() < 1e-9)
            .collect()
    }

    pub(super) fn frame(&self, d: &mut Drawing, names: [&str; 2], shown: [fn(f64) -> String; 2]) {
        for v in self.ticks(0) {
            let x = self.place(v, 1.0).x;
            d.line(&[DVec2::new(x, self.low.y), DVec2::new(x, self.high.y)], GRID, 1.0);
            d.text(DVec2::new(x, self.high.y + 10.0), &shown[0](v), Font::Body, INK, Anchor::Middle);
        }
        for v in self.ticks(1) {
            let y = self.place(1.0, v).y;
            d.line(&[DVec2::new(self.low.x, y), DVec2::new(self.high.x, y)], GRID, 1.0);
            d.text(DVec2::new(self.low.x - 10.0, y - 10.0), &shown[1](v), Font::Body, INK, Anchor::End);
        }
        let corners = [self.low, DVec2::new(self.high.x, self.low.y), self.high, DVec2::new(self.low.x, self.high.y)];
        d.line(&[corners[0], corners[1], corners[2], corners[3], corners[0]], LINE, 1.5);
        let middle = (self.low + self.high) * 0.5;
        d.text(DVec2::new(middle.x, self.high.y + 38.0), names[0], Font::Body, INK, Anchor::Middle);
        d.text_up(DVec2::new(self.low.x - 100.0, middle.y), names[1], Font::Body, INK);
    }
}

/// Two digits without zeros at the end.
pub(super) fn plain(x: f64) -> String {
    let decimals = (1.0 - x.log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

pub(super) fn heading(d: &mut Drawing, panel: &Panel, text: &str) {
    d.text(DVec2::new(panel.low.x, panel.low.y - 26.0), text, Font::Label, INK, Anchor::Start);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_other_programs_do_not_look_like_our_own() {
        // The eleven ways of a chart, and as many peers.
        let styles: Vec<String> = (0..2 * STYLES.len()).map(|k| format!("{:?}", style(k))).collect();
        let apart: std::collections::BTreeSet<&String> = styles.iter().collect();
        assert_eq!(apart.len(), styles.len());
    }
}
