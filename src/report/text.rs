//! Text in pictures: a bitmap font, Latin-1.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, RasterizedChar, get_raster, get_raster_width};

/// The sizes of text in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Font {
    /// Labels inside a map.
    Label,
    /// Axes, legend, notes.
    Body,
    /// The headline.
    Title,
}

impl Font {
    fn style(self) -> (FontWeight, RasterHeight) {
        match self {
            Self::Label => (FontWeight::Bold, RasterHeight::Size16),
            Self::Body => (FontWeight::Regular, RasterHeight::Size20),
            Self::Title => (FontWeight::Bold, RasterHeight::Size24),
        }
    }

    /// Height of a line, pixels.
    pub(super) fn height(self) -> usize {
        self.style().1.val()
    }

    /// Width of a text, pixels.
    pub(super) fn width(self, text: &str) -> usize {
        let (weight, size) = self.style();
        text.chars().count() * get_raster_width(weight, size)
    }

    /// The text, shortened to a width in pixels.
    pub(super) fn fit(self, text: &str, width: usize) -> String {
        if self.width(text) <= width {
            return text.into();
        }
        let room = width / self.width("m").max(1);
        let kept: String = text.chars().take(room.saturating_sub(3)).collect();
        format!("{kept}...")
    }

    /// A character's picture; a question mark where the font has none.
    fn glyph(self, c: char) -> Option<RasterizedChar> {
        let (weight, size) = self.style();
        get_raster(c, weight, size).or_else(|| get_raster('?', weight, size))
    }

    /// Calls `ink(x, y, coverage)` for every pixel of the text that has some, from its top left corner.
    pub(super) fn draw(self, text: &str, mut ink: impl FnMut(usize, usize, f64)) {
        let mut left = 0;
        for glyph in text.chars().filter_map(|c| self.glyph(c)) {
            for (y, row) in glyph.rows().enumerate() {
                for (x, &v) in row.iter().enumerate().filter(|(_, v)| **v > 0) {
                    ink(left + x, y, f64::from(v) / 255.0);
                }
            }
            left += glyph.width();
        }
    }
}
