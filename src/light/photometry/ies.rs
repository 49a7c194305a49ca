//! IES LM-63: the North American format, in its versions of 1986, 1991, 1995, 2002 and 2019.

use std::path::Path;

use super::numbers::{Numbers, rising, size_m};
use super::{Format, Opening, PhotometricType, Photometry, Tilt, Web};
use crate::{Error, Result};

/// Angles of one kind, at most; what a file holds bounds the rest.
const MOST_ANGLES: usize = 100_000;

const FOOT_M: f64 = 0.3048;

/// Number of the TILT line, from zero, and what it says.
pub(super) fn tilt_line(text: &str) -> Option<(usize, &str)> {
    text.lines().enumerate().find_map(|(k, line)| {
        let (key, value) = line.trim().split_once('=')?;
        key.trim().eq_ignore_ascii_case("TILT").then_some((k, value.trim()))
    })
}

/// Reads a file; `path` tells where a separate TILT file lies.
pub(super) fn parse(text: &str, path: &Path) -> Result<Photometry> {
    let Some((at, tilt)) = tilt_line(text) else {
        return Err(Error::malformed("there is no line `TILT=`: not an IES LM-63 file")
            .at_line(1)
            .mend("add TILT=NONE before the numbers"));
    };
    let mut warnings = Vec::new();
    let year = year(text, at, &mut warnings);
    let labels = labels(text.lines().take(at));
    let mut numbers = Numbers::new(text.lines().skip(at + 1), at + 2);
    let tilt = match tilt.to_ascii_uppercase().as_str() {
        "NONE" => None,
        "INCLUDE" => Some(tilt_table(&mut numbers)?),
        "" => return Err(Error::malformed("`TILT=` says nothing").at_line(at + 1).mend("write TILT=NONE")),
        _ => Some(tilt_file(tilt, path).map_err(|e| e.at_line(at + 1))?),
    };
    let head = head(&mut numbers, year, &mut warnings)?;
    let vertical_deg = numbers.list(head.verticals, "vertical angle")?;
    let vertical_deg = rising(vertical_deg, "vertical angles").map_err(|e| e.at_line(numbers.line()))?;
    let vertical_line = numbers.line();
    let horizontal_deg = numbers.list(head.horizontals, "horizontal angle")?;
    let horizontal_deg = rising(horizontal_deg, "horizontal angles").map_err(|e| e.at_line(numbers.line()))?;
    let expected = head.verticals * head.horizontals;
    if numbers.left() < expected {
        return Err(Error::malformed(format!(
            "{expected} candelas expected ({} planes of {} angles), {} found",
            head.horizontals,
            head.verticals,
            numbers.left()
        ))
        .at_line(numbers.line())
        .mend("the file is cut short, or a count in its head is wrong"));
    }
    let candela = candelas(&mut numbers, &vertical_deg, &horizontal_deg, head.factor)?;
    if numbers.left() > 0 {
        warnings.push(format!("{} numbers after the last candela are not read", numbers.left()));
    }
    tell_range(head.kind, &vertical_deg, &mut warnings);
    let web = Web::new(head.kind, vertical_deg, horizontal_deg, candela).map_err(|e| e.at_line(vertical_line))?;
    Ok(Photometry {
        format: Format::Ies(year),
        web,
        opening: head.opening,
        labels,
        lamps: head.lamps,
        rated_flux_lm: head.rated_flux_lm,
        stated_flux_lm: None,
        power_w: head.power_w,
        tilt,
        warnings,
    })
}

/// The version that the first line states; none is that of 1986.
fn year(text: &str, tilt_at: usize, warnings: &mut Vec<String>) -> u16 {
    let first = text.lines().next().unwrap_or("").trim().to_ascii_uppercase();
    if tilt_at == 0 || !first.starts_with("IES") {
        return 1986;
    }
    let years =
        [("2019", 2019), ("2002", 2002), ("1995", 1995), ("1991", 1991), ("1986", 1986), ("95", 1995), ("91", 1991)];
    if let Some((_, year)) = years.iter().find(|(mark, _)| first.contains(mark)) {
        return *year;
    }
    warnings
        .push(format!("the version `{}` is not known: read as LM-63-2002", first.chars().take(40).collect::<String>()));
    2002
}

