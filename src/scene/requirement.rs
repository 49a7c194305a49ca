//! What a grid is to fulfil, and what the watts refer to.

use schemars::JsonSchema;
use serde::Deserialize;

use super::file::{At, GridDef, SceneFile};
use super::grid::Stage;
use super::load::{Files, check_number};
use super::{LightState, suggest};
use crate::Result;

/// A requirement on a grid in the terms of EN 12464-1; values are maintained ones (`maintenance_factor` of the luminaires).
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RequirementDef {
    /// Least mean illuminance, lx.
    mean_lx: Option<At<f64>>,
    /// Least uniformity U0, minimum over mean.
    uniformity: Option<At<f64>>,
    /// Least mean cylindrical illuminance, lx; wants `cylindrical = true`.
    cylindrical_lx: Option<At<f64>>,
    /// Largest unified glare rating; wants `ugr = true`.
    ugr: Option<At<f64>>,
    /// Least colour rendering index, by the data of the luminaires (`ra`).
    ra: Option<At<f64>>,
    /// State of the lights in which it is to hold; the scene as it stands unless given.
    state: Option<At<String>>,
}

/// Emergency lighting (EN 1838): direct light alone counts.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct EmergencyDef {
    /// Least illuminance, lx: 0.5 (open area) unless given; 1 on the middle line of an escape route.
    min_lx: Option<At<f64>>,
    /// Largest ratio of the greatest to the least illuminance; 40 unless given.
    max_over_min: Option<At<f64>>,
    /// State of the lights in which it is to hold; the scene as it stands unless given.
    state: Option<At<String>>,
}

/// What the watts of the luminaires refer to.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PowerDef {
    /// Material or object whose faces that look up are the floor.
    floor: At<String>,
    /// Grid to whose mean illuminance W/(m² 100 lx) refers.
    grid: Option<At<String>>,
}

/// A quantity of a grid that has a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Mean illuminance, lx: at least.
    Mean,
    /// Minimum over mean: at least.
    Uniformity,
    /// Mean cylindrical illuminance, lx: at least.
    Cylindrical,
    /// Unified glare rating: at most.
    Ugr,
    /// Colour rendering index: at least.
    Ra,
    /// Least direct illuminance, lx: at least.
    DirectMin,
    /// Greatest over least direct illuminance: at most.
    DirectRatio,
}

impl Quantity {
    /// Name in results, with its unit.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean_lx",
            Self::Uniformity => "uniformity_U0",
            Self::Cylindrical => "cylindrical_lx",
            Self::Ugr => "ugr",
            Self::Ra => "ra",
            Self::DirectMin => "direct_min_lx",
            Self::DirectRatio => "direct_max_over_min",
        }
    }

    /// Is the limit the most that may be?
    #[must_use]
    pub fn is_at_most(self) -> bool {
        matches!(self, Self::Ugr | Self::DirectRatio)
    }
}

/// A limit that a grid is to keep.
#[derive(Clone, Debug, PartialEq)]
pub struct Requirement {
    /// Number of the grid.
    pub grid: usize,
    /// Number of the state of the lights; the scene as it stands where there is none.
    pub state: Option<usize>,
    /// What is limited.
    pub quantity: Quantity,
    /// The limit.
    pub limit: f64,
}

/// What the watts of the luminaires refer to.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerBasis {
    /// Floor area, m².
    pub area_m2: f64,
    /// Grid to whose mean illuminance they are compared.
    pub grid: Option<usize>,
}

/// The requirements of all grids.
pub(crate) fn resolve(files: &Files<'_>, file: &SceneFile, states: &[LightState]) -> Result<Vec<Requirement>> {
    let source = files.source;
    let state = |name: &Option<At<String>>| -> Result<Option<usize>> {
        let Some(name) = name else { return Ok(None) };
        let names: Vec<&str> = states.iter().map(|s| s.name.as_str()).collect();
        let found = names.iter().position(|n| *n == name.value);
        let unknown = || source.malformed(name.offset, format!("no state of the lights is called \"{}\"", name.value));
        found.map(Some).ok_or_else(|| unknown().mend(suggest::mend(&name.value, &names)))
    };
    let mut all = Vec::new();
    for (grid, def) in file.grids.iter().enumerate() {
        for (value, quantity, state_name) in asked(&def.value) {
            check_number(source, Some(value), quantity.name())?;
            if value.value <= 0.0 {
                return Err(
                    source.impossible(value.offset, format!("{} = {} asks for nothing", quantity.name(), value.value))
                );
            }
            let (has, key) = match quantity {
                Quantity::Ugr => (def.value.ugr, "ugr = true"),
                Quantity::Cylindrical => (def.value.cylindrical, "cylindrical = true"),
                _ => (true, ""),
            };
            if !has {
                let message = format!("grid \"{}\" does not measure what is required of it", def.value.name.value);
                return Err(source.malformed(value.offset, message).mend(format!("add {key} to the grid")));
            }
            all.push(Requirement { grid, state: state(state_name)?, quantity, limit: value.value });
        }
        if let Some(e) = &def.value.emergency {
            let state = state(&e.state)?;
            for (value, quantity, usual) in
                [(&e.min_lx, Quantity::DirectMin, 0.5), (&e.max_over_min, Quantity::DirectRatio, 40.0)]
            {
                check_number(source, value.as_ref(), quantity.name())?;
                all.push(Requirement { grid, state, quantity, limit: value.as_ref().map_or(usual, |v| v.value) });
            }
        }
    }
    Ok(all)
}

/// A limit in the file, and the state in which it holds.
type Asked<'a> = (&'a At<f64>, Quantity, &'a Option<At<String>>);

fn asked(def: &GridDef) -> Vec<Asked<'_>> {
    let Some(r) = &def.requirement else { return Vec::new() };
    let list = [
        (&r.mean_lx, Quantity::Mean),
        (&r.uniformity, Quantity::Uniformity),
        (&r.cylindrical_lx, Quantity::Cylindrical),
        (&r.ugr, Quantity::Ugr),
        (&r.ra, Quantity::Ra),
    ];
    list.into_iter().filter_map(|(value, quantity)| Some((value.as_ref()?, quantity, &r.state))).collect()
}

/// Floor and grid that the watts refer to.
pub(crate) fn power(files: &Files<'_>, stage: &Stage<'_>, file: &SceneFile) -> Result<Option<PowerBasis>> {
    let Some(def) = &file.power else { return Ok(None) };
    let (source, d) = (files.source, &def.value);
    let chosen = super::grid::faces_named(source, stage, &d.floor)?;
    let area_m2: f64 = chosen.iter().filter(|f| f.normal.z > 0.5).map(|f| f.area_m2 * f.normal.z).sum();
    if area_m2 <= 0.0 {
        let message = format!("no face of `{}` looks up: it is no floor", d.floor.value);
        return Err(source.impossible(d.floor.offset, message).mend("name the floor's material or object"));
    }
    let Some(name) = &d.grid else { return Ok(Some(PowerBasis { area_m2, grid: None })) };
    let names: Vec<&str> = file.grids.iter().map(|g| g.value.name.value.as_str()).collect();
    let grid = names.iter().position(|n| *n == name.value).ok_or_else(|| {
        let error = source.malformed(name.offset, format!("no grid is called \"{}\"", name.value));
        error.mend(suggest::mend(&name.value, &names))
    })?;
    Ok(Some(PowerBasis { area_m2, grid: Some(grid) }))
}
