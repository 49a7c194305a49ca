//! The hall as files: OBJ and scene.

use std::fmt::Write;

use super::hall::{Size, hall};
use super::parts::Part;

type Paint = (&'static str, [f64; 3], Option<(f64, u32)>);

/// Paints: name, reflectance (linear Rec. 709), luminance in cd/m² and colour temperature in K where they shine.
///
/// Lamps of 20,000 lm: `π L A`, with 0.137 m² of octagon. Ingots at 1,473 K with an emittance of 0.8: 0.8 times the
/// luminance of a black body (5,750 cd/m², Planck's law through V(λ)).
const PAINTS: [Paint; 12] = [
    ("concrete", [0.28, 0.26, 0.23], None),
    ("sheet", [0.42, 0.45, 0.46], None),
    ("steel", [0.20, 0.11, 0.08], None),
    ("bright", [0.35, 0.35, 0.36], None),
    ("yellow", [0.66, 0.44, 0.05], None),
    ("pipe", [0.12, 0.26, 0.20], None),
    ("brick", [0.36, 0.19, 0.12], None),
    ("wood", [0.40, 0.28, 0.17], None),
    ("scale", [0.12, 0.10, 0.10], None),
    ("housing", [0.60, 0.60, 0.60], None),
    ("lamp", [0.80, 0.80, 0.80], Some((46_500.0, 4000))),
    ("glowing", [0.20, 0.20, 0.20], Some((4_600.0, 1473))),
];

/// How many points along width and length of the floor's grid.
const GRID: [usize; 2] = [12, 20];

/// Number of polygons, and the text of the OBJ file.
pub(crate) fn obj(size: Size) -> (usize, String) {
    let mut text = "# metres, z up\n".to_owned();
    let (mut polygons, mut first) = (0, 1);
    let (mut object, mut paint) = ("", "");
    for Part { object: own, vertices, faces } in hall(size) {
        if own != object {
            object = own;
            let _ = writeln!(text, "o {object}");
        }
        for p in &vertices {
            let _ = writeln!(text, "v {:.7} {:.7} {:.7}", p.x, p.y, p.z);
        }
        for (face, material) in &faces {
            if *material != paint {
                paint = material;
                let _ = writeln!(text, "usemtl {paint}");
            }
            text.push('f');
            face.iter().for_each(|v| {
                let _ = write!(text, " {}", first + v);
            });
            text.push('\n');
        }
        polygons += faces.len();
        first += vertices.len() as u32;
    }
    (polygons, text)
}

/// The scene file: three bands, a grid on the floor, and a picture of `pixels` where asked for.
pub(crate) fn scene(size: Size, pixels: Option<[usize; 2]>) -> String {
    let [width, length] = size.extent_m();
    let mut text = format!(
        "title = \"Steel mill, {} aisles of {} bays\"\n\n[geometry]\nfiles = [\"hall.obj\"]\nunit = \"m\"\nup = \"z\"\n\n[bands]\nmode = \"rgb\"\n",
        size.aisles, size.bays
    );
    for (name, [r, g, b], light) in PAINTS {
        let _ = writeln!(text, "\n[materials.{name}]\nreflectance = [{r}, {g}, {b}]");
        if let Some((luminance, kelvin)) = light {
            let _ = writeln!(text, "emission = {{ luminance_cd_m2 = {luminance}, spectrum = {kelvin} }}");
        }
    }
    let [nu, nv] = GRID;
    let _ = write!(
        text,
        "\n[[grids]]\nname = \"floor\"\nplane = {{ origin_m = [0, 0, 0], u_m = [{width}, 0, 0], v_m = [0, {length}, 0], nu = {nu}, nv = {nv} }}\nnormal = [0, 0, 1]\n"
    );
    if let Some([w, h]) = pixels {
        let _ = write!(
            text,
            "\n[[views]]\nname = \"hall\"\nposition_m = [8.4, 0.6, 6.2]\ndirection = [0.12, 1, -0.12]\nup = [0, 0, 1]\nfov_deg = 75\npixels = [{w}, {h}]\n"
        );
    }
    text
}
