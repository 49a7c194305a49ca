//! [`Photometry`] as a file: IES LM-63-2002 and EULUMDAT.

use std::fmt::Write;

use super::numbers::LARGEST;
use super::{PhotometricType, Photometry, Symmetry};
use crate::{Error, Result};

/// Keywords of LM-63-2002; others are written as a user's own.
const KEYWORDS: [&str; 12] = [
    "TEST",
    "TESTLAB",
    "ISSUEDATE",
    "MANUFAC",
    "LUMCAT",
    "LUMINAIRE",
    "LAMPCAT",
    "LAMP",
    "BALLAST",
    "BALLASTCAT",
    "DATE",
    "OTHER",
];
/// Numbers on a line.
const ACROSS: usize = 10;
/// Longest text of a keyword.
const LONGEST: usize = 200;

/// Nine significant digits: what a number is, without the noise of its last bits.
fn tidy(x: f64) -> f64 {
    format!("{x:.8e}").parse().unwrap_or(x)
}

/// One line of plain text.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(LONGEST).collect()
}

fn numbers(text: &mut String, list: &[f64]) {
    for row in list.chunks(ACROSS) {
        let words: Vec<String> = row.iter().map(|x| tidy(*x).to_string()).collect();
        text.push_str(&words.join(" "));
        text.push('\n');
    }
}

/// The luminaire as IES LM-63-2002.
#[must_use]
pub fn to_ies(p: &Photometry) -> String {
    let mut text = String::from("IESNA:LM-63-2002\n");
    for (key, value) in &p.labels {
        let key = key.trim_start_matches('_').to_ascii_uppercase();
        let own = if KEYWORDS.contains(&key.as_str()) { "" } else { "_" };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "[{own}{}] {}", plain(&key), plain(value));
    }
    match &p.tilt {
        None => text.push_str("TILT=NONE\n"),
        Some(tilt) => {
            let _ = writeln!(text, "TILT=INCLUDE\n1\n{}", tilt.angles_deg.len());
            numbers(&mut text, &tilt.angles_deg);
            numbers(&mut text, &tilt.factors);
        }
    }
    let (web, o) = (&p.web, &p.opening);
    let kind = match web.kind() {
        PhotometricType::C => 1,
        PhotometricType::B => 2,
        PhotometricType::A => 3,
    };
    let lamps = p.lamps.max(1.0);
    let lumens = p.rated_flux_lm.map_or(-1.0, |r| tidy(r / lamps));
    let sign = if o.round { -1.0 } else { 1.0 };
    let (verticals, horizontals) = (web.vertical_deg(), web.horizontal_deg());
    let _ = writeln!(
        text,
        "{lamps} {lumens} 1 {} {} {kind} 2 {} {} {}",
        verticals.len(),
        horizontals.len(),
        tidy(sign * o.along_c90_m),
        tidy(sign * o.along_c0_m),
        tidy(o.height_m)
    );
    let _ = writeln!(text, "1 1 {}", p.power_w);
    numbers(&mut text, verticals);
    numbers(&mut text, horizontals);
    for h in 0..horizontals.len() {
        numbers(&mut text, web.plane(h));
    }
    text
}

/// Where a web begins above nadir, EULUMDAT needs darkness below: up to so little before its first angle, degrees.
const EDGE_DEG: f64 = 0.01;

