//! Light by name and by colour temperature. All spectra here are relative.

use super::tables::daylight::BASIS;
use super::tables::illuminants::{CURVES, NAMES};
use super::{Beyond, Spectrum};
use crate::{Error, Result};

/// Second radiation constant, m K, as the CIE uses it for colour temperatures (ITS-90).
const C2_M_K: f64 = 1.4388e-2;

/// First wavelength and step of the illuminants' tables, nm.
const TABLE_NM: (f64, f64) = (380.0, 5.0);
/// First wavelength and step of the daylight components, nm.
const DAYLIGHT_NM: (f64, f64) = (300.0, 5.0);

/// Where CIE's formula for illuminant A defines c2/T, nm, and what it is normalised at.
const ILLUMINANT_A: (f64, f64) = (1.435e7 / 2848.0, 560.0);

/// Range of [`from_cct`], K.
const CCT_K: (f64, f64) = (1000.0, 25000.0);
/// Least colour temperature of CIE daylight, K.
const LEAST_DAYLIGHT_K: f64 = 4000.0;
/// From here on, K, lights are compared with daylight instead of black bodies (CIE 13.3-1995).
pub(super) const LEAST_PHASE_K: f64 = 5000.0;

/// The names that [`illuminant`] knows.
#[must_use]
pub fn illuminant_names() -> &'static [&'static str] {
    &NAMES
}

/// A CIE illuminant by name (upper or lower case), relative; `None` if there is none of that name.
///
/// Source: CIE 15:2018. A and the D series reach from 300 to 830 nm (by CIE's formulas where the table
/// ends), E is the same everywhere, the others are zero outside 380 to 780 nm.
#[must_use]
pub fn illuminant(name: &str) -> Option<Spectrum> {
    if name.eq_ignore_ascii_case("E") {
        return Some(Spectrum::constant(100.0));
    }
    let (name, table) = CURVES.iter().find(|c| c.0.eq_ignore_ascii_case(name))?;
    Some(match *name {
        "A" => extended(table, illuminant_a),
        "D50" => extended(table, |nm| daylight_at(5000.0, nm)),
        "D55" => extended(table, |nm| daylight_at(5500.0, nm)),
        "D65" => extended(table, |nm| daylight_at(6500.0, nm)),
        "D75" => extended(table, |nm| daylight_at(7500.0, nm)),
        _ => {
            let nm = (0..table.len()).map(|i| TABLE_NM.0 + TABLE_NM.1 * i as f64);
            Spectrum::from_knots(nm.collect(), table.to_vec(), Beyond::Zero)
        }
    })
}

/// The table between its ends, `formula` beyond, 300 to 830 nm.
fn extended(table: &[f64], formula: impl Fn(f64) -> f64) -> Spectrum {
    sampled(|nm| {
        let place = (nm - TABLE_NM.0) / TABLE_NM.1;
        let inside = place >= 0.0 && place < table.len() as f64;
        if inside { table[place as usize] } else { formula(nm) }
    })
}

/// A curve at the wavelengths of the daylight components.
fn sampled(formula: impl Fn(f64) -> f64) -> Spectrum {
    let nm: Vec<f64> = (0..BASIS.len()).map(|i| DAYLIGHT_NM.0 + DAYLIGHT_NM.1 * i as f64).collect();
    let value = nm.iter().map(|&nm| formula(nm)).collect();
    Spectrum::from_knots(nm, value, Beyond::Zero)
}

/// CIE standard illuminant A, 100 at 560 nm (CIE 15:2018).
fn illuminant_a(nm: f64) -> f64 {
    let (c2_over_t, norm) = ILLUMINANT_A;
    100.0 * (norm / nm).powi(5) * (c2_over_t / norm).exp_m1() / (c2_over_t / nm).exp_m1()
}

/// A D illuminant of nominal colour temperature, beyond its table. The nominal temperature belongs to an
/// older c2 (1.4380e-2 m K), and CIE rounds the factors to three decimals.
fn daylight_at(nominal_k: f64, nm: f64) -> f64 {
    let m = daylight_factors(nominal_k * 1.4388 / 1.4380).map(|m| (m * 1e3).round() / 1e3);
    daylight_value(m, nm)
}

