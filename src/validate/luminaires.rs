//! Photometric files: candelas and lumens against formulas, and the same after writing them anew.

use std::f64::consts::PI;
use std::path::Path;

use super::References;
use super::scenes::{axial, half_degrees};
use super::sheet::{Sheet, exact, known};
use crate::Result;
use crate::light::photometry::{Photometry, to_eulumdat, to_ies};

/// The luminaires shipped with the program; their files are by formula and rated at its flux.
const SHIPPED: [(&str, &str, &str); 7] = [
    ("downlight", include_str!("../../luminaires/downlight.ies"), include_str!("../../luminaires/downlight.ldt")),
    ("linear", include_str!("../../luminaires/linear.ies"), include_str!("../../luminaires/linear.ldt")),
    ("panel", include_str!("../../luminaires/panel.ies"), include_str!("../../luminaires/panel.ldt")),
    ("pendant", include_str!("../../luminaires/pendant.ies"), include_str!("../../luminaires/pendant.ldt")),
    ("projector", include_str!("../../luminaires/projector.ies"), include_str!("../../luminaires/projector.ldt")),
    ("spot", include_str!("../../luminaires/spot.ies"), include_str!("../../luminaires/spot.ldt")),
    ("wall washer", include_str!("../../luminaires/wall_washer.ies"), include_str!("../../luminaires/wall_washer.ldt")),
];

/// Candelas are linear between angles: cosⁿ in steps of Δ is off by Δ² (n + 1)/12, 2.6e-4 for the narrowest spot.
const LINEAR: f64 = 3e-4;

pub(super) fn run(_: &References, sheet: &mut Sheet) -> Result<()> {
    for (name, ies, ldt) in SHIPPED {
        for (ending, text) in [("ies", ies), ("ldt", ldt)] {
            let file = format!("{name}.{ending}");
            let p = Photometry::parse(text.as_bytes(), Path::new(&file))?;
            sheet.topic("integrated over rated flux of a luminaire by formula", "closed form, written in the file", "");
            let rated = p.rated_flux_lm.unwrap_or(f64::NAN);
            sheet.equal(file, exact(1.0), p.web.flux_lm() / rated, LINEAR);
        }
    }
    for power in 0..=4 {
        cosines(sheet, power)?;
    }
    Ok(())
}

/// I = I0 cosⁿ below the horizon: 2π I0 / (n + 1) lumens. Read from LM-63, written as both formats, read again.
fn cosines(sheet: &mut Sheet, power: i32) -> Result<()> {
    let formula = |v: f64| 1000.0 * v.to_radians().cos().max(0.0).powi(power);
    let original = axial("0 0 0", &half_degrees(), formula);
    let read = Photometry::parse(&original, Path::new("lamp.ies"))?;
    let again = Photometry::parse(to_ies(&read).as_bytes(), Path::new("again.ies"))?;
    let eulumdat = Photometry::parse(to_eulumdat(&read)?.as_bytes(), Path::new("again.ldt"))?;
    let flux_lm = 2.0 * PI * 1000.0 / f64::from(power + 1);
    let step = 0.5f64.to_radians();
    let linear = step * step * f64::from(power + 1) / 12.0;
    for (name, p) in [("LM-63", &read), ("LM-63 written anew", &again), ("EULUMDAT written anew", &eulumdat)] {
        sheet.topic("flux of I0 cosⁿ", "closed form: 2π I0 / (n + 1)", "lm");
        let value = p.web.flux_lm();
        // The written files have seven digits.
        sheet.equal(format!("n = {power}, {name}"), exact(flux_lm), value, (linear + 1e-6) * value);
        sheet.topic("intensity of I0 cosⁿ between angles of the table", "closed form", "cd");
        for vertical in [0.25, 33.1, 60.4] {
            let (value, truth) = (p.web.at(vertical, 77.0), formula(vertical));
            // Linear interpolation: Δ²/8 of the second derivative, which is at most n (n + 1) I0.
            let bent = step * step / 8.0 * f64::from(power * (power + 1)) * 1000.0;
            sheet.equal(format!("n = {power}, {name}, {vertical}°"), known(truth, 0.0), value, bent + 1e-3);
        }
    }
    Ok(())
}
