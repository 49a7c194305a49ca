//! A picture to draw figures on.

use super::png;
use super::text::Font;
use crate::Result;

/// sRGB.
pub(super) type Colour = [u8; 3];

pub(super) const WHITE: Colour = [255; 3];
pub(super) const INK: Colour = [34; 3];
/// Frames and ticks.
pub(super) const LINE: Colour = [90; 3];

/// A rectangle in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rect {
    pub(super) left: usize,
    pub(super) top: usize,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Rect {
    pub(super) fn right(&self) -> usize {
        self.left + self.width
    }

    pub(super) fn bottom(&self) -> usize {
        self.top + self.height
    }

    /// Do the two come nearer than `gap`?
    pub(super) fn near(&self, other: &Self, gap: usize) -> bool {
        self.left < other.right() + gap
            && other.left < self.right() + gap
            && self.top < other.bottom() + gap
            && other.top < self.bottom() + gap
    }
}

/// Pixels row by row from the top left; what is drawn outside is lost.
#[derive(Debug)]
pub(super) struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<Colour>,
}

impl Canvas {
    pub(super) fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![WHITE; width * height] }
    }

    pub(super) fn set(&mut self, x: usize, y: usize, colour: Colour) {
        if x < self.width && y < self.height {
            self.pixels[y * self.width + x] = colour;
        }
    }

    #[cfg(test)]
    pub(super) fn get(&self, x: usize, y: usize) -> Colour {
        self.pixels[y * self.width + x]
    }

    /// Lays a colour over a pixel; `cover` from 0 to 1.
    pub(super) fn blend(&mut self, x: usize, y: usize, colour: Colour, cover: f64) {
        if x < self.width && y < self.height {
            let under = &mut self.pixels[y * self.width + x];
            *under = mixed(*under, colour, cover);
        }
    }

    pub(super) fn fill(&mut self, r: Rect, colour: Colour, cover: f64) {
        for y in r.top..r.bottom() {
            for x in r.left..r.right() {
                self.blend(x, y, colour, cover);
            }
        }
    }

    /// A line of one pixel around the outside of a rectangle.
    pub(super) fn frame(&mut self, r: Rect, colour: Colour) {
        let (left, top) = (r.left.saturating_sub(1), r.top.saturating_sub(1));
        for x in left..=r.right() {
            self.set(x, top, colour);
            self.set(x, r.bottom(), colour);
        }
        for y in top..=r.bottom() {
            self.set(left, y, colour);
            self.set(r.right(), y, colour);
        }
    }

    /// Text with its top left corner at (x, y).
    pub(super) fn text(&mut self, x: usize, y: usize, text: &str, font: Font, colour: Colour) {
        font.draw(text, |dx, dy, cover| {
            self.blend(x + dx, y + dy, colour, cover);
        });
    }

    /// Text that reads upwards, with its lower left corner (the first letter's top left) at (x, y).
    pub(super) fn text_up(&mut self, x: usize, y: usize, text: &str, font: Font, colour: Colour) {
        font.draw(text, |dx, dy, cover| {
            if let Some(y) = y.checked_sub(dx) {
                self.blend(x + dy, y, colour, cover);
            }
        });
    }

    pub(super) fn into_png(self) -> Result<Vec<u8>> {
        png::encode(self.width, self.height, self.pixels.as_flattened())
    }
}

/// `under` with `cover` of `over` on it.
pub(super) fn mixed(under: Colour, over: Colour, cover: f64) -> Colour {
    std::array::from_fn(|c| {
        let (a, b) = (f64::from(under[c]), f64::from(over[c]));
        (a + (b - a) * cover.clamp(0.0, 1.0)).round() as u8
    })
}

/// Black or white, whichever reads better on a colour.
pub(super) fn readable_on(colour: Colour) -> Colour {
    let luma = [0.30, 0.59, 0.11].iter().zip(colour).map(|(k, v)| k * f64::from(v)).sum::<f64>();
    if luma > 140.0 { [0; 3] } else { WHITE }
}
