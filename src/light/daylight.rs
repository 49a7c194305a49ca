//! The daylight of a moment: sky, sun and ground with their spectra and directions.
//!
//! In: the [`Daytime`] of a scene. Out: [`Daylight`]. Here the sun finds its place, the weather its hour and the amounts
//! their lux; whatever cannot be is told with the line of the scene file.

use glam::DVec3;

use super::sky::{PerezInput, Sky, SkyModel, USUAL_WATER_CM, cie_coefficients, irradiance_of};
use super::sun::{Air, Moment, Place, SunPosition};
use super::weather::{Weather, check_zone};
use crate::scene::{Amount, Daytime, Placed, Scene, Site, SkyName};
use crate::spectrum::Spectrum;
use crate::{Error, Result};

/// Sky, sun and ground, ready for rays.
#[derive(Clone, Debug)]
pub struct Daylight {
    /// How the sky's luminance is spread; `None` without a sky.
    pub sky: Option<Sky>,
    /// Unit vector to the sun, z up; `None` where it does not shine.
    pub sun: Option<DVec3>,
    /// Diffuse spectral irradiance of an unobstructed horizontal plane, W/(m² nm).
    pub sky_irradiance: Spectrum,
    /// Spectral irradiance of a plane that faces the sun, W/(m² nm).
    pub sun_irradiance: Spectrum,
    /// Reflectance of the ground.
    pub ground_reflectance: f64,
    /// What was found, for the record: name and value.
    pub facts: Vec<(String, String)>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Horizontal illuminance of the sky for which coefficients are worked out, lx: they do not depend on it.
const COEFFICIENT_LX: f64 = 10_000.0;

/// The sun's illuminance face on over that of a clear sky on the ground (CIE S 011, type 12, sun at 45°: 5 to 8).
const CLEAR_SUN: f64 = 6.0;

/// Amounts of a moment and what its sky looks like.
struct Light {
    diffuse_lx: f64,
    direct_lx: f64,
    model: Option<SkyModel>,
    facts: Vec<(String, String)>,
}

impl Daylight {
    /// The daylight of a scene, if it has any.
    ///
    /// # Errors
    /// A sun below the horizon, a place or a time that is missing or cannot be, weather without that hour.
    pub fn new(scene: &Scene) -> Result<Option<Self>> {
        scene.daytime.as_ref().map(Self::of).transpose()
    }

    fn of(day: &Daytime) -> Result<Self> {
        let mut warnings = Vec::new();
        let weather = read_weather(day)?;
        let position = position(day, weather.as_ref(), &mut warnings)?;
        let light = amounts(day, weather.as_ref(), position.as_ref())?;
        let needs_sun = light.direct_lx > 0.0 || light.model.is_some_and(|m| m.needs_sun());
        let sun = match &position {
            Some(p) if p.value.altitude_deg > 0.0 => Some(p.value.direction(day.north_deg)),
            Some(p) if needs_sun => return Err(night(day, p)),
            None if needs_sun => return Err(no_sun(day)),
            _ => None,
        };
        let sky = light.model.map(|m| Sky::new(m, sun.unwrap_or(DVec3::Z)));
        if sky.is_some_and(|s| !s.luminance(DVec3::Z).is_finite()) {
            return Err(at(day, day.model.line, Error::impossible("this sky has no light at all"))
                .mend("check direct and diffuse amounts"));
        }
        let mut facts = light.facts;
        if let Some(p) = position.filter(|_| needs_sun) {
            facts.push(("sun altitude".into(), format!("{:.3}°", p.value.altitude_deg)));
            facts.push(("sun azimuth".into(), format!("{:.3}° clockwise from true north", p.value.azimuth_deg)));
        }
        facts.push(("diffuse horizontal illuminance".into(), format!("{:.1} lx", light.diffuse_lx)));
        facts.push(("direct normal illuminance".into(), format!("{:.1} lx", light.direct_lx)));
        Ok(Self {
            sky,
            sun: sun.filter(|_| light.direct_lx > 0.0),
            sky_irradiance: scaled(&day.spectrum, light.diffuse_lx),
            sun_irradiance: scaled(&day.sun_spectrum, light.direct_lx),
            ground_reflectance: day.ground_reflectance,
            facts,
            warnings,
        })
    }

