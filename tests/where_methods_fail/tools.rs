//! Form factors by quadrature over the program's own point factors, and scenes as files.

#![allow(dead_code, reason = "every user takes what it needs")]

use clerestory::light::{above_plane, configuration_factor};
use clerestory::scene::{self, Face, MaterialKind, Scene};
use clerestory::spectrum::SpectralValue;
use glam::DVec3;

/// Place and weight of `n` points of 0..1 that crowd at both ends, where irradiance has its kinks: midpoints under
/// `x = t³(10 − 15t + 6t²)`, whose first two derivatives vanish there (Sidi 1993).
fn crowded(n: usize) -> Vec<(f64, f64)> {
    let point = |k: usize| {
        let t = (k as f64 + 0.5) / n as f64;
        (t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t), 30.0 * (t * (1.0 - t)).powi(2) / n as f64)
    };
    (0..n).map(point).collect()
}

/// Mean over polygon `a` of a function of the point: triangles from the first vertex, each a collapsed square.
pub(super) fn mean_over(a: &[DVec3], n: usize, mut f: impl FnMut(DVec3) -> f64) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for k in 1..a.len() - 1 {
        let (p, u, v) = (a[0], a[k] - a[0], a[k + 1] - a[0]);
        let size = u.cross(v).length();
        for (s, ws) in crowded(n) {
            for (t, wt) in crowded(n) {
                let w = size * s * ws * wt;
                sum += w * f(p + (u * (1.0 - t) + v * t) * s);
                area += w;
            }
        }
    }
    sum / area
}

/// Irradiance at a point per unit exitance of a polygon, back faces and horizon counted as they are.
pub(super) fn irradiance(x: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    if Face::new(polygon, 0).normal.dot(x - polygon[0]) <= 0.0 {
        return 0.0;
    }
    let seen: Vec<DVec3> = polygon.iter().map(|p| *p - x).collect();
    let mut above = Vec::new();
    above_plane(&seen, normal, 0.0, &mut above);
    configuration_factor(&above, normal)
}

pub(super) fn form_factor(a: &[DVec3], b: &[DVec3]) -> f64 {
    let normal = Face::new(a, 0).normal;
    mean_over(a, 160, |x| irradiance(x, normal, b))
}

pub(super) fn square(corner: DVec3, u: DVec3, v: DVec3) -> Vec<DVec3> {
    vec![corner, corner + u, corner + u + v, corner + v]
}

/// Writes the scene as a user would have drawn it, with extra OBJ text at its end, and reads it back.
pub(super) fn as_files(scene: &Scene, extra: &str) -> Scene {
    let folder = tempfile::tempdir().expect("made");
    let mut obj = String::from("o thing\n");
    for f in &scene.faces {
        for p in &f.vertices {
            obj += &format!("v {} {} {}\n", p.x, p.y, p.z);
        }
        let numbers: String =
            (0..f.vertices.len()).map(|k| format!(" {}", k as i64 - f.vertices.len() as i64)).collect();
        obj += &format!("usemtl {}\nf{numbers}\n", scene.materials[f.material].name);
    }
    let mut toml =
        String::from("[geometry]\nfiles = [\"a.obj\"]\nunit = \"m\"\nup = \"z\"\n[bands]\nmode = \"grey\"\n");
    for m in &scene.materials {
        let MaterialKind::Diffuse { front: SpectralValue::Grey(rho), .. } = m.kind else { panic!("grey paint") };
        toml += &format!("[materials.{}]\nreflectance = {rho}\n", m.name);
        if let Some(e) = &m.emission {
            toml += &format!("emission = {{ exitance_lm_m2 = {} }}\n", std::f64::consts::PI * e.radiance.luminous());
        }
    }
    std::fs::write(folder.path().join("a.obj"), obj + extra).expect("written");
    std::fs::write(folder.path().join("s.toml"), toml).expect("written");
    let mut read = scene::load(&folder.path().join("s.toml")).expect("a sound scene");
    read.grids.clone_from(&scene.grids);
    read
}
