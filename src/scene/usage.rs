//! How a building is used over the year: hours of presence, blinds.

use schemars::JsonSchema;
use serde::Deserialize;

use super::file::At;
use super::load::Files;
use super::{Face, Material, Scene, suggest};
use crate::{Error, Result};

/// What a year of daylight is judged by.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AnnualDef {
    /// First and last hour of presence on every day, standard time; [8, 18] unless given.
    hours: Option<At<[f64; 2]>>,
    /// Presence by the hour, in place of `hours`: a CSV file with the header `occupied` and one line for each hour of the
    /// year, 1 or 0.
    schedule: Option<At<String>>,
}

/// Blinds before a group of windows.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BlindDef {
    /// Names of materials or objects: the glass behind the blinds.
    panes: At<Vec<At<String>>>,
    /// Share of the diffuse light that closed blinds let by; 0.05 unless given.
    transmittance: Option<At<f64>>,
    /// "lm-83" closes them in hours in which more than 2 % of a grid's points get 1,000 lx or more straight from the sun;
    /// "open"; "closed"; or a CSV file with the header `closed` and one line for each hour of the year, 1 or 0. "lm-83"
    /// unless given.
    control: Option<At<String>>,
}

/// Hours of presence.
#[derive(Clone, Debug, PartialEq)]
pub enum Occupancy {
    /// From the first hour to the last of every day, standard time.
    Daily(f64, f64),
    /// By the hour of the year.
    Hourly(Vec<bool>),
}

impl Default for Occupancy {
    /// 8 to 18 h, as LM-83 has it.
    fn default() -> Self {
        Self::Daily(8.0, 18.0)
    }
}

/// When blinds are closed.
#[derive(Clone, Debug, PartialEq)]
pub enum BlindControl {
    /// By the sun on the grids, as LM-83 has it.
    Sun,
    /// Always, or never.
    Fixed(bool),
    /// By the hour of the year.
    Hourly(Vec<bool>),
}

/// Blinds before a group of windows.
#[derive(Clone, Debug, PartialEq)]
pub struct Blind {
    /// Materials or objects of the panes.
    pub panes: Vec<String>,
    /// Share of the diffuse light that they let by when closed.
    pub transmittance: f64,
    /// When they are closed.
    pub control: BlindControl,
}

impl Blind {
    /// Do they hang before this face?
    #[must_use]
    pub fn covers(&self, scene: &Scene, face: &Face) -> bool {
        let is_glass = matches!(scene.materials[face.material].kind, super::MaterialKind::Glass { .. });
        is_glass && self.names(scene, face)
    }

    /// Is this face among their panes, whatever it is made of?
    #[must_use]
    pub fn names(&self, scene: &Scene, face: &Face) -> bool {
        let names = [&scene.materials[face.material].name, &scene.objects[face.object]];
        self.panes.iter().any(|p| names.contains(&p))
    }
}

const USUAL_TRANSMITTANCE: f64 = 0.05;
/// Hours of a year, and of a leap year.
const YEARS: [usize; 2] = [8760, 8784];
/// Most groups of blinds.
const MOST_BLINDS: usize = 32;

pub(crate) fn occupancy(files: &mut Files<'_>, def: Option<&At<AnnualDef>>) -> Result<Occupancy> {
    let source = files.source;
    match def.map(|d| (&d.value.hours, &d.value.schedule)) {
        None | Some((None, None)) => Ok(Occupancy::default()),
        Some((Some(hours), Some(_))) => {
            Err(source.malformed(hours.offset, "presence is stated twice").mend("keep hours or schedule"))
        }
        Some((None, Some(file))) => Ok(Occupancy::Hourly(hourly(files, file, "occupied")?)),
        Some((Some(hours), None)) => {
            let [from, to] = hours.value;
            if from.is_finite() && to.is_finite() && 0.0 <= from && from < to && to <= 24.0 {
                return Ok(Occupancy::Daily(from, to));
            }
            Err(source
                .malformed(hours.offset, format!("hours = [{from}, {to}] is no part of a day"))
                .mend("hours = [8, 18]"))
        }
    }
}

pub(crate) fn blinds(
    files: &mut Files<'_>,
    defs: &[At<BlindDef>],
    materials: &[Material],
    objects: &[String],
) -> Result<Vec<Blind>> {
    let source = files.source;
    if let Some(def) = defs.get(MOST_BLINDS) {
        return Err(source.malformed(def.offset, format!("more than {MOST_BLINDS} groups of blinds")));
    }
    defs.iter().map(|def| blind(files, def, materials, objects)).collect()
}