    /// A sky of the same luminance everywhere, in the spectra and over the ground of a scene: for daylight coefficients.
    #[must_use]
    pub(crate) fn uniform(day: &Daytime) -> Self {
        Self {
            sky: Some(Sky::new(SkyModel::Uniform, DVec3::Z)),
            sun: None,
            sky_irradiance: scaled(&day.spectrum, COEFFICIENT_LX),
            sun_irradiance: scaled(&day.sun_spectrum, COEFFICIENT_LX),
            ground_reflectance: day.ground_reflectance,
            facts: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// The same with a sun as strong as under a clear sky.
    #[must_use]
    pub(crate) fn with_clear_sun(mut self, sun: DVec3) -> Self {
        self.sun = Some(sun);
        self.sun_irradiance = self.sun_irradiance.scaled(CLEAR_SUN);
        self
    }

    /// Horizontal illuminance under the whole sky without the sun, lx: what daylight factors refer to.
    #[must_use]
    pub fn diffuse_horizontal_lx(&self) -> f64 {
        if self.sky.is_some() { self.sky_irradiance.luminous() } else { 0.0 }
    }
}

/// A relative spectrum with an illuminance in lx.
fn scaled(spectrum: &Spectrum, lx: f64) -> Spectrum {
    spectrum.scaled(lx / spectrum.luminous())
}

fn at(day: &Daytime, line: usize, error: Error) -> Error {
    error.in_file(&day.file).at_line(line)
}

fn read_weather(day: &Daytime) -> Result<Option<Weather>> {
    let Some((path, bytes)) = day.site.as_ref().and_then(|s| s.weather.as_ref()) else { return Ok(None) };
    Weather::parse(bytes).map(Some).map_err(|e| e.in_file(path))
}

/// Where the sun stands, with the line that says so; `None` where nothing tells it.
fn position(
    day: &Daytime,
    weather: Option<&Weather>,
    warnings: &mut Vec<String>,
) -> Result<Option<Placed<SunPosition>>> {
    let timed = day.site.as_ref().and_then(|s| s.time.map(|t| (s, t)));
    match (day.sun_deg, timed) {
        (Some(given), None) => {
            let (altitude_deg, azimuth_deg) = given.value;
            Ok(Some(Placed { value: SunPosition { altitude_deg, azimuth_deg }, line: given.line }))
        }
        (Some(given), Some(_)) => Err(at(
            day,
            given.line,
            Error::malformed("the sun is placed twice, by its angles and by the time of [site]"),
        )
        .mend("remove sun_altitude_deg and sun_azimuth_deg, or the time")),
        (None, None) => Ok(None),
        (None, Some((site, time))) => {
            let place = site_of(day, site, weather, warnings)?;
            if !time.value.is_utc {
                let line = site.longitude_deg.map_or(time.line, |l| l.line);
                check_zone(place.longitude_deg, time.value.utc_offset_h).map_err(|e| at(day, line, e))?;
            }
            let value =
                SunPosition::at(&moment(&time.value), place, Air::default()).map_err(|e| at(day, time.line, e))?;
            Ok(Some(Placed { value, line: time.line }))
        }
    }
}

fn moment(time: &crate::scene::ClockTime) -> Moment {
    Moment { year: time.year, month: time.month, day: time.day, hours: time.hours - time.utc_offset_h }
}

/// Degrees between a site and its weather: beyond the first it is told, beyond the second refused.
const FAR_DEG: f64 = 1.0;
const TOO_FAR_DEG: f64 = 10.0;

/// Where a site is: its own words, else its weather's.
///
/// # Errors
/// Without a place, and far from its weather.
pub(crate) fn site_of(
    day: &Daytime,
    site: &Site,
    weather: Option<&Weather>,
    warnings: &mut Vec<String>,
) -> Result<Place> {
    let theirs = weather.map(|w| w.place);
    let latitude_deg = site.latitude_deg.or(theirs.map(|p| p.latitude_deg));
    let longitude_deg = site.longitude_deg.map(|l| l.value).or(theirs.map(|p| p.longitude_deg));
    let (Some(latitude_deg), Some(longitude_deg)) = (latitude_deg, longitude_deg) else {
        return Err(at(day, site.line, Error::malformed("[site] has a time but no place"))
            .mend("add latitude_deg and longitude_deg (north and east positive), or a weather file"));
    };
    let own = Place { latitude_deg, longitude_deg };
    if let (Some(w), Some(theirs)) = (weather, theirs) {
        let east = (own.longitude_deg - theirs.longitude_deg + 180.0).rem_euclid(360.0) - 180.0;
        let apart = (own.latitude_deg - theirs.latitude_deg).abs().max(east.abs());
        let told = format!(
            "the site ({latitude_deg}, {longitude_deg}) lies {apart:.1} degrees from its weather of {} ({}, {})",
            w.name, theirs.latitude_deg, theirs.longitude_deg
        );
        if apart > TOO_FAR_DEG {
            return Err(at(day, site.line, Error::impossible(told))
                .mend("check the signs (north and east are positive), or take another file"));
        }
        if apart > FAR_DEG {
            warnings.push(told);
        }
    }
    Ok(own)
}

fn night(day: &Daytime, position: &Placed<SunPosition>) -> Error {
    let message = format!("the sun stands at {:.2} degrees: not above the horizon", position.value.altitude_deg);
    at(day, position.line, Error::impossible(message)).mend(
        "choose a time between sunrise and sunset (check zone and longitude), or a sky without sun: \"cie-overcast\"",
    )
}

fn no_sun(day: &Daytime) -> Error {
    at(day, day.model.line, Error::malformed("this sky needs to know where the sun stands"))
        .mend("add a [site] with latitude_deg, longitude_deg and time, or sun_altitude_deg and sun_azimuth_deg")
}

/// Lux of sky and sun, and the sky's shape.
fn amounts(day: &Daytime, weather: Option<&Weather>, position: Option<&Placed<SunPosition>>) -> Result<Light> {
    let model = match day.model.value {
        SkyName::Perez => return perez(day, weather, position),
        SkyName::None => None,
        SkyName::Overcast => Some(SkyModel::Overcast),
        SkyName::Uniform => Some(SkyModel::Uniform),
        SkyName::Cie(number) => cie_coefficients(number).map(SkyModel::Cie),
    };
    let watts = |amount: Option<Placed<Amount>>| match amount {
        Some(Placed { value: Amount::Watts(_), line }) => {
            Err(at(day, line, Error::malformed("irradiances become illuminances by model = \"perez\" alone"))
                .mend("state horizontal_illuminance_lx and direct_normal_illuminance_lx, or take \"perez\""))
        }
        Some(Placed { value: Amount::Lux(lx), .. }) => Ok(Some(lx)),
        None => Ok(None),
    };
    let diffuse = watts(day.diffuse)?;
    if model.is_some() && diffuse.is_none() {
        return Err(at(day, day.model.line, Error::malformed("the sky has no `horizontal_illuminance_lx`"))
            .mend("add horizontal_illuminance_lx = 10000"));
    }
    let diffuse_lx = if model.is_some() { diffuse.unwrap_or(0.0) } else { 0.0 };
    Ok(Light { diffuse_lx, direct_lx: watts(day.direct)?.unwrap_or(0.0), model, facts: Vec::new() })
}

/// Perez's sky, from stated amounts or from the weather of the hour.
fn perez(day: &Daytime, weather: Option<&Weather>, position: Option<&Placed<SunPosition>>) -> Result<Light> {
    let Some(position) = position else { return Err(no_sun(day)) };
    if position.value.altitude_deg <= 0.0 {
        return Err(night(day, position));
    }
    let time = day.site.as_ref().and_then(|s| s.time);
    let mut input = PerezInput {
        direct_normal_w_m2: 0.0,
        diffuse_horizontal_w_m2: 0.0,
        sun_zenith_deg: 90.0 - position.value.altitude_deg,
        // Without a date the sun is taken at its mean distance, which it has about 4 April.
        day_of_year: time.map_or(94, |t| moment(&t.value).day_of_year()),
        precipitable_water_cm: USUAL_WATER_CM,
    };
    let both = (day.direct.map(|d| d.value), day.diffuse.map(|d| d.value));
    let lux = match (both, weather, time) {
        ((Some(Amount::Watts(direct)), Some(Amount::Watts(diffuse))), _, _) => {
            (input.direct_normal_w_m2, input.diffuse_horizontal_w_m2) = (direct, diffuse);
            None
        }
        ((Some(Amount::Lux(direct)), Some(Amount::Lux(diffuse))), _, _) => {
            check_diffuse(day, diffuse)?;
            input = irradiance_of(direct, diffuse, input);
            Some((direct, diffuse))
        }
        ((None, None), Some(weather), Some(time)) => {
            let path = day.site.as_ref().and_then(|s| s.weather.as_ref()).map(|w| w.0.clone()).unwrap_or_default();
            let record = weather.at(&moment(&time.value)).map_err(|e| at(day, time.line, e))?;
            let (Some(direct), Some(diffuse)) = (record.direct_normal_w_m2, record.diffuse_horizontal_w_m2) else {
                return Err(Error::malformed("this hour has no direct or no diffuse irradiance")
                    .mend("choose another time, or state both amounts in [sky]")
                    .in_file(path)
                    .at_line(record.line));
            };
            (input.direct_normal_w_m2, input.diffuse_horizontal_w_m2) = (direct, diffuse);
            input.precipitable_water_cm = record.precipitable_water_cm().unwrap_or(USUAL_WATER_CM);
            None
        }
        _ => {
            return Err(at(day, day.model.line, Error::malformed("model = \"perez\" wants direct and diffuse light"))
                .mend("add direct_normal_irradiance_W_m2 and diffuse_horizontal_irradiance_W_m2 (or both in lx), or a weather file with a time in [site]"));
        }
    };
    check_diffuse(day, input.diffuse_horizontal_w_m2)?;
    let sky = input.sky();
    let (direct_lx, diffuse_lx) =
        lux.unwrap_or((input.direct_normal_w_m2 * sky.direct_lm_w, input.diffuse_horizontal_w_m2 * sky.diffuse_lm_w));
    let facts = vec![
        ("Perez clearness".into(), format!("{:.4}", sky.clearness)),
        ("Perez brightness".into(), format!("{:.4}", sky.brightness)),
    ];
    Ok(Light { diffuse_lx, direct_lx, model: Some(SkyModel::Perez(sky.coefficients)), facts })
}

fn check_diffuse(day: &Daytime, diffuse: f64) -> Result<()> {
    if diffuse > 0.0 {
        return Ok(());
    }
    Err(at(day, day.model.line, Error::impossible("the diffuse light is zero while the sun is up"))
        .mend("there is no daylight without a sky: give the diffuse amount, or model = \"none\" for the sun alone"))
}
