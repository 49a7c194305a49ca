//! Luminaires: the user's table into places and directions.
//!
//! What the photometric file says is read by `light::Luminaires`.

use std::path::PathBuf;

use glam::{DMat3, DQuat, DVec3};
use schemars::JsonSchema;
use serde::Deserialize;

use super::Axes;
use super::file::{At, SpectrumDef};
use super::load::{Files, check_number, unit_vector, vector};
use super::material;
use crate::Result;
use crate::spectrum::Spectrum;

/// Luminaires of one kind, hung alike: one, or rows and columns of them.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LuminaireDef {
    /// Photometric file: IES LM-63 or EULUMDAT.
    file: At<String>,
    /// Centre of the luminous opening, m; of rows and columns the first.
    position_m: At<[f64; 3]>,
    /// Where nadir (vertical angle 0) points; down unless given.
    aim: Option<At<[f64; 3]>>,
    /// Turn about the aim, degrees, from C0 towards C90. With the aim down and no turn C0 points along +x.
    rotation_deg: Option<At<f64>>,
    /// Luminous flux of each luminaire, lm; that of the file's candelas unless given.
    flux_lm: Option<At<f64>>,
    /// Factor on the light, dimming or stock: 1 unless given.
    multiplier: Option<At<f64>>,
    /// Share of the light that is left in use, 0 to 1; 1 unless given.
    maintenance_factor: Option<At<f64>>,
    /// Spectrum of the light: illuminant name, colour temperature in K, or a CSV file of relative values.
    /// Equal energy ("E") unless given.
    spectrum: Option<At<SpectrumDef>>,
    /// Luminaires along `column_spacing_m`; 1 unless given.
    columns: Option<At<u32>>,
    /// From one luminaire to the next in a row, m.
    column_spacing_m: Option<At<[f64; 3]>>,
    /// Rows along `row_spacing_m`; 1 unless given.
    rows: Option<At<u32>>,
    /// From one row to the next, m.
    row_spacing_m: Option<At<[f64; 3]>>,
    /// Group of lamps that the states dim together.
    group: Option<String>,
    /// Electric power of each luminaire, W; that of the file unless given.
    #[serde(rename = "power_W")]
    power_w: Option<At<f64>>,
    /// General colour rendering index, for requirements; that of the file's lamps unless given.
    ra: Option<At<f64>>,
}

impl LuminaireDef {
    /// Group of lamps.
    pub(crate) fn group(&self) -> Option<&str> {
        self.group.as_deref()
    }
}

/// Luminaires of one kind, hung alike.
#[derive(Clone, Debug)]
pub struct LuminaireRow {
    /// The photometric file.
    pub file: PathBuf,
    /// What is in it.
    pub bytes: Vec<u8>,
    /// Photometric centres, metres, z up.
    pub positions: Vec<DVec3>,
    /// Columns: where C0, C90 and the direction opposite to the aim point.
    pub axes: DMat3,
    /// Luminous flux of each, lm, where it replaces that of the file.
    pub flux_lm: Option<f64>,
    /// Factor on the light.
    pub factor: f64,
    /// Relative spectrum.
    pub spectrum: Spectrum,
    /// Group of lamps that it is dimmed with.
    pub group: Option<String>,
    /// Electric power of each, W, where it replaces that of the file.
    pub power_w: Option<f64>,
    /// General colour rendering index, where it replaces that of the file.
    pub ra: Option<f64>,
    /// Line of the table in the scene file.
    pub line: usize,
}

impl LuminaireRow {
    /// Luminaires aimed down with C0 along x, as their file has them; `positions` in metres, z up.
    #[must_use]
    pub fn aimed_down(bytes: Vec<u8>, positions: Vec<DVec3>) -> Self {
        Self {
            file: "lamp.ies".into(),
            bytes,
            positions,
            axes: DMat3::IDENTITY,
            flux_lm: None,
            factor: 1.0,
            spectrum: Spectrum::constant(1.0),
            group: None,
            power_w: None,
            ra: None,
            line: 1,
        }
    }
}

/// Most luminaires of one table.
const MOST: u64 = 100_000;

