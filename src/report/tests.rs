//! Every file is read back by another reader.

use std::path::Path;

use super::samples::{grid, measurement, scene, view};
use super::*;
use crate::measure::Status;
use crate::scene::{Axes, Projection};
use crate::spectrum::BandMode;

fn three_bands() -> BandMode {
    BandMode::Edges(vec![400.0, 500.0, 600.0, 700.0])
}

fn provenance() -> Provenance {
    Provenance {
        version: "0.1.0".into(),
        command: vec!["clerestory".into(), "solve".into()],
        threads: 2,
        cpu_s: None,
        wall_s: 1.5,
        peak_bytes: Some(1 << 20),
    }
}

fn written(m: &Measurement, spectral: bool) -> (tempfile::TempDir, Vec<String>) {
    let dir = tempfile::tempdir().unwrap();
    let files = write_all(dir.path(), &scene(), m, Form { spectral, units: Units::Lux }, &provenance()).unwrap();
    let name = |p: &PathBuf| p.file_name().unwrap().to_str().unwrap().to_owned();
    let names = files.iter().map(name).collect();
    (dir, names)
}

fn rows(path: &Path) -> Vec<csv::StringRecord> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.records().map(std::result::Result::unwrap).collect()
}

#[test]
fn everything_asked_for_is_written_and_nothing_else() {
    let (dir, names) = written(&measurement(&three_bands()), true);
    let expected = [
        "illuminance.csv",
        "summary.csv",
        "irradiance.csv",
        "workplane.png",
        "camera.exr",
        "camera.hdr",
        "camera.png",
        "camera_luminance.png",
        "run.json",
    ];
    assert_eq!(names, expected);
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), expected.len());
}

#[test]
fn the_same_result_gives_the_same_bytes() {
    let mut m = measurement(&three_bands());
    // Several blocks, for several threads.
    m.views[0] = view("camera", 300, 400, 3);
    let ((a, names), (b, _)) = (written(&m, true), written(&m, true));
    for name in names {
        let [x, y] = [&a, &b].map(|d| std::fs::read(d.path().join(&name)).unwrap());
        assert!(x == y, "{name} differs");
    }
}

