//! Every reader of the product with samples of its own and the facts that hold for whatever it accepts.
//!
//! Shared by the mutation runner beside this file and by the coverage-guided targets in `fuzz`. A reader may refuse bytes;
//! it may not panic, and what it accepts is finite.

#[path = "samples.rs"]
mod samples;

use std::path::{Path, PathBuf};

use clerestory::light::photometry::{Format, Photometry, spread, to_eulumdat, to_ies};
use clerestory::light::weather::Weather;
use clerestory::light::{Daylight, Luminaires};
use clerestory::scene::bsdf::{Bsdf, Passage};
use clerestory::scene::{self, Scene};
use clerestory::spectrum::{Beyond, Spectrum};
use clerestory::{chart, compare};
use glam::DVec3;
use samples::*;

/// A reader and what to feed it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reader {
    /// As the target in `fuzz` is called.
    pub(crate) name: &'static str,
    /// Files to begin with; the first is accepted.
    pub(crate) samples: fn() -> Vec<Vec<u8>>,
    /// Reads bytes and holds what was accepted against its facts; was it accepted?
    pub(crate) read: fn(&[u8]) -> bool,
}

/// All readers.
pub(crate) const ALL: [Reader; 12] = [
    Reader { name: "ies", samples: ies_samples, read: ies },
    Reader { name: "eulumdat", samples: eulumdat_samples, read: eulumdat },
    Reader { name: "epw", samples: epw_samples, read: weather },
    Reader { name: "wea", samples: wea_samples, read: weather },
    Reader { name: "bsdf", samples: bsdf_samples, read: bsdf },
    Reader { name: "spectrum", samples: spectrum_samples, read: spectrum },
    Reader { name: "obj", samples: obj_samples, read: obj },
    Reader { name: "points", samples: points_samples, read: points },
    Reader { name: "schedule", samples: schedule_samples, read: schedule },
    Reader { name: "scene", samples: scene_samples, read: scene_file },
    Reader { name: "measured", samples: measured_samples, read: measured },
    Reader { name: "peer", samples: peer_samples, read: peer },
];

/// Reads as IES LM-63.
pub(crate) fn ies(bytes: &[u8]) -> bool {
    photometry(bytes, "a.ies")
}

/// Reads as EULUMDAT.
pub(crate) fn eulumdat(bytes: &[u8]) -> bool {
    photometry(bytes, "a.ldt")
}

fn photometry(bytes: &[u8], name: &str) -> bool {
    // A folder that is not there: no TILT file is found beside the file.
    let Ok(p) = Photometry::parse(bytes, Path::new("/nowhere").join(name).as_path()) else { return false };
    let flux_lm = p.web.flux_lm();
    assert!(flux_lm.is_finite() && flux_lm >= 0.0, "{flux_lm} lm");
    let (peak_cd, ..) = p.web.peak();
    for direction in [DVec3::NEG_Z, DVec3::Z, DVec3::X, DVec3::new(0.3, -0.5, -0.7), DVec3::new(-0.1, 0.2, 0.9)] {
        let candela = p.web.towards(direction);
        assert!((0.0..=peak_cd * (1.0 + 1e-12)).contains(&candela), "{candela} cd of at most {peak_cd}");
    }
    let found = spread(&p.web);
    assert!(found.beam_deg.iter().chain(&found.field_deg).all(|a| (0.0..=360.0).contains(a)), "{found:?}");
    assert!(
        [p.lamps, p.power_w, p.opening.along_c0_m, p.opening.along_c90_m, p.opening.height_m]
            .iter()
            .all(|x| x.is_finite())
    );
    assert!([p.rated_flux_lm, p.stated_flux_lm].iter().flatten().all(|x| x.is_finite()));
    if let Some(tilt) = &p.tilt {
        assert!([-10.0, 0.0, 45.0, 200.0].iter().all(|a| tilt.factor(*a).is_finite()));
    }
    write_and_read(&p, flux_lm);
    true
}

/// What was read can be written, and gives the same light when it is read again.
fn write_and_read(p: &Photometry, flux_lm: f64) {
    let again = Photometry::parse(to_ies(p).as_bytes(), Path::new("a.ies")).expect("our own IES file");
    assert!(matches!(again.format, Format::Ies(_)));
    // Candelas are written with nine digits at least, smallest of them beside the peak.
    let near = |lm: f64| (lm - flux_lm).abs() <= 1e-6 * flux_lm + 1e-6 * p.web.peak().0 + 1e-300;
    assert!(near(again.web.flux_lm()), "{flux_lm} lm became {} lm", again.web.flux_lm());
    if let Ok(text) = to_eulumdat(p) {
        Photometry::parse(text.as_bytes(), Path::new("a.ldt")).expect("our own EULUMDAT file");
    }
}

/// Reads as EPW or WEA.
pub(crate) fn weather(bytes: &[u8]) -> bool {
    let Ok(w) = Weather::parse(bytes) else { return false };
    assert!(w.place.latitude_deg.abs() <= 90.0 && w.place.longitude_deg.abs() <= 180.0 && w.utc_offset_h.abs() <= 24.0);
    assert!(!w.records.is_empty() && w.elevation_m.is_finite());
    for r in &w.records {
        assert!((0.0..=24.0).contains(&r.middle_h));
        let amounts = [r.direct_normal_w_m2, r.diffuse_horizontal_w_m2, r.precipitable_water_cm()];
        assert!(amounts.iter().flatten().all(|x| x.is_finite() && *x >= 0.0), "{r:?}");
    }
    true
}

