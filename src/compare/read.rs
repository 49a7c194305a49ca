//! Reads results and measured values.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

use super::{BandIrradiance, Comparison, Pair, Quantity, Reading, face_xyz};
use crate::spectrum::{Beyond, Spectrum, colour};
use crate::{Error, Result};

/// Name of the grid and number of the point in it.
type Key = (String, usize);

/// What a run computed.
#[derive(Clone, Debug, Default)]
pub struct Computed {
    points: BTreeMap<Key, BTreeMap<&'static str, Reading>>,
    /// Empty unless the run was asked for every band.
    bands: BTreeMap<Key, Vec<BandIrradiance>>,
}

/// A table with the places of its columns.
struct Table {
    reader: csv::Reader<std::fs::File>,
    columns: BTreeMap<String, usize>,
}

impl Table {
    fn open(path: &Path) -> Result<Self> {
        let file = std::fs::File::open(path).map_err(|e| Error::io(path, &e))?;
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
        let heads = reader.headers().map_err(|e| Error::malformed(e.to_string()).in_file(path).at_line(1))?;
        let columns = heads.iter().enumerate().map(|(i, h)| (h.trim_start_matches('\u{feff}').to_owned(), i)).collect();
        Ok(Self { reader, columns })
    }
}

/// A row that can tell what is wrong with it.
struct Row<'a> {
    path: &'a Path,
    line: usize,
    record: csv::StringRecord,
    columns: &'a BTreeMap<String, usize>,
}

impl Row<'_> {
    fn text(&self, column: &str) -> Option<&str> {
        self.columns.get(column).and_then(|i| self.record.get(*i)).filter(|t| !t.is_empty())
    }

    fn wrong(&self, what: String) -> Error {
        Error::malformed(what).in_file(self.path).at_line(self.line)
    }

    /// A number, or nothing where the field is empty or missing.
    fn number(&self, column: &str) -> Result<Option<f64>> {
        let Some(text) = self.text(column) else { return Ok(None) };
        match text.parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(Some(v)),
            _ => Err(self
                .wrong(format!("{column} is {text:?}, expected a number"))
                .mend("leave it empty if not measured")),
        }
    }

    fn key(&self) -> Result<Key> {
        let grid = self.text("grid").ok_or_else(|| self.wrong("no grid is named".into()))?;
        let point = self.text("point").unwrap_or_default();
        let number = point.parse().map_err(|_| self.wrong(format!("point is {point:?}, expected a number from 0")))?;
        Ok((grid.to_owned(), number))
    }
}

