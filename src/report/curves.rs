//! Curves beside each other: how errors grow with a parameter, on logarithmic axes.

use std::path::{Path, PathBuf};

use glam::DVec2;

use super::canvas::{INK, LINE};
use super::drawing::{Anchor, Drawing, Mark};
use super::file::write_whole;
use super::panel::{Panel, heading, plain, style};
use super::text::Font;
use crate::Result;

/// A figure of panels.
#[derive(Clone, Debug, Default)]
pub struct Curves {
    /// Headline.
    pub title: String,
    /// What is drawn, in a line.
    pub subtitle: String,
    /// Two panels in a row.
    pub panels: Vec<CurvePanel>,
}

/// One panel; both axes are logarithmic.
#[derive(Clone, Debug, Default)]
pub struct CurvePanel {
    /// What it shows.
    pub heading: String,
    /// Names of the axes.
    pub axes: [String; 2],
    /// The curves.
    pub curves: Vec<Curve>,
}

/// One curve.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Its points; those that are not above zero are left out.
    pub points: Vec<[f64; 2]>,
    /// Abscissas at which the method refused to answer.
    pub refused: Vec<f64>,
}

/// Size of a panel and the room about it, pixels.
const PANEL: DVec2 = DVec2::new(640.0, 420.0);
const LEFT: f64 = 140.0;
const TOP: f64 = 120.0;
const LEGEND: f64 = 240.0;
const GAP: f64 = 60.0;

/// Writes `<name>.svg` and `<name>.png` into `dir`.
///
/// # Errors
///
/// Io with the file's name.
pub fn write_curves(dir: &Path, name: &str, curves: &Curves) -> Result<[PathBuf; 2]> {
    let drawing = draw(curves);
    let [svg, png] = ["svg", "png"].map(|ending| dir.join(format!("{name}.{ending}")));
    write_whole(&svg, drawing.to_svg().as_bytes())?;
    write_whole(&png, &drawing.to_png()?)?;
    Ok([svg, png])
}

fn draw(curves: &Curves) -> Drawing {
    let rows = curves.panels.len().div_ceil(2) as f64;
    let step = DVec2::new(LEFT + PANEL.x + GAP, PANEL.y + LEGEND + GAP);
    let mut d = Drawing::new((2.0 * step.x) as usize, (TOP + rows * step.y) as usize);
    d.text(DVec2::new(30.0, 20.0), &curves.title, Font::Title, INK, Anchor::Start);
    d.text(DVec2::new(30.0, 52.0), &curves.subtitle, Font::Body, LINE, Anchor::Start);
    for (k, panel) in curves.panels.iter().enumerate() {
        let corner = DVec2::new(LEFT, TOP) + DVec2::new((k % 2) as f64, (k / 2) as f64) * step;
        draw_panel(&mut d, panel, corner);
    }
    d
}

fn draw_panel(d: &mut Drawing, content: &CurvePanel, corner: DVec2) {
    let all = content.curves.iter().flat_map(|c| &c.points).copied();
    let middle = content.curves.iter().find_map(|c| c.points.iter().find(|p| p[1] > 0.0)).map_or(1.0, |p| p[1]);
    let refused = content.curves.iter().flat_map(|c| &c.refused).map(|x| [*x, middle]);
    let panel = Panel::new([corner, corner + PANEL], &all.chain(refused).collect::<Vec<_>>());
    panel.frame(d, [&content.axes[0], &content.axes[1]], [short, short]);
    heading(d, &panel, &content.heading);
    for (k, curve) in content.curves.iter().enumerate() {
        let (colour, mark) = style(k);
        let seen = curve.points.iter().filter(|p| p[0] > 0.0 && p[1] > 0.0);
        let places: Vec<DVec2> = seen.map(|p| panel.place(p[0], p[1])).collect();
        d.line(&places, colour, 2.0);
        places.iter().for_each(|p| d.mark(*p, mark, 5.0, colour, false));
        for x in &curve.refused {
            let at = DVec2::new(panel.place(*x, 1.0).x, corner.y + 12.0 + 8.0 * k as f64);
            d.mark(at, Mark::Cross, 5.0, colour, false);
        }
        let line = DVec2::new(corner.x + 10.0, corner.y + PANEL.y + 72.0 + 22.0 * k as f64);
        d.mark(line + DVec2::new(0.0, 9.0), mark, 5.0, colour, false);
        let name = if curve.refused.is_empty() { curve.name.clone() } else { format!("{} (x: refused)", curve.name) };
        d.text(line + DVec2::new(16.0, 0.0), &name, Font::Label, INK, Anchor::Start);
    }
}

/// A tick in as few letters as can be.
fn short(x: f64) -> String {
    if (1e-3..1e4).contains(&x) { plain(x) } else { format!("{x:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_have_their_names_ticks_and_refusals() {
        let curve =
            Curve { name: "gathering".into(), points: vec![[0.1, 1e-6], [1.0, 0.0], [10.0, 2.0]], refused: vec![5.0] };
        let panel = CurvePanel { heading: "near".into(), axes: ["gap".into(), "error".into()], curves: vec![curve] };
        let drawing = draw(&Curves { title: "Failures".into(), subtitle: "of all kinds".into(), panels: vec![panel] });
        let svg = drawing.to_svg();
        for word in ["Failures", "near", "gap", "error", "gathering (x: refused)", ">1e-6<", ">0.1<"] {
            assert!(svg.contains(word), "{word}");
        }
        assert!(drawing.to_png().is_ok());
    }
}
