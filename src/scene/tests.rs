//! The reader as a whole: scenes written to a folder and loaded.

use std::f64::consts::PI;
use std::path::PathBuf;

use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::Result;

/// A folder with the files of a scene.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            folder.write(name, text.as_bytes());
        }
        folder
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn load(&self) -> Result<Scene> {
        load(&self.path("s.toml"))
    }
}

const HEAD: &str = "[geometry]\nfiles = [\"a.obj\"]\nunit = \"m\"\nup = \"z\"\n";
const WALL: &str = "[materials.wall]\nreflectance = 0.5\n";
const ROOM: &str = "o slab\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nusemtl wall\nf 1 2 3 4\n";

/// Loads a scene with the usual head and slab.
fn scene_of(rest: &str) -> Result<Scene> {
    Folder::new(&[("a.obj", ROOM), ("s.toml", &format!("{HEAD}{rest}"))]).load()
}

fn scene(rest: &str) -> Scene {
    scene_of(&format!("{WALL}{rest}")).unwrap()
}

/// The message of a scene that must fail, without the folder's name.
fn error(rest: &str) -> String {
    shorten(scene_of(rest))
}

fn shorten(result: Result<Scene>) -> String {
    let text = result.unwrap_err().to_string();
    match text.find("s.toml:").or_else(|| text.find("a.obj")) {
        Some(at) => text[at..].to_owned(),
        None => text,
    }
}

#[test]
fn a_plain_scene_is_read() {
    let s = scene("title = \"x\"\n".replace("title = \"x\"\n", "").as_str());
    assert_eq!((s.title.as_str(), s.faces.len(), s.axes), ("s", 1, Axes::ZUp));
    assert_eq!((s.faces[0].normal, s.faces[0].area_m2), (DVec3::Z, 2.0));
    assert_eq!((s.objects.as_slice(), s.materials[0].name.as_str()), (&["slab".to_owned()][..], "wall"));
    let names: Vec<_> = s.inputs.iter().map(|i| i.path.to_str().unwrap()).collect();
    assert_eq!(names, ["s.toml", "a.obj"]);
    assert_eq!(s.inputs[1].sha256.len(), 64);
    assert!(s.warnings.is_empty(), "{:?}", s.warnings);
}

#[test]
fn a_y_up_scene_in_millimetres_is_turned_and_scaled() {
    let obj = "v 0 0 0\nv 0 0 1000\nv 2000 0 1000\nv 2000 0 0\nusemtl wall\nf 1 2 3 4\n";
    let toml = "[geometry]\nfiles = [\"a.obj\"]\nunit = \"mm\"\nup = \"y\"\n[materials.wall]\nreflectance = 0.5\n\
                [[grids]]\nname = \"g\"\nplane = { origin_m = [0, 0.5, 0], u_m = [2, 0, 0], v_m = [0, 0, -1], nu = 1, nv = 1 }\n\
                [[views]]\nname = \"v\"\nposition_m = [0, 1, 3]\ndirection = [0, 0, -2]\nfov_deg = 60\npixels = [8, 8]\n";
    let s = Folder::new(&[("a.obj", obj), ("s.toml", toml)]).load().unwrap();
    assert_eq!(s.faces[0].normal, DVec3::Z, "a floor that faces +y in the file faces up");
    assert_eq!(s.faces[0].vertices[2], DVec3::new(2.0, -1.0, 0.0));
    let sensor = s.grids[0].sensors[0];
    assert!(sensor.position.distance(DVec3::new(1.0, 0.5, 0.5)) < 1e-12 && sensor.normal.distance(DVec3::Z) < 1e-12);
    assert_eq!(s.axes.to_user(sensor.position), DVec3::new(1.0, 0.5, -0.5));
    assert_eq!((s.views[0].direction, s.views[0].up), (DVec3::Y, DVec3::Z));
}

