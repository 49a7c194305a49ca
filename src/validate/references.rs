//! Stored reference values: CSV tables of `validation/references`, and scenes that the program carries.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::scene::{self, Scene};
use crate::{Error, Result};

/// The texts of all references by their path in the source, and where measured data lie that are not part of it.
#[derive(Clone, Debug)]
pub struct References {
    texts: BTreeMap<&'static str, String>,
    measured: Option<PathBuf>,
}

/// Path and text of files of the source.
macro_rules! embedded {
    ($($folder:literal: $($name:literal),+;)+) => {
        [$($((concat!($folder, "/", $name), include_str!(concat!("../../", $folder, "/", $name)))),+),+]
    };
}

/// Folder of the tables.
const TABLES: &str = "validation/references";

impl Default for References {
    /// Those that the program carries.
    fn default() -> Self {
        let all = embedded! {
            "validation/references": "boxes.csv", "cie171_daylight.csv", "cie171_electric.csv", "cie171_published.csv",
                "colour.csv",
                "cornell.csv", "ferren.csv", "form_factors.csv", "skies.csv", "sun.csv";
            "validation/cornell": "cornell.obj", "points.toml", "left_wall.pts", "white.csv", "red.csv", "green.csv",
                "light.csv";
            "experiments/ferren": "louvre.toml", "louvre.obj", "louvre.pts", "backing.toml", "backing.obj",
                "backing.pts", "white.csv", "black.csv", "red.csv", "yellow.csv", "green.csv", "cyan.csv", "blue.csv",
                "magenta.csv";
            "validation/growth-chamber": "results.csv";
        };
        let texts = all.into_iter().map(|(path, text)| (path, text.to_owned())).collect();
        Self { texts, measured: None }
    }
}

impl References {
    /// With the folder of the measured room's data, which the program does not carry.
    #[must_use]
    pub fn with_measured(mut self, folder: &Path) -> Self {
        self.measured = Some(folder.to_path_buf());
        self
    }

    pub(super) fn measured(&self) -> Option<&Path> {
        self.measured.as_deref()
    }

    /// The text of a file by its path in the source; empty if there is none.
    pub(super) fn text(&self, path: &str) -> &str {
        self.texts.get(path).map_or("", String::as_str)
    }

    /// The text of a table; empty if there is none of that name.
    #[must_use]
    pub fn table(&self, name: &str) -> &str {
        self.text(&format!("{TABLES}/{name}"))
    }

    /// Puts another text in the place of a table's.
    pub fn replace_table(&mut self, name: &str, text: String) {
        if let Some(old) = self.texts.get_mut(format!("{TABLES}/{name}").as_str()) {
            *old = text;
        }
    }

    /// A scene of a folder of the source, its text changed on the way.
    pub(super) fn scene(&self, folder: &str, name: &str, change: impl Fn(&str) -> String) -> Result<Scene> {
        let dir = tempfile::tempdir().map_err(|e| Error::io("a folder for a scene", &e))?;
        for (path, text) in &self.texts {
            let Some(file) = path.strip_prefix(folder).and_then(|p| p.strip_prefix('/')) else { continue };
            let place = dir.path().join(file);
            std::fs::write(&place, change(text)).map_err(|e| Error::io(&place, &e))?;
        }
        scene::load(&dir.path().join(name))
    }

    /// The lines of a table.
    pub(super) fn rows(&self, name: &str) -> Result<Vec<Row>> {
        rows_of(self.table(name), name)
    }
}

/// The lines of a table in CSV; `file` is told where something is wrong.
pub(super) fn rows_of(text: &str, file: &str) -> Result<Vec<Row>> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let broken = |e: csv::Error| Error::malformed(e.to_string()).in_file(file);
    let heads = reader.headers().map_err(broken)?.clone();
    let mut rows = Vec::new();
    for (i, record) in reader.records().enumerate() {
        let record = record.map_err(broken)?;
        let fields = heads.iter().zip(&record).map(|(h, v)| (h.to_owned(), v.to_owned())).collect();
        rows.push(Row { file: file.to_owned(), line: i + 2, fields });
    }
    Ok(rows)
}

/// A line of a table.
#[derive(Debug)]
pub(super) struct Row {
    file: String,
    line: usize,
    fields: BTreeMap<String, String>,
}

impl Row {
    fn wrong(&self, field: &str, wanted: &str) -> Error {
        let found = self.fields.get(field).map_or("nothing", String::as_str);
        Error::malformed(format!("{field} is {found:?}, expected {wanted}")).in_file(&self.file).at_line(self.line)
    }

    /// Names of its fields.
    pub(super) fn fields(&self) -> impl Iterator<Item = &str> {
        self.fields.keys().map(String::as_str)
    }

    pub(super) fn text(&self, field: &str) -> Result<&str> {
        self.fields.get(field).map(String::as_str).ok_or_else(|| self.wrong(field, "a text"))
    }

    pub(super) fn number(&self, field: &str) -> Result<f64> {
        let value = self.text(field)?.parse().ok().filter(|v: &f64| v.is_finite());
        value.ok_or_else(|| self.wrong(field, "a number"))
    }

    /// Numbers with blanks between them.
    pub(super) fn numbers<const N: usize>(&self, field: &str) -> Result<[f64; N]> {
        let list = numbers(self.text(field)?).and_then(|v| <[f64; N]>::try_from(v).ok());
        list.ok_or_else(|| self.wrong(field, &format!("{N} numbers")))
    }

    pub(super) fn point(&self, field: &str) -> Result<DVec3> {
        Ok(DVec3::from(self.numbers::<3>(field)?))
    }

    /// Points with semicolons between them.
    pub(super) fn points(&self, field: &str) -> Result<Vec<DVec3>> {
        self.points_between(field, ';')
    }

    /// Points with some character between them.
    pub(super) fn points_between(&self, field: &str, between: char) -> Result<Vec<DVec3>> {
        let list: Option<Vec<DVec3>> = self
            .text(field)?
            .split(between)
            .map(|p| numbers(p).and_then(|v| <[f64; 3]>::try_from(v).ok()).map(DVec3::from))
            .collect();
        list.ok_or_else(|| self.wrong(field, "points"))
    }
}

fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split_whitespace().map(|v| v.parse().ok().filter(|v: &f64| v.is_finite())).collect()
}
