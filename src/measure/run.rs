//! From a scene and a tolerance to a [`Measurement`].

use std::f64::consts::PI;
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use super::adaptive::{Adapted, Task};
use super::alpha_opic::AlphaOpicScale;
use super::appraisal::Appraisal;
use super::coefficients::{Coefficients, typical_sun};
use super::memory::Budget;
use super::options::{Method, Progress, SolveOptions};
use super::probe::{Probe, hidden};
use super::result::{
    BandValue, GridResult, Ledger, LeftOut, Measurement, Record, SensorResult, Setting, StateResult, Status, ViewResult,
};
use super::sensor_state::{Light, SensorState};
use super::solved::Solved;
use super::statement::Stated;
use super::states::{Channels, State};
use super::{appraisal, bsdf, classic, glare, ledger, path_tracing, picture, room_surfaces};
use crate::error::{Error, Result};
use crate::light::{Daylight, Emitter, Luminaire, Luminaires};
use crate::scene::{Daytime, Grid, MaterialKind, Receiver, Scene, Sensor};
use crate::solve::Abreast;
use crate::spectrum::{Bands, SpectralValue, Spectrum};
use crate::transport::caster::{MISS, Ray};
use crate::transport::points::seed;
use crate::transport::{GlazingUnit, LightPart, Optics, Pane, SUN, World, most_mirrored_lx};

/// Paths from a pixel, at most: a picture has many pixels and the eye averages.
const PIXEL_PATHS: u64 = 256;

/// Solves a scene to the tolerance asked for.
///
/// # Errors
///
/// When the scene is physically impossible (no face, no finite solution) or has no bands.
pub fn solve(scene: &Scene, options: &SolveOptions, progress: &dyn Progress) -> Result<Measurement> {
    if !(options.tolerance.is_finite() && options.tolerance > 0.0) {
        return Err(Error::malformed(format!("tolerance {} is not a positive number", options.tolerance)));
    }
    if scene.faces.is_empty() {
        return Err(no_face());
    }
    let start = Instant::now();
    progress.stage("geometry", 0);
    let daylight = Daylight::new(scene)?;
    let luminaires = Luminaires::new(scene)?;
    let options = &SolveOptions { spectral: options.spectral || options.alpha_opic, ..options.clone() };
    let (bands, why, alpha_opic) = plan_bands(scene, daylight.as_ref(), &luminaires, options)?;
    let power = appraisal::power(scene, &luminaires);
    let (told, tables, ra) = (luminaires.warnings.clone(), luminaires.tables.clone(), luminaires.ra.clone());
    let world = World::with_daylight(scene, daylight).hang(luminaires);
    // Points of the reference go their own way through windows with a BSDF; pictures show what the windows send on.
    let is_reference = options.method == Method::PathTracing && scene.views.is_empty();
    let world = if is_reference { world } else { world.glaze(options.tolerance, options.seed) };
    bsdf::check(&world)?;
    let channels = match options.method {
        Method::Auto | Method::PathTracing => Channels::new(scene, &world),
        _ => Channels::one(&world),
    };
    let optics = Optics::in_channels(scene, &world, bands, &channels.of_group);
    let mut record = Record {
        method: options.method.name().into(),
        seed: options.seed,
        tolerance: options.tolerance,
        settings: vec![Setting { name: "bands".into(), value: optics.bands.len().to_string(), why }],
        warnings: scene.warnings.clone(),
        ..Record::default()
    };
    record.settings.extend(glazings(scene, &optics.bands));
    record.settings.extend(bsdf::settings(scene, &world));
    record.left_out.extend(bsdf::omissions(scene, &world, world.daylight().is_some_and(|d| d.sun.is_some())));
    if let Some(light) = world.daylight() {
        record.settings.extend(light.facts.iter().map(|(name, value)| Setting {
            name: name.clone(),
            value: value.clone(),
            why: "from [sky] and [site]".into(),
        }));
        record.warnings.extend(light.warnings.iter().cloned());
    } else if world.emitters.is_empty() {
        record.warnings.push("nothing in the scene emits light: all results are zero".into());
    }
    record.warnings.extend(told);
    record.warnings.extend(buried_lamps(scene, &world));
    record.warnings.extend(covered_luminaires(scene, &world, &tables));
    record.timings_s.push(("geometry".into(), start.elapsed().as_secs_f64()));
    if !scene.states.is_empty() && channels.states.is_empty() {
        record.warnings.push("the classic methods tell nothing of the states of the lights".into());
    }
    let task = Task { scene, world: &world, optics: &optics, channels: &channels, options, progress };
    record.max_memory = options.max_memory;
    let mut measurement = match options.method {
        Method::Auto => by_radiosity(&task, record)?,
        Method::PathTracing => {
            let budget = Budget::new(&task);
            budget.check()?;
            record.planned_bytes = Some(budget.peak(0, Abreast::Block));
            by_path_tracing(&task, record)
        }
        _ => classic::run(&task, record)?,
    };
    measurement.alpha_opic = alpha_opic;
    measurement.appraisal.power = power;
    appraisal::appraise(scene, &ra, &mut measurement);
    Ok(measurement)
}