#[test]
fn impossible_reflectances_name_line_channel_and_wavelength() {
    let e = error("[materials.red]\nreflectance = [1.2, 0.7, 0.3]\n[materials.wall]\nreflectance = 0.5\n");
    assert!(e.starts_with("s.toml:6: material \"red\": reflectance 1.2 (red channel) exceeds 1\n  mend: "), "{e}");
    assert!(
        error("[materials.wall]\nreflectance = -0.1\n")
            .contains("s.toml:6: material \"wall\": reflectance -0.1 is negative")
    );
    assert!(error("[materials.wall]\nreflectance = nan\n").contains("is no number"));
    let folder =
        Folder::new(&[("a.obj", ROOM), ("s.toml", &format!("{HEAD}[materials.wall]\nreflectance = \"r.csv\"\n"))]);
    folder.write("r.csv", b"wavelength_nm,value\n400,0.5\n610,1.07\n");
    assert!(shorten(folder.load()).contains("reflectance 1.07 at 610 nm exceeds 1"));
    assert!(
        error("[materials.wall]\nkind = \"diffuse\"\n").contains("s.toml:5: material \"wall\" has no `reflectance`")
    );
}

#[test]
fn bright_materials_are_told_their_gain() {
    let s = scene_of("[materials.wall]\nreflectance = 0.99\n").unwrap();
    assert!(s.warnings[0].contains("up to 100 times"), "{:?}", s.warnings);
    assert!(scene_of("[materials.wall]\nreflectance = 1\n").unwrap().warnings[0].contains("no finite solution"));
}

#[test]
fn a_material_that_is_not_described_names_the_obj_line() {
    let e = error("[materials.wal]\nreflectance = 0.5\n");
    assert!(e.contains("a.obj:6: material `wall` is not described") && e.contains("did you mean `wal`?"), "{e}");
    let s = scene("[materials.unused]\nreflectance = 0.2\n");
    assert_eq!(s.warnings, ["material \"unused\" is on no face"]);
}

#[test]
fn photometric_quantities_are_exact_through_v_lambda() {
    // The slab has 2 m².
    for (quantity, luminance) in [
        ("luminance_cd_m2 = 1000", 1000.0),
        ("exitance_lm_m2 = 1000", 1000.0 / PI),
        ("flux_lm = 1000", 1000.0 / (2.0 * PI)),
        ("flux_lm = 1000, two_sided = true", 1000.0 / (4.0 * PI)),
        ("luminance_cd_m2 = 1000, spectrum = \"D65\"", 1000.0),
        ("luminance_cd_m2 = 1000, spectrum = 3000", 1000.0),
    ] {
        let s = scene_of(&format!("[materials.wall]\nemission = {{ {quantity} }}\n")).unwrap();
        let emission = s.materials[0].emission.as_ref().unwrap();
        assert!((emission.radiance.luminous() / luminance - 1.0).abs() < 1e-12, "{quantity}");
        let MaterialKind::Diffuse { front, .. } = &s.materials[0].kind else { panic!() };
        assert_eq!(front.max(), 0.0, "an emitter without a stated reflectance has none");
    }
}

#[test]
fn a_duplicated_lamp_keeps_its_flux() {
    let twice = format!("{ROOM}f 4 3 2 1\n");
    let toml = format!("{HEAD}[materials.wall]\nemission = {{ flux_lm = 1000 }}\n");
    let s = Folder::new(&[("a.obj", &twice), ("s.toml", &toml)]).load().unwrap();
    let flux = PI
        * s.faces.iter().map(|f| f.area_m2).sum::<f64>()
        * s.materials[0].emission.as_ref().unwrap().radiance.luminous();
    assert!((flux / 1000.0 - 1.0).abs() < 1e-12);
    assert!(s.warnings[0].contains("its light is emitted once: a.obj:8"), "{:?}", s.warnings);
}

#[test]
fn emission_is_judged() {
    for (emission, want) in [
        ("luminance_cd_m2 = -1", "s.toml:6: material \"wall\": luminance_cd_m2 = -1 is negative"),
        ("luminance_cd_m2 = 1, flux_lm = 1", "states 2 quantities"),
        ("two_sided = true", "states 0 quantities"),
        ("luminance_cd_m2 = inf", "not a finite number"),
        ("luminance_cd_m2 = 1, spectrum = \"D66\"", "unknown illuminant `D66`\n  mend: did you mean `D65`?"),
        ("luminance_cd_m2 = 1, spectrum = \"no.csv\"", "s.toml:6: no such file: `no.csv`"),
        ("luminanse_cd_m2 = 1", "unknown key `luminanse_cd_m2`\n  mend: did you mean `luminance_cd_m2`?"),
        ("radiant_exitance_W_m2 = 1", "unknown key"),
    ] {
        let e = error(&format!("[materials.wall]\nemission = {{ {emission} }}\n"));
        assert!(e.contains(want), "{emission} gave {e}");
    }
    let s = scene_of("[materials.wall]\nemission = { flux_lm = 0 }\n").unwrap();
    assert!(s.warnings[0].contains("its emission is zero"));
}

