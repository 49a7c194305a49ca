//! Colour against figures computed elsewhere, where those lie beside the source.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clerestory::spectrum::{colour, from_cct, illuminant};

/// field → value of each case.
type Cases = BTreeMap<String, BTreeMap<String, f64>>;

/// The cases of one kind; `None`, with a note, where the figures are not there.
fn golden(kind: &str) -> Option<Cases> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data/colour/golden.csv");
    let Ok(mut reader) = csv::Reader::from_path(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    };
    let mut cases = Cases::new();
    for row in reader.records().map(Result::unwrap) {
        if let (true, Ok(value)) = (&row[0] == kind, row[4].parse()) {
            let case = cases.entry(row[1].to_owned()).or_default();
            case.insert(row[2].to_owned(), value);
        }
    }
    assert!(!cases.is_empty(), "no cases of {kind}");
    Some(cases)
}

#[test]
fn illuminants_have_their_chromaticity_and_colour_temperature() {
    let Some(cases) = golden("source") else {
        return;
    };
    let mut compared = 0;
    for (name, fields) in cases {
        let Some(light) = illuminant(&name) else {
            continue;
        };
        let [x, y] = colour::xy(light.xyz()).unwrap();
        // The figures are sums at 5 nm, ours are integrals of the curve through the same points: lamps with
        // lines or steep flanks differ in the fourth decimal.
        let limit = 5e-4;
        assert!((x - fields["x"]).abs() < limit, "{name} x {x}");
        assert!((y - fields["y"]).abs() < limit, "{name} y {y}");
        if fields["Duv"].abs() < 0.02 {
            let ours = colour::cct([fields["x"], fields["y"]]).unwrap();
            assert!((ours.kelvin - fields["CCT_K"]).abs() < 1.0, "{name} {ours:?}");
            assert!((ours.duv - fields["Duv"]).abs() < 1e-5, "{name} {ours:?}");
            compared += 1;
        }
    }
    assert!(compared >= 20, "{compared}");
}

#[test]
fn daylight_has_the_values_of_the_cie_formula() {
    let Some(cases) = golden("daylight_d") else {
        return;
    };
    for (name, fields) in cases {
        let light = from_cct(fields["CCT_K"]).unwrap();
        for (field, value) in &fields {
            if let Some(nm) = field.strip_prefix('S') {
                let ours = light.at(nm.parse().unwrap());
                // The figures have nine digits.
                assert!((ours / value - 1.0).abs() < 1e-7, "{name} {nm} {ours}");
            }
        }
    }
}

#[test]
fn srgb_is_encoded_as_published() {
    let Some(cases) = golden("srgb_encode") else {
        return;
    };
    for (name, fields) in cases {
        let ours = colour::srgb_encode(fields["linear"]);
        assert!((ours - fields["encoded"]).abs() < 1e-6, "{name} {ours}");
    }
}
