//! Figures of lines, marks and words, written once and shown two ways: as SVG and as pixels.

use std::fmt::Write;

use glam::DVec2;

use super::canvas::{Canvas, Colour};
use super::text::Font;
use crate::Result;

/// Where a text hangs on its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// The forms of marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    Circle,
    Square,
    Diamond,
    Up,
    Down,
    Cross,
}

#[derive(Clone, Debug)]
enum Shape {
    Line { points: Vec<DVec2>, colour: Colour, width: f64 },
    Fill { low: DVec2, high: DVec2, colour: Colour },
    Mark { at: DVec2, mark: Mark, size: f64, colour: Colour, hollow: bool },
    Text { at: DVec2, text: String, font: Font, colour: Colour, anchor: Anchor, up: bool },
}

/// A figure. Places are pixels from the top left.
#[derive(Clone, Debug)]
pub(super) struct Drawing {
    width: usize,
    height: usize,
    shapes: Vec<Shape>,
}

impl Drawing {
    pub(super) fn new(width: usize, height: usize) -> Self {
        Self { width, height, shapes: Vec::new() }
    }

    pub(super) fn line(&mut self, points: &[DVec2], colour: Colour, width: f64) {
        self.shapes.push(Shape::Line { points: points.to_vec(), colour, width });
    }

    pub(super) fn fill(&mut self, low: DVec2, high: DVec2, colour: Colour) {
        self.shapes.push(Shape::Fill { low, high, colour });
    }

    pub(super) fn mark(&mut self, at: DVec2, mark: Mark, size: f64, colour: Colour, hollow: bool) {
        self.shapes.push(Shape::Mark { at, mark, size, colour, hollow });
    }

    /// Text with its top at the point.
    pub(super) fn text(&mut self, at: DVec2, text: &str, font: Font, colour: Colour, anchor: Anchor) {
        self.shapes.push(Shape::Text { at, text: text.into(), font, colour, anchor, up: false });
    }

    /// Text that reads upwards about a middle.
    pub(super) fn text_up(&mut self, middle: DVec2, text: &str, font: Font, colour: Colour) {
        let anchor = Anchor::Middle;
        self.shapes.push(Shape::Text { at: middle, text: text.into(), font, colour, anchor, up: true });
    }

    /// As SVG 1.1.
    pub(super) fn to_svg(&self) -> String {
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\">\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n",
            w = self.width,
            h = self.height
        );
        for shape in &self.shapes {
            // Writing to a string cannot fail.
            let _ = writeln!(out, "{}", svg(shape));
        }
        out.push_str("</svg>\n");
        out
    }

    /// As a PNG picture.
    pub(super) fn to_png(&self) -> Result<Vec<u8>> {
        let mut canvas = Canvas::new(self.width, self.height);
        for shape in &self.shapes {
            paint(&mut canvas, shape);
        }
        canvas.into_png()
    }
}

fn hex(c: Colour) -> String {
    format!("#{:02x}{:02x}{:02x}", c[0], c[1], c[2])
}

fn svg(shape: &Shape) -> String {
    let list = |points: &[DVec2]| points.iter().map(|p| format!("{:.1},{:.1}", p.x, p.y)).collect::<Vec<_>>().join(" ");
    match shape {
        Shape::Line { points, colour, width } => format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"/>",
            list(points),
            hex(*colour)
        ),
        Shape::Fill { low, high, colour } => format!(
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\"/>",
            low.x,
            low.y,
            high.x - low.x,
            high.y - low.y,
            hex(*colour)
        ),
        Shape::Mark { at, mark, size, colour, hollow } => {
            let (fill, stroke) = if *hollow { ("#ffffff".into(), hex(*colour)) } else { (hex(*colour), hex(*colour)) };
            let style = format!("fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\"2\"");
            match mark {
                Mark::Circle => format!("<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{size:.1}\" {style}/>", at.x, at.y),
                Mark::Cross => strokes(*at, *size)
                    .map(|s| format!("<polyline points=\"{}\" stroke=\"{stroke}\" stroke-width=\"3\"/>", list(&s)))
                    .concat(),
                _ => format!("<polygon points=\"{}\" {style}/>", list(&corners(*mark, *at, *size))),
            }
        }
        Shape::Text { at, text, font, colour, anchor, up } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let height = font.height() as f64;
            // The baseline of the bitmap font lies at four fifths of its height.
            let (x, y, turn) = if *up {
                (
                    at.x + 0.3 * height,
                    at.y,
                    format!(" transform=\"rotate(-90 {:.1} {:.1})\"", at.x + 0.3 * height, at.y),
                )
            } else {
                (at.x, at.y + 0.8 * height, String::new())
            };
            let weight = if *font == Font::Body { "normal" } else { "bold" };
            format!(
                "<text x=\"{x:.1}\" y=\"{y:.1}\"{turn} font-family=\"Noto Sans Mono, DejaVu Sans Mono, monospace\" font-size=\"{:.0}\" font-weight=\"{weight}\" fill=\"{}\" text-anchor=\"{anchor}\">{}</text>",
                0.8 * height,
                hex(*colour),
                escaped(text)
            )
        }
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Corners of a filled mark.
fn corners(mark: Mark, at: DVec2, size: f64) -> Vec<DVec2> {
    let unit: &[[f64; 2]] = match mark {
        Mark::Square => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
        Mark::Diamond => &[[0.0, -1.25], [1.25, 0.0], [0.0, 1.25], [-1.25, 0.0]],
        Mark::Up => &[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]],
        Mark::Down => &[[0.0, 1.2], [-1.1, -0.8], [1.1, -0.8]],
        Mark::Circle | Mark::Cross => &[],
    };
    unit.iter().map(|[x, y]| at + DVec2::new(*x, *y) * size).collect()
}