#[test]
fn glass_cannot_pass_more_than_a_clear_pane() {
    let glass = |t: &str| format!("[materials.wall]\nkind = \"glass\"\ntransmittance = {t}\n");
    let s = scene_of(&glass("0.88")).unwrap();
    assert!(matches!(s.materials[0].kind, MaterialKind::Glass { refractive_index, .. } if refractive_index == 1.52));
    let e = error(&glass("0.96"));
    assert!(e.contains("s.toml:7:") && e.contains("0.9183") && e.contains("not the transmissivity"), "{e}");
    assert!(scene_of(&glass("0.96\nn = 1.1")).is_ok(), "`n` is the index");
    assert!(error("[materials.wall]\nreflectance = 0.5\ntransmittance = 0.5\n").contains("set kind = \"glass\""));
    assert!(error("[materials.wall]\nkind = \"glass\"\n").contains("has no `transmittance`"));
}

/// A scene with one table of luminaires.
fn hung(keys: &str) -> String {
    format!("{WALL}[[luminaires]]\nfile = \"a.obj\"\nposition_m = [1, 2, 3]\n{keys}")
}

#[test]
fn luminaires_hang_in_rows_and_columns() {
    let keys = "columns = 3\ncolumn_spacing_m = [2, 0, 0]\nrows = 2\nrow_spacing_m = [0, 1.5, 0]\nflux_lm = 500\n\
                multiplier = 0.5\nmaintenance_factor = 0.8\nspectrum = 4000\n";
    let s = scene_of(&hung(keys)).unwrap();
    let row = &s.luminaires[0];
    assert_eq!(row.positions.len(), 6);
    assert_eq!(row.positions[5], DVec3::new(5.0, 3.5, 3.0));
    assert_eq!((row.flux_lm, row.factor, row.line), (Some(500.0), 0.4, 7));
    assert_eq!(s.inputs.last().unwrap().path, PathBuf::from("a.obj"), "its hash is kept");
    // y up: the aim is down all the same, and the user's x is C0's.
    let y_up = format!("{}{}", HEAD.replace("up = \"z\"", "up = \"y\""), hung(""));
    let s = Folder::new(&[("a.obj", ROOM), ("s.toml", &y_up)]).load().unwrap();
    assert_eq!(s.luminaires[0].positions, [DVec3::new(1.0, -3.0, 2.0)]);
    assert_eq!((s.luminaires[0].axes.z_axis, s.luminaires[0].axes.x_axis), (DVec3::Z, DVec3::X));
}

#[test]
fn luminaires_that_cannot_hang_name_line_and_mend() {
    for (keys, want) in [
        ("columns = 3\n", "s.toml:10: columns without column_spacing_m"),
        ("row_spacing_m = [0, 1, 0]\n", "s.toml:10: row_spacing_m without rows"),
        ("columns = 0\ncolumn_spacing_m = [1, 0, 0]\n", "s.toml:10: 0 luminaires, not 1 to 100000"),
        ("aim = [0, 0, 0]\n", "s.toml:10: aim is zero"),
        ("maintenance_factor = 1.2\n", "s.toml:10: maintenance_factor = 1.2 cannot be"),
        ("flux_lm = -1\n", "s.toml:10: flux_lm = -1 cannot be"),
        ("spectrum = \"D56\"\n", "s.toml:10: a luminaire: unknown illuminant `D56`"),
        ("colour = 1\n", "s.toml:10: unknown key `colour`"),
    ] {
        let e = error(&hung(keys));
        assert!(e.contains(want), "{keys} gave {e}");
    }
    assert!(error(&hung("").replace("\"a.obj\"", "\"b.ies\"")).contains("s.toml:8: no such file: `b.ies`"));
}

