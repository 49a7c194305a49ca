//! `requirements.csv`, `surfaces.csv`, and the same in `run.json`.

use serde_json::{Value, json};

use super::table::{Table, number};
use crate::error::{Error, ErrorKind, Result};
use crate::measure::{Appraisal, Judged, Power, RoomSurface};

const REQUIREMENTS: [&str; 8] = ["grid", "state", "quantity", "limit", "found", "found_low", "found_high", "verdict"];

const SURFACES: [&str; 9] = [
    "material",
    "side",
    "area_m2",
    "modelled_share",
    "illuminance_lx",
    "illuminance_error_lx",
    "luminance_cd_m2",
    "luminance_error_cd_m2",
    "object",
];

fn field(v: f64) -> Result<String> {
    number(v).map_err(|e| Error::new(ErrorKind::Internal, format!("an appraised value is {}", e.0)))
}

fn fields<const N: usize>(values: Option<[f64; N]>) -> Result<Vec<String>> {
    values.map_or_else(|| Ok(vec![String::new(); N]), |v| v.into_iter().map(field).collect())
}

/// `requirements.csv`: one line per limit; `found_low` and `found_high` are the ends of the 95 % interval. A ratio to nothing
/// is left empty.
pub(super) fn requirements(a: &Appraisal) -> Result<Vec<u8>> {
    let mut table = Table::new(&REQUIREMENTS)?;
    for j in &a.requirements {
        let mut line = vec![j.grid.clone(), j.state.clone(), j.quantity.name().to_owned(), field(j.limit)?];
        let finite = |v: f64| if v.is_infinite() { Ok(String::new()) } else { field(v) };
        let found =
            j.found.map_or_else(|| Ok(vec![String::new(); 3]), |f| f.into_iter().map(finite).collect::<Result<_>>());
        line.extend(found?);
        line.push(j.verdict.name().to_owned());
        table.line(&line)?;
    }
    table.finish()
}

/// `surfaces.csv`: one line per side of each opaque diffuse material that light reaches, then one for each object of the
/// drawing with it.
pub(super) fn surfaces(a: &Appraisal) -> Result<Vec<u8>> {
    let mut table = Table::new(&SURFACES)?;
    for s in &a.surfaces {
        let mut line = vec![s.material.clone(), side(s).to_owned(), field(s.area_m2)?, field(s.modelled_share)?];
        line.extend(fields(s.illuminance_lx)?);
        line.extend(fields(Some(s.luminance_cd_m2))?);
        line.push(s.object.clone().unwrap_or_default());
        table.line(&line)?;
    }
    table.finish()
}

fn side(s: &RoomSurface) -> &'static str {
    if s.front { "front" } else { "back" }
}

/// The keys `requirements`, `power` and `surfaces` of `run.json`.
pub(super) fn keys(a: &Appraisal) -> [(&'static str, Value); 3] {
    let surface = |s: &RoomSurface| {
        json!({
            "material": s.material,
            "object": s.object,
            "side": side(s),
            "area_m2": s.area_m2,
            "modelled_share": s.modelled_share,
            "illuminance_lx": s.illuminance_lx.map(|e| e[0]),
            "illuminance_error_lx": s.illuminance_lx.map(|e| e[1]),
            "luminance_cd_m2": s.luminance_cd_m2[0],
            "luminance_error_cd_m2": s.luminance_cd_m2[1],
        })
    };
    [
        ("requirements", a.requirements.iter().map(judged).collect()),
        ("power", a.power.as_ref().map_or(Value::Null, power)),
        ("surfaces", a.surfaces.iter().map(surface).collect()),
    ]
}

fn judged(j: &Judged) -> Value {
    json!({
        "grid": j.grid,
        "state": j.state,
        "quantity": j.quantity.name(),
        "limit": j.limit,
        "found": j.found.map(|f| f[0]),
        "found_low": j.found.map(|f| f[1]),
        "found_high": j.found.map(|f| f[2]),
        "verdict": j.verdict.name(),
    })
}

fn power(p: &Power) -> Value {
    json!({
        "luminaires_W": p.total_w,
        "luminaires_without_watts": p.unknown,
        "density_W_m2": p.density_w_m2,
        "density_W_m2_per_100_lx": p.density_w_m2_per_100_lx,
    })
}
