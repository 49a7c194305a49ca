//! Piecewise linear curves over the wavelength.

use std::path::Path;

use super::{KM, cie};
use crate::{Error, Result};

/// What a curve does beyond the ends of its table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// Holds the end value: reflectances, transmittances.
    Hold,
    /// Is zero: radiances.
    Zero,
}

/// A curve over the wavelength, linear between its knots.
///
/// The value's unit is the owner's: 1 for a reflectance, W/(m² sr nm) for a radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Knots, nm, strictly increasing, at least one.
    wavelength_nm: Vec<f64>,
    /// One value per knot.
    value: Vec<f64>,
    beyond: Beyond,
}

/// Knot of a constant curve: any wavelength would do.
const ANY_NM: f64 = 555.0;

impl Spectrum {
    /// A curve through the points `(wavelength_nm, value)`.
    ///
    /// # Errors
    /// Malformed unless there is a value for every wavelength, everything is finite, and the wavelengths are
    /// positive and increase strictly. A curve that is zero beyond its ends wants two points, or it would
    /// carry no light.
    pub fn new(wavelength_nm: Vec<f64>, value: Vec<f64>, beyond: Beyond) -> Result<Self> {
        if wavelength_nm.len() != value.len() {
            return Err(Error::malformed(format!(
                "a spectrum has {} wavelengths but {} values",
                wavelength_nm.len(),
                value.len()
            )));
        }
        let wanted = if beyond == Beyond::Hold { 1 } else { 2 };
        if value.len() < wanted {
            return Err(Error::malformed(format!("a spectrum has {} points, expected at least {wanted}", value.len())));
        }
        let mut previous = None;
        for (&nm, &v) in wavelength_nm.iter().zip(&value) {
            check_point(previous, nm, v)?;
            previous = Some(nm);
        }
        Ok(Self { wavelength_nm, value, beyond })
    }

    /// The same value at every wavelength.
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self { wavelength_nm: vec![ANY_NM], value: vec![value], beyond: Beyond::Hold }
    }

    /// A curve from knots that are known to be in order.
    pub(super) fn from_knots(wavelength_nm: Vec<f64>, value: Vec<f64>, beyond: Beyond) -> Self {
        debug_assert_eq!(wavelength_nm.len(), value.len());
        debug_assert!(!value.is_empty() && wavelength_nm.is_sorted_by(|a, b| a < b));
        Self { wavelength_nm, value, beyond }
    }

    /// Is the value the same at every wavelength?
    #[must_use]
    pub fn is_constant(&self) -> bool {
        let first = self.value[0];
        let level = self.value.iter().all(|&v| v == first);
        level && (self.beyond == Beyond::Hold || first == 0.0)
    }

    /// Value at a wavelength in nm.
    #[must_use]
    pub fn at(&self, nm: f64) -> f64 {
        let right = self.wavelength_nm.partition_point(|&w| w < nm);
        if self.wavelength_nm.get(right) == Some(&nm) {
            return self.value[right];
        }
        if right == 0 || right == self.value.len() {
            return match self.beyond {
                Beyond::Hold => self.value[right.saturating_sub(1)],
                Beyond::Zero => 0.0,
            };
        }
        let (a, b) = (self.wavelength_nm[right - 1], self.wavelength_nm[right]);
        let t = (nm - a) / (b - a);
        self.value[right - 1] * (1.0 - t) + self.value[right] * t
    }

    /// The curve times `k`.
    #[must_use]
    pub fn scaled(&self, k: f64) -> Self {
        Self {
            wavelength_nm: self.wavelength_nm.clone(),
            value: self.value.iter().map(|v| v * k).collect(),
            beyond: self.beyond,
        }
    }

    /// Largest value at a knot.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.value.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Smallest value at a knot.
    #[must_use]
    pub fn min(&self) -> f64 {
        self.value.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The wavelengths of the table, nm.
    #[must_use]
    pub fn knots_nm(&self) -> &[f64] {
        &self.wavelength_nm
    }

    /// What the curve does beyond its table.
    #[must_use]
    pub fn beyond(&self) -> Beyond {
        self.beyond
    }

    /// Mean over `lo_nm..=hi_nm`, exact for the piecewise linear curve.
    #[must_use]
    pub fn mean(&self, lo_nm: f64, hi_nm: f64) -> f64 {
        if self.is_constant() {
            return self.value[0];
        }
        let (sum, width) = cie::nodes(lo_nm, hi_nm, &[&self.wavelength_nm])
            .fold((0.0, 0.0), |(sum, width), (nm, w)| (sum + w * self.at(nm), width + w));
        if width > 0.0 { sum / width } else { self.at(lo_nm) }
    }

    /// CIE 1931 X, Y, Z of a spectral density per nm: `K_m ∫ S x̄ dλ` and so on over 360 to 830 nm.
    ///
    /// Of a radiance in W/(m² sr nm), Y is the luminance in cd/m²; of an irradiance, the illuminance in lx.
    #[must_use]
    pub fn xyz(&self) -> [f64; 3] {
        cie::integral(self, cie::FIRST_NM, cie::LAST_NM).map(|v| KM * v)
    }

    /// The photometric value of a spectral density: Y of [`Spectrum::xyz`].
    #[must_use]
    pub fn luminous(&self) -> f64 {
        self.xyz()[1]
    }

    /// Reads a file with the header `wavelength_nm,value`.
    ///
    /// # Errors
    /// Io when it cannot be read, malformed with file and line when it is no such table.
    pub fn from_csv(path: &Path, beyond: Beyond) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, &e))?;
        Self::from_csv_bytes(&bytes, beyond).map_err(|e| e.in_file(path))
    }

    /// Reads a table from the bytes of a file, see [`Spectrum::from_csv`].
    ///
    /// # Errors
    /// Malformed, with the line.
    pub fn from_csv_bytes(bytes: &[u8], beyond: Beyond) -> Result<Self> {
        let text = std::str::from_utf8(bytes).map_err(|_| Error::malformed("the file is not text in UTF-8"))?;
        parse(text.trim_start_matches('\u{feff}'), beyond)
    }
}

