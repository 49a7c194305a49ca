//! `clerestory compare`: what was done to the measured values is what is reported.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

use assert_cmd::Command;

const POINTS: usize = 400;

/// Numbers of a normal distribution, by Box and Muller's rule from a counter's golden-ratio sequence.
fn normal(k: usize) -> f64 {
    let even = |step: f64| ((k as f64 + 0.5) * step).fract();
    (-2.0 * even(0.754_877_666).ln()).sqrt() * (TAU * even(0.569_840_291)).cos()
}

fn computed(k: usize) -> f64 {
    300.0 + k as f64
}

/// A result as `solve` writes it, with an error of 1 %.
fn result(dir: &Path) {
    let mut text =
        "grid,point,x_m,y_m,z_m,nx,ny,nz,area_m2,status,illuminance_lx,error_lx,cie_x,cie_y,cct_K\n".to_owned();
    for k in 0..POINTS {
        let e = computed(k);
        let _ = writeln!(text, "desk,{k},0,0,0,0,0,1,,ok,{e},{},0.45,0.41,2850", 0.01 * e);
    }
    text.push_str("desk,400,0,0,0,0,0,1,,covered,,,,,\n");
    std::fs::write(dir.join("illuminance.csv"), text).expect("the folder is ours");
}

fn compare(dir: &Path, measured: &str, more: &[&str]) -> std::process::Output {
    std::fs::write(dir.join("measured.csv"), measured).expect("the folder is ours");
    let mut args = vec!["compare", ".", "--measured", "measured.csv"];
    args.extend(more);
    Command::cargo_bin("clerestory")
        .expect("the folder is ours")
        .current_dir(dir)
        .args(args)
        .output()
        .expect("the folder is ours")
}

#[test]
fn noise_and_bias_of_known_size_are_reported_as_that_size() {
    let dir = tempfile::tempdir().unwrap();
    result(dir.path());
    // Measured 3 % too low, with noise of 4 %, said to be uncertain by 1.96 times that.
    let (bias, noise) = (0.03, 0.04);
    let mut text = "grid,point,illuminance_lx,uncertainty_lx,cie_x,cie_y,uncertainty_xy,note\n".to_owned();
    for k in 0..POINTS {
        let e = computed(k) / (1.0 + bias + noise * normal(k));
        let _ = writeln!(text, "desk,{k},{e},{},0.452,0.41,0.004,\"by, hand\"", 1.96 * noise * e);
    }
    let out = compare(dir.path(), &text, &["--json", "-o", "told"]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let told: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let of = |k: usize, field: &str| told["comparisons"][k][field].as_f64().unwrap();
    assert_eq!(told["comparisons"].as_array().unwrap().len(), 3);
    assert_eq!(of(0, "points"), POINTS as f64);
    // The standard error of the mean of 400 values is 0.2 %, that of their RMS 0.14 %: three of each.
    assert!((of(0, "bias") - bias).abs() < 0.006, "{}", of(0, "bias"));
    let rms = bias.hypot(noise);
    assert!((of(0, "rms") - rms).abs() < 0.005, "{} {rms}", of(0, "rms"));
    // A bias of 0.75 standard deviations leaves 85 to 91 % inside of an interval of two.
    assert!((0.82..0.94).contains(&of(0, "share_inside")), "{}", of(0, "share_inside"));
    assert!((of(1, "bias") + 0.002).abs() < 1e-9 && of(2, "rms") == 0.0);
    assert!(dir.path().join("told/compare.csv").exists());
    assert!(
        std::fs::read_to_string(dir.path().join("told/compare.svg")).unwrap().matches("<circle").count() == 3 * POINTS
    );
}

#[test]
fn what_cannot_be_compared_is_told_with_its_line() {
    let dir = tempfile::tempdir().unwrap();
    result(dir.path());
    for (text, told) in [
        (
            "grid,point,illuminance_lx,uncertainty_lx\ndesk,0,100,1\ndesk,900,100,1\n",
            "measured.csv:3: the result has no point 900",
        ),
        ("grid,point,illuminance_lx,uncertainty_lx\ndesk,400,100,1\n", "measured.csv:2: point 400"),
        ("grid,point,illuminance_lx,uncertainty_lx\ndesk,0,-4,1\n", "measured.csv:2: illuminance_lx is -4"),
        ("grid,point,illuminance_lx,uncertainty_lx\ndesk,0,nan,1\n", "measured.csv:2: illuminance_lx is \"nan\""),
        ("grid,point,illuminance_lx\ndesk,0,100\n", "measured.csv:2: illuminance_lx has no uncertainty_lx"),
        ("grid,illuminance_lx\ndesk,100\n", "measured.csv:1: no column point"),
        ("grid,point,illuminance_lx,uncertainty_lx\ndesk,0,,\n", "measured.csv: nothing was measured"),
        ("grid,point\ndesk\n", "measured.csv:2: "),
        ("", "measured.csv:1: no column grid"),
    ] {
        let out = compare(dir.path(), text, &[]);
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(2), "{said}");
        assert!(said.contains(told), "{said:?} lacks {told:?}");
    }
}

