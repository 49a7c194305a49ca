//! EULUMDAT (A. Stockmar 1990): the European format, one value a line.

use super::numbers::{count, parse as number, rising, size_m};
use super::{Format, Opening, PhotometricType, Photometry, Web};
use crate::{Error, Result};

/// Planes and angles, at most; what a file holds bounds the rest.
const MOST_ANGLES: usize = 100_000;
const MOST_LAMP_SETS: usize = 20;
/// Lines before the lamp sets, of a lamp set, and of the direct ratios after them.
const HEAD_LINES: usize = 26;
const SET_LINES: usize = 6;
const RATIO_LINES: usize = 10;

/// The lines of a file, counted from one as the format's own description does.
struct Lines<'a>(Vec<&'a str>);

impl Lines<'_> {
    fn text(&self, line: usize) -> &str {
        self.0.get(line - 1).map_or("", |l| l.trim())
    }

    fn number(&self, line: usize, what: &str) -> Result<f64> {
        if line > self.0.len() {
            return Err(Error::malformed(format!("the file ends before {what} (line {line})"))
                .at_line(self.0.len())
                .mend("the file is cut short: get it again"));
        }
        number(self.text(line), what).map_err(|e| e.at_line(line))
    }

    fn count(&self, line: usize, what: &str, most: usize) -> Result<usize> {
        count(self.number(line, what)?, what, most).map_err(|e| e.at_line(line))
    }

    /// A size in mm, as metres.
    fn metres(&self, line: usize, what: &str) -> Result<f64> {
        let mm = self.number(line, what)?;
        if mm < 0.0 {
            return Err(Error::malformed(format!("{what} is {mm} mm")).at_line(line).mend("sizes are zero or more"));
        }
        size_m(mm / 1000.0, what).map_err(|e| e.at_line(line))
    }

    fn list(&self, from: usize, count: usize, what: &str) -> Result<Vec<f64>> {
        let found = (self.0.len() + 1).saturating_sub(from);
        if found < count {
            return Err(Error::malformed(format!("{what}: {count} lines expected from line {from} on, {found} found"))
                .at_line(self.0.len())
                .mend("the file is cut short, or one of its counts is too large"));
        }
        (0..count).map(|k| self.number(from + k, what)).collect()
    }
}

/// Reads a file.
pub(super) fn parse(text: &str) -> Result<Photometry> {
    let lines = Lines(text.trim_end_matches(['\u{1a}', '\n', '\r', ' ']).lines().collect());
    let mut warnings = Vec::new();
    let isym = lines.number(3, "the symmetry code (Isym)")?;
    let planes = lines.count(4, "the number of C-planes (Mc)", MOST_ANGLES)?;
    let angles = lines.count(6, "the number of intensities in a plane (Ng)", MOST_ANGLES)?;
    let stored = stored_planes(isym, planes)?;
    let sets = lines.count(26, "the number of lamp sets", MOST_LAMP_SETS)?;
    let lamps = lamps(&lines, sets, &mut warnings)?;
    let c_from = HEAD_LINES + 1 + sets * SET_LINES + RATIO_LINES;
    let g_from = c_from + planes;
    let c_deg = lines.list(c_from, planes, "angles of the C-planes")?;
    let g_deg = lines.list(g_from, angles, "angles in a plane")?;
    let c_deg = rising(c_deg, "angles of the C-planes").map_err(|e| e.at_line(g_from - 1))?;
    let g_deg = rising(g_deg, "angles in a plane").map_err(|e| e.at_line(g_from + angles - 1))?;
    let from = g_from + angles;
    let values = lines.list(from, stored.len() * angles, "intensities")?;
    if let Some(k) = values.iter().position(|v| *v < 0.0) {
        let (c, g) = (c_deg[stored[k / angles]], g_deg[k % angles]);
        return Err(Error::malformed(format!("the intensity at C {c}, gamma {g} degrees is {} cd/klm", values[k]))
            .at_line(from + k)
            .mend("intensities are zero or more: correct it"));
    }
    let conversion = match lines.number(24, "the conversion factor of the intensities")? {
        c if c > 0.0 => c,
        c => {
            warnings.push(format!("the conversion factor of the intensities is {c}: 1 is used"));
            1.0
        }
    };
    let factor = lamps.flux_lm / 1000.0 * conversion;
    let mut planes_deg: Vec<f64> = stored.iter().map(|k| c_deg[*k]).collect();
    let mut candela: Vec<f64> = values.iter().map(|v| v * factor).collect();
    if isym == 3.0 {
        (planes_deg, candela) = mirrored_to_90_270(&planes_deg, &candela, angles);
    }
    if isym == 0.0 && planes_deg[0] == 0.0 && planes_deg[planes - 1] < 360.0 {
        planes_deg.push(360.0);
        candela.extend_from_within(..angles);
    }
    check_ends(isym, &planes_deg).map_err(|e| e.at_line(c_from))?;
    let web = Web::new(PhotometricType::C, g_deg, planes_deg, candela).map_err(|e| e.at_line(c_from))?;
    let ratio_percent = lines.number(23, "the light output ratio")?;
    Ok(Photometry {
        format: Format::Eulumdat,
        web,
        opening: opening(&lines)?,
        labels: labels(&lines),
        lamps: lamps.count,
        rated_flux_lm: Some(lamps.flux_lm),
        stated_flux_lm: (ratio_percent > 0.0).then_some(lamps.flux_lm * ratio_percent / 100.0),
        power_w: lamps.power_w,
        tilt: None,
        warnings,
    })
}

