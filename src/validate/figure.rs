//! Small charts of the report, as SVG inside the page.

use std::fmt::Write;

use super::{Case, Comparison};

/// Width and height of the strip of a suite, pixels.
const STRIP: (f64, f64) = (720.0, 92.0);
/// Differences beyond this many times what is allowed are drawn at the rim.
const MOST: f64 = 1.5;

/// Every case of a suite at its difference from the reference, over what is allowed.
pub(super) fn strip(cases: &[Case]) -> String {
    let (width, height) = STRIP;
    let x = |ratio: f64| 0.5 * width + ratio.clamp(-MOST, MOST) / MOST * (0.5 * width - 12.0);
    let mut svg = opening(width, height);
    let limit = |svg: &mut String, at: f64, label: &str, colour: &str| {
        let _ = write!(
            svg,
            "<line x1='{0:.1}' y1='4' x2='{0:.1}' y2='72' stroke='{colour}'/><text x='{0:.1}' y='88' \
             text-anchor='middle'>{label}</text>",
            x(at)
        );
    };
    limit(&mut svg, -1.0, "−allowed", "#b33");
    limit(&mut svg, 0.0, "reference", "#999");
    limit(&mut svg, 1.0, "+allowed", "#b33");
    let two_sided = |c: &&Case| matches!(c.comparison, Comparison::Equal | Comparison::Estimate);
    for (i, c) in cases.iter().filter(two_sided).enumerate() {
        let ratio = (c.value - c.reference) / c.allowed().max(f64::MIN_POSITIVE);
        // Spread over the height by the golden ratio, so that neighbours stand apart.
        let y = 8.0 + 60.0 * (0.618_034 * i as f64).fract();
        let colour = if c.pass { "#2a6fb0" } else { "#d22" };
        let _ = write!(
            svg,
            "<circle cx='{:.1}' cy='{y:.1}' r='2.2' fill='{colour}' fill-opacity='0.6'><title>{}</title></circle>",
            x(if ratio.is_nan() { MOST } else { ratio }),
            escaped(&c.name)
        );
    }
    svg + "</svg>"
}

/// A grid of values; `None` where nothing can be read.
#[derive(Debug)]
pub(super) struct Map {
    pub(super) title: String,
    pub(super) columns: usize,
    pub(super) cells: Vec<Option<f64>>,
}

/// Maps side by side in one scale of false colours.
pub(super) fn maps(list: &[Map]) -> String {
    const CELL: f64 = 13.0;
    const GAP: f64 = 16.0;
    let most = list.iter().flat_map(|m| &m.cells).flatten().fold(f64::MIN_POSITIVE, |m, v| m.max(*v));
    let wide = |m: &Map| m.columns as f64 * CELL + GAP;
    let tall = |m: &Map| m.cells.len().div_ceil(m.columns.max(1)) as f64 * CELL;
    let width: f64 = list.iter().map(wide).sum();
    let height = list.iter().map(tall).fold(0.0, f64::max);
    let mut svg = opening(width, height + 44.0);
    let mut left = 0.0;
    for map in list {
        let _ = write!(svg, "<text x='{left:.0}' y='14'>{}</text>", escaped(&map.title));
        for (i, value) in map.cells.iter().enumerate() {
            let colour = value.map_or("#ccc".to_owned(), |v| {
                let c = colorous::VIRIDIS.eval_continuous(v / most);
                format!("#{:02x}{:02x}{:02x}", c.r, c.g, c.b)
            });
            let (column, row) = ((i % map.columns) as f64, (i / map.columns) as f64);
            // Rows run upwards, as v does.
            let y = 20.0 + tall(map) - (row + 1.0) * CELL;
            let _ = write!(
                svg,
                "<rect x='{:.0}' y='{y:.0}' width='{CELL}' height='{CELL}' fill='{colour}'/>",
                left + column * CELL
            );
        }
        left += wide(map);
    }
    let _ = write!(svg, "<text x='0' y='{:.0}'>dark blue 0, yellow {most:.3e}</text>", height + 38.0);
    svg + "</svg>"
}

fn opening(width: f64, height: f64) -> String {
    format!(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width:.0} {height:.0}' width='{width:.0}' \
         height='{height:.0}' font-family='sans-serif' font-size='12'>"
    )
}

/// Text for HTML and SVG.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('\'', "&#39;").replace('"', "&quot;")
}