/// The two strokes of a cross.
fn strokes(at: DVec2, size: f64) -> [[DVec2; 2]; 2] {
    let d = DVec2::splat(size);
    [[at - d, at + d], [at - d.perp(), at + d.perp()]]
}

fn paint(canvas: &mut Canvas, shape: &Shape) {
    match shape {
        Shape::Line { points, colour, width } => {
            for s in points.windows(2) {
                cover(canvas, [s[0].min(s[1]), s[0].max(s[1])], *colour, |p| 0.5 * width - to_segment(p, s[0], s[1]));
            }
        }
        Shape::Fill { low, high, colour } => {
            cover(canvas, [*low, *high], *colour, |p| (p - *low).min(*high - p).min_element());
        }
        Shape::Mark { at, mark, size, colour, hollow } => {
            let bounds = [*at - 1.5 * size, *at + 1.5 * size];
            let inside = |p: DVec2, grow: f64| match mark {
                Mark::Circle => size + grow - (p - *at).length(),
                Mark::Cross => {
                    1.5 - strokes(*at, *size)
                        .map(|s| to_segment(p, s[0], s[1]))
                        .into_iter()
                        .fold(f64::INFINITY, f64::min)
                }
                _ => to_outside(&corners(*mark, *at, *size), p) + grow,
            };
            cover(canvas, bounds, *colour, |p| inside(p, 1.0));
            if *hollow && *mark != Mark::Cross {
                cover(canvas, bounds, super::canvas::WHITE, |p| inside(p, -1.0));
            }
        }
        Shape::Text { at, text, font, colour, anchor, up } => {
            let width = font.width(text) as f64;
            let back = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => 0.5 * width,
                Anchor::End => width,
            };
            let whole = |x: f64| x.max(0.0).round() as usize;
            if *up {
                let left = at.x - 0.5 * font.height() as f64;
                canvas.text_up(whole(left), whole(at.y + back), text, *font, *colour);
            } else {
                canvas.text(whole(at.x - back), whole(at.y), text, *font, *colour);
            }
        }
    }
}

/// Lays a colour over the pixels whose depth inside a form is above zero, softly at its border.
fn cover(canvas: &mut Canvas, [low, high]: [DVec2; 2], colour: Colour, depth: impl Fn(DVec2) -> f64) {
    let whole = |x: f64| x.max(0.0) as usize;
    for y in whole(low.y - 2.0)..whole(high.y + 3.0) {
        for x in whole(low.x - 2.0)..whole(high.x + 3.0) {
            let share = depth(DVec2::new(x as f64 + 0.5, y as f64 + 0.5)) + 0.5;
            if share > 0.0 {
                canvas.blend(x, y, colour, share);
            }
        }
    }
}

fn to_segment(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let d = b - a;
    let t = if d.length_squared() > 0.0 { ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0) } else { 0.0 };
    (p - a - d * t).length()
}

/// Least distance inside a convex polygon, clockwise on the screen; negative outside.
fn to_outside(corners: &[DVec2], p: DVec2) -> f64 {
    (0..corners.len())
        .map(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
            (b - a).perp_dot(p - a) / (b - a).length()
        })
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn svg_escapes_what_it_must() {
        let mut d = Drawing::new(100, 50);
        d.text(DVec2::ZERO, "a < b & c", Font::Body, [0; 3], Anchor::Start);
        d.mark(DVec2::new(5.0, 5.0), Mark::Cross, 3.0, [255, 0, 0], false);
        let svg = d.to_svg();
        assert!(svg.contains("a &lt; b &amp; c") && svg.ends_with("</svg>\n"), "{svg}");
    }

    #[test]
    fn marks_are_filled_inside_and_white_outside() {
        for mark in [Mark::Circle, Mark::Square, Mark::Diamond, Mark::Up, Mark::Down] {
            let mut canvas = Canvas::new(30, 30);
            let at = DVec2::splat(15.0);
            paint(&mut canvas, &Shape::Mark { at, mark, size: 6.0, colour: [0; 3], hollow: false });
            assert_eq!((canvas.get(15, 15), canvas.get(2, 2)), ([0; 3], [255; 3]), "{mark:?}");
        }
    }
}
