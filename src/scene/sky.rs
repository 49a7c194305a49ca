//! Sky, sun and site: the user's words and numbers, checked for form.
//!
//! What they mean physically (where the sun stands, which sky the weather makes) is worked out by
//! `light::Daylight`, which reads the [`Daytime`] made here.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;
use toml::value::{Datetime, Offset};

use super::file::{At, Source, SpectrumDef};
use super::load::Files;
use super::{material, suggest};
use crate::spectrum::{self, Spectrum};
use crate::{Error, Result};

/// The sky, the sun and the ground.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SkyDef {
    /// "cie-1" to "cie-15", "cie-overcast", "cie-clear", "uniform", "perez" or "none".
    pub(crate) model: At<String>,
    /// Diffuse illuminance of an unobstructed horizontal plane, lx.
    horizontal_illuminance_lx: Option<At<f64>>,
    /// Direct illuminance on a plane that faces the sun, lx; no sun where neither this nor its irradiance is given.
    direct_normal_illuminance_lx: Option<At<f64>>,
    /// Diffuse irradiance of an unobstructed horizontal plane, W/m².
    #[serde(rename = "diffuse_horizontal_irradiance_W_m2")]
    diffuse_horizontal_irradiance_w_m2: Option<At<f64>>,
    /// Direct irradiance on a plane that faces the sun, W/m².
    #[serde(rename = "direct_normal_irradiance_W_m2")]
    direct_normal_irradiance_w_m2: Option<At<f64>>,
    /// Altitude of the sun above the horizon, degrees, where no [site] with a time gives it.
    sun_altitude_deg: Option<At<f64>>,
    /// Azimuth of the sun, degrees clockwise from true north.
    sun_azimuth_deg: Option<At<f64>>,
    /// Spectrum of the sky: illuminant name, colour temperature in K, or a CSV file of relative values. "D65" unless given.
    spectrum: Option<At<SpectrumDef>>,
    /// Spectrum of the sun; that of the sky unless given.
    sun_spectrum: Option<At<SpectrumDef>>,
    /// Reflectance of the endless ground, 0 to 1; 0.2 unless given.
    ground_reflectance: Option<At<f64>>,
}

/// Place and time.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SiteDef {
    /// Degrees, north positive; that of the weather file unless given.
    latitude_deg: Option<At<f64>>,
    /// Degrees, east positive; that of the weather file unless given.
    longitude_deg: Option<At<f64>>,
    /// Date, time and zone: "2026-03-21T12:00:00+01:00".
    time: Option<At<String>>,
    /// EPW or WEA file, for model = "perez".
    weather: Option<At<String>>,
    /// Altitude from which the sun counts for the sunlight hours of EN 17037, degrees: each country names one. 0 unless given.
    least_sun_deg: Option<At<f64>>,
}

/// A sky by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkyName {
    /// No sky; the sun and the ground may still shine.
    None,
    /// CIE S 011 type 1 to 15.
    Cie(u8),
    /// The traditional overcast sky.
    Overcast,
    /// The same luminance everywhere.
    Uniform,
    /// Perez all-weather.
    Perez,
}

/// What a quantity of light is stated in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// Illuminance, lx.
    Lux(f64),
    /// Irradiance of daylight, W/m².
    Watts(f64),
}

impl Amount {
    /// Is there any?
    #[must_use]
    pub fn is_some(self) -> bool {
        let (Self::Lux(v) | Self::Watts(v)) = self;
        v > 0.0
    }
}

/// A moment on the clock of a zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockTime {
    /// Year.
    pub year: i32,
    /// Month, 1 to 12.
    pub month: u32,
    /// Day of the month.
    pub day: u32,
    /// Hours from midnight, local.
    pub hours: f64,
    /// Zone against universal time, hours, east positive.
    pub utc_offset_h: f64,
    /// Stated in universal time (`Z`), which says nothing of the place.
    pub is_utc: bool,
}

/// A value with its line in the scene file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed<T> {
    /// The value.
    pub value: T,
    /// Line, from 1.
    pub line: usize,
}

/// Where and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// Line of the table.
    pub line: usize,
    /// Degrees, north positive.
    pub latitude_deg: Option<f64>,
    /// Degrees, east positive.
    pub longitude_deg: Option<Placed<f64>>,
    /// When.
    pub time: Option<Placed<ClockTime>>,
    /// The weather file and its bytes.
    pub weather: Option<(PathBuf, Vec<u8>)>,
    /// Altitude from which the sun counts for hours of possible sunlight, degrees.
    pub least_sun_deg: f64,
}

