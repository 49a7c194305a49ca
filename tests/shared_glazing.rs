//! Glazing units against figures computed elsewhere, where those lie beside the source.

use std::path::PathBuf;

use clerestory::transport::{Glazing, GlazingUnit, Pane};

/// The rows of the file of figures; `None`, with a note, where it is not there.
fn rows() -> Option<Vec<csv::StringRecord>> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data/materials/glazing_golden.csv");
    let Ok(mut reader) = csv::Reader::from_path(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    };
    let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
    assert!(rows.len() >= 72, "{}", rows.len());
    Some(rows)
}

#[test]
fn one_two_and_three_panes_pass_and_reflect_as_the_net_radiation_method_says() {
    let Some(rows) = rows() else { return };
    let number = |row: &csv::StringRecord, k: usize| row[k].parse::<f64>().unwrap();
    let mut worst = [0.0f64; 2];
    for row in &rows {
        let index = number(row, 2);
        let panes: Vec<Pane> = row[1].split('+').map(|t| Pane::bare(t.parse().unwrap(), index)).collect();
        let unit = GlazingUnit { panes, maintenance_factor: 1.0 };
        let cosine = number(row, 3).to_radians().cos();
        let table = Glazing::new(std::slice::from_ref(&unit), true);
        for (k, found) in [unit.shares(cosine), table.mean(cosine)].into_iter().enumerate() {
            let what = format!("{} at {}°", &row[0], &row[3]);
            let off = (found.passed - number(row, 6)).abs().max((found.reflected[1] - number(row, 7)).abs());
            // The formula to the figures' eight digits; the table to what is asked of it.
            assert!(off < [1e-8, 1e-4][k], "{what}: {found:?}");
            let absorbed = 1.0 - found.passed - found.reflected[1];
            assert!((absorbed - number(row, 8)).abs() < [2e-8, 1e-4][k], "{what}: absorbed {absorbed}");
            worst[k] = worst[k].max(off);
        }
        let hemispherical = unit.hemispherical_transmittance();
        assert!((hemispherical - number(row, 9)).abs() < 1e-5, "{}: {hemispherical}", &row[0]);
        if let ([Pane::Bare { internal, .. }], Ok(exact)) = (&unit.panes[..], row[10].parse::<f64>()) {
            // The figures are Radiance's, whose formula has constants of ten digits and cancellation.
            assert!((internal - exact).abs() < 1e-7, "{}: transmissivity {internal}", &row[0]);
        }
    }
    eprintln!("largest difference: formula {:.1e}, table {:.1e}", worst[0], worst[1]);
}
