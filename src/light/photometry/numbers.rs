//! Numbers in free form, each with its line, and the checks that all photometric tables share.

use crate::{Error, Result};

/// Larger magnitudes are no photometry.
pub(super) const LARGEST: f64 = 1e12;

/// The numbers of a text, one after another, wherever lines break.
#[derive(Debug)]
pub(super) struct Numbers<'a> {
    words: Vec<(usize, &'a str)>,
    next: usize,
    last_line: usize,
}

impl<'a> Numbers<'a> {
    /// Words of lines numbered from `first_line`, parted by blanks or commas.
    pub(super) fn new(lines: impl Iterator<Item = &'a str>, first_line: usize) -> Self {
        let mut words = Vec::new();
        let mut last_line = first_line;
        for (k, line) in lines.enumerate() {
            let found = line.split(|c: char| c.is_whitespace() || c == ',' || c == '\u{1a}');
            words.extend(found.filter(|w| !w.is_empty()).map(|w| (first_line + k, w)));
            last_line = first_line + k;
        }
        Self { words, next: 0, last_line }
    }

    /// The next number; `what` names it.
    pub(super) fn number(&mut self, what: &str) -> Result<f64> {
        let Some((line, word)) = self.words.get(self.next) else {
            return Err(Error::malformed(format!("the file ends before {what}"))
                .at_line(self.last_line)
                .mend("the file is cut short: get it again"));
        };
        self.next += 1;
        parse(word, what).map_err(|e| e.at_line(*line))
    }

    /// The next number, which counts things.
    pub(super) fn count(&mut self, what: &str, most: usize) -> Result<usize> {
        let n = self.number(what)?;
        count(n, what, most).map_err(|e| e.at_line(self.line()))
    }

    /// So many numbers.
    pub(super) fn list(&mut self, count: usize, what: &str) -> Result<Vec<f64>> {
        let left = self.words.len() - self.next;
        if left < count {
            return Err(Error::malformed(format!("{what}: {count} numbers expected, {left} found"))
                .at_line(self.last_line)
                .mend("the file is cut short, or one of its counts is too large"));
        }
        (0..count).map(|k| self.number(&format!("{what} {}", k + 1))).collect()
    }

    /// Line of the number read last.
    pub(super) fn line(&self) -> usize {
        self.words.get(self.next.saturating_sub(1)).map_or(self.last_line, |w| w.0)
    }

    /// Numbers not read yet.
    pub(super) fn left(&self) -> usize {
        self.words.len() - self.next
    }
}

/// Larger openings are none, m.
const LARGEST_OPENING_M: f64 = 1e6;

/// A size of an opening, m.
pub(super) fn size_m(size_m: f64, what: &str) -> Result<f64> {
    if size_m.abs() <= LARGEST_OPENING_M {
        return Ok(size_m);
    }
    Err(Error::malformed(format!("{what} is {size_m} m")).mend("correct the size, or its unit"))
}

/// A finite number; a comma may stand for the decimal point.
pub(super) fn parse(word: &str, what: &str) -> Result<f64> {
    let number = word.replace(',', ".").parse::<f64>();
    match number {
        Ok(n) if n.abs() <= LARGEST => Ok(n),
        _ => Err(Error::malformed(format!("{what}: `{}` is not a finite number", short(word)))
            .mend("write a decimal number such as 12.5")),
    }
}

/// At most 40 characters of a word.
fn short(word: &str) -> String {
    word.chars().take(40).collect()
}

/// A whole number from 1 to `most`.
pub(super) fn count(n: f64, what: &str, most: usize) -> Result<usize> {
    if n.fract() == 0.0 && n >= 1.0 && n <= most as f64 {
        return Ok(n as usize);
    }
    Err(Error::malformed(format!("{what} is {n}, not a whole number from 1 to {most}")).mend("correct the count"))
}

/// Angles to six decimals, as they are written again: what is closer is one angle. Refuses those that do not rise.
pub(super) fn rising(mut angles_deg: Vec<f64>, what: &str) -> Result<Vec<f64>> {
    angles_deg.iter_mut().for_each(|a| *a = (*a * 1e6).round() / 1e6);
    let Some(w) = angles_deg.windows(2).find(|w| w[1] <= w[0]) else { return Ok(angles_deg) };
    let message = if w[1] == w[0] {
        format!("{what}: the angle {} stands there twice", w[0])
    } else {
        format!("{what}: {} follows {}", w[1], w[0])
    };
    Err(Error::malformed(message).mend("angles must increase: correct the list or its count"))
}