/// Everything that is asked of sky, sun and ground.
#[derive(Clone, Debug)]
pub struct Daytime {
    /// The scene file, for errors.
    pub file: PathBuf,
    /// The sky's model.
    pub model: Placed<SkyName>,
    /// Diffuse horizontal light.
    pub diffuse: Option<Placed<Amount>>,
    /// Direct normal light of the sun.
    pub direct: Option<Placed<Amount>>,
    /// Altitude and azimuth of the sun (clockwise from true north), degrees.
    pub sun_deg: Option<Placed<(f64, f64)>>,
    /// Where and when.
    pub site: Option<Site>,
    /// Spectrum of the sky, relative.
    pub spectrum: Spectrum,
    /// Spectrum of the sun, relative.
    pub sun_spectrum: Spectrum,
    /// Reflectance of the ground.
    pub ground_reflectance: f64,
    /// True north, clockwise from +y of the program's axes, degrees.
    pub north_deg: f64,
}

/// Names of sky models, for "did you mean".
const MODELS: [&str; 20] = [
    "none",
    "uniform",
    "perez",
    "cie-overcast",
    "cie-clear",
    "cie-1",
    "cie-2",
    "cie-3",
    "cie-4",
    "cie-5",
    "cie-6",
    "cie-7",
    "cie-8",
    "cie-9",
    "cie-10",
    "cie-11",
    "cie-12",
    "cie-13",
    "cie-14",
    "cie-15",
];
/// The type that CIE calls clear, low turbidity.
const CIE_CLEAR: u8 = 12;
/// More light than the day has: lx and W/m².
const MOST_LX: f64 = 200_000.0;
const MOST_W_M2: f64 = 1500.0;
const USUAL_GROUND: f64 = 0.2;

/// Checks `[sky]` and `[site]`; `None` where there is neither sky nor sun.
pub(crate) fn resolve(
    files: &mut Files<'_>,
    sky: Option<&At<SkyDef>>,
    site: Option<&At<SiteDef>>,
    north_deg: f64,
) -> Result<Option<Daytime>> {
    let site = site.map(|s| self::site(files, s)).transpose()?;
    let Some(sky) = sky else {
        if site.is_some() {
            files.warnings.push("[site] has no use without a [sky]".into());
        }
        return Ok(None);
    };
    let source = files.source;
    let def = &sky.value;
    let name = model(source, &def.model)?;
    let diffuse =
        amount(source, &def.horizontal_illuminance_lx, &def.diffuse_horizontal_irradiance_w_m2, "diffuse horizontal")?;
    let direct =
        amount(source, &def.direct_normal_illuminance_lx, &def.direct_normal_irradiance_w_m2, "direct normal")?;
    if name == SkyName::None && !direct.is_some_and(|d| d.value.is_some()) {
        return Ok(None);
    }
    let usual = spectrum::illuminant("D65").unwrap_or_else(|| Spectrum::constant(1.0));
    let spectrum = light(files, def.spectrum.as_ref(), usual)?;
    let sun_spectrum = light(files, def.sun_spectrum.as_ref(), spectrum.clone())?;
    let ground_reflectance = match &def.ground_reflectance {
        Some(g) => within(source, g, "ground_reflectance", 0.0, 1.0, "give a share from 0 to 1; grass is about 0.2")?,
        None => USUAL_GROUND,
    };
    Ok(Some(Daytime {
        file: source.path.to_path_buf(),
        model: Placed { value: name, line: source.line(def.model.offset) },
        diffuse,
        direct,
        sun_deg: sun(source, def)?,
        site,
        spectrum,
        sun_spectrum,
        ground_reflectance,
        north_deg,
    }))
}

fn model(source: Source<'_>, name: &At<String>) -> Result<SkyName> {
    let numbered = name.value.strip_prefix("cie-").and_then(|n| n.parse::<u8>().ok()).filter(|n| (1..=15).contains(n));
    match (name.value.as_str(), numbered) {
        (_, Some(number)) => Ok(SkyName::Cie(number)),
        ("none", _) => Ok(SkyName::None),
        ("uniform", _) => Ok(SkyName::Uniform),
        ("perez", _) => Ok(SkyName::Perez),
        ("cie-overcast", _) => Ok(SkyName::Overcast),
        ("cie-clear", _) => Ok(SkyName::Cie(CIE_CLEAR)),
        (other, _) => Err(source
            .malformed(name.offset, format!("unknown sky model `{other}`"))
            .mend(suggest::mend(other, &MODELS))),
    }
}

/// A spectrum that holds visible light.
fn light(files: &mut Files<'_>, def: Option<&At<SpectrumDef>>, usual: Spectrum) -> Result<Spectrum> {
    let Some(def) = def else { return Ok(usual) };
    let spectrum = material::relative(files, "[sky]", def)?;
    if spectrum.luminous() > 0.0 {
        return Ok(spectrum);
    }
    Err(files
        .source
        .impossible(def.offset, "[sky]: its spectrum holds no visible light to scale")
        .mend("give a spectrum that reaches into 380 to 780 nm"))
}

