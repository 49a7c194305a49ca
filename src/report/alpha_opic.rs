//! `alpha_opic.csv`: what the light at each sensor does to the receptors of CIE S 026.

use super::table::{Table, at, number};
use crate::error::Result;
use crate::measure::{AlphaOpicScale, Measurement, Status};
use crate::spectrum::ALPHA_OPIC;

/// One line per ok sensor: five irradiances and the melanopic equivalent daylight illuminance, each with its error.
pub(super) fn table(m: &Measurement, scale: &AlphaOpicScale) -> Result<Vec<u8>> {
    let mut header = vec!["grid".to_owned(), "point".to_owned()];
    header.extend(ALPHA_OPIC.iter().flat_map(|a| [format!("{}_W_m2", a.name()), format!("{}_error_W_m2", a.name())]));
    header.extend(["melanopic_edi_lx".to_owned(), "melanopic_edi_error_lx".to_owned()]);
    let mut table = Table::new(&header.iter().map(String::as_str).collect::<Vec<_>>())?;
    for grid in &m.grids {
        for (point, sensor) in grid.sensors.iter().enumerate().filter(|(_, s)| s.status == Status::Ok) {
            let read = scale.read(sensor);
            let mut line = vec![grid.name.clone(), point.to_string()];
            for (value, error) in read.irradiance.into_iter().chain([read.melanopic_edi_lx]) {
                for v in [value, error] {
                    line.push(number(v).map_err(|e| at(grid, point, &e))?);
                }
            }
            table.line(&line)?;
        }
    }
    table.finish()
}
