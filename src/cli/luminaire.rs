//! `clerestory luminaire`.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde_json::json;

use super::{LuminaireArgs, LuminaireFormat, print};
use crate::Result;
use crate::light::photometry::{PhotometricType, Photometry, Spread, spread, to_eulumdat, to_ies};
use crate::light::{UGR_REFLECTANCES, UgrRow, UgrSpacing, point_distance_m, ugr_table};
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
        "point_distance_m": point_distance_m(p),
        "ugr_table": glare_json(p, UgrSpacing::Quarter),
        "ugr_table_cie190": glare_json(p, UgrSpacing::Whole),
        "power_W": p.power_w,
        "efficacy_lm_W": efficacy(p),
        "warnings": p.warnings,
        "files": written,
    });
    format!("{report:#}\n")
}

fn glare_json(p: &Photometry, spacing: UgrSpacing) -> Option<serde_json::Value> {
    let rows = ugr_table(p, spacing)?;
    Some(json!({
        "spacing_H": spacing.over_h(),
        "reflectances": UGR_REFLECTANCES,
        "rooms": rows.iter().map(room).collect::<Vec<_>>(),
    }))
}

fn room(row: &UgrRow) -> serde_json::Value {
    json!({ "x_H": row.x, "y_H": row.y, "along_c0": row.along_c0, "along_c90": row.along_c90 })
}

/// The table of glare ratings as makers print it, for the terminal.
fn glare(text: &mut String, p: &Photometry) {
    let Some(rows) = ugr_table(p, UgrSpacing::Quarter) else { return };
    text.push_str("uncorrected UGR (CIE 117), spacing 0.25 H; reflectances of ceiling, walls, floor in %\n");
    let shares = UGR_REFLECTANCES.map(|r| r.map(|v| format!("{:.0}", 100.0 * v)).join("/"));
    let _ = writeln!(text, "  {:<9} {}    {}", "", shares.join(" "), shares.join(" "));
    let _ = writeln!(text, "  {:<9} {:<47}    eyes look along C90", "room", "eyes look along C0");
    for row in rows {
        let line = |ratings: [f64; 5]| ratings.map(|r| format!("{r:>8.1}")).join(" ");
        let name = format!("{}H x {}H", row.x, row.y);
        let _ = writeln!(text, "  {name:<9} {}    {}", line(row.along_c0), line(row.along_c90));
    }
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
    let near = format!("from {:.2} m on within 1 %, where it gets a tenth of the peak", point_distance_m(p));
    line("taken as a point", near);
    if let Some(efficacy) = efficacy(p) {
        line("power", format!("{} W, {efficacy:.1} lm/W", p.power_w));
    }
    glare(&mut text, p);
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
