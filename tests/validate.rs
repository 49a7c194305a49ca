//! The validation suite as a person runs it, and that it can fail.

use assert_cmd::Command;
use clerestory::measure::Silent;
use clerestory::validate::{self, Case, References, Suite};

fn suite(name: &str, references: &References) -> Suite {
    validate::run(&[name.into()], references, &Silent).expect("the suite runs").remove(0)
}

fn failed(suite: &Suite) -> Vec<String> {
    suite.failures().map(|c: &Case| c.name.clone()).collect()
}

/// The references with one number of one table altered: `from` must stand there once.
fn altered(file: &str, from: &str, to: &str) -> References {
    let mut references = References::default();
    let text = references.table(file).to_owned();
    assert_eq!(text.matches(from).count(), 1, "{file} holds {from} once");
    references.replace_table(file, text.replace(from, to));
    references
}

#[test]
fn an_altered_reference_fails_and_nothing_else_does() {
    // Alterations of a few parts in a thousand at most: what the suite must tell apart.
    for (name, file, from, to, case) in [
        ("form-factors", "form_factors.csv", "0.0126477817015", "0.0126478817015", "perp-gap"),
        ("colour", "colour.csv", "7.2195,5e-05", "7.2197,5e-05", "pair 12 dE00"),
        ("sky", "skies.csv", "2.08602321", "2.08602421", "sky 2, sun at 60°, 180°"),
        ("sky", "sun.csv", "23.907565311", "23.927565311", "Washington DC 2003-04-25T12:26:56Z"),
    ] {
        let sound = suite(name, &References::default());
        assert_eq!(failed(&sound), Vec::<String>::new(), "{name}");
        assert_eq!(failed(&suite(name, &altered(file, from, to))), [case], "{file}");
    }
}

#[test]
fn every_table_is_read_and_a_broken_one_is_told_with_its_line() {
    let tables = ["boxes.csv", "cie171_daylight.csv", "cie171_electric.csv", "colour.csv", "cornell.csv", "ferren.csv"];
    let suites = ["coverage", "cie-171", "cie-171", "colour", "cornell", "ferren"];
    for (file, name) in tables.into_iter().zip(suites) {
        let mut references = References::default();
        let mut lines: Vec<String> = references.table(file).lines().map(str::to_owned).collect();
        let last = lines[1].rfind(',').unwrap();
        lines[1].replace_range(last.., ",x");
        references.replace_table(file, lines.join("\n"));
        let told = validate::run(&[name.into()], &references, &Silent).unwrap_err().to_string();
        assert!(told.starts_with(&format!("{file}:2:")), "{told}");
    }
}

#[test]
fn the_command_prints_json_and_writes_its_report() {
    let dir = tempfile::tempdir().unwrap();
    let run =
        |args: &[&str]| Command::cargo_bin("clerestory").unwrap().current_dir(dir.path()).args(args).output().unwrap();
    let out = run(&["validate", "form-factors", "luminaires", "--json", "-o", "report", "-q"]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let told: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let suites = told["suites"].as_array().unwrap();
    assert_eq!(suites.iter().map(|s| s["name"].as_str().unwrap()).collect::<Vec<_>>(), ["form-factors", "luminaires"]);
    for case in suites.iter().flat_map(|s| s["cases"].as_array().unwrap()) {
        assert!(case["name"].is_string() && case["source"].as_str().is_some_and(|s| s.len() > 3), "{case}");
        assert!(["reference", "uncertainty", "value", "error"].iter().all(|k| case[k].is_number()), "{case}");
        assert_eq!(case["pass"], true, "{case}");
    }
    for name in ["index.html", "validation.csv", "validation.json", "VALIDATION.md"] {
        assert!(dir.path().join("report").join(name).exists(), "{name}");
    }
    let page = std::fs::read_to_string(dir.path().join("report/index.html")).unwrap();
    assert!(
        page.contains("<svg") && !page.contains("http://")
            || page.matches("http").count() == page.matches("www.w3.org").count()
    );
    let unknown = run(&["validate", "colours"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("form-factors"));
}

#[test]
fn the_page_of_the_repository_is_that_of_the_suite() {
    // Suites and counts; the figures beside them move with every digit of the program.
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/VALIDATION.md")).unwrap();
    for name in validate::names() {
        assert!(
            page.contains(&format!("| {name} |")),
            "{name}: write VALIDATION.md anew by `clerestory validate -o DIR`"
        );
    }
    assert!(page.contains(", 0 failed."), "the page tells of failures");
}