/// Reads as the XML of WINDOW.
pub(crate) fn bsdf(bytes: &[u8]) -> bool {
    let Ok(found) = Bsdf::from_xml(&String::from_utf8_lossy(bytes)) else { return false };
    for passage in Passage::ALL {
        let Some(s) = found.scattering(passage) else { continue };
        // 0.1 % over for rounding in the file.
        assert!((0.0..=1.001).contains(&s.hemispherical()), "{passage:?}: {}", s.hemispherical());
    }
    true
}

/// Reads as a table of a spectrum.
pub(crate) fn spectrum(bytes: &[u8]) -> bool {
    for beyond in [Beyond::Hold, Beyond::Zero] {
        let Ok(s) = Spectrum::from_csv_bytes(bytes, beyond) else { return false };
        let values =
            [s.at(300.0), s.at(555.0), s.mean(380.0, 780.0), s.mean(500.0, 500.0), s.luminous(), s.min(), s.max()];
        assert!(values.iter().all(|v| v.is_finite()), "{values:?}");
    }
    true
}

/// Reads as OBJ, by way of a scene that names it.
pub(crate) fn obj(bytes: &[u8]) -> bool {
    in_folder("room.obj", bytes)
}

/// Reads as points of a grid.
pub(crate) fn points(bytes: &[u8]) -> bool {
    in_folder("points.pts", bytes)
}

/// Reads as hours of presence.
pub(crate) fn schedule(bytes: &[u8]) -> bool {
    in_folder("presence.csv", bytes)
}

/// Reads as a scene file.
pub(crate) fn scene_file(bytes: &[u8]) -> bool {
    in_folder("scene.toml", bytes)
}

/// Reads as a table of measured values, and as the result that it is held against.
pub(crate) fn measured(bytes: &[u8]) -> bool {
    let folder = folder();
    let [result, table] = ["illuminance.csv", "measured.csv"].map(|n| folder.join(n));
    std::fs::write(&result, ILLUMINANCE).expect("written");
    std::fs::write(&table, bytes).expect("written");
    let mut accepted = false;
    for computed in [&result, &table].into_iter().flat_map(|p| compare::result(p)) {
        for c in compare::measured(&table, &computed).iter().flatten() {
            accepted = true;
            assert!([c.bias, c.rms, c.worst, c.share_inside].iter().all(|x| x.is_finite()), "{c:?}");
            assert!(c.pairs.iter().all(|p| p.measured.value.is_finite() && p.computed.error.is_finite()));
        }
    }
    accepted
}

/// Reads as points of another program.
pub(crate) fn peer(bytes: &[u8]) -> bool {
    let path = folder().join("peer.csv");
    std::fs::write(&path, bytes).expect("written");
    let Ok(points) = chart::read_peers(&path) else { return false };
    for p in points {
        let found = p.found.expect("a peer has an error");
        assert!([p.cpu_s, p.wall_s, found.rms, found.bias, found.largest].iter().all(|x| x.is_finite()));
    }
    true
}

/// The folder of a whole scene, one for each thread.
fn folder() -> PathBuf {
    thread_local! {
        static FOLDER: tempfile::TempDir = tempfile::tempdir().expect("a temporary folder");
    }
    FOLDER.with(|f| f.path().to_path_buf())
}

/// Files of the scene, of which one is replaced by what is to be read.
const SCENE: [(&str, &str); 6] = [
    ("scene.toml", SCENE_TOML),
    ("room.obj", ROOM_OBJ),
    ("points.pts", POINTS),
    ("wall.csv", SPECTRUM_CSV),
    ("lamp.ies", LAMP_IES),
    ("place.wea", WEA),
];

/// Reads the scene with one of its files replaced, as `clerestory check` does.
fn in_folder(name: &str, bytes: &[u8]) -> bool {
    let folder = folder();
    for (file, text) in SCENE {
        std::fs::write(folder.join(file), text).expect("written");
    }
    if name == "presence.csv" {
        let year = SCENE_TOML.replace("hours = [8, 18]", "schedule = \"presence.csv\"");
        std::fs::write(folder.join("scene.toml"), year).expect("written");
    }
    std::fs::write(folder.join(name), bytes).expect("written");
    let scene = scene::load(&folder.join("scene.toml"));
    scene.as_ref().is_ok_and(|s| {
        check(s);
        true
    })
}

fn check(scene: &Scene) {
    for face in &scene.faces {
        assert!(face.vertices.iter().all(|v| v.is_finite()) && face.normal.is_normalized() && face.area_m2 > 0.0);
    }
    for sensor in scene.grids.iter().flat_map(|g| &g.sensors) {
        assert!(sensor.position.is_finite() && sensor.normal.is_normalized(), "{sensor:?}");
    }
    for view in &scene.views {
        assert!(view.direction.is_normalized() && view.up.is_normalized() && view.direction.dot(view.up).abs() < 1e-6);
    }
    for emission in scene.materials.iter().filter_map(|m| m.emission.as_ref()) {
        assert!(emission.radiance.luminous().is_finite());
    }
    let _ = scene::check(scene);
    if let Ok(Some(light)) = Daylight::new(scene) {
        assert!(light.diffuse_horizontal_lx().is_finite() && light.sun_irradiance.luminous().is_finite());
        assert!(light.sun.is_none_or(|s| s.is_normalized()));
    }
    if let Ok(hung) = Luminaires::new(scene) {
        assert!(hung.list.iter().all(|l| l.flux_lm.is_finite() && l.corners.iter().all(|c| c.is_finite())));
        assert!(hung.lights().all(|(spectrum, lm)| lm.is_finite() && spectrum.luminous().is_finite()));
    }
}
