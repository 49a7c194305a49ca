//! The whole year: daylight coefficients, hourly illuminances, climate-based metrics.
//!
//! In: a scene with a weather file, and a tolerance. Out: [`Year`]. The coefficients come from the solver's own rows
//! ([`Coefficients`]); the sky of each hour is Perez's; the sun's own light is worked out at its true place in every
//! hour, and its reflected light between the patches of the sky among which it stands.

mod blinds;
mod climate;
mod metrics;
mod series;
mod sunlight;

use std::path::PathBuf;
use std::time::Instant;

use blinds::Blinds;
pub use climate::{CALENDAR_YEAR, Climate, Hour};
use glam::DVec3;
pub use metrics::{Equinox, Figure, GridMetrics, Level, Metrics, Overcast, PointMetrics};
pub use series::Series;
use series::{Light, Luminances, Rough};
pub use sunlight::DAYS as SUNLIGHT_DAYS;
use sunlight::SunPaths;

use crate::error::{Error, Result};
use crate::light::sky::Patches;
use crate::light::sun::Place;
use crate::light::weather::{Weather, check_zone};
use crate::measure::{self, Coefficients, ESTIMATES, LeftOut, Progress, Record, Setting, SolveOptions, Status};
use crate::scene::{BlindControl, Daytime, GridLayout, MaterialKind, Scene, Sensor};

/// What a person asks of a year.
#[derive(Clone, Debug, Default)]
pub struct AnnualOptions {
    /// Tolerance and seed.
    pub solve: SolveOptions,
    /// A weather file in place of the scene's.
    pub weather: Option<PathBuf>,
    /// Parts of a side of Tregenza's patches in which reflected light is told apart, 1 to 4; from the tolerance when absent.
    pub parts: Option<usize>,
}

/// A year of daylight.
#[derive(Clone, Debug)]
pub struct Year {
    /// Name of the weather's place.
    pub weather: String,
    /// Where the building stands.
    pub place: Place,
    /// Standard time against universal time, hours, east positive.
    pub utc_offset_h: f64,
    /// The hours with sun.
    pub climate: Climate,
    /// By grid.
    pub grids: Vec<GridYear>,
    /// Settings, counts, what was left out.
    pub record: Record,
}

/// The year of a grid.
#[derive(Clone, Debug)]
pub struct GridYear {
    /// Name.
    pub name: String,
    /// Arrangement of the sensors.
    pub layout: GridLayout,
    /// The sensors as asked for.
    pub sensors: Vec<Sensor>,
    /// Can they see?
    pub status: Vec<Status>,
    /// Illuminances.
    pub series: Series,
    /// What they come to.
    pub metrics: Metrics,
}

/// Computes the year of a scene.
///
/// # Errors
/// Without sky, weather or grids; where the weather lacks hours; where the scene cannot be solved.
pub fn annual(scene: &Scene, options: &AnnualOptions, progress: &dyn Progress) -> Result<Year> {
    let Some(day) = &scene.daytime else {
        return Err(Error::malformed("the scene has no [sky]").mend("add [sky] with model = \"perez\""));
    };
    if scene.grids.is_empty() {
        return Err(Error::malformed("the scene has no grid").mend("add a [[grids]] table"));
    }
    let start = Instant::now();
    progress.stage("weather", 0);
    let (path, weather) = read_weather(day, options)?;
    let mut warnings = Vec::new();
    let place = place(day, &weather, &mut warnings)?;
    let climate = Climate::new(&weather, place, day.north_deg).map_err(|e| e.in_file(&path))?;
    if scene.blinds.is_empty() {
        warnings.push("no [[blinds]]: all figures are of open windows; LM-83 has blinds run for its sDA".into());
    }
    if climate.left_out > 0 {
        warnings.push(format!(
            "the weather leaves out {} of {} hours of the year: they count as dark",
            climate.left_out, climate.total
        ));
    }
    let weather_s = start.elapsed().as_secs_f64();
    let parts = options.parts.unwrap_or_else(|| parts_for(options.solve.tolerance));
    let of_equinox = climate.equinox.iter().flatten();
    let suns: Vec<DVec3> =
        climate.hours.iter().chain(of_equinox).filter(|h| h.direct_lx > 0.0).map(|h| h.sun).collect();
    let (coefficients, mut record) = measure::coefficients(scene, &options.solve, (parts, &suns), progress)?;
    record.timings_s.insert(0, ("weather".into(), weather_s));
    record.warnings.append(&mut warnings);
    let start = Instant::now();
    progress.stage("hours", 0);
    check_hours(scene, &climate)?;
    let least_sun_deg = day.site.as_ref().map_or(0.0, |s| s.least_sun_deg);
    let paths = SunPaths::new(place, day.north_deg, least_sun_deg)?;
    let (grids, closed) = series_of(scene, day, &coefficients, (&climate, &paths), options.solve.tolerance);
    record.timings_s.push(("hours".into(), start.elapsed().as_secs_f64()));
    describe(scene, &climate, &coefficients, &closed, &mut record);
    Ok(Year { weather: weather.name, place, utc_offset_h: weather.utc_offset_h, climate, grids, record })
}