#[test]
fn glazing_units_are_judged() {
    let glass = |rest: &str| format!("[materials.wall]\nkind = \"glass\"\n{rest}\n");
    let s = scene_of(&glass("transmittance = 0.78\npanes = 2")).unwrap();
    assert!(matches!(&s.materials[0].kind, MaterialKind::Glass { panes: Panes::Alike { count: 2, .. }, .. }));
    let coated = "{ transmittance = 0.82, reflectance_front = 0.11, reflectance_back = 0.05 }";
    let s = scene_of(&glass(&format!("panes = [{{ transmittance = 0.88 }}, {coated}]"))).unwrap();
    let MaterialKind::Glass { panes: Panes::Listed(list), .. } = &s.materials[0].kind else { panic!() };
    assert!(list[0].reflectance.is_none());
    // Back, then front.
    assert_eq!(list[1].reflectance.as_ref().unwrap().each_ref().map(|r| r.max()), [0.05, 0.11]);
    for (rest, want) in [
        // Two clear panes pass (1 − r)/(1 + 3r), r = 0.042580.
        (
            "transmittance = 0.86\npanes = 2",
            "s.toml:7: material \"wall\": transmittance 0.86 is more than 2 clear panes",
        ),
        ("transmittance = 0.8\npanes = 0", "s.toml:8: material \"wall\": 0 panes"),
        ("transmittance = 0.8\npanes = 9", "1 to 8"),
        ("transmittance = 0.8\npanes = -1", "a number of panes or a list of tables"),
        ("panes = 2", "has no `transmittance`"),
        ("panes = []", "0 panes"),
        ("transmittance = 0.8\npanes = [{ transmittance = 0.9 }]", "each pane tells its transmittance"),
        ("panes = [{ transmittance = 0.93 }]", "more than a clear pane"),
        ("panes = [{ transmittance = 0.8, reflectance_front = 0.1 }]", "both of its sides"),
        (
            "panes = [{ transmittance = 0.8, reflectance_front = 0.1, reflectance_back = 0.3 }]",
            "transmittance and reflectance_back of a pane sum to 1.1000",
        ),
        ("panes = [{ transmitance = 0.8 }]", "unknown key `transmitance`\n  mend: did you mean `transmittance`?"),
    ] {
        let e = error(&glass(rest));
        assert!(e.contains(want), "{rest} gave {e}");
    }
    assert!(error("[materials.wall]\nreflectance = 0.5\npanes = 2\n").contains("a diffuse material has no `panes`"));
}

#[test]
fn translucent_materials_are_judged() {
    let sheet = |rest: &str| format!("[materials.wall]\nkind = \"translucent\"\n{rest}\n");
    let s = scene_of(&sheet("transmittance = 0.4\nreflectance = 0.5")).unwrap();
    assert!(matches!(s.materials[0].kind, MaterialKind::Translucent { .. }));
    for (rest, want) in [
        ("transmittance = 0.4", "has no `reflectance`"),
        ("reflectance = 0.4", "has no `transmittance`"),
        (
            "transmittance = 0.4\nreflectance = 0.7",
            "s.toml:8: material \"wall\": transmittance and reflectance sum to 1.1",
        ),
        ("transmittance = 0.4\nreflectance = 0.5\nreflectance_back = 0.61", "s.toml:9:"),
        ("transmittance = 0.4\nreflectance = 0.5\npanes = 2", "a translucent material has no `panes`"),
    ] {
        let e = error(&sheet(rest));
        assert!(e.contains(want), "{rest} gave {e}");
    }
}

/// An even sheet in Klems's quarter basis that lets by 30 %.
fn sheet_xml() -> String {
    let values = vec![format!("{}", 0.3 / PI); 41 * 41].join(",");
    format!(
        "<WindowElement><Optical><Layer>\n<DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure></DataDefinition>\n<WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock><WavelengthDataDirection>Transmission Front</WavelengthDataDirection><ColumnAngleBasis>LBNL/Klems Quarter</ColumnAngleBasis><RowAngleBasis>LBNL/Klems Quarter</RowAngleBasis><ScatteringData>{values}</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>"
    )
}