/// Daylight coefficients of a scene to the tolerance asked for under an even sky; reflected light in `parts` of
/// Tregenza's patches a side; `suns` are the places of the sun that may be asked for.
///
/// # Errors
/// As [`solve`], and for a scene without a sky.
pub fn coefficients(
    scene: &Scene,
    options: &SolveOptions,
    (parts, suns): (usize, &[DVec3]),
    progress: &dyn Progress,
) -> Result<(Coefficients, Record)> {
    let Some(day) = &scene.daytime else {
        return Err(Error::malformed("the scene has no [sky]").mend("add a [sky] table"));
    };
    if scene.faces.is_empty() {
        return Err(no_face());
    }
    if scene.grids.iter().any(|g| g.receiver != Receiver::Plane) {
        return Err(Error::unsupported("a year knows no cylindrical illuminance")
            .mend("leave cylindrical and semicylindrical out of the scene of the year"));
    }
    bsdf::check_blinds(scene)?;
    let start = Instant::now();
    let world = World::with_daylight(scene, Some(Daylight::uniform(day))).glaze(options.tolerance, options.seed);
    bsdf::check(&world)?;
    let (bands, why, _) = plan_bands(scene, world.daylight(), &Luminaires::default(), options)?;
    let optics = Optics::new(scene, &world, bands);
    let mut record = Record {
        method: "daylight coefficients".into(),
        seed: options.seed,
        tolerance: options.tolerance,
        settings: vec![Setting { name: "bands".into(), value: optics.bands.len().to_string(), why }],
        warnings: scene.warnings.clone(),
        ..Record::default()
    };
    if !(world.emitters.is_empty() && scene.luminaires.is_empty()) {
        record.warnings.push("a year is of daylight alone: the lamps of the scene are off".into());
    }
    let channels = Channels::one(&world);
    let task = Task { scene, world: &world, optics: &optics, channels: &channels, options, progress };
    let mut adapted = match typical_sun(&world, suns) {
        Some(sun) => refine_in_the_sun(&task, day, sun)?,
        None => task.refine()?,
    };
    record.timings_s.append(&mut adapted.timings);
    describe(&task, &adapted, &mut record);
    record.settings.extend(bsdf::settings(scene, &world));
    record.left_out.extend(bsdf::omissions(scene, &world, true));
    if world.has_specular() {
        record.left_out.push(LeftOut {
            what: "sun by two and more reflections at mirrors and panes onto points".into(),
            bound: "at most the sun's illuminance times the reflectances at its angles, where such an image falls"
                .into(),
        });
    }
    let found = task.coefficients(&adapted, parts, suns)?;
    record.timings_s.push(("coefficients".into(), start.elapsed().as_secs_f64()));
    Ok((found, record))
}