/// Patches for a tolerance: a side of 12° at 10 %, of 6° at 5 %, of 3° at 2 %.
fn parts_for(tolerance: f64) -> usize {
    match tolerance {
        t if t >= 0.1 => 1,
        t if t > 0.02 => 2,
        _ => 4,
    }
}

fn series_of(
    scene: &Scene,
    day: &Daytime,
    coefficients: &Coefficients,
    (climate, paths): (&Climate, &SunPaths),
    tolerance: f64,
) -> (Vec<GridYear>, Vec<usize>) {
    let grids = &coefficients.grids;
    let (fine, coarse) = (&coefficients.seen_patches, &coefficients.patches);
    let rough = Patches::new(1);
    let homes = coarse.homes(&rough);
    let seen = Luminances::new(fine, &climate.hours, day.ground_reflectance, &wanted(coefficients));
    let joined = (coarse.sky() != fine.sky()).then(|| seen.joined(fine, coarse));
    let reflected = joined.as_ref().unwrap_or(&seen);
    let light = Light {
        coefficients,
        hours: &climate.hours,
        ground_reflectance: day.ground_reflectance,
        seen: &seen,
        reflected,
        rough: Rough { homes: &homes, luminances: &reflected.joined(coarse, &rough) },
        iteration: 0.01 * tolerance,
    };
    let suns: Vec<_> = (0..grids.len()).map(|g| light.own_suns(g)).collect();
    let on_panels = light.suns_on_panels();
    let ok = |g: usize| (0..scene.grids[g].sensors.len()).filter(move |i| grids[g].status(*i) == Status::Ok);
    let lit: Vec<usize> = (0..grids.len()).map(|g| ok(g).count()).collect();
    let blinds = Blinds::new(&scene.blinds, &climate.hours, &suns, &lit);
    let equinox = equinox(coefficients, climate, day.ground_reflectance, tolerance);
    let grid = |(g, grid): (usize, &crate::scene::Grid)| {
        let series = light.series(g, (&suns[g], &on_panels), &blinds);
        let status: Vec<Status> = (0..grid.sensors.len()).map(|i| grids[g].status(i)).collect();
        let overcast = metrics::overcast(coefficients, g, day.ground_reflectance);
        let sunlight = paths.hours(coefficients, g, &status);
        let of_points = (&overcast[..], &sunlight[..]);
        let mut metrics = Metrics::new(&grid.sensors, &status, &series, of_points, climate, &scene.occupancy);
        if let (Some(of_grid), Some(moments)) = (&mut metrics.grid, equinox.get(g)) {
            of_grid.equinox = Some(metrics::equinox(&grid.sensors, &status, moments));
        }
        let (name, layout, sensors) = (grid.name.clone(), grid.layout.clone(), grid.sensors.clone());
        GridYear { name, layout, sensors, status, series, metrics }
    };
    (scene.grids.iter().enumerate().map(grid).collect(), blinds.closed_hours())
}

/// Clear sky at equinox by grid, blinds open; nothing where the weather has no such days.
fn equinox(coefficients: &Coefficients, climate: &Climate, ground_reflectance: f64, tolerance: f64) -> Vec<Series> {
    let Some(hours) = &climate.equinox else { return Vec::new() };
    let (fine, coarse) = (&coefficients.seen_patches, &coefficients.patches);
    let seen = Luminances::new(fine, hours, ground_reflectance, &vec![true; fine.all()]);
    let joined = seen.joined(fine, coarse);
    let tregenza = Patches::new(1);
    let rough = Rough { homes: &coarse.homes(&tregenza), luminances: &joined.joined(coarse, &tregenza) };
    let light = Light {
        coefficients,
        hours,
        ground_reflectance,
        seen: &seen,
        reflected: &joined,
        rough,
        iteration: 0.01 * tolerance,
    };
    let blinds = Blinds::open(coefficients.openings);
    let on_panels = light.suns_on_panels();
    (0..coefficients.grids.len()).map(|g| light.series(g, (&light.own_suns(g), &on_panels), &blinds)).collect()
}

/// Schedules must have the hours of the weather.
fn check_hours(scene: &Scene, climate: &Climate) -> Result<()> {
    let of_blinds = scene.blinds.iter().filter_map(|b| match &b.control {
        BlindControl::Hourly(hours) => Some(hours.len()),
        _ => None,
    });
    match scene.occupancy.told().into_iter().chain(of_blinds).find(|n| *n != climate.total) {
        Some(n) => Err(Error::malformed(format!("a schedule has {n} hours, the weather {}", climate.total))
            .mend("give one line for each hour of the weather file")),
        None => Ok(()),
    }
}

