//! The shipped luminaires: each a formula whose flux is known in closed form, and no maker's product.
//!
//! Angles: `γ` from nadir, `C` from plane C0. `I0` follows from the flux.

use std::f64::consts::PI;

use clerestory::light::photometry::{Format, Opening, PhotometricType, Photometry, Web};

/// A formula luminaire.
pub struct Shipped {
    /// Name of its files.
    pub stem: &'static str,
    /// What it is called.
    pub title: &'static str,
    /// Its luminous flux, lm.
    pub flux_lm: f64,
    /// Its flux at `I0 = 1 cd`, in closed form.
    unit_flux: f64,
    /// Its intensity at `I0 = 1 cd`, by `γ` and `C` in radians.
    intensity: fn(f64, f64) -> f64,
    opening: Opening,
    /// Planes and angles written, degrees: from, to, step.
    planes: [f64; 3],
    angles: [f64; 3],
}

const FLAT: Opening = Opening { along_c0_m: 0.0, along_c90_m: 0.0, height_m: 0.0, round: false };

fn disc(diameter_m: f64) -> Opening {
    Opening { along_c0_m: diameter_m, along_c90_m: diameter_m, round: true, ..FLAT }
}

fn rectangle(along_c0_m: f64, along_c90_m: f64) -> Opening {
    Opening { along_c0_m, along_c90_m, ..FLAT }
}

fn cosine(gamma: f64) -> f64 {
    gamma.cos().max(0.0)
}

/// `cos^16` of the angle to an axis 35° from nadir, towards C30.
fn projector(gamma: f64, c: f64) -> f64 {
    let (tilt, turn) = (35f64.to_radians(), 30f64.to_radians());
    (gamma.cos() * tilt.cos() + gamma.sin() * tilt.sin() * (c - turn).cos()).max(0.0).powi(16)
}

/// All of them.
pub fn catalogue() -> Vec<Shipped> {
    let axial = [0.0, 0.0, 1.0];
    vec![
        Shipped {
            stem: "panel",
            title: "Lambertian panel 0.6 x 0.6 m",
            flux_lm: 3600.0,
            unit_flux: PI, // ∫ cos γ dω
            intensity: |g, _| cosine(g),
            opening: rectangle(0.6, 0.6),
            planes: axial,
            angles: [0.0, 90.0, 1.0],
        },
        Shipped {
            stem: "downlight",
            title: "Downlight, cos^4",
            flux_lm: 1500.0,
            unit_flux: 2.0 * PI / 5.0, // 2π/(n + 1)
            intensity: |g, _| cosine(g).powi(4),
            opening: disc(0.15),
            planes: axial,
            angles: [0.0, 90.0, 1.0],
        },
        Shipped {
            stem: "spot",
            title: "Narrow downlight, cos^40",
            flux_lm: 800.0,
            unit_flux: 2.0 * PI / 41.0,
            intensity: |g, _| cosine(g).powi(40),
            opening: disc(0.08),
            planes: axial,
            angles: [0.0, 90.0, 0.5],
        },
        Shipped {
            stem: "wall_washer",
            title: "Wall washer towards C0",
            flux_lm: 2000.0,
            unit_flux: 1.25 * PI, // ∫ cos γ (1 + 2 sin γ cos C + sin² γ cos² C) dω = π + π/4
            intensity: |g, c| cosine(g) * (1.0 + g.sin() * c.cos()).powi(2),
            opening: rectangle(0.1, 0.3),
            planes: [0.0, 180.0, 5.0],
            angles: [0.0, 90.0, 1.0],
        },
        Shipped {
            stem: "pendant",
            title: "Direct-indirect pendant",
            flux_lm: 5000.0,
            unit_flux: 2.0 * PI / 3.0 + 1.2 * PI, // cos² down, 1.2 |cos| up
            intensity: |g, _| if g.cos() >= 0.0 { g.cos().powi(2) } else { -1.2 * g.cos() },
            opening: rectangle(1.2, 0.25),
            planes: axial,
            angles: [0.0, 180.0, 1.0],
        },
        Shipped {
            stem: "linear",
            title: "Linear luminaire 1.5 m along C0",
            flux_lm: 4000.0,
            unit_flux: 0.9 * PI, // ∫ cos γ (1 − 0.4 sin² γ cos² C) dω = π − 0.4 π/4
            intensity: |g, c| cosine(g) * (1.0 - 0.4 * (g.sin() * c.cos()).powi(2)),
            opening: rectangle(1.5, 0.06),
            planes: [0.0, 90.0, 5.0],
            angles: [0.0, 90.0, 1.0],
        },
        Shipped {
            stem: "projector",
            title: "Projector, cos^16 about an axis at gamma 35, C30",
            flux_lm: 10_000.0,
            unit_flux: 2.0 * PI / 17.0,
            intensity: projector,
            opening: rectangle(0.3, 0.4),
            planes: [0.0, 355.0, 5.0],
            angles: [0.0, 180.0, 2.5],
        },
    ]
}

fn list([from, to, step]: [f64; 3]) -> Vec<f64> {
    (0..=((to - from) / step).round() as usize).map(|k| from + step * k as f64).collect()
}

/// A tenth of a millicandela: what lies below is rounding.
fn rounded(candela: f64) -> f64 {
    (candela * 1e4).round() / 1e4
}

impl Shipped {
    /// Luminous intensity, cd, at angles in degrees: the formula itself.
    pub fn candela(&self, gamma_deg: f64, c_deg: f64) -> f64 {
        self.flux_lm / self.unit_flux * (self.intensity)(gamma_deg.to_radians(), c_deg.to_radians())
    }

    /// As a photometric file holds it.
    pub fn photometry(&self) -> Photometry {
        let (planes, angles) = (list(self.planes), list(self.angles));
        let candela = planes.iter().flat_map(|c| angles.iter().map(move |g| rounded(self.candela(*g, *c)))).collect();
        let web = Web::new(PhotometricType::C, angles, planes, candela).expect("a formula without gaps");
        let label = |key: &str, text: &str| (key.to_owned(), text.to_owned());
        Photometry {
            format: Format::Ies(2002),
            web,
            opening: self.opening,
            labels: vec![
                label("TEST", "made by formula"),
                label("MANUFAC", "clerestory"),
                label("LUMCAT", self.stem),
                label("LUMINAIRE", self.title),
            ],
            lamps: 1.0,
            rated_flux_lm: Some(self.flux_lm),
            stated_flux_lm: None,
            power_w: (self.flux_lm / 125.0).round(),
            tilt: None,
            warnings: Vec::new(),
        }
    }
}