/// The mesh and the rays that the tolerance wants where the sun shines into windows with a BSDF: they scatter it, and what the
/// even sky wants is too little for that.
fn refine_in_the_sun(task: &Task<'_>, day: &Daytime, sun: DVec3) -> Result<Adapted> {
    let &Task { scene, options, .. } = task;
    let light = Daylight::uniform(day).with_clear_sun(sun);
    let world = World::with_daylight(scene, Some(light)).glaze(options.tolerance, options.seed);
    let optics = Optics::new(scene, &world, task.optics.bands.clone());
    Task { world: &world, optics: &optics, channels: &Channels::one(&world), ..*task }.refine()
}

fn no_face() -> Error {
    Error::impossible("no geometry: the scene has no face").mend("add faces to a file of [geometry]")
}

/// What the glass of a scene does, told in the terms of data sheets and of other programs: luminous values for light of
/// equal energy.
fn glazings<'a>(scene: &'a Scene, bands: &'a Bands) -> impl Iterator<Item = Setting> + 'a {
    scene.materials.iter().filter_map(|m| {
        let MaterialKind::Glass { panes, refractive_index, maintenance_factor } = &m.kind else { return None };
        let units = GlazingUnit::in_bands(panes, *refractive_index, &|v| bands.reflectance(v)).into_iter();
        let units: Vec<GlazingUnit> = units.map(|u| u.in_use(*maintenance_factor)).collect();
        let luminous = |of: &dyn Fn(&GlazingUnit) -> f64| {
            let whole = bands.xyz(&vec![1.0; bands.len()])[1];
            bands.xyz(&units.iter().map(of).collect::<Vec<f64>>())[1] / whole
        };
        let transmittance = luminous(&|u| u.shares(1.0).passed);
        let reflected = |side: usize| luminous(&|u| u.shares(1.0).reflected[side]);
        let transmissivity = match Pane::bare(transmittance, *refractive_index) {
            Pane::Bare { internal, .. } => internal,
            Pane::Coated(_) => return None,
        };
        let value = format!(
            "transmittance {transmittance:.4}, transmissivity {transmissivity:.4}, reflectance front {:.4} and back {:.4}, hemispherical transmittance {:.4}",
            reflected(1),
            reflected(0),
            luminous(&|u| u.hemispherical_transmittance()),
        );
        let why = format!(
            "{} pane(s), n = {refractive_index}, at normal incidence, maintenance factor {maintenance_factor}; the transmissivity is that of one pane of the same transmittance",
            units[0].panes.len()
        );
        Some(Setting { name: format!("glass {}", m.name), value, why })
    })
}

/// Tells of emitting faces inside closed solids: their light stays there.
fn buried_lamps(scene: &Scene, world: &World) -> Option<String> {
    let buried = |e: &&Emitter| {
        let centre = e.vertices.iter().sum::<DVec3>() / e.vertices.len() as f64;
        hidden(world, world.lift(centre, e.normal), e.normal)
    };
    let mut all = world.emitters.list.iter().filter(buried);
    let first = &scene.objects[scene.faces[all.next()?.surface].object];
    let count = 1 + all.count();
    Some(format!(
        "{count} emitting face(s) lie inside closed solids, their light stays there; the first: object `{first}`"
    ))
}

/// Distance, m, at which something before a luminaire is taken for a slip: its housing, or the ceiling it sits in.
const COVER_M: f64 = 0.1;

/// Tells of luminaires whose strongest light meets a surface at once.
fn covered_luminaires(scene: &Scene, world: &World, tables: &[String]) -> Option<String> {
    let covered = |l: &&Luminaire| {
        let (_, vertical_deg, horizontal_deg) = l.web.peak();
        let direction = l.axes * l.web.direction(vertical_deg, horizontal_deg);
        let start = world.lift(l.start(direction, 0.5, 0.5).0, direction);
        let hit = world.caster.closest(&Ray::new(start, direction));
        let near = hit.surface != MISS && f64::from(hit.t) * world.surfaces.frame.size_m < COVER_M;
        near.then_some((l.table, hit))
    };
    let mut all = world.emitters.luminaires.iter().filter_map(|l| covered(&l));
    let (table, hit) = all.next()?;
    let count = 1 + all.count();
    Some(format!(
        "{count} luminaire(s) shine into a surface less than {COVER_M} m before them; the first: {} into object `{}`, {:.1} mm away: move it in front",
        tables[table],
        scene.objects[scene.faces[hit.surface as usize].object],
        1e3 * f64::from(hit.t) * world.surfaces.frame.size_m
    ))
}