#[test]
fn a_bsdf_is_read_with_its_file_and_what_is_up() {
    let load = |material: &str, xml: &str| {
        let toml = format!("{HEAD}[materials.wall]\nkind = \"bsdf\"\n{material}");
        Folder::new(&[("a.obj", ROOM), ("w.xml", xml), ("s.toml", &toml)]).load()
    };
    let s = load("file = \"w.xml\"\nup = [0, 2, 0]\nmaintenance_factor = 0.9\n", &sheet_xml()).unwrap();
    let MaterialKind::Bsdf { bsdf, up, maintenance_factor } = &s.materials[0].kind else { panic!() };
    assert_eq!((*up, *maintenance_factor), (DVec3::Y, 0.9));
    let passed = bsdf.scattering(bsdf::Passage::TransmissionFront).unwrap().hemispherical();
    assert!((passed - 0.3).abs() < 1e-12, "the file's own: dirt is apart");
    assert!(s.inputs.iter().any(|i| i.path.to_str() == Some("w.xml")), "its hash is told");
    for (material, xml, want) in [
        ("up = [0, 1, 0]\n", sheet_xml(), "s.toml:5: material \"wall\" has no `file`"),
        ("file = \"v.xml\"\n", sheet_xml(), "s.toml:7: no such file: `v.xml`"),
        // The slab lies level: what is up must be said.
        ("file = \"w.xml\"\n", sheet_xml(), "`up` points along the normal of one of its faces"),
        ("file = \"w.xml\"\nup = [0, 0, 0]\n", sheet_xml(), "s.toml:8: up is zero"),
        (
            "file = \"w.xml\"\nreflectance = 0.5\n",
            sheet_xml(),
            "s.toml:8: material \"wall\": a bsdf material has no `reflectance`",
        ),
        ("file = \"w.xml\"\nmaintenance_factor = 1.1\n", sheet_xml(), "maintenance_factor = 1.1 is not within 0 to 1"),
        (
            "file = \"w.xml\"\nup = [0, 1, 0]\n",
            sheet_xml().replace("Visible", "Solar"),
            "w.xml:1: no visible scattering data",
        ),
    ] {
        let e = load(material, &xml).unwrap_err().to_string();
        assert!(e.contains(want), "{material} gave {e}");
    }
}

#[test]
fn keys_of_windows_belong_to_windows() {
    for (rest, want) in [
        (
            "[materials.blind]\nreflectance = 0.5\nfile = \"blind.xml\"\n",
            "s.toml:9: material \"blind\": `file` belongs to kind",
        ),
        (
            "[materials.blind]\nreflectance = 0.5\nup = [0, 0, 1]\n",
            "s.toml:9: material \"blind\": `up` belongs to kind",
        ),
        (
            "[materials.m]\nkind = \"mirror\"\nreflectance = 0.5\nmaintenance_factor = 0.9\n",
            "a mirror material has no `maintenance_factor`",
        ),
        (
            "[materials.m]\nreflectance = 0.5\nmaintenance_factor = 0.9\n",
            "a diffuse material has no `maintenance_factor`",
        ),
    ] {
        let e = error(&format!("{WALL}{rest}"));
        assert!(e.contains(want), "{rest} gave {e}");
    }
}

#[test]
fn skies_and_sites_that_cannot_be_name_line_and_mend() {
    for (rest, line, want, mend) in [
        ("[sky]\nmodel = \"cie-overcost\"\n", 8, "unknown sky model `cie-overcost`", "did you mean `cie-overcast`?"),
        ("[sky]\nmodel = \"cie-16\"\n", 8, "unknown sky model `cie-16`", "`cie-"),
        ("[sky]\nhorizontal_illuminance_lx = 1\n", 7, "missing key `model`", "model = "),
        ("[sky]\nmodel = \"uniform\"\nground_reflectance = 1.2\n", 9, "ground_reflectance = 1.2", "from 0 to 1"),
        ("[sky]\nmodel = \"uniform\"\nhorizontal_illuminance_lx = -5\n", 9, "= -5", "15000 lx"),
        ("[sky]\nmodel = \"uniform\"\nhorizontal_illuminance_lx = nan\n", 9, "NaN", "15000 lx"),
        ("[sky]\nmodel = \"perez\"\ndirect_normal_irradiance_W_m2 = 2000\n", 9, "= 2000", "900 W/m²"),
        ("[sky]\nmodel = \"uniform\"\nsun_altitude_deg = 30\n", 9, "no azimuth", "sun_azimuth_deg"),
        ("[sky]\nmodel = \"uniform\"\nspectrum = \"D66\"\n", 9, "unknown illuminant `D66`", "`D65`"),
        (
            "[sky]\nmodel = \"perez\"\ndirect_normal_irradiance_W_m2 = 200\ndirect_normal_illuminance_lx = 9\n",
            9,
            "stated twice",
            "keep one",
        ),
        ("[site]\nlatitude_deg = 91\n", 8, "latitude_deg = 91", "north and east"),
        ("[site]\nlongitude = 13\n", 8, "unknown key `longitude`", "did you mean `longitude_deg`?"),
        ("[site]\ntime = \"2026-03-21T12:00:00\"\n", 8, "time zone is missing", "+01:00"),
        ("[site]\ntime = \"21 March\"\n", 8, "no date and time", "+01:00"),
        ("[site]\ntime = \"2026-03-21\"\n", 8, "date or time is missing", "+01:00"),
        ("[site]\nweather = \"none.epw\"\n", 8, "no such file: `none.epw`", "relative to the scene file"),
    ] {
        let e = error(&format!("{WALL}{rest}"));
        assert!(e.starts_with(&format!("s.toml:{line}:")) || e.contains(&format!("s.toml:{line}:")), "{rest} gave {e}");
        assert!(e.contains(want) && e.contains(mend), "{rest} gave {e}");
    }
    assert!(scene_of(&format!("{WALL}[sky]\nmodel = \"none\"\n")).unwrap().daytime.is_none());
}

