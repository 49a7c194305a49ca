//! States of the lamps: how bright each group of them burns.

use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

use super::file::{At, SceneFile};
use super::load::{Files, check_number};
use super::suggest;
use crate::Result;

/// One state of the lights: a level for each group of lamps. Light is linear, so one run serves all states.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StateDef {
    /// Name, unique among the states.
    name: At<String>,
    /// Level of each group of lamps, 0 to 1.
    #[serde(default)]
    levels: BTreeMap<String, At<f64>>,
    /// Level of lamps of other groups and of no group, 0 to 1; 1 unless given.
    others: Option<At<f64>>,
    /// Does the light of the day count? Yes, unless given.
    daylight: Option<bool>,
}

/// One state of the lights.
#[derive(Clone, Debug, PartialEq)]
pub struct LightState {
    /// Name.
    pub name: String,
    /// Level of each group of lamps that is named, 0 to 1.
    pub levels: Vec<(String, f64)>,
    /// Level of all other lamps.
    pub others: f64,
    /// Whether daylight counts.
    pub daylight: bool,
}

impl LightState {
    /// Level of the lamps of a group.
    #[must_use]
    pub fn level(&self, group: Option<&str>) -> f64 {
        self.levels.iter().find(|(name, _)| Some(name.as_str()) == group).map_or(self.others, |(_, level)| *level)
    }
}

/// Names of the two states that every scene with lamps under a sky has.
pub const DAYLIGHT: &str = "daylight";
/// The lamps without the light of the day.
pub const ELECTRIC: &str = "electric";

/// Most states; most groups of lamps that differ in them.
const MOST: usize = 256;
const MOST_GROUPS: usize = 32;

/// Checks the states of a scene.
pub(crate) fn resolve(files: &Files<'_>, file: &SceneFile) -> Result<Vec<LightState>> {
    let source = files.source;
    let of_surfaces = file.materials.values().filter_map(|m| m.value.emission.as_ref()?.value.group.as_deref());
    let mut groups: Vec<&str> = of_surfaces.chain(file.luminaires.iter().filter_map(|l| l.value.group())).collect();
    groups.sort_unstable();
    groups.dedup();
    let mut states: Vec<LightState> = Vec::new();
    for def in &file.states {
        let d = &def.value;
        let name = d.name.value.trim();
        let is_taken = [DAYLIGHT, ELECTRIC, ""].contains(&name) || states.iter().any(|s| s.name == name);
        if is_taken || states.len() == MOST {
            let message = format!("the name \"{name}\" of a state is empty or taken, or there are more than {MOST}");
            let mend = format!("give each state its own name; \"{DAYLIGHT}\" and \"{ELECTRIC}\" are there already");
            return Err(source.malformed(d.name.offset, message).mend(mend));
        }
        let level = |level: &At<f64>, key: &str| {
            check_number(source, Some(level), key)?;
            let is_level = (0.0..=1.0).contains(&level.value);
            is_level.then_some(level.value).ok_or_else(|| {
                source
                    .impossible(level.offset, format!("{key} = {} is no level", level.value))
                    .mend("give 0 (off) to 1 (as the scene has it)")
            })
        };
        let mut levels = Vec::new();
        for (group, value) in &d.levels {
            if !groups.contains(&group.as_str()) {
                let message = format!("state \"{name}\": no lamp is of group `{group}`");
                return Err(source.malformed(value.offset, message).mend(suggest::mend(group, &groups)));
            }
            levels.push((group.clone(), level(value, group)?));
        }
        let others = d.others.as_ref().map_or(Ok(1.0), |o| level(o, "others"))?;
        states.push(LightState { name: name.to_owned(), levels, others, daylight: d.daylight.unwrap_or(true) });
    }
    if let Some(first) = file.states.first().filter(|_| groups.len() > MOST_GROUPS) {
        let message = format!("{} groups of lamps are more than the {MOST_GROUPS} allowed", groups.len());
        return Err(source.malformed(first.offset, message).mend("let lamps that burn alike share a group"));
    }
    Ok(states)
}
