//! What the cases add to scenes put together in memory: light of equal energy, grey paints, skies, and quadrature.

use std::f64::consts::PI;
use std::path::PathBuf;

use glam::DVec3;

use crate::Result;
use crate::measure::{self, Measurement, Silent, SolveOptions};
pub(super) use crate::scene::Build;
use crate::scene::{Amount, Daytime, Emission, LuminaireRow, Material, MaterialKind, Panes, Placed, SkyName};
use crate::spectrum::{SpectralValue, Spectrum};

impl Build {
    /// A material of some kind.
    pub(super) fn made_of(&mut self, kind: MaterialKind, emission: Option<Emission>) -> usize {
        let name = format!("material {}", self.0.materials.len());
        self.material(Material { name, kind, emission, outside: false })
    }

    /// A Lambertian material with an exitance of its own, lm/m².
    pub(super) fn paint(&mut self, reflectance: f64, exitance_lm_m2: f64) -> usize {
        let rho = SpectralValue::Grey(reflectance);
        let per_unit = PI * Spectrum::constant(1.0).luminous();
        let radiance = Spectrum::constant(exitance_lm_m2 / per_unit);
        let emission = (exitance_lm_m2 > 0.0).then_some(Emission { radiance, two_sided: false, group: None });
        self.made_of(MaterialKind::Diffuse { front: rho.clone(), back: rho }, emission)
    }

    /// One uncoated pane of a transmittance at normal incidence.
    pub(super) fn pane(&mut self, transmittance: f64) -> usize {
        let panes = Panes::Alike { count: 1, transmittance: SpectralValue::Grey(transmittance) };
        self.made_of(MaterialKind::Glass { panes, refractive_index: 1.52, maintenance_factor: 1.0 }, None)
    }

    /// Hangs a photometric file, aimed down.
    pub(super) fn hang(&mut self, file: Vec<u8>, position: DVec3) {
        self.0.luminaires.push(LuminaireRow::aimed_down(file, vec![position]));
    }

    /// A sky of 10,000 lx without its sun; type 16 is CIE's older overcast sky.
    pub(super) fn sky(&mut self, number: u8, sun_deg: (f64, f64), ground_reflectance: f64) {
        let placed = |value| Placed { value, line: 0 };
        let model = if number == 16 { SkyName::Overcast } else { SkyName::Cie(number) };
        self.0.daytime = Some(Daytime {
            file: PathBuf::from("validation.toml"),
            model: Placed { value: model, line: 0 },
            diffuse: Some(placed(Amount::Lux(1e4))),
            direct: None,
            sun_deg: Some(Placed { value: sun_deg, line: 0 }),
            site: None,
            spectrum: Spectrum::constant(1.0),
            sun_spectrum: Spectrum::constant(1.0),
            ground_reflectance,
            north_deg: 0.0,
        });
    }

    /// Solves it with the method that the program would choose.
    pub(super) fn solve(&self, tolerance: f64) -> Result<Measurement> {
        self.solve_by(&SolveOptions { tolerance, ..SolveOptions::default() })
    }

    pub(super) fn solve_by(&self, options: &SolveOptions) -> Result<Measurement> {
        measure::solve(&self.0, options, &Silent)
    }
}

/// A photometric file of one plane, LM-63-2002; sizes of the opening as it has them (width, length, height, m).
pub(super) fn axial(sizes: &str, vertical_deg: &[f64], candela: impl Fn(f64) -> f64) -> Vec<u8> {
    let join = |list: Vec<f64>| list.iter().map(f64::to_string).collect::<Vec<_>>().join("\n");
    format!(
        "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {} 1 1 2 {sizes}\n1 1 0\n{}\n0\n{}\n",
        vertical_deg.len(),
        join(vertical_deg.to_vec()),
        join(vertical_deg.iter().map(|v| candela(*v)).collect())
    )
    .into_bytes()
}

/// 0 to 90 degrees in half degrees.
pub(super) fn half_degrees() -> Vec<f64> {
    (0..=180).map(|k| 0.5 * f64::from(k)).collect()
}