fn blind(files: &mut Files<'_>, def: &At<BlindDef>, materials: &[Material], objects: &[String]) -> Result<Blind> {
    let source = files.source;
    let names: Vec<&str> =
        materials.iter().map(|m| m.name.as_str()).chain(objects.iter().map(String::as_str)).collect();
    for name in &def.value.panes.value {
        if !names.contains(&name.value.as_str()) {
            return Err(source
                .malformed(name.offset, format!("no material or object is called `{}`", name.value))
                .mend(suggest::mend(&name.value, &names)));
        }
    }
    if def.value.panes.value.is_empty() {
        return Err(source
            .malformed(def.value.panes.offset, "these blinds hang before no pane")
            .mend("panes = [\"glazing\"]"));
    }
    let transmittance = match &def.value.transmittance {
        None => USUAL_TRANSMITTANCE,
        Some(t) if (0.0..=1.0).contains(&t.value) => t.value,
        Some(t) => {
            return Err(source
                .impossible(t.offset, format!("transmittance = {} is not within 0 to 1", t.value))
                .mend("a share of the light, as 0.05"));
        }
    };
    let control = match def.value.control.as_ref().map(|c| (c, c.value.as_str())) {
        None | Some((_, "lm-83")) => BlindControl::Sun,
        Some((_, "open")) => BlindControl::Fixed(false),
        Some((_, "closed")) => BlindControl::Fixed(true),
        Some((file, name)) if name.contains('.') => BlindControl::Hourly(hourly(files, file, "closed")?),
        Some((other, name)) => {
            return Err(source
                .malformed(other.offset, format!("unknown control `{name}`"))
                .mend(suggest::mend(name, &["lm-83", "open", "closed"])));
        }
    };
    let panes = def.value.panes.value.iter().map(|p| p.value.clone()).collect();
    Ok(Blind { panes, transmittance, control })
}

/// A column of ones and zeros, one for each hour of a year.
fn hourly(files: &mut Files<'_>, name: &At<String>, header: &str) -> Result<Vec<bool>> {
    let bytes = files.read(name)?;
    let path = files.path(&name.value);
    parse_hours(&bytes, header).map_err(|e| e.in_file(&path))
}

fn parse_hours(bytes: &[u8], header: &str) -> Result<Vec<bool>> {
    let text = super::text(bytes)?;
    let mut lines = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())).filter(|(_, l)| !l.is_empty());
    if lines.next().map(|(_, l)| l) != Some(header) {
        return Err(Error::malformed(format!("the first line is not `{header}`"))
            .mend(format!("begin with the header `{header}`, then one line for each hour, 1 or 0"))
            .at_line(1));
    }
    let values: Vec<bool> = lines
        .map(|(line, text)| match text {
            "0" => Ok(false),
            "1" => Ok(true),
            _ => Err(Error::malformed(format!("`{text}` is neither 1 nor 0")).mend("write 1 or 0").at_line(line)),
        })
        .collect::<Result<_>>()?;
    if YEARS.contains(&values.len()) {
        return Ok(values);
    }
    Err(Error::malformed(format!("{} hours, expected 8760, or 8784 in a leap year", values.len()))
        .mend("give one line for each hour of the weather file"))
}

impl Occupancy {
    /// Is somebody there in an hour of the year whose middle is `middle_h` hours from midnight?
    #[must_use]
    pub fn holds(&self, index: usize, middle_h: f64) -> bool {
        match self {
            Self::Daily(from, to) => (*from..*to).contains(&middle_h),
            Self::Hourly(hours) => hours.get(index).copied().unwrap_or(false),
        }
    }

    /// Number of hours that it tells, where it tells each.
    #[must_use]
    pub fn told(&self) -> Option<usize> {
        match self {
            Self::Daily(..) => None,
            Self::Hourly(hours) => Some(hours.len()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_schedule_has_every_hour_of_a_year() {
        let file = |n: usize| format!("closed\n{}", "1\n0\n".repeat(n / 2));
        assert_eq!(parse_hours(file(8760).as_bytes(), "closed").unwrap().len(), 8760);
        let short = parse_hours(file(100).as_bytes(), "closed").unwrap_err().to_string();
        assert!(short.contains("100 hours"), "{short}");
        let wrong = parse_hours(b"closed\n1\nx\n", "closed").unwrap_err().in_file("blinds.csv").to_string();
        assert!(wrong.starts_with("blinds.csv:3"), "{wrong}");
        assert!(parse_hours(b"", "closed").is_err() && parse_hours(b"open\n", "closed").is_err());
    }

    #[test]
    fn presence_is_told_by_the_middle_of_the_hour() {
        let usual = Occupancy::default();
        let present = (0..24).filter(|h| usual.holds(*h, *h as f64 + 0.5)).count();
        assert_eq!(present, 10);
    }
}
