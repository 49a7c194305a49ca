//! Colour: published differences, illuminants, daylight, and round trips.

use super::References;
use super::references::Row;
use super::sheet::{Sheet, exact, known};
use crate::spectrum::cie::{self, Observer};
use crate::spectrum::colour::{
    ACESCG, BRADFORD, CAT02, CAT16, REC709, REC2020, adaptation, apply, cct, ciede2000, linear_srgb, rec2020_decode,
    rec2020_encode, reflectance_rgb, rendering, srgb_decode, srgb_encode, xy, xyz_of,
};
use crate::spectrum::{
    Action, KM, KM_SCOTOPIC, SpectralValue, Spectrum, daylight_factors, daylight_xy, from_cct, illuminant,
};
use crate::{Error, Result};

/// Sums of the published tables, nm: range and step.
const SUM_NM: (f64, f64, f64) = (380.0, 780.0, 5.0);
/// Rounding of sums of some hundred products.
const ROUNDING: f64 = 1e-9;

pub(super) fn run(references: &References, sheet: &mut Sheet) -> Result<()> {
    for row in references.rows("colour.csv")? {
        let reference = known(row.number("value")?, row.number("uncertainty")?);
        let (value, source) = match row.text("kind")? {
            "ciede2000" => (difference(&row)?, "Sharma, Wu and Dalal 2005, table 1"),
            "source" => (of_source(&row)?, "CIE 15:2018 tables summed at 5 nm by another program"),
            _ => (of_daylight(&row)?, "CIE 15:2018, phases of daylight, by another program"),
        };
        sheet.topic(&format!("{} of colours and lights", row.text("field")?), source, "");
        let name = format!("{} {}", row.text("case")?, row.text("field")?);
        sheet.equal(name, reference, value, ROUNDING * value.abs().max(1e-3));
    }
    photometry(sheet);
    spaces(sheet);
    round_trips(sheet);
    Ok(())
}

fn lamp(name: &str) -> Result<Spectrum> {
    illuminant(name).ok_or_else(|| Error::malformed(format!("no illuminant {name}")).in_file("colour.csv"))
}

fn difference(row: &Row) -> Result<f64> {
    let [l1, a1, b1, l2, a2, b2] = row.numbers::<6>("input")?;
    Ok(ciede2000([l1, a1, b1], [l2, a2, b2]))
}

fn of_source(row: &Row) -> Result<f64> {
    let light = lamp(row.text("case")?)?;
    let (lo, hi, step) = SUM_NM;
    let xyz = cie::sum(Observer::Cie1931, &[&light], lo, hi, step);
    let place = xy(xyz).unwrap_or([f64::NAN; 2]);
    let temperature = || cct(place);
    let action = |a: Action| (0..=80).map(|i| lo + step * f64::from(i)).map(|nm| light.at(nm) * a.at(nm)).sum::<f64>();
    Ok(match row.text("field")? {
        "x" => place[0],
        "y" => place[1],
        "CCT_K" => temperature().map_or(f64::NAN, |t| t.kelvin),
        "Duv" => temperature().map_or(f64::NAN, |t| t.duv),
        "Ra" => rendering(&light).map_or(f64::NAN, |r| r.ra),
        "R9" => rendering(&light).map_or(f64::NAN, |r| r.special[8]),
        "melanopic_DER" => action(Action::Melanopic) / (KM * xyz[1]) / Action::Melanopic.d65_w_lm().unwrap_or(f64::NAN),
        _ => KM_SCOTOPIC * action(Action::Scotopic) / (KM * xyz[1]),
    })
}

fn of_daylight(row: &Row) -> Result<f64> {
    let kelvin = row.number("case")?;
    let ([x, y], [m1, m2]) = (daylight_xy(kelvin), daylight_factors(kelvin));
    Ok(match row.text("field")? {
        "xD" => x,
        "yD" => y,
        "M1" => m1,
        "M2" => m2,
        "S450" => from_cct(kelvin)?.at(450.0),
        _ => from_cct(kelvin)?.at(600.0),
    })
}