#[test]
fn bands_are_read_in_all_forms() {
    let mode = |m: &str| scene(&format!("[bands]\nmode = {m}\n")).bands;
    assert_eq!(mode("\"grey\""), BandMode::Grey);
    assert_eq!(
        mode("{ step_nm = 5, range_nm = [380, 780] }"),
        BandMode::Step { step_nm: 5.0, lo_nm: 380.0, hi_nm: 780.0 }
    );
    assert_eq!(mode("{ edges_nm = [400, 500.5, 700] }"), BandMode::Edges(vec![400.0, 500.5, 700.0]));
    for bad in [
        "{ step_nm = 5 }",
        "{ step_nm = 0, range_nm = [380, 780] }",
        "{ edges_nm = [500, 400] }",
        "{ step_nm = nan, range_nm = [1, 2] }",
    ] {
        let e = error(&format!("{WALL}[bands]\nmode = {bad}\n"));
        assert!(e.starts_with("s.toml:8:"), "{bad} gave {e}");
    }
}

#[test]
fn grids_are_placed_in_all_forms() {
    let s = scene(
        "[[grids]]\nname = \"a\"\nplane = { origin_m = [0, 0, 1], u_m = [2, 0, 0], v_m = [0, 1, 0], nu = 4, nv = 2 }\n\
         [[grids]]\nname = \"b\"\non = \"slab\"\nspacing_m = 0.5\nheight_m = 0.8\n\
         [[grids]]\nname = \"c\"\non = \"wall\"\nspacing_m = 0.25\ninset_m = 0.3\n",
    );
    let first = s.grids[0].sensors[0];
    assert_eq!((first.position, first.normal), (DVec3::new(0.25, 0.25, 1.0), DVec3::Z));
    assert!((first.area_m2.unwrap() - 0.25).abs() < 1e-12);
    assert_eq!(s.grids[1].sensors.len(), 8);
    assert!(s.grids[1].sensors[7].position.distance(DVec3::new(1.75, 0.75, 0.8)) < 1e-12);
    assert_eq!(s.grids[2].sensors.len(), 6 * 2, "0.375 to 1.625 by 0.375 to 0.625");
    let GridLayout::Raster { nu, nv, index, .. } = &s.grids[2].layout else { panic!() };
    assert_eq!((*nu, *nv, index.iter().flatten().count()), (8, 4, 12));
}

#[test]
fn grids_are_judged() {
    let plane = "plane = { origin_m = [0, 0, 1], u_m = [2, 0, 0], v_m = [0, 1, 0], nu = 4, nv = 2 }";
    for (grid, want) in [
        ("name = \"\"\non = \"wall\"\nspacing_m = 1".to_owned(), "s.toml:8: the name of a grid is empty"),
        ("name = \"a/b\"\non = \"wall\"\nspacing_m = 1".to_owned(), "cannot be a file name"),
        ("name = \"a\"".to_owned(), "says nowhere or more than once"),
        (format!("name = \"a\"\n{plane}\non = \"wall\""), "says nowhere or more than once"),
        (format!("name = \"a\"\n{plane}\nspacing_m = 1"), "`spacing_m` belongs to a grid with `on`"),
        (format!("name = \"a\"\n{}", plane.replace("v_m = [0, 1, 0]", "v_m = [1, 0, 0]")), "span no area"),
        (format!("name = \"a\"\n{}", plane.replace("nu = 4", "nu = 0")), "nu is zero"),
        (format!("name = \"a\"\n{plane}\nnormal = [0, 0, 0]"), "s.toml:10: normal is zero"),
        ("name = \"a\"\non = \"slub\"\nspacing_m = 1".to_owned(), "s.toml:9: no object and no material in use is called `slub`\n  mend: did you mean `slab`?"),
        ("name = \"a\"\non = \"slab\"\nspacing_m = 0".to_owned(), "spacing_m must be positive"),
        ("name = \"a\"\non = \"slab\"\nspacing_m = 1e-5".to_owned(), "more than the"),
        ("name = \"a\"\non = \"slab\"\nspacing_m = 0.25\ninset_m = 5".to_owned(), "no point lies on `slab`"),
        ("name = \"a\"\npoints = \"none.pts\"".to_owned(), "s.toml:9: no such file: `none.pts`"),
        ("name = \"a\"\non = \"slab\"\nspacing_m = 1\n[[views]]\nname = \"A\"\nposition_m = [0,0,0]\ndirection = [1,0,0]\nfov_deg = 60\npixels = [8, 8]".to_owned(), "the name \"A\" is taken by a grid already"),
    ] {
        let e = error(&format!("{WALL}[[grids]]\n{grid}\n"));
        assert!(e.contains(want), "{grid} gave {e}");
    }
}