/// The bands of a run: the scene's own spectra decide. With the scale of alpha-opic irradiances, where asked for.
fn plan_bands(
    scene: &Scene,
    daylight: Option<&Daylight>,
    luminaires: &Luminaires,
    options: &SolveOptions,
) -> Result<(Bands, String, Option<AlphaOpicScale>)> {
    let mut area = vec![0.0; scene.materials.len()];
    for f in &scene.faces {
        area[f.material] += f.area_m2;
    }
    // Daylight comes through the panes; where there are none, all is in the open.
    let panes = || scene.materials.iter().zip(&area).filter(|(m, _)| m.kind.lets_light_in());
    let glazed_m2: f64 = panes().map(|(_, a)| *a).sum();
    let open_m2 = if glazed_m2 > 0.0 { glazed_m2 } else { area.iter().sum::<f64>() };
    let mut reflectances: Vec<(&SpectralValue, f64)> = Vec::new();
    let mut lights: Vec<(&Spectrum, f64)> = Vec::new();
    for (m, a) in scene.materials.iter().zip(&area).filter(|(_, a)| **a > 0.0) {
        match &m.kind {
            MaterialKind::Diffuse { front, back } => reflectances.extend([(front, *a), (back, *a)]),
            MaterialKind::Translucent { front, back, transmittance, .. } => {
                reflectances.extend([front, back, transmittance].map(|v| (v, *a)));
            }
            MaterialKind::Bsdf { .. } => {} // grey
            MaterialKind::Mirror { reflectance } => reflectances.push((reflectance, *a)),
            MaterialKind::Glass { panes, .. } => reflectances.extend(panes.values().into_iter().map(|v| (v, *a))),
        }
        lights.extend(m.emission.as_ref().map(|e| (&e.radiance, *a)));
    }
    lights.extend(luminaires.lights());
    if let Some(light) = daylight {
        lights.extend([(&light.sky_irradiance, open_m2 / PI), (&light.sun_irradiance, open_m2 / PI)]);
    }
    let (mut bands, mut why) = Bands::plan(&scene.bands, &reflectances, &lights, options.tolerance)?;
    if !options.alpha_opic {
        return Ok((bands, why, None));
    }
    let chosen = bands.len();
    bands = bands.narrowed();
    if bands.len() != chosen {
        why = format!("narrow enough for alpha-opic irradiances; for the eye {chosen} would do");
    }
    let scale = AlphaOpicScale::new(&bands, &reflectances, &lights)?;
    Ok((bands, why, Some(scale)))
}

