//! `clerestory luminaire`.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde_json::json;

use super::{LuminaireArgs, LuminaireFormat, print};
use crate::Result;
use crate::light::photometry::{PhotometricType, Photometry, Spread, spread, to_eulumdat, to_ies};
use crate::report;

/// Reads, tells, and writes what was asked for.
pub(super) fn run(args: &LuminaireArgs) -> Result<ExitCode> {
    let photometry = Photometry::read(&args.file)?;
    let found = spread(&photometry.web);
    let mut written = Vec::new();
    let stem = args.file.file_stem().unwrap_or_else(|| "luminaire".as_ref()).to_string_lossy();
    if args.out.is_some() || args.to.is_some() {
        let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(&*stem));
        if let Some(format) = args.to {
            let (ending, text) = match format {
                LuminaireFormat::Ies => ("ies", to_ies(&photometry)),
                LuminaireFormat::Ldt => ("ldt", to_eulumdat(&photometry).map_err(|e| e.in_file(&args.file))?),
            };
            written.push(report::write_text(&folder, &format!("{stem}.{ending}"), &text)?);
        }
        written.extend(report::write_polar(&folder, &stem, &photometry)?);
    }
    print(&if args.json { as_json(&photometry, &found, &written) } else { as_text(&photometry, &found, &written) })?;
    Ok(ExitCode::SUCCESS)
}

fn as_json(p: &Photometry, spread: &Spread, written: &[PathBuf]) -> String {
    let (peak_cd, peak_vertical_deg, peak_horizontal_deg) = p.web.peak();
    let flux_lm = p.web.flux_lm();
    let report = json!({
        "schema": 1,
        "format": p.format.name(),
        "name": p.name(),
        "manufacturer": p.label("MANUFAC"),
        "photometric_type": p.web.kind().name(),
        "symmetry": p.web.symmetry().name(),
        "vertical_angles": p.web.vertical_deg().len(),
        "horizontal_angles": p.web.horizontal_deg().len(),
        "integrated_flux_lm": flux_lm,
        "rated_flux_lm": p.rated_flux_lm,
        "stated_flux_lm": p.stated_flux_lm,
        "light_output_ratio": p.light_output_ratio(),
        "downward_flux_share": downward(p),
        "peak_cd": peak_cd,
        "peak_vertical_deg": peak_vertical_deg,
        "peak_horizontal_deg": peak_horizontal_deg,
        "beam_angle_deg": spread.beam_deg,
        "field_angle_deg": spread.field_deg,
        "opening": {
            "shape": p.opening.shape(),
            "along_c0_m": p.opening.along_c0_m,
            "along_c90_m": p.opening.along_c90_m,
            "height_m": p.opening.height_m,
        },
        "power_W": p.power_w,
        "efficacy_lm_W": efficacy(p),
        "warnings": p.warnings,
        "files": written,
    });
    format!("{report:#}\n")
}

/// Share of the flux below the horizon; types A and B have no horizon of their own.
fn downward(p: &Photometry) -> Option<f64> {
    let flux_lm = p.web.flux_lm();
    (p.web.kind() == PhotometricType::C && flux_lm > 0.0).then(|| p.web.zone_flux_lm(0.0, 90.0) / flux_lm)
}

fn efficacy(p: &Photometry) -> Option<f64> {
    (p.power_w > 0.0).then(|| p.web.flux_lm() / p.power_w)
}

fn as_text(p: &Photometry, spread: &Spread, written: &[PathBuf]) -> String {
    let mut text = format!("{}: {}\n", p.name(), p.format.name());
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {name:<20} {value}");
    };
    let web = &p.web;
    line("flux", format!("{:.1} lm from the candelas", web.flux_lm()));
    line("rated flux of lamps", p.rated_flux_lm.map_or("none: absolute photometry".into(), |r| format!("{r:.1} lm")));
    if let Some(ratio) = p.light_output_ratio() {
        line("light output ratio", format!("{:.1} %", 100.0 * ratio));
    }
    if let Some(share) = downward(p) {
        line("downward", format!("{:.1} %", 100.0 * share));
    }
    let (peak, vertical, horizontal) = web.peak();
    line("peak", format!("{peak:.1} cd at vertical {vertical}°, horizontal {horizontal}°"));
    let planes = if web.kind() == PhotometricType::C { "C0 and C90" } else { "vertical and horizontal" };
    let pair = |a: [f64; 2]| format!("{:.1}° and {:.1}° ({planes})", a[0], a[1]);
    line("beam angle (50 %)", pair(spread.beam_deg));
    line("field angle (10 %)", pair(spread.field_deg));
    line("photometric type", web.kind().name().into());
    let stored = (web.vertical_deg().len(), web.horizontal_deg().len());
    line("symmetry", format!("{} ({} planes of {} angles)", web.symmetry().name(), stored.1, stored.0));
    let o = &p.opening;
    let sizes = format!("{} x {} x {} m (C0 x C90 x height)", o.along_c0_m, o.along_c90_m, o.height_m);
    line("luminous opening", format!("{}, {sizes}", o.shape()));
    if let Some(efficacy) = efficacy(p) {
        line("power", format!("{} W, {efficacy:.1} lm/W", p.power_w));
    }
    for warning in &p.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    if !written.is_empty() {
        text.push_str("written:\n");
    }
    for file in written {
        let _ = writeln!(text, "  {}", file.display());
    }
    text
}