#[test]
fn points_are_read_in_metres_and_hashed() {
    let folder = Folder::new(&[
        ("a.obj", ROOM),
        ("s.toml", &format!("{HEAD}{WALL}[[grids]]\nname = \"p\"\npoints = \"p.pts\"\n")),
    ]);
    folder.write("p.pts", b"1 0.5 0 0 0 3\n");
    let s = folder.load().unwrap();
    assert_eq!(s.grids[0].sensors[0], Sensor { position: DVec3::new(1.0, 0.5, 0.0), normal: DVec3::Z, area_m2: None });
    assert_eq!(s.inputs[2].path.to_str(), Some("p.pts"));
    folder.write("p.pts", b"1 0.5 0 0 0 3\n1 2\n");
    assert!(folder.load().unwrap_err().to_string().contains("p.pts:2: expected six numbers"));
}

const VIEW: &str = "[[views]]\nname = \"v\"\nposition_m = [0, 0, 1]\ndirection = [0, 3, 0]\n";

#[test]
fn views_have_angles_from_film_or_degrees() {
    let view = |rest: &str| scene(&format!("{VIEW}{rest}\n")).views[0].clone();
    let film = view("film_mm = [25, 25]\nfocal_mm = 35\npixels = [512, 512]");
    let Projection::Perspective { horizontal, vertical } = film.projection else { panic!() };
    assert!((horizontal.to_degrees() - 39.307_65).abs() < 1e-5 && horizontal == vertical);
    let Projection::Perspective { horizontal, vertical } = view("fov_deg = 90\npixels = [200, 100]").projection else {
        panic!()
    };
    assert!((horizontal - PI / 2.0).abs() < 1e-15 && ((0.5 * vertical).tan() - 0.5).abs() < 1e-15);
    assert_eq!(view("kind = \"fisheye\"\npixels = [9, 9]").projection, Projection::Fisheye { angle: PI });
    assert_eq!(view("kind = \"panorama\"\npixels = [20, 10]").projection, Projection::Panorama);
    let tilted = view("up = [0, 1, 1]\nfov_deg = 90\npixels = [10, 10]");
    assert!(tilted.up.distance(DVec3::Z) < 1e-15, "up is made perpendicular");
}

#[test]
fn views_are_judged() {
    for (rest, want) in [
        ("up = [0, -2, 0]\nfov_deg = 60\npixels = [8, 8]", "s.toml:11: view \"v\": `up` is parallel to `direction`"),
        ("fov_deg = 60\npixels = [0, 8]", "pixels = [0, 8] is not within 1 to 16384"),
        ("fov_deg = 60\npixels = [8, 20000]", "is not within"),
        ("fov_deg = 180\npixels = [8, 8]", "kind = \"fisheye\""),
        ("pixels = [8, 8]", "states no angle"),
        ("fov_deg = 60", "missing key `pixels`"),
        ("kind = \"panorama\"\nfov_deg = 60\npixels = [8, 8]", "sees all around"),
        ("kind = \"fish\"\npixels = [8, 8]", "did you mean `fisheye`?"),
    ] {
        let e = error(&format!("{WALL}{VIEW}{rest}\n"));
        assert!(e.contains(want), "{rest} gave {e}");
    }
}