/// A quantity in lux or in watts, not both.
fn amount(
    source: Source<'_>,
    lux: &Option<At<f64>>,
    watts: &Option<At<f64>>,
    what: &str,
) -> Result<Option<Placed<Amount>>> {
    let mend = "clear noon has about 100000 lx or 900 W/m² of direct light, 15000 lx or 120 W/m² of diffuse";
    match (lux, watts) {
        (Some(_), Some(w)) => Err(source
            .malformed(w.offset, format!("the {what} light is stated twice, in lx and in W/m²"))
            .mend("keep one of the two")),
        (Some(l), None) => {
            let value = Amount::Lux(within(source, l, &format!("the {what} illuminance"), 0.0, MOST_LX, mend)?);
            Ok(Some(Placed { value, line: source.line(l.offset) }))
        }
        (None, Some(w)) => {
            let value = Amount::Watts(within(source, w, &format!("the {what} irradiance"), 0.0, MOST_W_M2, mend)?);
            Ok(Some(Placed { value, line: source.line(w.offset) }))
        }
        (None, None) => Ok(None),
    }
}

fn sun(source: Source<'_>, def: &SkyDef) -> Result<Option<Placed<(f64, f64)>>> {
    match (&def.sun_altitude_deg, &def.sun_azimuth_deg) {
        (None, None) => Ok(None),
        (Some(altitude), Some(azimuth)) => {
            let mend = "degrees above the horizon; an azimuth runs clockwise from true north";
            let h = within(source, altitude, "sun_altitude_deg", -90.0, 90.0, mend)?;
            let a = within(source, azimuth, "sun_azimuth_deg", -360.0, 360.0, mend)?;
            Ok(Some(Placed { value: (h, a), line: source.line(altitude.offset) }))
        }
        (Some(one), None) => Err(source
            .malformed(one.offset, "the sun has an altitude but no azimuth")
            .mend("add sun_azimuth_deg = 180")),
        (None, Some(one)) => Err(source
            .malformed(one.offset, "the sun has an azimuth but no altitude")
            .mend("add sun_altitude_deg = 30")),
    }
}

fn site(files: &mut Files<'_>, def: &At<SiteDef>) -> Result<Site> {
    let source = files.source;
    let degrees = |value: &Option<At<f64>>, key, most: f64| {
        let mend = "degrees; north and east are positive";
        value.as_ref().map(|v| within(source, v, key, -most, most, mend)).transpose()
    };
    let latitude_deg = degrees(&def.value.latitude_deg, "latitude_deg", 90.0)?;
    let longitude = degrees(&def.value.longitude_deg, "longitude_deg", 180.0)?;
    let longitude_deg = longitude
        .zip(def.value.longitude_deg.as_ref())
        .map(|(value, at)| Placed { value, line: source.line(at.offset) });
    let time = def.value.time.as_ref().map(|t| clock(source, t)).transpose()?;
    let weather = match &def.value.weather {
        Some(name) => Some((files.path(&name.value), files.read(name)?)),
        None => None,
    };
    let least = def.value.least_sun_deg.as_ref();
    let mend = "degrees above the horizon; EN 17037 names one for each country";
    let least_sun_deg = least.map_or(Ok(0.0), |v| within(source, v, "least_sun_deg", 0.0, 60.0, mend))?;
    Ok(Site { line: source.line(def.offset), latitude_deg, longitude_deg, time, weather, least_sun_deg })
}

/// A date with time and zone (RFC 3339).
fn clock(source: Source<'_>, text: &At<String>) -> Result<Placed<ClockTime>> {
    let wrong = |what: &str| {
        source
            .malformed(text.offset, format!("time = \"{}\": {what}", text.value))
            .mend("write date, time and zone: \"2026-03-21T12:00:00+01:00\", or Z for universal time")
    };
    let stamp: Datetime = text.value.parse().map_err(|_| wrong("no date and time"))?;
    let (Some(date), Some(time)) = (stamp.date, stamp.time) else { return Err(wrong("date or time is missing")) };
    let (utc_offset_h, is_utc) = match stamp.offset {
        Some(Offset::Z) => (0.0, true),
        Some(Offset::Custom { minutes }) => (f64::from(minutes) / 60.0, false),
        None => return Err(wrong("the time zone is missing")),
    };
    let seconds = f64::from(time.second.unwrap_or(0)) + f64::from(time.nanosecond.unwrap_or(0)) * 1e-9;
    let value = ClockTime {
        year: i32::from(date.year),
        month: u32::from(date.month),
        day: u32::from(date.day),
        hours: f64::from(time.hour) + f64::from(time.minute) / 60.0 + seconds / 3600.0,
        utc_offset_h,
        is_utc,
    };
    Ok(Placed { value, line: source.line(text.offset) })
}

/// A number in a range.
fn within(source: Source<'_>, number: &At<f64>, what: &str, low: f64, high: f64, mend: &str) -> Result<f64> {
    if (low..=high).contains(&number.value) {
        return Ok(number.value);
    }
    let message = format!("{what} = {} is not within {low} to {high}", number.value);
    Err(source.place(number.offset, Error::impossible(message)).mend(mend))
}
