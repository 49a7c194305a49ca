//! What materials do with light, band by band.

use super::daylight::{GROUND, SKY, SUN};
use super::glass::Pane;
use super::world::World;
use crate::scene::{MaterialKind, Scene};
use crate::spectrum::Bands;

/// Lanes to which band vectors are padded.
pub(crate) const LANES: usize = 8;

/// Reflectances and exitances of a scene in the bands of a run. All vectors are padded with zeros to a multiple
/// of eight.
#[derive(Clone, Debug)]
pub struct Optics {
    /// The bands.
    pub bands: Bands,
    /// Padded number of bands.
    pub pad: usize,
    /// Diffuse reflectance of back and front of each material.
    pub reflectance: Vec<[Vec<f32>; 2]>,
    /// Exitance of each group of emitting sides, W/(m² nm), spectrum of a lumen of each group of luminaires; then the sky's horizontal irradiance, the ground's exitance and
    /// the sun's irradiance face on.
    pub exitance: Vec<Vec<f32>>,
    /// XYZ weights of the bands, X then Y then Z, each padded.
    pub xyz: [Vec<f32>; 3],
    /// Number of groups of emitters; those of daylight follow.
    pub lamps: usize,
    pub(super) specular: Vec<Specular>,
}

/// A part of direct light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightPart {
    /// Emitting surfaces.
    Lamps,
    /// The sky.
    Sky,
    /// The endless ground.
    Ground,
    /// The sun's disc.
    Sun,
}

/// What a mirror or a pane does.
#[derive(Clone, Debug)]
pub(super) enum Specular {
    None,
    Mirror(Vec<f32>),
    Glass(Vec<Pane>),
}

impl Optics {
    /// Averages everything over the bands.
    #[must_use]
    pub fn new(scene: &Scene, world: &World, bands: Bands) -> Self {
        let pad = bands.len().div_ceil(LANES) * LANES;
        let padded = |mut v: Vec<f64>| {
            v.resize(pad, 0.0);
            v.into_iter().map(|x| x as f32).collect::<Vec<f32>>()
        };
        let black = vec![0.0f32; pad];
        let mut reflectance = Vec::new();
        let mut specular = Vec::new();
        for m in &scene.materials {
            let (sides, mirror) = match &m.kind {
                MaterialKind::Diffuse { front, back } => {
                    ([padded(bands.reflectance(back)), padded(bands.reflectance(front))], Specular::None)
                }
                MaterialKind::Mirror { reflectance } => {
                    ([black.clone(), black.clone()], Specular::Mirror(padded(bands.reflectance(reflectance))))
                }
                MaterialKind::Glass { transmittance, refractive_index } => {
                    let transmittances = bands.reflectance(transmittance);
                    let panes = transmittances.iter().map(|t| Pane::new(*t, *refractive_index)).collect();
                    ([black.clone(), black.clone()], Specular::Glass(panes))
                }
            };
            reflectance.push(sides);
            specular.push(mirror);
        }
        let mut exitance: Vec<Vec<f32>> = world
            .emitters
            .materials
            .iter()
            .map(|m| {
                let radiance = scene.materials[*m].emission.as_ref().map(|e| bands.radiance(&e.radiance));
                padded(radiance.unwrap_or_default().iter().map(|l| l * std::f64::consts::PI).collect())
            })
            .collect();
        exitance.extend(world.emitters.spectra.iter().map(|s| padded(bands.radiance(s))));
        if let Some(light) = world.daylight() {
            let height = light.sun.map_or(0.0, |d| d.z);
            let sky = if light.sky.is_some() { bands.radiance(&light.sky_irradiance) } else { vec![0.0; bands.len()] };
            let sun = bands.radiance(&light.sun_irradiance);
            // The ground lies in the open: sky and sun reach all of it.
            let ground = sky.iter().zip(&sun).map(|(d, s)| light.ground_reflectance * (d + s * height)).collect();
            exitance.extend([padded(sky), padded(ground), padded(sun)]);
        }
        let xyz = [0, 1, 2].map(|k| padded(bands.xyz_weights().iter().map(|w| w[k]).collect()));
        Self { bands, pad, reflectance, exitance, xyz, lamps: world.emitters.groups(), specular }
    }

    /// Reflectance of a side of a material, padded.
    #[must_use]
    #[inline]
    pub fn rho(&self, material: usize, front: bool) -> &[f32] {
        &self.reflectance[material][usize::from(front)]
    }

    /// XYZ of direct light from its factors by group.
    #[must_use]
    pub fn xyz_of_direct(&self, factors: &[f64]) -> [f64; 3] {
        let band = |b: usize| factors.iter().zip(&self.exitance).map(|(f, m)| f * f64::from(m[b])).sum();
        self.bands.xyz(&(0..self.bands.len()).map(band).collect::<Vec<f64>>())
    }

    /// Illuminance of one part of direct light, by its factors by group, lx.
    #[must_use]
    pub fn lux_of_direct(&self, factors: &[f64], part: LightPart) -> f64 {
        let groups = match part {
            LightPart::Lamps => 0..self.lamps,
            LightPart::Sky => self.lamps + SKY..self.lamps + SKY + 1,
            LightPart::Ground => self.lamps + GROUND..self.lamps + GROUND + 1,
            LightPart::Sun => self.lamps + SUN..self.lamps + SUN + 1,
        };
        let of_group = |g: usize| {
            factors[g] * self.exitance[g].iter().zip(&self.xyz[1]).map(|(m, w)| f64::from(m * w)).sum::<f64>()
        };
        groups.filter(|g| *g < factors.len()).map(of_group).sum()
    }

    /// Largest reflectance in any band of the materials in use.
    #[must_use]
    pub fn largest_reflectance(&self, world: &World) -> f64 {
        let mut largest = 0.0f32;
        for s in &world.surfaces.list {
            for side in &self.reflectance[s.material] {
                largest = side.iter().copied().fold(largest, f32::max);
            }
        }
        f64::from(largest)
    }
}