#[test]
fn illuminances_read_back_to_the_same_bits() {
    let mut m = measurement(&three_bands());
    m.grids[0].sensors[3].xyz = [0.0; 3];
    m.grids[0].sensors[4].area_m2 = None;
    let (dir, _) = written(&m, false);
    let path = dir.path().join("illuminance.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("grid,point,x_m,y_m,z_m,nx,ny,nz,area_m2,status,illuminance_lx,error_lx,direct_lx,sun_lx,sky_lx,external_lx,reflected_lx,cie_x,cie_y,cct_K\n"));
    let rows = rows(&path);
    assert_eq!(rows.len(), m.grids[0].sensors.len());
    for (i, (row, s)) in rows.iter().zip(&m.grids[0].sensors).enumerate() {
        assert_eq!(&row[1], i.to_string());
        if s.status == Status::Ok {
            assert_eq!(row[10].parse::<f64>().unwrap(), s.xyz[1]);
            assert_eq!(row[16].parse::<f64>().unwrap(), s.reflected_lx);
        } else {
            assert_eq!(&row[9], "covered");
            assert!((10..20).all(|c| row[c].is_empty()));
        }
    }
    assert!((17..20).all(|c| rows[3][c].is_empty()), "the dark has no colour");
    assert!(rows[4][8].is_empty());
    let cct: f64 = rows[0][19].parse().unwrap();
    assert!((cct - 6504.0).abs() < 10.0, "{cct}");
}

#[test]
fn coordinates_are_the_users() {
    let mut turned = scene();
    turned.axes = Axes::YUp;
    let m = measurement(&three_bands());
    let table = table::illuminance(&turned, &m).unwrap();
    let mut reader = csv::Reader::from_reader(&table[..]);
    let row = reader.records().next().unwrap().unwrap();
    let p = m.grids[0].sensors[0].position;
    let read: Vec<f64> = (2..8).map(|c| row[c].parse().unwrap()).collect();
    assert_eq!(read, [p.x, p.z, -p.y, 0.0, 1.0, 0.0]);
}

#[test]
fn the_summary_is_weighted_by_area() {
    let mut m = measurement(&three_bands());
    m.grids[0].sensors.truncate(2);
    for (s, (lx, area)) in m.grids[0].sensors.iter_mut().zip([(100.0, 3.0), (200.0, 1.0)]) {
        s.xyz[1] = lx;
        s.area_m2 = Some(area);
    }
    m.grids[0].holding = 1;
    let read = |m: &Measurement| {
        let table = table::summary(m).unwrap();
        let mut reader = csv::Reader::from_reader(&table[..]);
        let row = reader.records().next().unwrap().unwrap();
        (row[5].to_owned(), row[8].to_owned(), row[12].to_owned(), row[13].to_owned())
    };
    // 125 lx inside, 10,000 lx in the open.
    assert_eq!(read(&m), ("125".into(), "0.8".into(), "0.5".into(), "1.25".into()));
    m.grids[0].sensors[0].area_m2 = None;
    assert_eq!(read(&m).0, "150");
    m.grids[0].sensors.clear();
    assert_eq!(read(&m), Default::default());
}

#[test]
fn irradiances_name_their_bands() {
    let m = measurement(&three_bands());
    let (dir, _) = written(&m, true);
    let rows = rows(&dir.path().join("irradiance.csv"));
    let ok = m.grids[0].sensors.iter().filter(|s| s.status == Status::Ok);
    assert_eq!(rows.len(), 3 * ok.count());
    assert_eq!((&rows[1][2], &rows[1][3]), ("500", "600"));
    let value: f64 = rows[1][4].parse().unwrap();
    assert_eq!(value, m.grids[0].sensors[0].spectral[1].irradiance);
}

#[test]
fn nothing_that_is_not_finite_is_written() {
    let breaks: [fn(&mut Measurement); 5] = [
        |m| m.grids[0].sensors[7].xyz[1] = f64::NAN,
        |m| m.grids[0].sensors[7].error_lx = f64::INFINITY,
        |m| m.views[0].xyz[5][0] = f32::NAN,
        |m| m.views[0].radiance[5] = f32::INFINITY,
        |m| m.ledger.absorbed[2] = f64::NAN,
    ];
    for (i, spoil) in breaks.iter().enumerate() {
        let mut m = measurement(&three_bands());
        spoil(&mut m);
        let dir = tempfile::tempdir().unwrap();
        let error =
            write_all(dir.path(), &scene(), &m, Form { spectral: true, units: Units::Lux }, &provenance()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Internal);
        let place = ["point 7", "point 7", "camera", "camera", "band 2"][i];
        assert!(error.to_string().contains(place), "{error}");
    }
}

#[test]
fn exr_reads_back_exactly() {
    use ::exr::prelude::*;

    let m = measurement(&three_bands());
    let (dir, _) = written(&m, false);
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(dir.path().join("camera.exr"))
        .unwrap();
    let layer = &image.layer_data;
    let plane = |name: &str| {
        let found = layer.channel_data.list.iter().find(|c| c.name == *name);
        let found = found.unwrap_or_else(|| panic!("no channel {name}"));
        found.sample_data.values_as_f32().collect::<Vec<f32>>()
    };
    assert_eq!(layer.channel_data.list.len(), 7);
    let result = &m.views[0];
    let luminance: Vec<f32> = result.xyz.iter().map(|p| p[1]).collect();
    assert_eq!(plane("Y"), luminance);
    for (b, name) in ["S0.450,000000nm", "S0.550,000000nm", "S0.650,000000nm"].iter().enumerate() {
        let own: Vec<f32> = result.radiance.iter().skip(b).step_by(3).copied().collect();
        assert_eq!(plane(name), own);
    }
    let (r, g, b) = (plane("R"), plane("G"), plane("B"));
    for i in 0..luminance.len() {
        let y = 0.212_639 * r[i] + 0.715_169 * g[i] + 0.072_192 * b[i];
        assert!((y / luminance[i] - 1.0).abs() < 1e-4);
    }
    let text = |name: &str| match layer.attributes.other.get(&Text::from(name)) {
        Some(AttributeValue::Text(t)) => t.to_string(),
        other => panic!("{name}: {other:?}"),
    };
    assert_eq!(text("spectralLayoutVersion"), "1.0");
    assert_eq!(text("emissiveUnits"), "W.m^-2.sr^-1");
    assert_eq!(text("clerestory:bandEdges_nm"), "400-500 500-600 600-700");
    assert_eq!(layer.attributes.white_luminance, Some(1.0));
    assert_eq!(image.attributes.chromaticities.unwrap().red.0, 0.64);
}

#[test]
fn exr_of_rgb_bands_has_no_spectral_channels() {
    use ::exr::prelude::*;

    let (dir, names) = written(&measurement(&BandMode::Rgb), true);
    assert!(!names.iter().any(|n| n == "irradiance.csv"));
    let meta = MetaData::read_from_file(dir.path().join("camera.exr"), true).unwrap();
    let names = meta.headers[0].channels.list.iter().map(|c| c.name.to_string());
    assert_eq!(names.collect::<Vec<_>>(), ["B", "G", "R", "Y"]);
}

#[test]
fn hdr_keeps_luminance_and_view() {
    let m = measurement(&three_bands());
    let (dir, _) = written(&m, false);
    let bytes = std::fs::read(dir.path().join("camera.hdr")).unwrap();
    let (header, pixels) = hdr::tests::decode(&bytes);
    assert_eq!(header[0], "#?RADIANCE");
    let has = |line: &str| assert!(header.iter().any(|h| h == line), "{header:?}");
    has("EXPOSURE=1.0");
    has("FORMAT=32-bit_rle_rgbe");
    let view = header.iter().find(|h| h.starts_with("VIEW= ")).unwrap();
    assert!(view.starts_with("VIEW= -vtv -vp 1 2 1.5 -vd 0 1 0 -vu 0 0 1 -vh 60 -vv 45 "), "{view}");
    for (p, xyz) in pixels.iter().zip(&m.views[0].xyz) {
        let luminance = 179.0 * (0.265 * p[0] + 0.670 * p[1] + 0.065 * p[2]);
        // Half a step of the mantissa, and Radiance's rounded factors.
        assert!((luminance / f64::from(xyz[1]) - 1.0).abs() < 0.01);
    }
}

#[test]
fn the_tone_mapped_picture_has_the_views_pixels_and_a_white_lamp() {
    let m = measurement(&three_bands());
    let (dir, _) = written(&m, false);
    let bytes = std::fs::read(dir.path().join("camera.png")).unwrap();
    let image = image::load_from_memory(&bytes).unwrap().to_rgb8();
    assert_eq!(image.dimensions(), (96, 64));
    assert_eq!(image.get_pixel(48, 7).0, [255; 3]);
    let wall = image.get_pixel(80, 40).0;
    assert!(wall.iter().all(|v| (60..200).contains(v)), "{wall:?}");
    let tinted = image.get_pixel(2, 40).0;
    assert!(tinted[0] > tinted[2] + 40, "{tinted:?}");
}

#[test]
fn every_projection_and_width_makes_a_valid_hdr() {
    let fisheye = Projection::Fisheye { angle: std::f64::consts::PI };
    for (projection, width, word) in [(fisheye, 64, Some("-vta")), (Projection::Panorama, 5, None)] {
        let mut result = view("v", width, 7, 1);
        result.view.projection = projection;
        let bytes = hdr::encode(&scene(), &result, &provenance()).unwrap();
        let (header, pixels) = hdr::tests::decode(&bytes);
        assert_eq!(pixels.len(), 7 * width);
        let view = header.iter().find(|h| h.starts_with("VIEW="));
        assert_eq!(view.is_some(), word.is_some());
        assert!(view.is_none_or(|v| v.contains(word.unwrap_or_default())));
    }
}

#[test]
fn maps_are_large_enough_to_read_in_every_shape() {
    for (nu, nv, size) in [(16, 24, [3.5, 5.5]), (1, 1, [1.0, 1.0]), (40, 2, [20.0, 0.4])] {
        let png = map::illuminance(&scene(), &grid("g", nu, nv, size), Units::Lux).unwrap();
        let image = image::load_from_memory(&png).unwrap();
        assert!(image.width().max(image.height()) >= 900);
    }
    for (width, height) in [(1, 1), (96, 64), (1200, 800)] {
        let png = map::luminance(&scene(), &view("v", width, height, 1)).unwrap();
        let image = image::load_from_memory(&png).unwrap();
        assert!(image.width().max(image.height()) >= 900);
    }
}

#[test]
fn maps_of_the_dark_and_of_nothing_are_drawn() {
    let mut dark = grid("dark", 4, 4, [1.0, 1.0]);
    dark.sensors.iter_mut().for_each(|s| s.xyz = [0.0; 3]);
    map::illuminance(&scene(), &dark, Units::Lux).unwrap();
    dark.sensors.iter_mut().for_each(|s| s.status = Status::Inside);
    map::illuminance(&scene(), &dark, Units::Lux).unwrap();
    let mut black = view("v", 8, 8, 1);
    black.xyz.fill([0.0; 3]);
    map::luminance(&scene(), &black).unwrap();
    png::tone_mapped(&scene(), &black).unwrap();
}

#[test]
fn the_record_says_how_the_balance_closes() {
    let m = measurement(&three_bands());
    let (dir, _) = written(&m, false);
    let text = std::fs::read_to_string(dir.path().join("run.json")).unwrap();
    let record: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(record["schema"], "clerestory-run/1");
    assert_eq!(record["bands"][2]["closure"], 0.025);
    assert_eq!(record["bands"][2]["lo_nm"], 600.0);
    // 10 W/nm over three bands of 100 nm.
    assert_eq!(record["energy_balance"]["emitted_W"], 3000.0);
    assert_eq!(record["energy_balance"]["worst_closure"], 0.025);
    assert_eq!(record["spectrum"]["edges_nm"], serde_json::json!([400.0, 500.0, 600.0, 700.0]));
    assert_eq!(record["inputs"][0]["sha256"], "00ff");
    assert_eq!(record["warnings"].as_array().unwrap().len(), 2);
    assert_eq!(record["settings"][0]["name"], "bands");
    assert_eq!(record["grids"][0]["name"], "workplane");
    assert_eq!(record["views"][0]["error_p95"], 0.046);
}

#[test]
fn bands_without_edges_have_no_totals() {
    let record = run_json(&scene(), &measurement(&BandMode::Rgb), &provenance());
    assert_eq!(record["spectrum"]["bands"], 3);
    assert!(record["spectrum"]["edges_nm"].is_null());
    assert!(record["energy_balance"]["emitted_W"].is_null());
    assert_eq!(record["energy_balance"]["worst_closure"], 0.025);
}

#[test]
fn a_run_without_a_balance_says_nothing_about_it() {
    let mut m = measurement(&three_bands());
    m.ledger = Ledger::default();
    let record = run_json(&scene(), &m, &provenance());
    assert!(record["energy_balance"].as_object().unwrap().values().all(serde_json::Value::is_null));
}

#[test]
fn grids_and_views_of_one_name_keep_apart() {
    let mut m = measurement(&three_bands());
    m.grids.push(grid("workplane", 4, 4, [1.0, 1.0]));
    m.views[0].view.name = "workplane".into();
    let (_dir, names) = written(&m, false);
    let mut unique = names.clone();
    unique.sort();
    unique.dedup();
    assert_eq!(unique.len(), names.len(), "{names:?}");
}

#[test]
fn a_view_without_diffuse_surfaces_states_no_error() {
    let mut m = measurement(&three_bands());
    m.views[0].error_median = f64::NAN;
    m.views[0].error_p95 = f64::NAN;
    let record = run_json(&scene(), &m, &provenance());
    assert!(record["views"][0]["error_median"].is_null());
    map::luminance(&scene(), &m.views[0]).unwrap();
}