/// Checks one table.
pub(crate) fn resolve(files: &mut Files<'_>, axes: Axes, def: &At<LuminaireDef>) -> Result<LuminaireRow> {
    let source = files.source;
    let d = &def.value;
    let first = axes.to_internal(vector(source, &d.position_m, "position_m")?);
    let aim = d.aim.as_ref().map_or(Ok(DVec3::NEG_Z), |a| Ok(axes.to_internal(unit_vector(source, a, "aim")?)))?;
    check_number(source, d.rotation_deg.as_ref(), "rotation_deg")?;
    let rotation_deg = d.rotation_deg.as_ref().map_or(0.0, |r| r.value);
    let flux_lm = match &d.flux_lm {
        Some(f) => Some(positive(files, f, "flux_lm", f64::INFINITY)?),
        None => None,
    };
    let mut factor = 1.0;
    for (value, key, most) in
        [(&d.multiplier, "multiplier", f64::INFINITY), (&d.maintenance_factor, "maintenance_factor", 1.0)]
    {
        if let Some(value) = value {
            factor *= positive(files, value, key, most)?;
        }
    }
    let stated = |value: &Option<At<f64>>, key: &str, most: f64| {
        value.as_ref().map(|v| positive(files, v, key, most)).transpose()
    };
    let (power_w, ra) = (stated(&d.power_w, "power_W", f64::INFINITY)?, stated(&d.ra, "ra", 100.0)?);
    let spectrum = match &d.spectrum {
        Some(spectrum) => material::relative(files, "a luminaire", spectrum)?,
        None => Spectrum::constant(1.0),
    };
    if spectrum.luminous() <= 0.0 {
        return Err(source.impossible(def.offset, "the luminaire's spectrum holds no visible light to scale"));
    }
    let mut positions = vec![first];
    let columns = step(files, axes, [d.columns.as_ref(), d.rows.as_ref()], 0, d.column_spacing_m.as_ref())?;
    let rows = step(files, axes, [d.columns.as_ref(), d.rows.as_ref()], 1, d.row_spacing_m.as_ref())?;
    for (count, step) in [columns, rows] {
        positions = (0..count)
            .flat_map(|k| positions.iter().map(move |p| *p + step * f64::from(k)).collect::<Vec<_>>())
            .collect();
    }
    let bytes = files.read(&d.file)?;
    Ok(LuminaireRow {
        file: files.path(&d.file.value),
        bytes,
        positions,
        axes: hung(aim, rotation_deg),
        flux_lm,
        factor,
        spectrum,
        group: d.group.clone(),
        power_w,
        ra,
        line: source.line(def.offset),
    })
}

/// A number of zero or more, up to `most`.
fn positive(files: &Files<'_>, number: &At<f64>, key: &str, most: f64) -> Result<f64> {
    check_number(files.source, Some(number), key)?;
    if (0.0..=most).contains(&number.value) {
        return Ok(number.value);
    }
    let mend =
        if most.is_finite() { format!("give a number from 0 to {most}") } else { "nothing less than 0 can be".into() };
    Err(files.source.impossible(number.offset, format!("{key} = {} cannot be", number.value)).mend(mend))
}

/// Number and step of columns (0) or rows (1).
fn step(
    files: &Files<'_>,
    axes: Axes,
    counts: [Option<&At<u32>>; 2],
    which: usize,
    spacing: Option<&At<[f64; 3]>>,
) -> Result<(u32, DVec3)> {
    let (count_key, key) = [("columns", "column_spacing_m"), ("rows", "row_spacing_m")][which];
    let all: u64 = counts.iter().map(|c| c.map_or(1, |c| u64::from(c.value))).product();
    match (counts[which], spacing) {
        (None, None) => Ok((1, DVec3::ZERO)),
        (None, Some(spacing)) => Err(files
            .source
            .malformed(spacing.offset, format!("{key} without {count_key}"))
            .mend(format!("add {count_key}"))),
        (Some(count), _) if !(1..=MOST).contains(&all) => Err(files
            .source
            .malformed(count.offset, format!("{all} luminaires, not 1 to {MOST}"))
            .mend("correct columns and rows")),
        (Some(count), None) if count.value > 1 => Err(files
            .source
            .malformed(count.offset, format!("{count_key} without {key}"))
            .mend(format!("add {key} = [2, 0, 0]"))),
        (Some(_), None) => Ok((1, DVec3::ZERO)),
        (Some(count), Some(spacing)) => {
            let step = vector(files.source, spacing, key)?;
            Ok((count.value, axes.to_internal(step)))
        }
    }
}

/// Axes of a luminaire that is turned the shortest way from hanging straight down, then about its aim.
fn hung(aim: DVec3, rotation_deg: f64) -> DMat3 {
    let turn = DMat3::from_axis_angle(DVec3::Z, rotation_deg.to_radians());
    if aim.z < -1.0 + 1e-12 {
        return turn;
    }
    if aim.z > 1.0 - 1e-12 {
        return DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)) * turn;
    }
    DMat3::from_quat(DQuat::from_rotation_arc(DVec3::NEG_Z, aim)) * turn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_luminaire_hangs_as_its_aim_and_turn_say() {
        let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-12, "{a} {b}");
        let down = hung(DVec3::NEG_Z, 0.0);
        near(down.x_axis, DVec3::X);
        near(down.y_axis, DVec3::Y);
        near(hung(DVec3::NEG_Z, 90.0).x_axis, DVec3::Y);
        for aim in [DVec3::Y, DVec3::X, DVec3::Z, DVec3::new(0.6, 0.0, -0.8)] {
            let axes = hung(aim, 30.0);
            near(axes.z_axis, -aim);
            assert!((axes.determinant() - 1.0).abs() < 1e-12, "a turn, no mirror: {aim}");
        }
        near(hung(DVec3::Y, 0.0).x_axis, DVec3::X);
        near(hung(DVec3::Y, 0.0).y_axis, DVec3::Z);
    }
}