/// `[KEYWORD] text`; a line that has none goes on with the one before (`[MORE]` too), or stands alone before the first.
fn labels<'a>(lines: impl Iterator<Item = &'a str>) -> Vec<(String, String)> {
    let mut labels: Vec<(String, String)> = Vec::new();
    for line in lines.map(str::trim).filter(|l| !l.is_empty()) {
        let keyword = line.strip_prefix('[').and_then(|rest| rest.split_once(']'));
        match (keyword, labels.last_mut()) {
            (Some((key, text)), Some(last)) if key.eq_ignore_ascii_case("MORE") => {
                last.1 = format!("{} {}", last.1, text.trim());
            }
            (Some((key, text)), _) => labels.push((key.trim().to_owned(), text.trim().to_owned())),
            (None, _) if line.to_ascii_uppercase().starts_with("IES") => {}
            (None, _) => labels.push(("OTHER".into(), line.to_owned())),
        }
    }
    labels
}

fn tilt_table(numbers: &mut Numbers<'_>) -> Result<Tilt> {
    numbers.number("the lamp-to-luminaire geometry of TILT")?;
    let count = numbers.count("the number of TILT angles", MOST_ANGLES)?;
    let angles_deg = numbers.list(count, "TILT angle")?;
    let angles_deg = rising(angles_deg, "TILT angles").map_err(|e| e.at_line(numbers.line()))?;
    let factors = numbers.list(count, "TILT factor")?;
    match factors.iter().find(|f| **f < 0.0) {
        Some(f) => Err(Error::malformed(format!("a TILT factor is {f}"))
            .at_line(numbers.line())
            .mend("factors are shares of the upright output: zero or more")),
        None => Ok(Tilt { angles_deg, factors }),
    }
}

/// A TILT table in a file of its own, beside the photometric file.
fn tilt_file(name: &str, path: &Path) -> Result<Tilt> {
    let beside = path.parent().unwrap_or_else(|| Path::new("")).join(name);
    let bytes = std::fs::read(&beside).map_err(|_| {
        Error::malformed(format!("the TILT file `{name}` cannot be read"))
            .mend("put it beside the photometric file, or write TILT=NONE")
    })?;
    let text = super::text(&bytes);
    tilt_table(&mut Numbers::new(text.lines(), 1)).map_err(|e| e.in_file(&beside))
}

/// The two lines of numbers before the angles.
struct Head {
    lamps: f64,
    rated_flux_lm: Option<f64>,
    /// What every candela is multiplied by.
    factor: f64,
    verticals: usize,
    horizontals: usize,
    kind: PhotometricType,
    opening: Opening,
    power_w: f64,
}

fn head(numbers: &mut Numbers<'_>, year: u16, warnings: &mut Vec<String>) -> Result<Head> {
    let lamps = numbers.number("the number of lamps")?;
    let lumens = numbers.number("the lumens per lamp")?;
    let multiplier = positive(numbers, "the candela multiplier")?;
    let verticals = numbers.count("the number of vertical angles", MOST_ANGLES)?;
    let horizontals = numbers.count("the number of horizontal angles", MOST_ANGLES)?;
    let kind = match numbers.number("the photometric type")? {
        1.0 => PhotometricType::C,
        2.0 => PhotometricType::B,
        3.0 => PhotometricType::A,
        other => return Err(field(numbers, "the photometric type", other, "1 (C), 2 (B) or 3 (A)")),
    };
    let metres = match numbers.number("the units code")? {
        1.0 => FOOT_M,
        2.0 => 1.0,
        other => return Err(field(numbers, "the units code", other, "1 (feet) or 2 (metres)")),
    };
    let mut size = |what| {
        let m = numbers.number(what)? * metres;
        size_m(m, what).map_err(|e| e.at_line(numbers.line()))
    };
    let [width, length, height] =
        [size("the luminous width")?, size("the luminous length")?, size("the luminous height")?];
    let ballast = positive(numbers, "the ballast factor")?;
    let third = third_factor(numbers, year, warnings)?;
    let power_w = numbers.number("the input watts")?;
    // −1 lumens mark absolute photometry.
    let rated_flux_lm = (lumens > 0.0 && lamps > 0.0).then_some(lamps * lumens);
    Ok(Head {
        lamps,
        rated_flux_lm,
        factor: multiplier * ballast * third,
        verticals,
        horizontals,
        kind,
        opening: opening(width, length, height),
        power_w,
    })
}

