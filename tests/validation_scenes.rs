//! The scenes under `validation/` are what their pages say.

use std::path::{Path, PathBuf};

use clerestory::scene::{self, Face, GridLayout, Scene, Severity};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("validation").join(name)
}

fn load(name: &str) -> Scene {
    scene::load(&path(name)).expect("a scene of ours is sound")
}

fn area(scene: &Scene, material: &str) -> f64 {
    let of = |f: &&Face| scene.materials[f.material].name == material;
    scene.faces.iter().filter(of).map(|f| f.area_m2).sum()
}

#[test]
fn the_cornell_box_has_its_published_areas_and_no_trouble() {
    let scene = load("cornell/scene.toml");
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert!(scene::check(&scene).iter().all(|d| d.severity == Severity::Info));
    // mm² of the published quads; the ceiling's hole and the lamp in it make up the published ceiling.
    assert!((area(&scene, "light") - 0.013_650).abs() < 1e-12);
    assert!((area(&scene, "green") - 0.306_888_96).abs() < 1e-12);
    let ceiling: f64 = scene.faces.iter().filter(|f| scene.objects[f.object] == "ceiling").map(|f| f.area_m2).sum();
    assert!((ceiling + 0.013_650 - 0.310_915_2).abs() < 1e-12);
    // Two triangles of a warped quad: more than its Newell area by about (3.2 mm / 550 mm)².
    assert!((area(&scene, "red") / 0.306_904_5 - 1.0).abs() < 1e-4);
}

#[test]
fn the_cornell_lamp_has_its_stated_luminance() {
    let scene = load("cornell/scene.toml");
    let lamp = scene.materials.iter().find(|m| m.name == "light").and_then(|m| m.emission.as_ref()).expect("it emits");
    assert!((lamp.radiance.luminous() - 10_000.0).abs() < 1e-6);
    assert!((lamp.radiance.at(600.0) / lamp.radiance.at(500.0) - 15.6 / 8.0).abs() < 1e-12);
}

#[test]
fn every_cornell_sensor_lies_on_a_face_and_looks_as_it_does() {
    let scene = load("cornell/scene.toml");
    assert_eq!(scene.grids.len(), 5);
    for grid in &scene.grids {
        assert_eq!(grid.sensors.len(), 100);
        for s in &grid.sensors {
            // 1e-8 m: the points file has nine decimals.
            let on = |f: &Face| {
                (s.position - f.vertices[0]).dot(f.normal).abs() < 1e-8 && s.normal.dot(f.normal) > 1.0 - 1e-9
            };
            assert!(scene.faces.iter().any(on), "{} {:?}", grid.name, s.position);
        }
    }
    let wall = &scene.grids[2];
    assert!(matches!(wall.layout, GridLayout::Points));
}

#[test]
fn the_furnace_emits_what_it_does_not_reflect() {
    let scene = load("furnace/furnace.toml");
    for material in &scene.materials {
        let scene::MaterialKind::Diffuse { front, .. } = &material.kind else { panic!("all are diffuse") };
        let exitance = std::f64::consts::PI * material.emission.as_ref().expect("all emit").radiance.luminous();
        assert!((exitance + 1000.0 * front.max() - 1000.0).abs() < 1e-9, "{}", material.name);
    }
    assert!(scene::check(&scene).iter().all(|d| d.severity != Severity::Error));
}