/// Numbers of the planes whose intensities are written, in the order of the file.
fn stored_planes(isym: f64, planes: usize) -> Result<Vec<usize>> {
    let quarter = planes / 4;
    let needs = |times: usize| {
        if planes.is_multiple_of(times) {
            return Ok(());
        }
        Err(Error::malformed(format!("{planes} C-planes (Mc) do not suit the symmetry code {isym}"))
            .at_line(4)
            .mend(format!("their number must be a multiple of {times}")))
    };
    match isym {
        0.0 => Ok((0..planes).collect()),
        1.0 => Ok(vec![0]),
        2.0 => needs(2).map(|()| (0..=planes / 2).collect()),
        // From C270 through C0 to C90.
        3.0 => needs(4).map(|()| (0..=planes / 2).map(|k| (3 * quarter + k) % planes).collect()),
        4.0 => needs(4).map(|()| (0..=quarter).collect()),
        _ => Err(Error::malformed(format!("the symmetry code (Isym) is {isym}"))
            .at_line(3)
            .mend("0 none, 1 about the axis, 2 about C0-C180, 3 about C90-C270, 4 about both")),
    }
}

/// Planes from C270 through C0 to C90, seen in the mirror C90-C270: from C90 to C270.
fn mirrored_to_90_270(planes_deg: &[f64], candela: &[f64], angles: usize) -> (Vec<f64>, Vec<f64>) {
    let mirrored = |c: &f64| if *c > 180.0 { 540.0 - c } else { 180.0 - c };
    let degrees = planes_deg.iter().rev().map(mirrored).collect();
    let candela = candela.chunks_exact(angles).rev().flatten().copied().collect();
    (degrees, candela)
}

/// Do the stored planes reach as far as the symmetry code says?
fn check_ends(isym: f64, planes_deg: &[f64]) -> Result<()> {
    let expected = match isym {
        2.0 => (0.0, 180.0),
        3.0 => (90.0, 270.0),
        4.0 => (0.0, 90.0),
        _ => return Ok(()),
    };
    let found = (planes_deg[0], planes_deg[planes_deg.len() - 1]);
    if (found.0 - expected.0).abs() < 1e-6 && (found.1 - expected.1).abs() < 1e-6 {
        return Ok(());
    }
    Err(Error::malformed(format!(
        "the symmetry code {isym} needs planes from C{} to C{}, the file has C{} to C{}",
        expected.0, expected.1, found.0, found.1
    ))
    .mend("correct the symmetry code (line 3) or the angles of the C-planes"))
}

/// The lamp set that counts.
struct Lamps {
    count: f64,
    flux_lm: f64,
    power_w: f64,
}

/// The first set; the others are told.
fn lamps(lines: &Lines<'_>, sets: usize, warnings: &mut Vec<String>) -> Result<Lamps> {
    let line = HEAD_LINES + 1;
    let count = lines.number(line, "the number of lamps")?;
    let flux_lm = lines.number(line + 2, "the luminous flux of the lamps")?;
    if flux_lm <= 0.0 {
        return Err(Error::malformed(format!("the luminous flux of the lamps is {flux_lm} lm"))
            .at_line(line + 2)
            .mend("intensities are per 1000 lm of it: state it, 1000 for absolute photometry"));
    }
    if sets > 1 {
        warnings
            .push(format!("the file has {sets} lamp sets: the first is used, {flux_lm} lm ({})", lines.text(line + 1)));
    }
    // A word or nothing there is no reason to refuse the light.
    let power_w = number(lines.text(line + 5), "the power").unwrap_or(0.0);
    Ok(Lamps { count: count.abs(), flux_lm, power_w })
}

/// Length lies across C0, width along it; a width of zero is that of a circle.
fn opening(lines: &Lines<'_>) -> Result<Opening> {
    let length_m = lines.metres(16, "the length of the luminous area")?;
    let width_m = lines.metres(17, "the width of the luminous area")?;
    let mut height_m = 0.0;
    for line in 18..=21 {
        height_m += 0.25 * lines.metres(line, "the height of the luminous area")?;
    }
    let round = width_m == 0.0 && length_m > 0.0;
    Ok(Opening { along_c0_m: if round { length_m } else { width_m }, along_c90_m: length_m, height_m, round })
}

fn labels(lines: &Lines<'_>) -> Vec<(String, String)> {
    let lamp = HEAD_LINES + 2;
    [("MANUFAC", 1), ("TEST", 8), ("LUMINAIRE", 9), ("LUMCAT", 10), ("FILE", 11), ("DATE", 12), ("LAMP", lamp)]
        .into_iter()
        .chain([("COLOR", lamp + 2), ("CRI", lamp + 3)])
        .map(|(key, line)| (key.to_owned(), lines.text(line).to_owned()))
        .filter(|(_, text)| !text.is_empty())
        .collect()
}