#[test]
fn the_face_is_compared_where_its_reflectance_is_told() {
    let dir = tempfile::tempdir().unwrap();
    result(dir.path());
    // 300 lx at point 0, of equal energy from 380 to 780 nm.
    let mut bands = "grid,point,band_lo_nm,band_hi_nm,irradiance_W_m2_nm,error_W_m2_nm\n".to_owned();
    for lo in (380..780).step_by(20) {
        let _ = writeln!(bands, "desk,0,{lo},{},0.02,0.0001", lo + 20);
    }
    std::fs::write(dir.path().join("irradiance.csv"), bands).unwrap();
    std::fs::write(dir.path().join("grey.csv"), "wavelength_nm,value\n400,0.5\n700,0.5\n").unwrap();
    let heads = "grid,point,reflectance,luminance_cd_m2,uncertainty_cd_m2,cie_x,cie_y,uncertainty_xy\n";
    let luminance = 0.5 * computed(0) / std::f64::consts::PI;
    for (reflectance, x) in [("grey.csv", 1.0 / 3.0), ("0.5", 0.45)] {
        let text = format!("{heads}desk,0,{reflectance},{luminance},1,{x},{x},0.01\n");
        let out = compare(dir.path(), &text, &["--json"]);
        let told: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
        let names: Vec<&str> =
            told["comparisons"].as_array().unwrap().iter().map(|c| c["quantity"].as_str().unwrap()).collect();
        assert_eq!(names, ["luminance", "cie_x", "cie_y"]);
        let of = |k: usize, field: &str| told["comparisons"][k][field].as_f64().unwrap();
        assert!(of(0, "rms") < 1e-9, "L = ρ E / π: {}", of(0, "rms"));
        // A spectrum tells the colour of the face (white under equal energy), a number leaves that of the light.
        assert!(of(1, "rms") < 1e-4, "{reflectance}: {}", of(1, "rms"));
        assert!(
            (told["comparisons"][0]["pairs"][0]["computed"]["error"].as_f64().unwrap() / luminance - 0.01).abs() < 1e-9
        );
    }
    for (row, told) in [
        ("desk,0,,100,1,,,", "measured.csv:2: point 0 of grid \"desk\" has no luminance_cd_m2"),
        ("desk,0,1.5,100,1,,,", "measured.csv:2: reflectance is 1.5"),
        ("desk,1,grey.csv,100,1,,,", "measured.csv:2: the colour of a face needs the light of every band"),
        ("desk,0,none.csv,100,1,,,", "measured.csv:2: reflectance is \"none.csv\", neither a number nor a file"),
    ] {
        let out = compare(dir.path(), &format!("{heads}{row}\n"), &[]);
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(2), "{said}");
        assert!(said.contains(told), "{said:?} lacks {told:?}");
    }
}
