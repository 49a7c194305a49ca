//! `run.json` of a year, with the metrics of the tables.

use serde_json::{Value, json};

use super::Provenance;
use super::annual_tables::{FIGURES, OTHERS};
use super::run_json::preface;
use crate::annual::{GridYear, PointMetrics, Year};
use crate::scene::Scene;

/// Version of the record's form.
const SCHEMA: &str = "clerestory-annual/1";

/// The record of a year: inputs with their hashes, what was chosen and why, what was left out, and the metrics.
#[must_use]
pub fn year_json(scene: &Scene, year: &Year, provenance: &Provenance) -> Value {
    let mut object = preface(SCHEMA, scene, &year.record, provenance);
    let own = [
        ("weather", json!(year.weather)),
        ("latitude_deg", json!(year.place.latitude_deg)),
        ("longitude_deg", json!(year.place.longitude_deg)),
        ("utc_offset_h", json!(year.utc_offset_h)),
        ("hours", json!(year.climate.total)),
        ("hours_with_sun", json!(year.climate.hours.len())),
        ("grids", json!(year.grids.iter().map(grid).collect::<Vec<_>>())),
    ];
    object.extend(own.map(|(k, v)| (k.to_owned(), v)));
    Value::Object(object)
}

fn grid(grid: &GridYear) -> Value {
    let mut value = json!({ "name": grid.name, "points": grid.metrics.points.iter().flatten().count() });
    let (Some(object), Some(m)) = (value.as_object_mut(), &grid.metrics.grid) else { return value };
    let percent = |v: f64| json!(100.0 * v);
    let own = [
        ("sda300_50_percent", percent(m.spatial_autonomy.value)),
        ("sda300_50_percent_error", percent(m.spatial_autonomy.error)),
        ("ase1000_250_percent", percent(m.sunlight_exposure[0])),
        ("ase1000_at_least_250_percent", percent(m.sunlight_exposure[1])),
        ("leed_v41_option1_points", json!(m.leed_points[0])),
        ("leed_v41_option1_points_range", json!([m.leed_points[1], m.leed_points[2]])),
        ("en17037_hourly", json!(m.en17037_hourly[0].name())),
        ("en17037_hourly_range", json!([m.en17037_hourly[1].name(), m.en17037_hourly[2].name()])),
        ("en17037_daylight_factor", json!(m.en17037_factor.name())),
        ("outdoor_median_diffuse_lx", json!(m.outdoor_median_lx)),
        ("breeam_mean_300_hours", json!(m.breeam_hours[0])),
        ("breeam_worst_90_hours", json!(m.breeam_hours[1])),
        ("breeam_hea01", json!(m.breeam)),
        ("present_hours", json!(m.present_hours)),
        ("no_sky_percent", percent(m.no_sky)),
    ];
    object.extend(own.map(|(k, v)| (k.to_owned(), v)));
    if let Some(e) = &m.equinox {
        object.extend([
            ("equinox_300_3000_percent".to_owned(), percent(e.useful.value)),
            ("equinox_300_3000_percent_error".to_owned(), percent(e.useful.error)),
            ("equinox_9h_mean_lx".to_owned(), json!(e.mean_lx[0])),
            ("equinox_15h_mean_lx".to_owned(), json!(e.mean_lx[1])),
            ("leed_v41_option2_points".to_owned(), json!(e.leed_points)),
        ]);
    }
    object.extend(figures(&m.mean));
    value
}

fn figures(m: &PointMetrics) -> impl Iterator<Item = (String, Value)> + '_ {
    let of = FIGURES.iter().flat_map(|(name, factor, of)| {
        let figure = of(m);
        [((*name).to_owned(), json!(factor * figure.value)), (format!("{name}_error"), json!(factor * figure.error))]
    });
    of.chain(OTHERS.iter().map(|(name, of)| ((*name).to_owned(), json!(of(m)))))
}