/// Light of a colour temperature in kelvin, relative: CIE daylight from 4000 to 25000 K (CIE 15:2018),
/// 100 at 560 nm; a black body below, from 1000 K.
///
/// # Errors
/// Impossible outside 1000 to 25000 K.
pub fn from_cct(kelvin: f64) -> Result<Spectrum> {
    if !(CCT_K.0..=CCT_K.1).contains(&kelvin) {
        return Err(Error::impossible(format!(
            "a colour temperature of {kelvin} K is out of range, expected {} to {} K",
            CCT_K.0, CCT_K.1
        ))
        .mend("give the spectrum as a file or name a CIE illuminant"));
    }
    Ok(if kelvin < LEAST_DAYLIGHT_K { black_body(kelvin) } else { daylight(kelvin) })
}

/// A black body, 100 at 560 nm.
pub(super) fn black_body(kelvin: f64) -> Spectrum {
    let norm = planck(560.0, kelvin);
    sampled(|nm| 100.0 * planck(nm, kelvin) / norm)
}

/// CIE daylight, 100 at 560 nm; defined from 4000 to 25000 K.
pub(super) fn daylight(kelvin: f64) -> Spectrum {
    let m = daylight_factors(kelvin);
    sampled(|nm| daylight_value(m, nm))
}

/// Spectral exitance of a black body, relative, at a wavelength in nm.
pub(super) fn planck(nm: f64, kelvin: f64) -> f64 {
    let m = nm * 1e-9;
    (560.0 / nm).powi(5) / (C2_M_K / (m * kelvin)).exp_m1()
}

/// Chromaticity x, y of CIE daylight of 4000 to 25000 K (CIE 15:2018, phases of daylight).
#[must_use]
pub fn daylight_xy(kelvin: f64) -> [f64; 2] {
    let t = 1e3 / kelvin;
    let x = if kelvin <= 7000.0 {
        0.244063 + t * (0.09911 + t * (2.9678 - t * 4.6070))
    } else {
        0.237040 + t * (0.24748 + t * (1.9018 - t * 2.0064))
    };
    [x, -3.0 * x * x + 2.870 * x - 0.275]
}

/// Factors M1 and M2 of the components of CIE daylight of 4000 to 25000 K.
#[must_use]
pub fn daylight_factors(kelvin: f64) -> [f64; 2] {
    let [x, y] = daylight_xy(kelvin);
    let m = 0.0241 + 0.2562 * x - 0.7341 * y;
    [(-1.3515 - 1.7703 * x + 5.9114 * y) / m, (0.0300 - 31.4424 * x + 30.0717 * y) / m]
}

fn daylight_value([m1, m2]: [f64; 2], nm: f64) -> f64 {
    let place = ((nm - DAYLIGHT_NM.0) / DAYLIGHT_NM.1).round();
    let [s0, s1, s2] = BASIS[(place as usize).min(BASIS.len() - 1)];
    // Far in the ultraviolet the components cancel to slightly less than nothing.
    (s0 + m1 * s1 + m2 * s2).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_a_spectrum() {
        for name in illuminant_names() {
            let s = illuminant(name).unwrap();
            assert!(s.luminous() > 0.0 && s.min() >= 0.0, "{name}");
        }
        assert!(illuminant("d65").is_some());
        assert!(illuminant("D66").is_none());
    }

    #[test]
    fn tables_and_formulas_agree_where_they_meet() {
        let table = |name: &str| CURVES.iter().find(|c| c.0 == name).unwrap().1;
        for (i, v) in table("A").iter().enumerate() {
            // Rounding of the published table.
            assert!((illuminant_a(380.0 + 5.0 * i as f64) - v).abs() < 1e-3);
        }
        for (name, k) in [("D50", 5e3), ("D55", 5.5e3), ("D65", 6.5e3), ("D75", 7.5e3)] {
            for (i, v) in table(name).iter().enumerate() {
                let formula = daylight_at(k, 380.0 + 5.0 * i as f64);
                assert!((formula - v).abs() < 2e-3, "{name} {i} {formula} {v}");
            }
        }
    }

    #[test]
    fn colour_temperatures_out_of_range_are_refused() {
        for k in [999.0, 25001.0, f64::NAN, f64::INFINITY, -1.0] {
            assert!(from_cct(k).is_err(), "{k}");
        }
        assert!(from_cct(1000.0).unwrap().luminous() > 0.0);
    }
}
