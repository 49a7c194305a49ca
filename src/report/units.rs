//! The unit of illuminance: all is computed in lux and written in lux or in footcandles.

use serde_json::{Map, Value};

use super::table::number;
use crate::error::{Error, ErrorKind, Result};

/// Lux in a footcandle, one lumen per square foot of 0.3048² m².
pub const LUX_PER_FOOTCANDLE: f64 = 1.0 / (0.3048 * 0.3048);

/// Unit in which illuminances are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Units {
    /// Lux.
    #[default]
    Lux,
    /// Footcandles: lumens per square foot.
    Footcandles,
}

impl Units {
    /// Its sign.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Lux => "lx",
            Self::Footcandles => "fc",
        }
    }

    /// Of one unit, lx.
    #[must_use]
    pub fn lux(self) -> f64 {
        match self {
            Self::Lux => 1.0,
            Self::Footcandles => LUX_PER_FOOTCANDLE,
        }
    }

    /// A CSV table in lux in this unit: columns ending in `_lx` become `_fc`; limits and findings of `requirements.csv`, whose
    /// quantity says their unit, too.
    pub(super) fn table(self, csv_text: Vec<u8>) -> Result<Vec<u8>> {
        if self == Self::Lux { Ok(csv_text) } else { converted(&csv_text) }
    }

    /// A record in lux in this unit, by the same rules for its keys.
    #[must_use]
    pub fn record(self, record: Value) -> Value {
        if self == Self::Lux {
            return record;
        }
        match record {
            Value::Array(list) => list.into_iter().map(|v| self.record(v)).collect(),
            Value::Object(object) => {
                let of_lux = |v: &Value| v.as_str().is_some_and(|q| q.ends_with("_lx"));
                let found_in_lux = object.get("quantity").is_some_and(of_lux);
                let each = |(key, value)| self.entry(key, value, found_in_lux);
                Value::Object(object.into_iter().map(each).collect::<Map<_, _>>())
            }
            other => other,
        }
    }

    fn entry(self, key: String, value: Value, found_in_lux: bool) -> (String, Value) {
        let is_finding = found_in_lux && (key == "limit" || key.starts_with("found"));
        let value = match value.as_f64().filter(|_| is_finding || key.ends_with("_lx")) {
            Some(lux) => Value::from(lux / self.lux()),
            None if key == "quantity" => value.as_str().map_or(Value::Null, |q| Value::from(renamed(q))),
            None => self.record(value),
        };
        (renamed(&key), value)
    }
}

fn converted(csv_text: &[u8]) -> Result<Vec<u8>> {
    let broken = |e: csv::Error| Error::new(ErrorKind::Internal, format!("a table: {e}"));
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(csv_text);
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut header: Option<Vec<String>> = None;
    for record in reader.records() {
        let mut record: Vec<String> = record.map_err(broken)?.iter().map(str::to_owned).collect();
        let Some(names) = &header else {
            header = Some(record.clone());
            record.iter_mut().for_each(|name| *name = renamed(name));
            writer.write_record(&record).map_err(broken)?;
            continue;
        };
        let quantity = names.iter().position(|n| n == "quantity").map(|k| record[k].clone());
        for (name, value) in names.iter().zip(&mut record) {
            let is_finding = name == "limit" || name.starts_with("found");
            let is_lux = name.ends_with("_lx") || (is_finding && quantity.as_ref().is_some_and(|q| q.ends_with("_lx")));
            if let (true, Ok(lux)) = (is_lux, value.parse::<f64>()) {
                let wrong = |_| Error::new(ErrorKind::Internal, "a value in footcandles is not finite");
                *value = number(lux / LUX_PER_FOOTCANDLE).map_err(wrong)?;
            } else if name == "quantity" {
                *value = renamed(value);
            }
        }
        writer.write_record(&record).map_err(broken)?;
    }
    writer.into_inner().map_err(|e| Error::new(ErrorKind::Internal, format!("a table: {e}")))
}

fn renamed(name: &str) -> String {
    name.strip_suffix("_lx").map_or_else(|| name.to_owned(), |stem| format!("{stem}_fc"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_says_footcandles_wherever_it_said_lux() {
        let lux = serde_json::json!({
            "grids": [{ "mean_lx": 107.63910416709722, "min_lx": null, "holding": 3 }],
            "requirements": [{ "quantity": "mean_lx", "limit": 10.763910416709722 }, { "quantity": "ugr", "limit": 19.0 }],
        });
        let feet = serde_json::json!({
            "grids": [{ "mean_fc": 10.0, "min_fc": null, "holding": 3 }],
            "requirements": [{ "quantity": "mean_fc", "limit": 1.0 }, { "quantity": "ugr", "limit": 19.0 }],
        });
        assert_eq!(Units::Lux.record(lux.clone()), lux);
        assert_eq!(Units::Footcandles.record(lux), feet);
    }

    #[test]
    fn a_lumen_per_square_foot_is_a_footcandle() {
        assert!((LUX_PER_FOOTCANDLE - 10.763_910_416_709_722).abs() < 1e-12);
        let table = b"grid,mean_lx,ugr\n\"a, b\",107.63910416709722,19\nc,,\n";
        assert_eq!(String::from_utf8(converted(table).unwrap()).unwrap(), "grid,mean_fc,ugr\n\"a, b\",10,19\nc,,\n");
        let table = b"grid,quantity,limit\ng,mean_lx,107.63910416709722\ng,ugr,19\n";
        assert_eq!(
            String::from_utf8(converted(table).unwrap()).unwrap(),
            "grid,quantity,limit\ng,mean_fc,10\ng,ugr,19\n"
        );
    }
}
