//! The measured growth chamber, where its data lie beside the source.

use std::path::PathBuf;

use clerestory::measure::Silent;
use clerestory::validate::{self, References};

/// x, y, z, band and reflecting surfaces; residual and stated error in percent.
fn residuals(text: &str) -> Vec<(String, f64, f64)> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let number = |r: &csv::StringRecord, i: usize| r[i].parse::<f64>().expect("a number");
    let row = |r: csv::StringRecord| (r.iter().take(5).collect::<Vec<_>>().join(","), number(&r, 5), number(&r, 6));
    reader.records().map(|r| row(r.expect("a sound table"))).collect()
}

#[test]
fn the_measured_chamber_is_met_and_the_stored_outcome_is_that_of_the_program() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let data = root.join("../shared/data/measured/growth_chamber");
    if !data.exists() {
        eprintln!("skipped: {} is not there", data.display());
        return;
    }
    let references = References::default().with_measured(&data);
    let suite = validate::run(&["growth-chamber".into()], &references, &Silent).expect("the data are sound").remove(0);
    let failed: Vec<_> = suite.failures().collect();
    assert!(failed.is_empty() && suite.skipped.is_none() && suite.cases.len() == 28, "{failed:#?}");
    let stored = std::fs::read_to_string(root.join("validation/growth-chamber/results.csv")).expect("it is stored");
    let (stored, found) = (residuals(&stored), residuals(&suite.files[0].1));
    assert_eq!(stored.len(), 96, "four runs, two bands, twelve points");
    for ((key, was, error), (same, is, other)) in stored.iter().zip(&found) {
        assert_eq!(key, same);
        // Both errors of the point, and as much for the fit.
        assert!((was - is).abs() <= 2.0 * error.hypot(*other), "{key}: stored {was} %, found {is} %");
    }
}

#[test]
fn without_its_data_the_suite_is_skipped_and_says_so() {
    let suite = validate::run(&["growth-chamber".into()], &References::default(), &Silent).unwrap().remove(0);
    assert!(suite.skipped.is_some() && suite.cases.is_empty() && suite.tables.len() == 3);
    let broken = References::default().with_measured(&PathBuf::from("no/such/folder"));
    let told = validate::run(&["growth-chamber".into()], &broken, &Silent).unwrap_err().to_string();
    assert!(told.contains("reflectance_1nm.csv"), "{told}");
}