/// Calls `each` with every row; the named columns must be there.
fn rows(path: &Path, wanted: &[&str], mut each: impl FnMut(&Row<'_>) -> Result<()>) -> Result<()> {
    let Table { mut reader, columns } = Table::open(path)?;
    if let Some(missing) = wanted.iter().find(|w| !columns.contains_key(**w)) {
        return Err(Error::malformed(format!("no column {missing}"))
            .mend(format!("the table needs the columns {}", wanted.join(", ")))
            .in_file(path)
            .at_line(1));
    }
    for record in reader.records() {
        let record = record.map_err(|e| {
            let line = e.position().map_or(1, |p| p.line() as usize);
            Error::malformed(e.to_string()).in_file(path).at_line(line)
        })?;
        let line = record.position().map_or(1, |p| p.line() as usize);
        each(&Row { path, line, record, columns: &columns })?;
    }
    Ok(())
}

/// The readings of `illuminance.csv`, or of the folder that holds it; also of `irradiance.csv`, if it stands beside.
///
/// # Errors
/// Io where it cannot be read, malformed with file and line where it is no such table.
pub fn result(path: &Path) -> Result<Computed> {
    let path = if path.is_dir() { path.join("illuminance.csv") } else { path.to_path_buf() };
    let mut computed = Computed::default();
    rows(&path, &["grid", "point", "status", "illuminance_lx", "error_lx"], |row| {
        let mut readings = BTreeMap::new();
        for quantity in [Quantity::Illuminance, Quantity::CieX, Quantity::CieY] {
            // Chromaticities have no stated error of their own in the table.
            let error = if quantity == Quantity::Illuminance { row.number("error_lx")? } else { Some(0.0) };
            if let (Some(value), Some(error)) = (row.number(quantity.column())?, error) {
                readings.insert(quantity.column(), Reading { value, error });
            }
        }
        computed.points.insert(row.key()?, readings);
        Ok(())
    })?;
    let spectral = path.with_file_name("irradiance.csv");
    if spectral.exists() {
        rows(&spectral, &["grid", "point", "band_lo_nm", "band_hi_nm", "irradiance_W_m2_nm"], |row| {
            let wanted = |column: &str| row.number(column)?.ok_or_else(|| row.wrong(format!("no {column}")));
            let limits_nm = (wanted("band_lo_nm")?, wanted("band_hi_nm")?);
            let irradiance = wanted("irradiance_W_m2_nm")?;
            computed.bands.entry(row.key()?).or_default().push(BandIrradiance { limits_nm, irradiance });
            Ok(())
        })?;
    }
    Ok(computed)
}

/// The readings of a point; of the face, where the row tells its reflectance.
fn readings(row: &Row<'_>, computed: &Computed) -> Result<BTreeMap<&'static str, Reading>> {
    let key = row.key()?;
    let Some(there) = computed.points.get(&key) else {
        return Err(row
            .wrong(format!("the result has no point {} in grid {:?}", key.1, key.0))
            .mend("points count from 0 in the order of illuminance.csv"));
    };
    let mut there = there.clone();
    let (Some(told), Some(arriving)) = (row.text("reflectance"), there.get(Quantity::Illuminance.column()).copied())
    else {
        return Ok(there);
    };
    let luminance = if let Ok(grey) = told.parse::<f64>() {
        if !(0.0..=1.0).contains(&grey) {
            return Err(row.wrong(format!("reflectance is {grey}, expected 0 to 1 or a file of a spectrum")));
        }
        grey * arriving.value / PI
    } else {
        let file = row.path.with_file_name(told);
        if !file.exists() {
            return Err(row.wrong(format!("reflectance is {told:?}, neither a number nor a file beside the table")));
        }
        let curve = Spectrum::from_csv(&file, Beyond::Hold)?;
        let Some(bands) = computed.bands.get(&key) else {
            return Err(row
                .wrong("the colour of a face needs the light of every band".into())
                .mend("solve with --spectral, which writes irradiance.csv"));
        };
        let xyz = face_xyz(bands, arriving.value, &curve);
        if let Some([x, y]) = colour::xy(xyz) {
            there.insert(Quantity::CieX.column(), Reading { value: x, error: 0.0 });
            there.insert(Quantity::CieY.column(), Reading { value: y, error: 0.0 });
        }
        xyz[1]
    };
    // The luminance errs as the illuminance does.
    let error = luminance * arriving.error / arriving.value.max(f64::MIN_POSITIVE);
    there.insert(Quantity::Luminance.column(), Reading { value: luminance, error });
    Ok(there)
}

/// Measured values beside what was computed at the same points, one comparison for each quantity that was measured.
///
/// # Errors
/// Io where the file cannot be read; malformed with file and line for what cannot be, an unknown point, or a table in which
/// nothing was measured.
pub fn measured(path: &Path, computed: &Computed) -> Result<Vec<Comparison>> {
    let mut pairs: [Vec<Pair>; Quantity::ALL.len()] = Default::default();
    rows(path, &["grid", "point"], |row| {
        for (quantity, list) in Quantity::ALL.into_iter().zip(&mut pairs) {
            let Some(value) = row.number(quantity.column())? else { continue };
            let (key, there) = (row.key()?, readings(row, computed)?);
            let Some(found) = there.get(quantity.column()) else {
                let what = quantity.column();
                let told = row.wrong(format!("point {} of grid {:?} has no {what} in the result", key.1, key.0));
                let mend = "give the column reflectance: a number, or a file of a spectrum beside the table";
                return Err(if quantity == Quantity::Luminance { told.mend(mend) } else { told });
            };
            list.push(Pair { grid: key.0, point: key.1, measured: reading(row, quantity, value)?, computed: *found });
        }
        Ok(())
    })?;
    let found: Vec<Comparison> =
        Quantity::ALL.into_iter().zip(pairs).filter_map(|(q, p)| Comparison::of(q, p)).collect();
    if found.is_empty() {
        return Err(Error::malformed("nothing was measured")
            .mend("fill in illuminance_lx and uncertainty_lx, luminance_cd_m2 and uncertainty_cd_m2, or cie_x, cie_y and uncertainty_xy")
            .in_file(path));
    }
    Ok(found)
}

/// A measured value with its uncertainty, both of which must be physical.
fn reading(row: &Row<'_>, quantity: Quantity, value: f64) -> Result<Reading> {
    if value <= 0.0 {
        return Err(row.wrong(format!("{} is {value}, expected more than nothing", quantity.column())));
    }
    let column = quantity.uncertainty_column();
    let error = row.number(column)?;
    let error = error.ok_or_else(|| row.wrong(format!("{} has no {column}", quantity.column())))?;
    if error < 0.0 {
        return Err(row.wrong(format!("{column} is {error}, expected none below zero")));
    }
    Ok(Reading { value, error })
}