/// Fine patches of which the light is wanted: those that sensors see, and those in patches that reach them by reflection.
fn wanted(coefficients: &Coefficients) -> Vec<bool> {
    let (fine, coarse) = (&coefficients.seen_patches, &coefficients.patches);
    let mut reflected = vec![false; coarse.all()];
    let width = coefficients.sheets * coarse.all();
    for grid in &coefficients.grids {
        for (estimate, sensor) in (0..ESTIMATES).flat_map(|k| (0..grid.seen.len()).map(move |i| (k, i))) {
            for row in grid.of_sky(estimate, sensor, width).chunks_exact(coarse.all()) {
                reflected.iter_mut().zip(row).for_each(|(wanted, v)| *wanted |= *v != 0.0);
            }
        }
    }
    let mut wanted: Vec<bool> = (0..fine.sky()).map(|p| reflected[coarse.of(fine.middle(p))]).chain([true]).collect();
    for (p, _) in coefficients.grids.iter().flat_map(|g| g.seen.iter().flatten()) {
        wanted[*p as usize % fine.all()] = true;
    }
    wanted
}

fn describe(scene: &Scene, climate: &Climate, coefficients: &Coefficients, closed: &[usize], record: &mut Record) {
    let setting = |name: &str, value: String, why: &str| Setting { name: name.into(), value, why: why.into() };
    record.settings.extend([
        setting("sky patches", coefficients.patches.sky().to_string(), "for reflected light; from the tolerance"),
        setting(
            "sky patches seen",
            coefficients.seen_patches.sky().to_string(),
            "for the sky that a sensor sees itself",
        ),
        setting("hours with sun", format!("{} of {}", climate.hours.len(), climate.total), "from weather and place"),
        setting("calendar", CALENDAR_YEAR.to_string(), "for the sun's place; standard time, no summer time"),
    ]);
    for (blind, hours) in scene.blinds.iter().zip(closed) {
        let name = format!("blinds of {}", blind.panes.join(", "));
        record.settings.push(setting(&name, format!("closed in {hours} hours with sun"), "by their control"));
        record.left_out.push(LeftOut {
            what: format!("directions of the light behind closed blinds ({})", blind.panes.join(", ")),
            bound: "closed blinds dim the light of their windows and keep its directions".into(),
        });
    }
    if coefficients.has_panels() {
        record.left_out.push(LeftOut {
            what: "sun and sky by windows with a BSDF in figures of sunlight".into(),
            bound: "they are in all illuminances; as scattered light they count for no sunlit point, no hour of sunlight and no sky component".into(),
        });
    }
    if coefficients.has_panels() && !scene.blinds.is_empty() {
        record.left_out.push(LeftOut {
            what: "closed blinds of panes between a point and a window with a BSDF".into(),
            bound: "at most the light that comes by that window".into(),
        });
    }
    let has_mirrors = scene.materials.iter().any(|m| matches!(m.kind, MaterialKind::Mirror { .. }));
    if has_mirrors && !scene.blinds.is_empty() {
        record.left_out.push(LeftOut {
            what: "closed blinds before the sky's light that mirrors throw on".into(),
            bound: "at most that light".into(),
        });
    }
    if climate.dark_share > 0.0 {
        record.left_out.push(LeftOut {
            what: "light that the weather gives to hours without sun".into(),
            bound: format!("{:.3} % of the year's irradiance", 100.0 * climate.dark_share),
        });
    }
}

fn read_weather(day: &Daytime, options: &AnnualOptions) -> Result<(PathBuf, Weather)> {
    if let Some(path) = &options.weather {
        if !path.is_file() {
            return Err(Error::malformed("no such file").mend("check the name").in_file(path));
        }
        return Ok((path.clone(), Weather::read(path)?));
    }
    match day.site.as_ref().and_then(|s| s.weather.as_ref()) {
        Some((path, bytes)) => Ok((path.clone(), Weather::parse(bytes).map_err(|e| e.in_file(path))?)),
        None => Err(Error::malformed("no weather file")
            .mend("add weather = \"place.epw\" to [site], or give --weather place.epw")
            .in_file(&day.file)),
    }
}

/// The building's place: that of [site], else that of the weather.
fn place(day: &Daytime, weather: &Weather, warnings: &mut Vec<String>) -> Result<Place> {
    let Some(site) = &day.site else { return Ok(weather.place) };
    let place = crate::light::site_of(day, site, Some(weather), warnings)?;
    check_zone(place.longitude_deg, weather.utc_offset_h).map_err(|e| e.in_file(&day.file).at_line(site.line))?;
    Ok(place)
}