fn photometry(sheet: &mut Sheet) {
    sheet.topic("sums of the colour-matching functions at 1 nm", "CIE 018:2019", "nm");
    let sums = cie::integral(&Spectrum::constant(1.0), cie::FIRST_NM, cie::LAST_NM);
    for (name, (value, published)) in ["x", "y", "z"].iter().zip(sums.into_iter().zip([106.865, 106.857, 106.892])) {
        // Three decimals; the integral of the linear curve drops half of the first and last entries.
        sheet.equal(*name, known(published, 5e-4), value, 1e-4);
    }
    sheet.topic("luminous efficacy at 555 nm", "CIE 018:2019, K_m", "lm/W");
    sheet.equal("K_m V(555 nm)", exact(683.002), KM * cie::cmf(555.0)[1], 1e-9);
    sheet.topic("white points", "CIE 15:2018, table 3: four decimals", "");
    for (name, x, y) in
        [("A", 0.4476, 0.4074), ("D50", 0.3457, 0.3585), ("D55", 0.3324, 0.3474), ("D65", 0.3127, 0.3290)]
    {
        let found = illuminant(name).and_then(|s| xy(s.xyz())).unwrap_or([f64::NAN; 2]);
        sheet.equal(format!("{name} x"), known(x, 5e-5), found[0], 2e-5);
        sheet.equal(format!("{name} y"), known(y, 5e-5), found[1], 2e-5);
    }
}

fn spaces(sheet: &mut Sheet) {
    sheet.topic("luminance of the primaries", "ITU-R BT.709, BT.2020, ACES S-2014-004", "");
    for (name, space, published, digits) in [
        ("BT.709", REC709, [0.2126, 0.7152, 0.0722], 5e-5),
        ("BT.2020", REC2020, [0.2627, 0.6780, 0.0593], 5e-5),
        ("ACEScg", ACESCG, [0.272_228_716_8, 0.674_081_765_8, 0.053_689_517_4], 5e-11),
    ] {
        for (k, value) in space.xyz_from_rgb()[1].into_iter().enumerate() {
            sheet.equal(format!("{name} {}", ["R", "G", "B"][k]), known(published[k], digits), value, 1e-12);
        }
    }
    sheet.topic("adaptation turns white into white", "definition (von Kries)", "");
    let (from, to) = (xyz_of([0.4476, 0.4074], 1.0), xyz_of([0.3127, 0.3290], 1.0));
    for (name, lms) in [("Bradford", BRADFORD), ("CAT02", CAT02), ("CAT16", CAT16)] {
        let found = apply(&adaptation(&lms, from, to), from);
        for k in 0..3 {
            sheet.equal(format!("{name} {}", ["X", "Y", "Z"][k]), exact(to[k]), found[k], 1e-12);
        }
    }
}

/// Largest difference over a walk.
fn worst(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |m, v| if v.is_nan() { f64::NAN } else { m.max(v.abs()) })
}

fn round_trips(sheet: &mut Sheet) {
    sheet.topic("decoding undoes encoding", "IEC 61966-2-1, ITU-R BT.2020", "");
    let levels = || (0..=1000).map(|i| f64::from(i) / 1000.0);
    sheet.at_most("sRGB, largest difference", 1e-7, worst(levels().map(|v| srgb_decode(srgb_encode(v)) - v)));
    sheet.at_most("BT.2020, largest difference", 1e-12, worst(levels().map(|v| rec2020_decode(rec2020_encode(v)) - v)));
    sheet.topic("white is R = G = B = 1", "definition", "");
    for (k, v) in linear_srgb(xyz_of(REC709.white, 1.0)).into_iter().enumerate() {
        sheet.equal(["R", "G", "B"][k], exact(1.0), v, 1e-12);
    }
    sheet.topic("RGB to a reflectance curve and back, over 8 × 8 × 8 colours of sRGB", "Jakob and Hanika 2019", "");
    let Some(d65) = illuminant("D65") else { return };
    let (mut off, mut low, mut high) = (0.0f64, f64::INFINITY, f64::NEG_INFINITY);
    for i in 0..512u32 {
        let rgb = [i % 8, i / 8 % 8, i / 64].map(|v| f64::from(v) / 7.0);
        let curve = SpectralValue::Rgb(rgb).to_spectrum();
        let back = reflectance_rgb(&curve, &d65).unwrap_or([f64::NAN; 3]);
        off = off.max(worst((0..3).map(|k| back[k] - rgb[k])));
        (low, high) = (low.min(curve.min()), high.max(curve.max()));
    }
    sheet.at_most("largest difference", 1e-3, off);
    sheet.at_least("least reflectance", 0.0, low);
    sheet.at_most("largest reflectance", 1.0, high);
}
