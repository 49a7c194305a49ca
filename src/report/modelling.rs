//! `modelling.csv`: cylindrical illuminance beside the horizontal, and their ratio.

use super::table::{Table, at, number};
use crate::error::Result;
use crate::measure::{Measurement, Status};
use crate::scene::Scene;

const MODELLING: [&str; 8] = [
    "grid",
    "point",
    "illuminance_lx",
    "error_lx",
    "cylindrical_lx",
    "cylindrical_error_lx",
    "modelling_ratio",
    "modelling_ratio_error",
];

/// One line per point that carries a cylinder. The modelling ratio (EN 12464-1) is cylindrical over horizontal illuminance;
/// it has no meaning where the grid's points do not face up, and is empty there.
pub(super) fn modelling(scene: &Scene, m: &Measurement) -> Result<Vec<u8>> {
    let mut table = Table::new(&MODELLING)?;
    for (plane, cylinders) in &scene.modelling {
        let (grid, cylinders) = (&m.grids[*plane], &m.grids[*cylinders]);
        for (point, (flat, round)) in grid.sensors.iter().zip(&cylinders.sensors).enumerate() {
            let field = |v: f64| number(v).map_err(|e| at(grid, point, &e));
            let known = |s: Status, v: f64| if s == Status::Ok { field(v) } else { Ok(String::new()) };
            let (e, c) = (flat.xyz[1], round.xyz[1]);
            let is_level = flat.normal.z > 0.999 && e > 0.0 && c > 0.0;
            let both = is_level && flat.status == Status::Ok && round.status == Status::Ok;
            let ratio = |v: f64| if both { field(v) } else { Ok(String::new()) };
            table.line(&[
                grid.name.clone(),
                point.to_string(),
                known(flat.status, e)?,
                known(flat.status, flat.error_lx)?,
                known(round.status, c)?,
                known(round.status, round.error_lx)?,
                ratio(c / e)?,
                // The errors of the two are taken to be independent: each has rays of its own.
                ratio(c / e * (flat.error_lx / e).hypot(round.error_lx / c))?,
            ])?;
        }
    }
    table.finish()
}