/// Header of a spectrum file.
const HEADER: &str = "wavelength_nm,value";

/// Below this the wavelengths are in micrometres or metres; above, in nothing that light has.
const LEAST_NM: f64 = 10.0;
const MOST_NM: f64 = 1e9;
/// Magnitudes of values: their products stay numbers in single precision too.
const MAGNITUDES: std::ops::RangeInclusive<f64> = 1e-15..=1e15;

fn parse(text: &str, beyond: Beyond) -> Result<Spectrum> {
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())).filter(|(_, line)| !line.is_empty());
    let (first, header) = lines.next().unwrap_or((1, ""));
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    if names.join(",") != HEADER {
        return Err(Error::malformed(format!("the header is {header:?}, expected {HEADER:?}"))
            .at_line(first)
            .mend(format!("write {HEADER} in the first line")));
    }
    let (mut nm, mut value) = (Vec::new(), Vec::new());
    let mut last = first;
    for (number, line) in lines {
        let (w, v) = parse_row(line).map_err(|e| e.at_line(number))?;
        check_point(nm.last().copied(), w, v).map_err(|e| e.at_line(number))?;
        nm.push(w);
        value.push(v);
        last = number;
    }
    Spectrum::new(nm, value, beyond).map_err(|e| e.at_line(last))
}

fn parse_row(line: &str) -> Result<(f64, f64)> {
    let mut fields = line.split(',').map(str::trim);
    let (Some(a), Some(b), None) = (fields.next(), fields.next(), fields.next()) else {
        return Err(Error::malformed(format!("{line:?} is not a wavelength and a value, expected two fields"))
            .mend("separate the two with one comma and write decimals with a point"));
    };
    Ok((parse_number(a)?, parse_number(b)?))
}

fn parse_number(field: &str) -> Result<f64> {
    field.parse().map_err(|_| Error::malformed(format!("{field:?} is not a number")))
}