/// The luminaire as EULUMDAT.
///
/// # Errors
/// Photometry of types A and B: the format knows C-planes alone; lumens of the lamps that the candelas go beyond.
pub fn to_eulumdat(p: &Photometry) -> Result<String> {
    let web = &p.web;
    if web.kind() != PhotometricType::C {
        return Err(Error::unsupported(format!("EULUMDAT holds no photometry of type {}", web.kind().name()))
            .mend("keep it as IES"));
    }
    let (isym, planes_deg, stored) = planes(p);
    let dark: Vec<f64> = match web.vertical_deg()[0] {
        first if first > EDGE_DEG => vec![0.0, first - EDGE_DEG],
        _ => Vec::new(),
    };
    let angles: Vec<f64> = dark.iter().chain(web.vertical_deg()).copied().collect();
    let flux_lm = web.flux_lm();
    let lamps_lm = p.rated_flux_lm.unwrap_or(flux_lm);
    if lamps_lm <= 0.0 {
        return Err(Error::impossible("EULUMDAT scales by lumens, and this luminaire has none").mend("keep it as IES"));
    }
    if lamps_lm > LARGEST || web.peak().0.max(flux_lm) * 1000.0 / lamps_lm > LARGEST {
        return Err(Error::impossible(format!("{flux_lm:e} lm cannot be scaled by the {lamps_lm:e} lm of its lamps"))
            .mend("keep it as IES"));
    }
    let mut lines: Vec<String> = vec![plain(p.label("MANUFAC").unwrap_or(""))];
    let mut add = |value: f64| lines.push(tidy(value).to_string());
    let o = &p.opening;
    // 1: a point with an axis, 2: linear, 3: any other.
    let linear = o.along_c0_m.max(o.along_c90_m) > 4.0 * o.along_c0_m.min(o.along_c90_m);
    add(if isym == 1 {
        1.0
    } else if linear {
        2.0
    } else {
        3.0
    });
    add(f64::from(isym));
    add(planes_deg.len() as f64);
    add(step(&planes_deg));
    add(angles.len() as f64);
    add(step(&angles));
    lines.push(plain(p.label("TEST").unwrap_or("")));
    lines.push(plain(p.name()));
    lines.push(plain(p.label("LUMCAT").unwrap_or("")));
    lines.push(plain(p.label("FILE").unwrap_or("")));
    lines.push(plain(p.label("DATE").or_else(|| p.label("ISSUEDATE")).unwrap_or("")));
    let (length, width) = if o.round {
        ((o.along_c0_m * o.along_c90_m).sqrt() * 1e3, 0.0)
    } else {
        (o.along_c90_m * 1e3, o.along_c0_m * 1e3)
    };
    let height = o.height_m * 1e3;
    let mut add = |values: &[f64]| lines.extend(values.iter().map(|v| tidy(*v).to_string()));
    // Sizes of the luminaire, unknown here, are those of its opening.
    add(&[length, width, height, length, width, height, height, height, height]);
    add(&[100.0 * web.zone_flux_lm(0.0, 90.0) / flux_lm.max(f64::MIN_POSITIVE), 100.0 * flux_lm / lamps_lm, 1.0, 0.0]);
    add(&[1.0, if p.rated_flux_lm.is_some() { p.lamps.max(1.0) } else { -1.0 }]);
    lines.push(plain(p.label("LAMP").unwrap_or("")));
    lines.push(tidy(lamps_lm).to_string());
    lines.push(plain(p.label("COLOR").or_else(|| p.label("_COLOR")).unwrap_or("")));
    lines.push(plain(p.label("CRI").or_else(|| p.label("_CRI")).unwrap_or("")));
    let mut add = |values: &[f64]| lines.extend(values.iter().map(|v| tidy(*v).to_string()));
    add(&[p.power_w]);
    // Direct ratios: not known.
    add(&[0.0; 10]);
    add(&planes_deg);
    add(&angles);
    for h in stored {
        add(&vec![0.0; dark.len()]);
        let per_klm: Vec<f64> = web.plane(h).iter().map(|i| i * 1000.0 / lamps_lm).collect();
        add(&per_klm);
    }
    Ok(lines.join("\r\n") + "\r\n")
}

/// Symmetry code, all C-planes of the circle, and the numbers of the web's planes that are written, in order.
fn planes(p: &Photometry) -> (u8, Vec<f64>, Vec<usize>) {
    let stored = p.web.horizontal_deg();
    let all = 0..stored.len();
    let circle = |images: &dyn Fn(f64) -> Vec<f64>| {
        let mut planes: Vec<f64> = stored.iter().flat_map(|c| images(*c)).map(|c| tidy(c.rem_euclid(360.0))).collect();
        planes.sort_by(f64::total_cmp);
        planes.dedup();
        planes
    };
    match p.web.symmetry() {
        Symmetry::Axial => (1, vec![0.0], vec![0]),
        Symmetry::Quadrant => (4, circle(&|c| vec![c, 180.0 - c, 180.0 + c, 360.0 - c]), all.collect()),
        Symmetry::Bilateral => (2, circle(&|c| vec![c, 360.0 - c]), all.collect()),
        Symmetry::Lateral => (3, circle(&|c| vec![c, 180.0 - c]), all.rev().collect()),
        Symmetry::None => (0, stored[..stored.len() - 1].to_vec(), (0..stored.len() - 1).collect()),
    }
}

/// The step of a list, 0 where it has several.
fn step(list: &[f64]) -> f64 {
    let Some(first) = list.windows(2).next().map(|w| w[1] - w[0]) else { return 0.0 };
    if list.windows(2).all(|w| (w[1] - w[0] - first).abs() < 1e-9) { first } else { 0.0 }
}