#[test]
fn a_scene_of_the_wrong_unit_is_suspected() {
    let s =
        Folder::new(&[("a.obj", &ROOM.replace("v 2", "v 2000")), ("s.toml", &format!("{HEAD}{WALL}"))]).load().unwrap();
    assert!(s.warnings[0].contains("2.000e3 m across: is unit = \"m\" right?"), "{:?}", s.warnings);
}

#[test]
fn missing_and_flat_geometry_are_errors() {
    let e = shorten(Folder::new(&[("s.toml", &format!("{HEAD}{WALL}"))]).load());
    assert!(e.contains("s.toml:2: no such file: `a.obj`"), "{e}");
    let flat = "v 0 0 0\nv 1 0 0\nv 2 0 0\nusemtl wall\nf 1 2 3\n";
    let e = shorten(Folder::new(&[("a.obj", flat), ("s.toml", &format!("{HEAD}{WALL}"))]).load());
    assert!(e.contains("no geometry: none of the 1 faces has an area"), "{e}");
    let e = error_of_file("[geometry]\nfiles = []\nunit = \"m\"\nup = \"z\"\n");
    assert!(e.contains("`files` is empty"), "{e}");
    assert!(load(std::path::Path::new("nowhere.toml")).unwrap_err().is_input());
}

fn error_of_file(text: &str) -> String {
    shorten(Folder::new(&[("s.toml", text)]).load())
}

#[test]
fn a_material_library_is_told_to_be_ignored() {
    let obj = format!("mtllib a.mtl\n{ROOM}");
    let folder = Folder::new(&[("a.obj", &obj), ("s.toml", &format!("{HEAD}{WALL}"))]);
    assert!(folder.load().unwrap().warnings.is_empty(), "a library that is not there does not matter");
    folder.write("a.mtl", b"newmtl wall\nKd 1 1 1\n");
    assert_eq!(folder.load().unwrap().warnings, ["a.obj: a.mtl is not read: materials come from the scene file"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn any_scene_bytes_give_a_scene_or_a_named_error(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let folder = Folder::new(&[("a.obj", ROOM)]);
        folder.write("s.toml", &bytes);
        if let Err(e) = folder.load() {
            prop_assert!(e.to_string().contains("s.toml"));
        }
    }

    #[test]
    fn a_scene_with_a_word_changed_gives_a_scene_or_a_named_error(
        at in 0usize..600,
        word in prop::sample::select(vec!["", "nan", "-1", "inf", "\"x\"", "[1]", "{}", "1e300", "=", "]", "\n", "0", "\"a.obj\"", "true"]),
        cut in 0usize..12,
    ) {
        let mut text = format!(
            "{HEAD}north_deg = 0\n[bands]\nmode = {{ step_nm = 5, range_nm = [380, 780] }}\n\
             [materials.wall]\nreflectance = 0.5\nemission = {{ flux_lm = 10, spectrum = \"D65\" }}\n\
             [[grids]]\nname = \"a\"\nplane = {{ origin_m = [0, 0, 1], u_m = [2, 0, 0], v_m = [0, 1, 0], nu = 4, nv = 2 }}\n\
             [[grids]]\nname = \"b\"\non = \"slab\"\nspacing_m = 0.5\nheight_m = 0.8\n\
             {VIEW}film_mm = [25, 25]\nfocal_mm = 35\npixels = [8, 8]\n"
        );
        let from = at % text.len();
        let to = (from + cut).min(text.len());
        text.replace_range(from..to, word);
        let folder = Folder::new(&[("a.obj", ROOM), ("s.toml", &text)]);
        match folder.load() {
            Err(e) => prop_assert!(e.to_string().contains("s.toml") || e.to_string().contains("a.obj"), "{e}"),
            Ok(s) => prop_assert!(s.grids.iter().flat_map(|g| &g.sensors).all(|x| x.position.is_finite() && x.normal.is_normalized())),
        }
    }

    #[test]
    fn any_side_file_bytes_give_a_scene_or_a_named_error(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let toml = format!("{HEAD}[materials.wall]\nreflectance = \"r.csv\"\n[[grids]]\nname = \"p\"\npoints = \"p.pts\"\n");
        let folder = Folder::new(&[("a.obj", ROOM), ("s.toml", &toml), ("p.pts", "0 0 0 0 0 1\n")]);
        folder.write("r.csv", &bytes);
        if let Err(e) = folder.load() {
            prop_assert!(e.to_string().contains("r.csv") || e.to_string().contains("reflectance"), "{e}");
        }
    }
}
