//! Photometric files of luminaires: IES LM-63 and EULUMDAT in, [`Photometry`] out, and back.
//!
//! A file gives a luminous intensity for directions on a web of two angles ([`Web`]), a luminous opening ([`Opening`])
//! and words. Candelas are what counts: lumens stated beside them are compared and told, never used to scale.

mod eulumdat;
mod ies;
mod numbers;
mod spread;
mod web;
mod write;

use std::path::Path;

pub use spread::{Spread, spread};
pub use web::{PhotometricType, Symmetry, Web};
pub use write::{to_eulumdat, to_ies};

use crate::{Error, Result};

/// The format of a photometric file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// IES LM-63 of a year: 1986, 1991, 1995, 2002 or 2019.
    Ies(u16),
    /// EULUMDAT (A. Stockmar 1990).
    Eulumdat,
}

impl Format {
    /// What a user calls it.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Ies(year) => format!("IES LM-63-{year}"),
            Self::Eulumdat => "EULUMDAT".into(),
        }
    }
}

/// The luminous opening: an upright box (or a cylinder where it is round) centred on the photometric centre; a disc or
/// rectangle where its height is zero, a line or a point where less is left.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Opening {
    /// Extent along the plane C0-C180, m.
    pub along_c0_m: f64,
    /// Extent along the plane C90-C270, m.
    pub along_c90_m: f64,
    /// Extent from below to above, m.
    pub height_m: f64,
    /// Elliptic outline instead of a rectangular one.
    pub round: bool,
}

impl Opening {
    /// Point, line, rectangle, disc, box or cylinder.
    #[must_use]
    pub fn shape(&self) -> &'static str {
        let extents = [self.along_c0_m, self.along_c90_m, self.height_m];
        match extents.iter().filter(|e| **e > 0.0).count() {
            0 => "point",
            1 => "line",
            2 if !self.round => "rectangle",
            2 => "disc",
            _ if self.round => "cylinder",
            _ => "box",
        }
    }
}

/// How the output follows the tilt of the luminaire (the TILT table of LM-63).
#[derive(Clone, Debug, PartialEq)]
pub struct Tilt {
    /// Angles from the upright position, degrees, increasing.
    pub angles_deg: Vec<f64>,
    /// Output relative to the upright position.
    pub factors: Vec<f64>,
}

impl Tilt {
    /// Output at a tilt relative to the upright position; linear, constant beyond the ends.
    #[must_use]
    pub fn factor(&self, tilt_deg: f64) -> f64 {
        let above = self.angles_deg.partition_point(|a| *a <= tilt_deg);
        let last = self.factors.len() - 1;
        if above == 0 || above > last {
            return self.factors[above.min(last)];
        }
        let (a, b) = (self.angles_deg[above - 1], self.angles_deg[above]);
        let (f, g) = (self.factors[above - 1], self.factors[above]);
        f + (g - f) * (tilt_deg - a) / (b - a)
    }
}

/// What a photometric file says.
#[derive(Clone, Debug, PartialEq)]
pub struct Photometry {
    /// The format it was written in.
    pub format: Format,
    /// Luminous intensity by direction, cd.
    pub web: Web,
    /// Where the light leaves from.
    pub opening: Opening,
    /// Keywords and their text, in the file's order.
    pub labels: Vec<(String, String)>,
    /// Number of lamps.
    pub lamps: f64,
    /// Luminous flux of all lamps together, lm; `None` in absolute photometry.
    pub rated_flux_lm: Option<f64>,
    /// Luminous flux that the file says the luminaire gives, lm, where it says so.
    pub stated_flux_lm: Option<f64>,
    /// Electric power, W.
    pub power_w: f64,
    /// How the output follows the tilt.
    pub tilt: Option<Tilt>,
    /// What a careful reader would tell the user.
    pub warnings: Vec<String>,
}

