//! Writes the scenes, the cut list, the drawing and the measuring sheets of both arrangements beside this file.
//!
//! ```text
//! cargo run --release --example ferren
//! ```

pub(crate) mod design;

use std::fmt::Write;
use std::path::Path;

use design::{Design, backing, louvre};
use glam::DVec3;

fn main() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/ferren");
    for design in [louvre(), backing()] {
        for (ending, text) in files(&design) {
            std::fs::write(folder.join(format!("{}{ending}", design.name)), text)?;
        }
    }
    Ok(())
}

/// The files of an arrangement by the end of their names.
pub(crate) fn files(design: &Design) -> [(&'static str, String); 6] {
    [
        (".obj", obj(design)),
        (".toml", scene(design)),
        (".pts", points(design)),
        ("_cut_list.csv", cut_list(design)),
        ("_measured.csv", sheet(design)),
        ("_plan.svg", plan(design)),
    ]
}

/// Nine decimals, without a minus before zero.
fn number(v: f64) -> String {
    format!("{:.9}", if v.abs() < 5e-10 { 0.0 } else { v })
}

fn triple(p: DVec3) -> String {
    [p.x, p.y, p.z].map(number).join(" ")
}

fn obj(design: &Design) -> String {
    let mut text = "# metres, y up, the viewer at -z\n".to_owned();
    for (k, part) in design.parts().iter().enumerate() {
        let _ = writeln!(text, "o {}\nusemtl {}", part.name, part.paint);
        for p in part.corners {
            let _ = writeln!(text, "v {}", triple(p));
        }
        let first = 4 * k + 1;
        let _ = writeln!(text, "f {first} {} {} {}", first + 1, first + 2, first + 3);
    }
    text
}

/// The viewer of the protocol: 1.2 m before the boards, 0.25 m up, aimed at 0.2 m.
const CAMERA: &str = "\
[[views]]
name = \"viewer\"
position_m = [0, 0.25, -1.2]
direction = [0, -0.05, 1.2]
up = [0, 1, 0]
fov_deg = 32
pixels = [512, 512]
";

fn scene(design: &Design) -> String {
    let mut text = format!(
        "title = \"Boards with hidden colours: {0}\"\n\n[geometry]\nfiles = [\"{0}.obj\"]\nunit = \"m\"\nup = \"y\"\n\n\
         [bands]\nmode = {{ step_nm = 10, range_nm = [375, 785] }}\n",
        design.name
    );
    let mut paints: Vec<&str> = design.boards.paints.clone();
    paints.extend(["white", "black"]);
    for paint in paints {
        let _ = writeln!(text, "\n[materials.{paint}]\nreflectance = \"{paint}.csv\"");
    }
    let _ = write!(
        text,
        "\n[materials.sky]\nreflectance = 0.0\nemission = {{ luminance_cd_m2 = 4000, spectrum = \"D65\" }}\n\n\
         [[grids]]\nname = \"points\"\npoints = \"{}.pts\"\n\n{CAMERA}",
        design.name
    );
    text
}

fn points(design: &Design) -> String {
    design.points().iter().map(|(_, p, n)| format!("{} {}\n", triple(*p), triple(*n))).collect()
}

/// What to saw and how to paint it, millimetres.
fn cut_list(design: &Design) -> String {
    let b = &design.boards;
    let mm = |m: f64| format!("{:.0}", 1000.0 * m);
    let mut text = "part,pieces,width_mm,height_mm,thickness_mm,front,back,narrow_sides,top\n".to_owned();
    for (i, paint) in b.paints.iter().enumerate() {
        let edges = if b.white_edge { format!("viewer's white; other {paint}") } else { (*paint).to_owned() };
        let size = [b.width_m, b.height_m, b.thickness_m].map(mm).join(",");
        let _ = writeln!(text, "board {i},1,{size},white,{paint},{edges},black");
    }
    let mut flat = |name: &str, [_, u, v]: [DVec3; 3], front: &str| {
        let _ = writeln!(text, "{name},1,{},{},any,{front},any,any,any", mm(v.length()), mm(u.length()));
    };
    flat("base", design.base, "black");
    flat("light", design.sky, "diffuser of 4000 cd/m²");
    if let Some(backing) = design.backing {
        flat("backing", backing, "white");
    }
    text
}

/// What to fill in: `clerestory compare` is to read it; the point counts from 0.
fn sheet(design: &Design) -> String {
    let mut text = "grid,point,surface,x_m,y_m,z_m,reflectance,illuminance_lx,uncertainty_lx,luminance_cd_m2,\
                    uncertainty_cd_m2,cie_x,cie_y,uncertainty_xy\n"
        .to_owned();
    for (k, (surface, p, _)) in design.points().iter().enumerate() {
        let place = [p.x, p.y, p.z].map(|v| format!("{v:.4}")).join(",");
        let _ = writeln!(text, "points,{k},{surface},{place},white.csv,,,,,,,");
    }
    text
}

/// The plan from above at half size, to print and lay beneath the boards: 1 mm of paper for 2 mm.
fn plan(design: &Design) -> String {
    const SCALE: f64 = 500.0;
    let (left, top) = (-0.37, -0.30);
    let place = |p: DVec3| format!("{:.2},{:.2}", (p.x - left) * SCALE, (p.z - top) * SCALE);
    let mut text = "<svg xmlns='http://www.w3.org/2000/svg' width='370mm' height='500mm' viewBox='0 0 370 500' \
                    font-family='sans-serif' font-size='7'>\n<text x='10' y='12'>Plan at 1:2; the viewer stands above \
                    this line. Boards are drawn where they stand, the colour of each at its hidden side.</text>\n"
        .to_owned();
    for part in design.parts() {
        let colour = match part.paint.as_str() {
            "white" => "#888",
            "black" => "#000",
            "sky" => "#9cf",
            other => other,
        };
        let line: Vec<String> = part.corners.iter().map(|p| place(*p)).collect();
        let _ = writeln!(
            text,
            "<polygon points='{}' fill='none' stroke='{colour}' stroke-width='0.5'><title>{}</title></polygon>",
            line.join(" "),
            part.name
        );
    }
    for i in 0..design.boards.paints.len() {
        let m = design.boards.middle(i);
        let x = (m.x - left) * SCALE;
        let _ = writeln!(text, "<text x='{x:.1}' y='{:.1}' text-anchor='middle'>{i}</text>", (-0.1 - top) * SCALE);
    }
    let end = (-0.35 - left) * SCALE;
    let _ = writeln!(
        text,
        "<path d='M{end:.1} 485h50' stroke='#000'/><text x='{end:.1}' y='480'>100 mm of the model</text>\n</svg>"
    );
    text
}
