//! Photometric files against lumens and candelas computed elsewhere, where those lie beside the source.

use std::path::PathBuf;

use clerestory::light::photometry::{Photometry, to_eulumdat, to_ies};

/// The folder of files; `None`, with a note, where it is not there.
fn folder() -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data/luminaires");
    if !path.is_dir() {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}

fn rows(path: &PathBuf) -> Vec<csv::StringRecord> {
    let rows: Vec<_> = csv::Reader::from_path(path).unwrap().into_records().map(Result::unwrap).collect();
    assert!(!rows.is_empty());
    rows
}

/// Vertical and horizontal angle of the last columns of `expected.csv`.
const DIRECTIONS: [(f64, f64); 9] = [
    (0.0, 0.0),
    (20.0, 10.0),
    (33.0, 75.0),
    (45.0, 140.0),
    (60.0, 200.0),
    (61.0, 301.0),
    (85.0, 45.0),
    (100.0, 30.0),
    (135.0, 95.0),
];

#[test]
fn lumens_and_candelas_agree_with_the_expected_values() {
    let Some(folder) = folder() else { return };
    let mut compared = 0;
    for row in rows(&folder.join("expected.csv")) {
        let name = &row[0];
        let path = ["real", "synthetic"].map(|f| folder.join(f).join(name)).into_iter().find(|p| p.exists()).unwrap();
        let p = Photometry::read(&path).unwrap();
        // Six digits are given.
        let agree = |what: &str, found: f64, expected: &str| {
            let expected: f64 = expected.parse().unwrap();
            assert!((found - expected).abs() <= 1e-5 * expected.abs().max(1e-3), "{name} {what}: {found} {expected}");
        };
        agree("peak", p.web.peak().0, &row[5]);
        agree("lumens", p.web.flux_lm(), &row[6]);
        if !row[7].is_empty() {
            agree("rated lumens", p.rated_flux_lm.unwrap(), &row[7]);
        }
        for (k, (vertical, horizontal)) in DIRECTIONS.iter().enumerate().filter(|(k, _)| !row[11 + k].is_empty()) {
            agree(&format!("cd at {vertical}, {horizontal}"), p.web.at(*vertical, *horizontal), &row[11 + k]);
            compared += 1;
        }
        let again = Photometry::parse(to_ies(&p).as_bytes(), &path.with_extension("ies")).unwrap();
        agree("lumens written as IES", again.web.flux_lm(), &row[6]);
        if let Ok(text) = to_eulumdat(&p) {
            let again = Photometry::parse(text.as_bytes(), &path.with_extension("ldt")).unwrap();
            agree("lumens written as EULUMDAT", again.web.flux_lm(), &row[6]);
        }
    }
    assert!(compared >= 100, "{compared}");
}

#[test]
fn malformed_files_are_refused_with_file_line_and_mend() {
    let Some(folder) = folder() else { return };
    let good = std::fs::read(folder.join("synthetic/lambert_1000lm_1986.ies")).unwrap();
    for row in rows(&folder.join("malformed.csv")) {
        let path = folder.join(&row[0]);
        if std::fs::read(&path).unwrap() == good {
            eprintln!("skipped: {} has no defect: its bytes are those of the good file", row[0].to_owned());
            continue;
        }
        let error = Photometry::read(&path).unwrap_err();
        let text = error.to_string();
        let (_, after) = text.split_once(&row[0]).unwrap();
        let line: usize = after[1..].split(':').next().unwrap().parse().unwrap();
        assert!(error.is_input() && line > 0 && text.contains("mend:"), "{text}");
    }
}
