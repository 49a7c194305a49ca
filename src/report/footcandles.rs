//! Tables in footcandles.

use std::path::PathBuf;

use super::file::write_whole;
use super::table::number;
use crate::error::{Error, ErrorKind, Result};

/// Lux in a footcandle, one lumen per square foot of 0.3048² m².
pub const LUX_PER_FOOTCANDLE: f64 = 1.0 / (0.3048 * 0.3048);

/// Turns the columns in lux of the CSV files among those written into footcandles: `_lx` becomes `_fc`. Limits and findings
/// of `requirements.csv`, whose quantity says their unit, too.
///
/// # Errors
/// Io with the file's name.
pub fn in_footcandles(files: &[PathBuf]) -> Result<()> {
    for path in files.iter().filter(|p| p.extension().is_some_and(|e| e == "csv")) {
        let text = std::fs::read(path).map_err(|e| Error::io(path, &e))?;
        write_whole(path, &converted(&text)?)?;
    }
    Ok(())
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
