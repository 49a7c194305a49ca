//! BSDF files and Klems's bases against figures computed elsewhere, where those lie beside the source.

use std::path::PathBuf;

use clerestory::scene::bsdf::{Bsdf, KlemsBasis, Passage};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data/materials")
}

/// The rows of a file of figures; `None`, with a note, where it is not there.
fn rows(name: &str) -> Option<Vec<csv::StringRecord>> {
    let path = folder().join(name);
    let Ok(mut reader) = csv::Reader::from_path(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    };
    Some(reader.records().map(Result::unwrap).collect())
}

#[test]
fn the_patches_lie_where_the_tables_say() {
    for (name, basis) in
        [("klems_full", KlemsBasis::Full), ("klems_half", KlemsBasis::Half), ("klems_quarter", KlemsBasis::Quarter)]
    {
        let Some(rows) = rows(&format!("{name}.csv")) else { return };
        let patches = basis.patches();
        assert_eq!(rows.len(), patches.len(), "{name}");
        for (row, patch) in rows.iter().zip(&patches) {
            let number = |k: usize| row[k].parse::<f64>().unwrap();
            let degrees = [patch.theta[0], patch.theta[1], patch.phi, patch.width].map(f64::to_degrees);
            for (found, k) in degrees.into_iter().zip([2, 3, 5, 6]) {
                assert!((found - number(k)).abs() < 1e-9, "{name} {}: {found} {}", &row[0], number(k));
            }
            // The figures have ten decimals.
            assert!((patch.projected_solid_angle() - number(7)).abs() < 1e-10, "{name} {}", &row[0]);
        }
    }
}

#[test]
fn measured_elements_pass_and_reflect_what_the_figures_say() {
    let Some(rows) = rows("bsdf_golden.csv") else { return };
    let visible: Vec<_> = rows.iter().filter(|r| &r[1] == "Visible").collect();
    assert_eq!(visible.len(), 12);
    for row in visible {
        let text = std::fs::read_to_string(folder().join("bsdf").join(&row[0])).unwrap();
        let bsdf = Bsdf::from_xml(&text).unwrap();
        let passage = Passage::ALL.into_iter().find(|p| p.name() == &row[2]).unwrap();
        let scattering = bsdf.scattering(passage).unwrap();
        let shares = scattering.directional_hemispherical();
        let patches = scattering.incident.patches();
        // The first patch of the ring about 50°.
        let ring = patches.iter().position(|p| (p.theta[0].to_degrees() - 45.0).abs() < 1e-9).unwrap();
        let largest = shares.iter().copied().fold(0.0, f64::max);
        let least = (0..145 * 145).map(|k| scattering.value(k / 145, k % 145)).fold(f64::INFINITY, f64::min);
        for (found, k) in [(shares[0], 3), (shares[ring], 4), (scattering.hemispherical(), 5), (least, 6), (largest, 7)]
        {
            let exact: f64 = row[k].parse().unwrap();
            // The figures have six decimals.
            assert!((found - exact).abs() < 6e-7, "{} {} column {k}: {found} {exact}", &row[0], &row[2]);
        }
    }
}

#[test]
fn a_blind_told_one_way_is_the_blind_told_both_ways() {
    let Ok(text) = std::fs::read_to_string(folder().join("bsdf/lbnl_venetian_45.xml")) else {
        eprintln!("skipped: no blind there");
        return;
    };
    let both = Bsdf::from_xml(&text).unwrap();
    // Under another name the block is none.
    let one = Bsdf::from_xml(&text.replace("Transmission Back", "Transmission")).unwrap();
    let [told, found] = [&both, &one].map(|b| b.scattering(Passage::TransmissionBack).unwrap());
    let values = || (0..145 * 145).map(|k| (told.value(k / 145, k % 145), found.value(k / 145, k % 145)));
    let (off, all) = values().fold((0.0, 0.0), |(off, all), (a, b)| (off + (a - b).abs(), all + a));
    // The file has six digits.
    assert!(off < 1e-6 * all, "{off} of {all}");
}
