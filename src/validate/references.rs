//! Stored reference values: CSV tables of `validation/references` and the scene of the Cornell box.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::{Error, Result};

/// The texts of all references by file name.
#[derive(Clone, Debug)]
pub struct References(BTreeMap<&'static str, String>);

macro_rules! embedded {
    ($($folder:literal: $($name:literal),+;)+) => {
        [$($(($name, include_str!(concat!("../../validation/", $folder, "/", $name)))),+),+]
    };
}

impl Default for References {
    /// Those that the program carries.
    fn default() -> Self {
        let all = embedded! {
            "references": "boxes.csv", "cie171_daylight.csv", "cie171_electric.csv", "colour.csv", "cornell.csv",
                "form_factors.csv", "skies.csv", "sun.csv";
            "cornell": "cornell.obj", "points.toml", "left_wall.pts", "white.csv", "red.csv", "green.csv", "light.csv";
        };
        Self(all.into_iter().map(|(name, text)| (name, text.to_owned())).collect())
    }
}

impl References {
    /// The names of the tables.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.keys().copied()
    }

    /// The text of a file; empty if there is none of that name.
    #[must_use]
    pub fn text(&self, name: &str) -> &str {
        self.0.get(name).map_or("", String::as_str)
    }

    /// Puts another text in the place of a file's.
    pub fn replace(&mut self, name: &str, text: String) {
        if let Some(old) = self.0.get_mut(name) {
            *old = text;
        }
    }

    /// The lines of a table.
    pub(super) fn rows(&self, name: &'static str) -> Result<Vec<Row>> {
        let mut reader = csv::Reader::from_reader(self.text(name).as_bytes());
        let broken = |e: csv::Error| Error::malformed(e.to_string()).in_file(name);
        let heads = reader.headers().map_err(broken)?.clone();
        let mut rows = Vec::new();
        for (i, record) in reader.records().enumerate() {
            let record = record.map_err(broken)?;
            let fields = heads.iter().zip(&record).map(|(h, v)| (h.to_owned(), v.to_owned())).collect();
            rows.push(Row { file: name, line: i + 2, fields });
        }
        Ok(rows)
    }
}

/// A line of a table.
#[derive(Debug)]
pub(super) struct Row {
    file: &'static str,
    line: usize,
    fields: BTreeMap<String, String>,
}

impl Row {
    fn wrong(&self, field: &str, wanted: &str) -> Error {
        let found = self.fields.get(field).map_or("nothing", String::as_str);
        Error::malformed(format!("{field} is {found:?}, expected {wanted}")).in_file(self.file).at_line(self.line)
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
        let list: Option<Vec<DVec3>> = self
            .text(field)?
            .split(';')
            .map(|p| numbers(p).and_then(|v| <[f64; 3]>::try_from(v).ok()).map(DVec3::from))
            .collect();
        list.ok_or_else(|| self.wrong(field, "points"))
    }
}

fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split_whitespace().map(|v| v.parse().ok().filter(|v: &f64| v.is_finite())).collect()
}
