//! Boards whose hidden sides are coloured (`experiments/ferren`), in 41 bands, against path tracing.

use super::References;
use super::sheet::{Sheet, exact, known};
use crate::compare::{BandIrradiance, face_xyz};
use crate::error::{Error, Result};
use crate::measure::{self, Silent, SolveOptions};
use crate::spectrum::colour::uv_prime;
use crate::spectrum::{Beyond, Spectrum};

const TOLERANCE: f64 = 0.02;
/// RMS of the illuminance and difference in u'v' that are asked for.
const MOST_RMS: f64 = 0.015;
const MOST_UV: f64 = 0.002;
const SOURCE: &str =
    "our path tracer: experiments/ferren/<arrangement>.toml --method path-tracing --paths 2097152 --seed 7";

const FACE_SOURCE: &str = "our path tracer: experiments/ferren/<arrangement>.toml --method path-tracing --paths 524288 --spectral, times the white";

pub(super) fn run(references: &References, sheet: &mut Sheet) -> Result<()> {
    let white = Spectrum::from_csv_bytes(references.text("experiments/ferren/white.csv").as_bytes(), Beyond::Hold)
        .map_err(|e: Error| e.in_file("white.csv"))?;
    let rows = references.rows("ferren.csv")?;
    for arrangement in ["louvre", "backing"] {
        let mut scene = references.scene("experiments/ferren", &format!("{arrangement}.toml"), str::to_owned)?;
        scene.views.clear();
        let options = SolveOptions { tolerance: TOLERANCE, spectral: true, ..SolveOptions::default() };
        let m = measure::solve(&scene, &options, &Silent)?;
        let sensors = &m.grids[0].sensors;
        let (mut off, mut near, mut face_near, mut inside) = (Vec::new(), 0, 0, 0);
        for row in &rows {
            let (point, lux, se) =
                (row.number("point")?, row.number("illuminance_lx")?, row.number("standard_error_lx")?);
            let uv = [row.number("u_prime")?, row.number("v_prime")?];
            let face_uv = [row.number("face_u_prime")?, row.number("face_v_prime")?];
            let Some(s) =
                sensors.get(point as usize).filter(|_| row.text("arrangement").is_ok_and(|a| a == arrangement))
            else {
                continue;
            };
            sheet.topic("illuminance of a board", SOURCE, "lx");
            sheet.sensor(format!("{arrangement} point {point}"), known(lux, 1.96 * se), s, 0.0);
            off.push(s.xyz[1] / lux - 1.0);
            inside += usize::from((s.xyz[1] - lux).abs() <= s.error_lx + 1.96 * se);
            let is_near = |xyz: [f64; 3], uv: [f64; 2]| {
                let found = uv_prime(xyz).unwrap_or([f64::NAN; 2]);
                usize::from((found[0] - uv[0]).hypot(found[1] - uv[1]) <= MOST_UV)
            };
            near += is_near(s.xyz, uv);
            let limits = m.bands.limits_nm().iter();
            let bands: Vec<BandIrradiance> = limits
                .zip(&s.spectral)
                .map(|(limits_nm, v)| BandIrradiance { limits_nm: *limits_nm, irradiance: v.irradiance })
                .collect();
            face_near += is_near(face_xyz(&bands, s.xyz[1], &white), face_uv);
        }
        let n = off.len().max(1) as f64;
        sheet.topic("RMS relative difference of the illuminance", SOURCE, "");
        sheet.at_most(arrangement, MOST_RMS, (off.iter().map(|o| o * o).sum::<f64>() / n).sqrt());
        sheet.topic("share of the points within 0.002 in u'v', light that arrives", SOURCE, "");
        sheet.at_least(arrangement, 0.95, near as f64 / n);
        sheet.topic("share of the points within 0.002 in u'v', light that the white face sends out", FACE_SOURCE, "");
        sheet.at_least(arrangement, 0.95, face_near as f64 / n);
        sheet.topic("share of the points within their stated error", SOURCE, "");
        sheet.at_least(arrangement, 0.95, inside as f64 / n);
        if arrangement == "louvre" {
            sheet.topic("direct light on fronts that do not see the light", "geometry", "lx");
            let most = sensors.iter().map(|s| s.direct_lx).fold(0.0, f64::max);
            sheet.equal("louvre, the most at any point", exact(0.0), most, 0.0);
        }
    }
    Ok(())
}