fn by_radiosity(task: &Task<'_>, mut record: Record) -> Result<Measurement> {
    let mut adapted = task.refine()?;
    let start = Instant::now();
    // Pictures and balance are of all light together.
    let whole = (task.optics.channels() > 1).then(|| {
        let optics = Optics::new(task.scene, task.world, task.optics.bands.clone());
        let join = |solved: &Solved| solved.joined(task.optics, &optics);
        (join(&adapted.main), join(&adapted.twin), optics)
    });
    record.planned_bytes = Some(adapted.planned_bytes);
    let (main, twin, optics) =
        whole.as_ref().map_or((&adapted.main, &adapted.twin, task.optics), |w| (&w.0, &w.1, &w.2));
    let joined = Task { optics, ..*task };
    let ledger = ledger::balance(task.world, optics, main, task.options.tolerance, task.options.seed);
    record.timings_s.append(&mut adapted.timings);
    record.timings_s.push(("energy balance".into(), start.elapsed().as_secs_f64()));
    check_ledger(&ledger, &mut record);
    let mut views = Vec::new();
    for (number, v) in task.scene.views.iter().enumerate() {
        let start = Instant::now();
        let (painted, rays) = picture::paint(&joined, v, number, main, twin);
        adapted.rays += rays;
        record.timings_s.push((format!("picture {}", v.name), start.elapsed().as_secs_f64()));
        views.push(painted);
    }
    describe(task, &adapted, &mut record);
    record.left_out.extend(omissions(task));
    let grids = grids(task, &adapted, |states| task.holding(states), |s| (s.light, s.y));
    let of_state = |(k, state): (usize, &State)| StateResult {
        name: state.name.clone(),
        held: k < task.channels.held,
        grids: self::grids(task, &adapted, |states| task.holding_in_state(states, k), |s| s.states[k]),
    };
    let states: Vec<StateResult> = task.channels.states.iter().enumerate().map(of_state).collect();
    Ok(Measurement {
        bands: task.optics.bands.clone(),
        glare: glare::ratings(task, &grids, &states),
        grids,
        states,
        views,
        outdoor_lx: outdoor_lx(task.world),
        appraisal: Appraisal { surfaces: room_surfaces::surfaces(task, optics, main, twin), ..Appraisal::default() },
        alpha_opic: None,
        ledger,
        record,
    })
}

/// What all grids read, in the state of the lights that `of` picks out.
fn grids(
    task: &Task<'_>,
    adapted: &Adapted,
    holding: impl Fn(&[SensorState]) -> usize,
    of: impl Fn(&SensorState) -> (Light, Stated),
) -> Vec<GridResult> {
    let both = task.scene.grids.iter().zip(&adapted.grids);
    both.map(|(grid, states)| GridResult {
        name: grid.name.clone(),
        layout: grid.layout.clone(),
        holding: holding(states),
        sensors: grid.sensors.iter().zip(states).map(|(sensor, s)| reading(sensor, s, of(s))).collect(),
    })
    .collect()
}

/// Horizontal illuminance under the whole sky, where it alone shines.
fn outdoor_lx(world: &World) -> Option<f64> {
    let light = world.daylight().filter(|l| l.sun.is_none() && world.emitters.is_empty())?;
    Some(light.diffuse_horizontal_lx()).filter(|lx| *lx > 0.0)
}

/// What daylight and luminaires leave out, told.
fn omissions(task: &Task<'_>) -> Vec<LeftOut> {
    further_suns(task).into_iter().chain(mirrored_luminaires(task)).collect()
}

/// What mirrors and panes throw on of the light of luminaires, which show in no image.
fn mirrored_luminaires(task: &Task<'_>) -> Option<LeftOut> {
    let (world, scene) = (task.world, task.scene);
    if world.emitters.luminaires.is_empty() || !world.has_specular() {
        return None;
    }
    let at = |grid: &Grid, s: &Sensor| {
        let p = Probe::new(world, s, grid.receiver);
        // No side of a body gets more than a plane that faces the light.
        let lx = |normal| most_mirrored_lx(world, &task.optics.speculars, (p.position, normal));
        match grid.receiver {
            Receiver::Plane => lx(p.normal),
            _ => [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y].map(lx).into_iter().sum(),
        }
    };
    let most = |g: &Grid| g.sensors.par_iter().map(|s| at(g, s)).reduce(|| 0.0, f64::max);
    let most_lx = scene.grids.iter().map(most).fold(0.0, f64::max);
    Some(LeftOut {
        what: "light of luminaires mirrored by mirrors and panes".into(),
        bound: format!(
            "at most {most_lx:.3e} lx at any point of the grids by one reflection; what goes on from there to other surfaces is the unexpanded flux of the energy balance"
        ),
    })
}