fn check_point(previous: Option<f64>, nm: f64, value: f64) -> Result<()> {
    if !nm.is_finite() || !value.is_finite() {
        return Err(Error::malformed(format!("the point ({nm} nm, {value}) is not finite")));
    }
    if value != 0.0 && !MAGNITUDES.contains(&value.abs()) {
        return Err(Error::malformed(format!("the value {value} is no spectrum's: expected 0, or 1e-15 to 1e15"))
            .mend("scale the values"));
    }
    if !(LEAST_NM..=MOST_NM).contains(&nm) {
        return Err(
            Error::malformed(format!("a wavelength of {nm} nm is out of range")).mend("give wavelengths in nanometres")
        );
    }
    match previous {
        Some(previous) if previous >= nm => Err(Error::malformed(format!(
            "the wavelength {nm} nm follows {previous} nm, expected increasing wavelengths"
        ))),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn ramp(beyond: Beyond) -> Spectrum {
        Spectrum::new(vec![400.0, 500.0], vec![1.0, 3.0], beyond).unwrap()
    }

    #[test]
    fn a_curve_is_linear_between_its_knots_and_holds_or_vanishes_beyond() {
        assert_eq!(ramp(Beyond::Hold).at(450.0), 2.0);
        assert_eq!(ramp(Beyond::Hold).at(300.0), 1.0);
        assert_eq!(ramp(Beyond::Hold).at(600.0), 3.0);
        assert_eq!(ramp(Beyond::Zero).at(399.9), 0.0);
        assert_eq!(ramp(Beyond::Zero).at(500.1), 0.0);
        assert_eq!(ramp(Beyond::Zero).at(500.0), 3.0);
    }

    #[test]
    fn means_are_exact_for_linear_curves() {
        // Rounding of sums of a few hundred terms.
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(ramp(Beyond::Hold).mean(400.0, 500.0), 2.0);
        close(ramp(Beyond::Hold).mean(420.3, 420.9), 1.412);
        close(ramp(Beyond::Zero).mean(300.0, 500.0), 1.0);
        close(ramp(Beyond::Hold).mean(300.0, 600.0), 2.0);
        close(ramp(Beyond::Hold).mean(450.0, 450.0), 2.0);
    }

    #[test]
    fn a_constant_curve_knows_that_it_is_one() {
        assert!(Spectrum::constant(0.3).is_constant());
        assert!(!ramp(Beyond::Hold).is_constant());
        let window = Spectrum::new(vec![400.0, 500.0], vec![1.0, 1.0], Beyond::Zero).unwrap();
        assert!(!window.is_constant());
        assert_eq!(Spectrum::constant(0.3).mean(1.0, 2.0), 0.3);
    }

    #[test]
    fn files_with_bom_and_crlf_and_blank_lines_are_read() {
        let text = "\u{feff}wavelength_nm,value\r\n\r\n400, 0.5\r\n500,0.75\r\n\r\n";
        let s = Spectrum::from_csv_bytes(text.as_bytes(), Beyond::Hold).unwrap();
        assert_eq!(s.at(450.0), 0.625);
    }

    #[test]
    fn broken_files_are_refused_with_file_and_line() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("s.csv");
        for (text, line) in [
            ("", 1),
            ("400,1\n", 1),
            ("wavelength_nm,value\n", 1),
            ("wavelength_nm,value\n400,nan\n", 2),
            ("wavelength_nm,value\n400,1\n500,inf\n", 3),
            ("wavelength_nm,value\n400,1\n400,1\n", 3),
            ("wavelength_nm,value\n500,1\n400,1\n", 3),
            ("wavelength_nm,value\n0.5,1\n", 2),
            ("wavelength_nm,value\n400;1,5\n", 2),
            ("wavelength_nm,value\n\n400,1,2\n", 3),
        ] {
            std::fs::write(&path, text).unwrap();
            let said = Spectrum::from_csv(&path, Beyond::Hold).unwrap_err().to_string();
            let place = format!("{}:{line}: ", path.display());
            assert!(said.starts_with(&place), "{text:?} gave {said}");
        }
        std::fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
        assert!(Spectrum::from_csv(&path, Beyond::Hold).is_err());
        assert!(Spectrum::from_csv(&dir.path().join("none.csv"), Beyond::Hold).is_err());
    }

    proptest! {
        #[test]
        fn no_bytes_can_break_the_reader(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = Spectrum::from_csv_bytes(&bytes, Beyond::Zero);
        }

        #[test]
        fn no_rows_can_break_the_reader(
            rows in prop::collection::vec(("[-+.0-9einfaNx]{0,8}", "[-+.0-9einfaNx]{0,8}"), 0..8)
        ) {
            let mut text = String::from("wavelength_nm,value\n");
            for (a, b) in rows {
                text.push_str(&format!("{a},{b}\n"));
            }
            if let Ok(s) = Spectrum::from_csv_bytes(text.as_bytes(), Beyond::Hold) {
                prop_assert!(s.at(550.0).is_finite());
            }
        }

        #[test]
        fn the_mean_lies_between_the_extremes(values in prop::collection::vec(0.0..1.0f64, 2..20), lo in 380.0..700.0f64, width in 0.0..80.0f64) {
            let nm = (0..values.len()).map(|i| 400.0 + 13.7 * i as f64).collect();
            let s = Spectrum::new(nm, values, Beyond::Hold).unwrap();
            let mean = s.mean(lo, lo + width);
            prop_assert!(mean >= s.min() - 1e-12 && mean <= s.max() + 1e-12);
        }
    }
}
