//! `run.json`: the record of a run.

use serde_json::{Map, Value, json};

use super::Provenance;
use super::table::{Statistics, Values};
use crate::measure::{GridResult, Ledger, Measurement, Record, StateResult, ViewResult};
use crate::scene::Scene;

/// Version of the record's form.
const SCHEMA: &str = "clerestory-run/1";

/// The record of a run: inputs with their hashes, version, what was chosen and why, what was left out, the
/// balance of energy, and how well each grid and view came out.
#[must_use]
pub fn run_json(scene: &Scene, m: &Measurement, provenance: &Provenance) -> Value {
    let mut object = preface(SCHEMA, scene, &m.record, provenance);
    let own = [
        ("method", json!(m.record.method)),
        ("spectrum", spectrum(m)),
        ("energy_balance", balance(m)),
        ("bands", json!(bands(m))),
        ("grids", json!(m.grids.iter().map(|g| grid(g, m.outdoor_lx)).collect::<Vec<_>>())),
        ("states", json!(m.states.iter().map(state).collect::<Vec<_>>())),
        ("views", json!(m.views.iter().map(view).collect::<Vec<_>>())),
    ];
    object.extend(own.map(|(k, v)| (k.to_owned(), v)));
    object.extend(super::appraisal::keys(&m.appraisal).map(|(k, v)| (k.to_owned(), v)));
    Value::Object(object)
}

/// What every record begins with: how it came about, what was chosen and why, what was left out.
pub(super) fn preface(schema: &str, scene: &Scene, record: &Record, provenance: &Provenance) -> Map<String, Value> {
    let warnings: Vec<&String> = scene.warnings.iter().chain(&record.warnings).collect();
    let inputs = scene.inputs.iter().map(|f| json!({ "path": f.path.display().to_string(), "sha256": f.sha256 }));
    let keys = [
        ("schema", json!(schema)),
        ("program", json!("clerestory")),
        ("version", json!(provenance.version)),
        ("command", json!(provenance.command)),
        ("threads", json!(provenance.threads)),
        ("cpu_s", json!(provenance.cpu_s)),
        ("wall_s", json!(provenance.wall_s)),
        ("memory", memory(record, provenance)),
        ("title", json!(scene.title)),
        ("inputs", inputs.collect()),
        ("seed", json!(record.seed)),
        ("tolerance", json!(record.tolerance)),
        ("settings", json!(record.settings)),
        ("left_out", json!(record.left_out)),
        ("counts", object(record.counts.iter().map(|(k, v)| (k, json!(v))))),
        ("timings_s", object(record.timings_s.iter().map(|(k, v)| (k, json!(v))))),
        ("warnings", json!(warnings)),
    ];
    keys.map(|(k, v)| (k.to_owned(), v)).into_iter().collect()
}

/// Bytes planned for the peak, held at it, allowed.
fn memory(record: &Record, provenance: &Provenance) -> Value {
    json!({
        "planned_bytes": record.planned_bytes,
        "peak_bytes": provenance.peak_bytes,
        "max_bytes": record.max_memory,
    })
}

/// How the spectrum is divided. The limits of nominal bands (RGB) only say where they lie: they have no edges.
fn spectrum(m: &Measurement) -> Value {
    let limits = m.bands.limits_nm();
    let edges: Vec<f64> = limits.iter().map(|l| l.0).chain(limits.last().map(|l| l.1)).collect();
    json!({
        "bands": m.bands.len(),
        "limits": limits_kind(m),
        "edges_nm": m.bands.is_spectral().then_some(edges),
    })
}

fn limits_kind(m: &Measurement) -> &'static str {
    if m.bands.is_spectral() { "range" } else { "nominal" }
}

/// The balance over all bands, in W where the bands are ranges, and the band that closes worst.
fn balance(m: &Measurement) -> Value {
    let total = |line: &[f64]| -> Option<f64> {
        (m.bands.is_spectral() && line.len() == m.bands.len())
            .then(|| m.bands.limits_nm().iter().zip(line).map(|((lo, hi), v)| (hi - lo) * v).sum())
    };
    let ledger = &m.ledger;
    let closures = (0..m.bands.len()).filter_map(|b| Some((b, closure(ledger, b)?)));
    let worst = closures.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    json!({
        "emitted_W": total(&ledger.emitted),
        "absorbed_W": total(&ledger.absorbed),
        "escaped_W": total(&ledger.escaped),
        "unexpanded_W": total(&ledger.unexpanded),
        "worst_closure": worst.map(|w| w.1),
        "worst_band": worst.map(|w| w.0),
    })
}

fn object<'a>(pairs: impl Iterator<Item = (&'a String, Value)>) -> Value {
    Value::Object(pairs.map(|(k, v)| (k.clone(), v)).collect::<Map<_, _>>())
}

/// The balance of energy of each band: W per nm, summed line by line; `closure` is what is missing.
fn bands(m: &Measurement) -> Vec<Value> {
    let ledger = &m.ledger;
    let kind = limits_kind(m);
    m.bands
        .limits_nm()
        .iter()
        .enumerate()
        .map(|(b, (lo, hi))| {
            json!({
                "lo_nm": lo,
                "hi_nm": hi,
                "limits": kind,
                "emitted_W_nm": ledger.emitted.get(b),
                "absorbed_W_nm": ledger.absorbed.get(b),
                "escaped_W_nm": ledger.escaped.get(b),
                "unexpanded_W_nm": ledger.unexpanded.get(b),
                "sampling_error_W_nm": ledger.sampling_error.get(b),
                "closure": closure(ledger, b),
            })
        })
        .collect()
}

/// (emitted − absorbed − escaped − unexpanded)/emitted; nothing where nothing is emitted.
fn closure(ledger: &Ledger, band: usize) -> Option<f64> {
    let emitted = *ledger.emitted.get(band)?;
    let line = |v: &[f64]| v.get(band).copied().unwrap_or(0.0);
    let gone = line(&ledger.absorbed) + line(&ledger.escaped) + line(&ledger.unexpanded);
    (emitted != 0.0).then(|| (emitted - gone) / emitted)
}

fn grid(grid: &GridResult, outdoor_lx: Option<f64>) -> Value {
    let s = Statistics::of(grid);
    let v = s.values.as_ref();
    json!({
        "name": grid.name,
        "points": grid.sensors.len(),
        "ok": s.ok,
        "covered": s.covered,
        "inside": s.inside,
        "mean_lx": v.map(|v| v.mean_lx),
        "min_lx": v.map(|v| v.min_lx),
        "max_lx": v.map(|v| v.max_lx),
        "uniformity_U0": v.and_then(Values::uniformity),
        "daylight_factor_percent": v.and_then(|v| v.daylight_factor_percent(outdoor_lx)),
        "median_error_lx": v.map(|v| v.median_error_lx),
        "max_error_lx": v.map(|v| v.max_error_lx),
        "holding": s.holding,
        "holding_share": s.holding_share(),
    })
}

fn state(state: &StateResult) -> Value {
    json!({ "name": state.name, "grids": state.grids.iter().map(|g| grid(g, None)).collect::<Vec<_>>() })
}

fn view(result: &ViewResult) -> Value {
    json!({
        "name": result.view.name,
        "width": result.view.width,
        "height": result.view.height,
        "error_median": result.error_median,
        "error_p95": result.error_p95,
    })
}