/// What the sun gives by more than one reflection at mirrors.
fn further_suns(task: &Task<'_>) -> Option<LeftOut> {
    let share = task.world.sun_images().bound(task.world, &task.optics.speculars)?;
    let mut face_on = vec![0.0; task.optics.columns()];
    face_on[task.optics.lamps + SUN] = 1.0;
    let sun_lx = task.optics.lux_of_direct(&face_on, &task.optics.full(), LightPart::Sun);
    Some(LeftOut {
        what: "sun by two and more reflections at mirrors and panes".into(),
        bound: format!("at most {:.3e} lx for each such image of the sun, where it falls", share * sun_lx),
    })
}

fn reading(sensor: &Sensor, s: &SensorState, (light, y): (Light, Stated)) -> SensorResult {
    let mut result = SensorResult::new(sensor, s.probe.status);
    if s.probe.status == Status::Ok {
        result.xyz = light.xyz;
        result.error_lx = y.error;
        result.direct_lx = light.direct_y;
        result.sun_lx = light.sun_y;
        result.sky_lx = light.sky_y;
        result.external_lx = light.external_y;
        result.reflected_lx = light.reflected_y;
        result.spectral = s.bands.iter().map(|b| BandValue { irradiance: b.value, error: b.error }).collect();
    }
    result
}

fn describe(task: &Task<'_>, a: &Adapted, record: &mut Record) {
    let size_m = a.mesh_size * task.world.surfaces.frame.size_m;
    let setting = |name: &str, value: String, why: &str| Setting { name: name.into(), value, why: why.into() };
    record.settings.extend([
        setting("element size", format!("{size_m:.4} m"), "refined until the stated error of the sensors holds"),
        setting("rays per element", "32".into(), "four independent sets of eight; accuracy comes from element size"),
        setting(
            "rays per sensor",
            format!("{} to {}", 4 * a.sensor_rays.0, 4 * a.sensor_rays.1),
            "each sensor gets what its own error asks for",
        ),
        setting("rounds", a.rounds.to_string(), "until 95 % of every grid's sensors hold the tolerance"),
        setting(
            "solver",
            format!("stabilised bi-conjugate gradients, {} products", a.main.solution.products),
            "relative residual below a hundredth of the tolerance after amplification",
        ),
    ]);
    if a.held_by_memory {
        let why = "it would need more than --max-memory; where it was wanted, longer paths stand in for it";
        record.settings.push(setting("finer mesh", "none".into(), why));
    }
    record.counts.extend([
        ("elements".into(), a.main.mesh.len() as u64),
        ("elements_possible".into(), a.main.mesh.capacity() as u64),
        ("rays".into(), a.rays),
        ("form_factors".into(), a.factors),
        ("products".into(), a.main.solution.products as u64),
    ]);
    record.left_out.push(LeftOut {
        what: "iteration of the linear system".into(),
        bound: format!(
            "residual {:.1e}; at most {:.2} % of a reading, included in its error",
            a.main.solution.residual.max(a.accuracy),
            task.options.tolerance
        ),
    });
    for (grid, states) in task.scene.grids.iter().zip(&a.grids) {
        let lit = states.iter().filter(|s| s.probe.status == Status::Ok).count();
        let held = task.holding(states);
        if (held as f64) < super::adaptive::HOLD * lit as f64 {
            record.warnings.push(format!(
                "grid {:?}: {held} of {lit} points hold the tolerance; the rest would need more elements or rays than this version takes, and their error says so",
                grid.name
            ));
        }
    }
    if a.rows.refused > 0 {
        record.warnings.push(format!("{} rays asked for elements beyond the largest mesh", a.rows.refused));
    }
}

/// The balance must close within 0.1 % or its stated sampling error.
fn check_ledger(ledger: &Ledger, record: &mut Record) {
    for band in 0..ledger.emitted.len() {
        let rest = ledger.emitted[band] - ledger.absorbed[band] - ledger.escaped[band] - ledger.unexpanded[band];
        let allowed = (1e-3 * ledger.emitted[band]).max(ledger.sampling_error[band]);
        if rest.abs() > allowed {
            record.warnings.push(format!(
                "energy balance of band {} is open by {:.2e} of {:.3e} W/nm (allowed {:.1e})",
                band + 1,
                rest,
                ledger.emitted[band],
                allowed
            ));
        }
    }
}