impl Photometry {
    /// Reads a photometric file; its format is told by the ending of its name, `.ies` or `.ldt`, else by what is in it.
    ///
    /// # Errors
    /// A file that cannot be read, or is neither LM-63 nor EULUMDAT, or is malformed: with line and mend.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|e| match e.kind() {
            std::io::ErrorKind::NotFound => Error::malformed("no such file").mend("check the name").in_file(path),
            _ => Error::io(path, &e),
        })?;
        Self::parse(&bytes, path)
    }

    /// The same from bytes; `path` names them, and a separate TILT file is looked for beside it.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self> {
        let text = text(bytes);
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if extension == "xml" || (!matches!(&*extension, "ies" | "ldt") && text.trim_start().starts_with("<?xml")) {
            return Err(Error::unsupported("photometric data in XML (TM-33) is not read in this version")
                .mend("ask for the luminaire's IES or EULUMDAT file")
                .in_file(path));
        }
        // A maker may be called `TILT=`: the ending of the name decides where it says what the file is.
        let photometry = if extension == "ies" || (extension != "ldt" && ies::tilt_line(&text).is_some()) {
            ies::parse(&text, path)
        } else {
            eulumdat::parse(&text)
        };
        let mut photometry = photometry.map_err(|e| e.in_file(path))?;
        photometry.compare_lumens();
        Ok(photometry)
    }

    /// The text of a keyword, where it says something.
    #[must_use]
    pub fn label(&self, keyword: &str) -> Option<&str> {
        let found = self.labels.iter().find(|(k, v)| k.eq_ignore_ascii_case(keyword) && !v.trim().is_empty());
        found.map(|(_, v)| v.trim())
    }

    /// What the luminaire is called: LUMINAIRE, else LUMCAT, else "luminaire".
    #[must_use]
    pub fn name(&self) -> &str {
        self.label("LUMINAIRE").or_else(|| self.label("LUMCAT")).unwrap_or("luminaire")
    }

    /// Least general colour rendering index that the file states for its lamps (EULUMDAT's field "colour rendering group /
    /// colour rendering index", where either stands).
    #[must_use]
    pub fn colour_rendering(&self) -> Option<f64> {
        let text = self.label("CRI").or_else(|| self.label("_CRI"))?.to_ascii_uppercase();
        let group = text.split_whitespace().collect::<String>();
        if let Some((_, least)) = RENDERING_GROUPS.iter().find(|(name, _)| *name == group) {
            return Some(*least);
        }
        // "Ra 80", ">80", "80-89", "80/1B": the first number counts.
        let digits = |c: char| !(c.is_ascii_digit() || c == '.');
        let index = text.split(digits).find(|w| !w.is_empty())?.parse::<f64>().ok()?;
        (LEAST_RENDERING..=100.0).contains(&index).then_some(index)
    }

    /// Flux out of the luminaire over that of its lamps; `None` in absolute photometry.
    #[must_use]
    pub fn light_output_ratio(&self) -> Option<f64> {
        self.rated_flux_lm.filter(|r| *r > 0.0).map(|r| self.web.flux_lm() / r)
    }

    /// Tells of lumens that the candelas do not bear out.
    fn compare_lumens(&mut self) {
        let flux_lm = self.web.flux_lm();
        if flux_lm == 0.0 {
            self.warnings.push("all candelas are zero: the luminaire gives no light".into());
            return;
        }
        let (lumens, whose) = match (self.stated_flux_lm, self.rated_flux_lm) {
            (Some(lumens), _) => (lumens, "light output ratio and lamp lumens give"),
            (None, Some(lumens)) => (lumens, "its lamps are rated at"),
            (None, None) => return,
        };
        let ratio = flux_lm / lumens;
        if (ratio - 1.0).abs() > LUMENS_DIFFER {
            self.warnings.push(format!(
                "the candelas integrate to {flux_lm:.1} lm, {whose} {lumens:.1} lm ({:.1} %): the candelas are used",
                100.0 * ratio
            ));
        }
    }
}

/// Groups of colour rendering and the least index of each (DIN 5035; CIE 29.2).
const RENDERING_GROUPS: [(&str, f64); 8] =
    [("1A", 90.0), ("1B", 80.0), ("1", 80.0), ("2A", 70.0), ("2B", 60.0), ("2", 60.0), ("3", 40.0), ("4", 20.0)];
/// Smaller numbers in the same field are groups.
const LEAST_RENDERING: f64 = 5.0;

/// Share by which candelas and stated lumens may differ before it is told.
const LUMENS_DIFFER: f64 = 0.05;

/// Text of a file: UTF-8 where it is that, else Latin-1.
fn text(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    }
}

#[cfg(test)]
mod tests;
