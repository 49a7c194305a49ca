//! BSDF files by formula, and rooms with windows of them.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use clerestory::scene::bsdf::{Bsdf, KlemsBasis, Patch, PatchFinder};
use clerestory::scene::{Amount, Daytime, Material, MaterialKind, Placed, SkyName};
use clerestory::spectrum::Spectrum;

use super::{Build, at, diffuse};

/// `f(outgoing, incident)`, sr⁻¹.
pub type Value<'a> = &'a dyn Fn(usize, usize) -> f64;

/// The XML of an element in a basis: for each passage its name and `f(outgoing, incident)`, sr⁻¹.
pub fn xml(basis: &str, passages: &[(&str, Value<'_>)]) -> String {
    let n = KlemsBasis::named(basis).expect("a basis").patches().len();
    let mut text = String::from(
        "<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure></DataDefinition>\n",
    );
    for (name, f) in passages {
        let _ = writeln!(
            text,
            "<WavelengthData><Wavelength unit=\"Integral\">Visible</Wavelength><WavelengthDataBlock><WavelengthDataDirection>{name}</WavelengthDataDirection><ColumnAngleBasis>{basis}</ColumnAngleBasis><RowAngleBasis>{basis}</RowAngleBasis><ScatteringData>"
        );
        for o in 0..n {
            for i in 0..n {
                let _ = write!(text, "{:.9e},", f(o, i));
            }
            text.push('\n');
        }
        text.push_str("</ScatteringData></WavelengthDataBlock></WavelengthData>\n");
    }
    text + "</Layer></Optical></WindowElement>"
}

/// An even sheet: transmittance and reflectance the same for all directions.
pub fn lambertian(tau: f64, rho: f64) -> Bsdf {
    let (t, r) = (tau / std::f64::consts::PI, rho / std::f64::consts::PI);
    let text = xml(
        "LBNL/Klems Full",
        &[("Transmission Front", &|_, _| t), ("Reflection Front", &|_, _| r), ("Reflection Back", &|_, _| r)],
    );
    Bsdf::from_xml(&text).expect("even")
}

/// What the slats do, by shares: evenly to all directions; straight on where light goes up, and where it goes down; turned
/// from down to up.
pub const EVEN: f64 = 0.1;
pub const UPWARDS: f64 = 0.45;
pub const DOWNWARDS: f64 = 0.1;
pub const TURNED: f64 = 0.3;

/// A blind of mirrored slats: f(outgoing, incident) of light that comes in by the front.
pub fn slats_value(basis: KlemsBasis) -> impl Fn(usize, usize) -> f64 {
    let patches = basis.patches();
    let finder = PatchFinder::new(basis);
    move |o: usize, i: usize| {
        let (from, to): (Patch, Patch) = (patches[i], patches[o]);
        let goes_up = from.phi.sin() > 1e-9;
        let theta = 0.5 * (from.theta[0] + from.theta[1]);
        let (x, y) = (theta.sin() * from.phi.cos(), theta.sin() * from.phi.sin());
        let mut share = 0.0;
        if o == i {
            share += if goes_up { UPWARDS } else { DOWNWARDS };
        }
        if !goes_up && finder.find(theta.cos(), x, -y) == o {
            share += TURNED;
        }
        EVEN / std::f64::consts::PI + share / to.projected_solid_angle()
    }
}

/// The blind, with a reflectance of 0.1 on both sides.
pub fn slats() -> Bsdf {
    let rho = 0.1 / std::f64::consts::PI;
    let text = xml(
        "LBNL/Klems Full",
        &[
            ("Transmission Front", &slats_value(KlemsBasis::Full)),
            ("Reflection Front", &|_, _| rho),
            ("Reflection Back", &|_, _| rho),
        ],
    );
    Bsdf::from_xml(&text).expect("slats")
}

/// A material of it.
pub fn window(bsdf: Bsdf, maintenance_factor: f64) -> Material {
    let kind = MaterialKind::Bsdf { bsdf: Arc::new(bsdf), up: glam::DVec3::Z, maintenance_factor };
    Material { kind, ..diffuse("window", 0.0) }
}

/// A sky of 10,000 lx over a ground of 0.2, with a sun at an altitude and azimuth if `direct_lx` is not zero.
pub fn day(model: SkyName, direct_lx: f64, sun_deg: (f64, f64)) -> Daytime {
    let placed = |lx| Placed { value: Amount::Lux(lx), line: 1 };
    Daytime {
        file: PathBuf::from("test.toml"),
        model: Placed { value: model, line: 1 },
        diffuse: Some(placed(1e4)),
        direct: Some(placed(direct_lx)),
        sun_deg: Some(Placed { value: sun_deg, line: 1 }),
        site: None,
        spectrum: Spectrum::constant(1.0),
        sun_spectrum: Spectrum::constant(1.0),
        ground_reflectance: 0.2,
        north_deg: 0.0,
    }
}

/// A room of 4 × 6 × 3 m, its materials `[floor, walls, ceiling]`, with a window of 3 × 1.5 m in the wall to the south (y = 0),
/// whose front looks out.
pub fn office([floor, walls, ceiling]: [f64; 3], pane: Material) -> Build {
    let mut b = Build::new();
    let [floor, wall, ceiling] =
        [("floor", floor), ("wall", walls), ("ceiling", ceiling)].map(|(n, r)| b.material(diffuse(n, r)));
    let pane = b.material(pane);
    b.room(glam::DVec3::ZERO, at(4.0, 6.0, 3.0), [wall, wall, wall, wall, floor, ceiling]);
    b.0.faces.retain(|f| f.vertices.iter().any(|v| v.y > 1e-9));
    for (x0, x1, z0, z1) in [(0.0, 4.0, 0.0, 1.0), (0.0, 4.0, 2.5, 3.0), (0.0, 0.5, 1.0, 2.5), (3.5, 4.0, 1.0, 2.5)] {
        b.rectangle(at(x0, 0.0, z0), at(x1 - x0, 0.0, 0.0), at(0.0, 0.0, z1 - z0), wall);
    }
    b.rectangle(at(0.5, 0.0, 1.0), at(3.0, 0.0, 0.0), at(0.0, 0.0, 1.5), pane);
    b
}