fn by_path_tracing(task: &Task<'_>, mut record: Record) -> Measurement {
    let paths = task.options.paths.unwrap_or_else(|| {
        // A path varies by about its own mean; well-spread batches gain a factor of two.
        let wanted = (1.0 / task.options.tolerance).powi(2) * 2.0;
        wanted.clamp(1024.0, 1e7) as u64
    });
    record.settings.push(Setting {
        name: "paths per sensor".into(),
        value: paths.to_string(),
        why: if task.options.paths.is_some() { "as asked" } else { "from the tolerance" }.into(),
    });
    let whole = Optics::new(task.scene, task.world, task.optics.bands.clone());
    let (grids, mut rays) = traced(task, &whole, paths, "", &mut record);
    let mut states = Vec::new();
    for (k, state) in task.channels.states.iter().enumerate() {
        let levels: Vec<f64> = task.channels.of_group.iter().map(|channel| state.levels[*channel]).collect();
        let (grids, more) = traced(task, &whole.dimmed(&levels), paths, &state.name, &mut record);
        rays += more;
        states.push(StateResult { name: state.name.clone(), held: k < task.channels.held, grids });
    }
    let joined = Task { optics: &whole, ..*task };
    let views: Vec<ViewResult> = task
        .scene
        .views
        .iter()
        .enumerate()
        .map(|(number, v)| picture::trace(&joined, v, number, paths.min(PIXEL_PATHS)))
        .collect();
    record.left_out.extend(omissions(task));
    record.counts.extend([("rays".into(), rays), ("paths_per_sensor".into(), paths)]);
    Measurement {
        bands: task.optics.bands.clone(),
        glare: glare::ratings(task, &grids, &states),
        grids,
        states,
        views,
        outdoor_lx: outdoor_lx(task.world),
        appraisal: Appraisal::default(),
        alpha_opic: None,
        ledger: Ledger::default(),
        record,
    }
}

/// All grids by path tracing in one state of the lights, and the rays cast.
fn traced(task: &Task<'_>, optics: &Optics, paths: u64, state: &str, record: &mut Record) -> (Vec<GridResult>, u64) {
    let mut rays = 0;
    let mut grids = Vec::new();
    for (g, grid) in task.scene.grids.iter().enumerate() {
        let start = Instant::now();
        let name = format!("grid {} {state}", grid.name);
        task.progress.stage(&format!("paths from {}", name.trim_end()), grid.sensors.len() as u64);
        let stream = seed(&[task.options.seed, 9, g as u64]);
        let (mut result, cast) =
            path_tracing::grid(task.world, optics, grid, stream, paths, task.options.spectral, task.progress);
        result.holding = count_holding(&result, task.options.tolerance);
        rays += cast;
        record.timings_s.push((name.trim_end().into(), start.elapsed().as_secs_f64()));
        grids.push(result);
    }
    (grids, rays)
}

/// Sensors whose half-widths hold the tolerance, in lux and in every band reported.
pub(super) fn count_holding(grid: &GridResult, tolerance: f64) -> usize {
    let lit = || grid.sensors.iter().filter(|s| s.status == Status::Ok);
    let n = lit().count().max(1) as f64;
    let mean_lx = lit().map(|s| s.xyz[1]).sum::<f64>() / n;
    let bands = lit().next().map_or(0, |s| s.spectral.len());
    let means: Vec<f64> = (0..bands).map(|b| lit().map(|s| s.spectral[b].irradiance).sum::<f64>() / n).collect();
    let holds = |value: f64, error: f64, mean: f64| error <= tolerance * value.max(0.1 * mean);
    lit()
        .filter(|s| {
            holds(s.xyz[1], s.error_lx, mean_lx)
                && s.spectral.iter().zip(&means).all(|(b, m)| holds(b.irradiance, b.error, *m))
        })
        .count()
}