fn field(numbers: &Numbers<'_>, what: &str, found: f64, expected: &str) -> Error {
    Error::malformed(format!("{what} is {found}")).at_line(numbers.line()).mend(format!("it must be {expected}"))
}

fn positive(numbers: &mut Numbers<'_>, what: &str) -> Result<f64> {
    match numbers.number(what)? {
        n if n > 0.0 => Ok(n),
        n => Err(field(numbers, what, n, "a positive number, usually 1")),
    }
}

/// The number after the ballast factor: the ballast-lamp photometric factor up to 1995, nothing in 2002, a code for how
/// the file was made in 2019.
fn third_factor(numbers: &mut Numbers<'_>, year: u16, warnings: &mut Vec<String>) -> Result<f64> {
    let third = numbers.number("the number after the ballast factor")?;
    match year {
        2019 => Ok(1.0),
        2002 if third != 1.0 => {
            warnings.push(format!(
                "the number after the ballast factor is {third}: LM-63-2002 gives it no meaning, 1 is used"
            ));
            Ok(1.0)
        }
        2002 => Ok(1.0),
        _ if third > 0.0 => Ok(third),
        _ => {
            warnings.push(format!("the ballast-lamp photometric factor is {third}: 1 is used"));
            Ok(1.0)
        }
    }
}

/// Width lies along the plane 90-270, length along 0-180; negative sizes are diameters.
fn opening(width_m: f64, length_m: f64, height_m: f64) -> Opening {
    let (across, along, height) = (width_m.abs(), length_m.abs(), height_m.abs());
    // One diameter alone is that of a circle (1986 to 1995).
    let circle = width_m < 0.0 && length_m == 0.0;
    Opening {
        along_c0_m: if circle { across } else { along },
        along_c90_m: across,
        // A cylinder that lies is as high as it is wide.
        height_m: match (width_m < 0.0, length_m < 0.0) {
            (true, false) if !circle => height.max(across),
            (false, true) => height.max(along),
            _ => height,
        },
        round: circle || (width_m < 0.0 && length_m < 0.0),
    }
}

fn candelas(numbers: &mut Numbers<'_>, vertical: &[f64], horizontal: &[f64], factor: f64) -> Result<Vec<f64>> {
    let mut candela = Vec::with_capacity(vertical.len() * horizontal.len());
    for h in horizontal {
        for v in vertical {
            let value = numbers.number(&format!("the intensity at vertical {v}, horizontal {h} degrees"))?;
            if value < 0.0 {
                return Err(Error::malformed(format!(
                    "the intensity at vertical {v}, horizontal {h} degrees is {value}"
                ))
                .at_line(numbers.line())
                .mend("intensities are zero or more: correct it"));
            }
            candela.push(value * factor);
        }
    }
    Ok(candela)
}

/// Tells where the web ends short of what the standard asks for.
fn tell_range(kind: PhotometricType, vertical_deg: &[f64], warnings: &mut Vec<String>) {
    let (first, last) = (vertical_deg[0], vertical_deg[vertical_deg.len() - 1]);
    let (starts, ends) = match kind {
        PhotometricType::C => ([0.0, 90.0], [90.0, 180.0]),
        _ => ([-90.0, 0.0], [90.0, 90.0]),
    };
    if !starts.contains(&first) || !ends.contains(&last) || (kind != PhotometricType::C && first == 0.0) {
        warnings
            .push(format!("vertical angles reach from {first} to {last} degrees alone: no light is assumed beyond"));
    }
}
