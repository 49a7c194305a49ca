//! What materials do with light, band by band.

use super::daylight::{DAYLIGHT_GROUPS, GROUND, SKY, SUN};
use super::specular::Speculars;
use super::world::World;
use crate::scene::{MaterialKind, Scene};
use crate::spectrum::{Bands, SpectralValue};

/// Lanes to which band vectors are padded.
pub(crate) const LANES: usize = 8;

/// Reflectances and exitances of a scene in the bands of a run. All vectors are padded with zeros to a multiple
/// of eight.
///
/// Light may be divided into channels, for which all bands are there once more, one channel after the other: each group of
/// light shines in its own channel alone. What is called a band below is a band of a channel where there are several.
#[derive(Clone, Debug)]
pub struct Optics {
    /// The bands.
    pub bands: Bands,
    /// Padded number of bands.
    pub pad: usize,
    /// Diffuse reflectance of back and front of each material.
    pub reflectance: Vec<[Vec<f32>; 2]>,
    /// Diffuse transmittance of each material.
    pub transmittance: Vec<Vec<f32>>,
    /// Exitance of each group of emitting sides, W/(m² nm), spectrum of a lumen of each group of luminaires; then the sky's
    /// horizontal irradiance, the ground's exitance and
    /// the sun's irradiance face on.
    pub exitance: Vec<Vec<f32>>,
    /// XYZ weights of the bands, X then Y then Z, each padded; all channels together.
    pub xyz: [Vec<f32>; 3],
    /// The same of each channel alone.
    pub eyes: Vec<[Vec<f32>; 3]>,
    /// Channel of each group of light.
    of_group: Vec<usize>,
    /// Number of groups of emitters; those of daylight follow.
    pub lamps: usize,
    /// Mirrors and panes.
    pub speculars: Speculars,
    has_sky: bool,
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

/// What becomes of a path at a diffuse surface.
#[derive(Clone, Copy, Debug)]
pub struct Scatter<'a> {
    /// Does it go on from the other side?
    pub passes: bool,
    /// Reflectance or transmittance by band.
    pub shares: &'a [f32],
    /// Chance of this way.
    pub odds: f32,
}

impl Optics {
    /// Averages everything over the bands.
    #[must_use]
    pub fn new(scene: &Scene, world: &World, bands: Bands) -> Self {
        Self::in_channels(scene, world, bands, &vec![0; world.groups()])
    }

    /// The same with the light divided into channels: `of_group` tells that of each group, from 0 on without a gap.
    #[must_use]
    pub fn in_channels(scene: &Scene, world: &World, bands: Bands, of_group: &[usize]) -> Self {
        let count = of_group.iter().max().map_or(1, |last| last + 1);
        let pad = (count * bands.len()).div_ceil(LANES) * LANES;
        let single = |v: Vec<f64>, channel: usize| {
            let mut lanes = vec![0.0f32; pad];
            let own = &mut lanes[channel * bands.len()..(channel + 1) * bands.len()];
            own.iter_mut().zip(v).for_each(|(lane, x)| *lane = x as f32);
            lanes
        };
        let in_all = |v: Vec<f64>| std::iter::repeat_n(v, count).flatten().collect::<Vec<f64>>();
        let padded = |v: Vec<f64>| {
            let mut v = in_all(v);
            v.resize(pad, 0.0);
            v.into_iter().map(|x| x as f32).collect::<Vec<f32>>()
        };
        let black = vec![0.0f32; pad];
        let (mut reflectance, mut transmittance) = (Vec::new(), Vec::new());
        for (material, m) in scene.materials.iter().enumerate() {
            let values = |v: &SpectralValue| padded(bands.reflectance(v));
            let (sides, through) = match &m.kind {
                MaterialKind::Diffuse { front, back } => ([values(back), values(front)], black.clone()),
                MaterialKind::Translucent { front, back, transmittance, maintenance_factor } => {
                    let through = bands.reflectance(transmittance).into_iter().map(|t| t * maintenance_factor);
                    ([values(back), values(front)], padded(through.collect()))
                }
                MaterialKind::Bsdf { .. } => {
                    let rho = |front: bool| world.scatterer_of(material).map_or(0.0, |s| s.reflectance(front));
                    ([false, true].map(|front| padded(vec![rho(front); bands.len()])), black.clone())
                }
                MaterialKind::Mirror { .. } | MaterialKind::Glass { .. } => {
                    ([black.clone(), black.clone()], black.clone())
                }
            };
            reflectance.push(sides);
            transmittance.push(through);
        }
        let mut exitance: Vec<Vec<f64>> = world
            .emitters
            .materials
            .iter()
            .map(|m| {
                let radiance = scene.materials[*m].emission.as_ref().map(|e| bands.radiance(&e.radiance));
                radiance.unwrap_or_default().iter().map(|l| l * std::f64::consts::PI).collect()
            })
            .collect();
        exitance.extend(world.emitters.spectra.iter().map(|s| bands.radiance(s)));
        if let Some(light) = world.daylight() {
            let height = light.sun.map_or(0.0, |d| d.z);
            let sky = if light.sky.is_some() { bands.radiance(&light.sky_irradiance) } else { vec![0.0; bands.len()] };
            let sun = bands.radiance(&light.sun_irradiance);
            // The ground lies in the open: sky and sun reach all of it.
            let ground = sky.iter().zip(&sun).map(|(d, s)| light.ground_reflectance * (d + s * height)).collect();
            exitance.extend([sky, ground, sun]);
        }
        let exitance = exitance.into_iter().zip(of_group).map(|(m, channel)| single(m, *channel)).collect();
        let weights = [0, 1, 2].map(|k| bands.xyz_weights().iter().map(|w| w[k]).collect::<Vec<f64>>());
        let xyz = weights.clone().map(&padded);
        let eyes = (0..count).map(|channel| weights.clone().map(|w| single(w, channel))).collect();
        let speculars = Speculars::in_bands(scene, |v| in_all(bands.reflectance(v)));
        let has_sky = world.daylight().is_some();
        Self {
            bands,
            pad,
            reflectance,
            transmittance,
            exitance,
            xyz,
            eyes,
            of_group: of_group.to_vec(),
            lamps: world.emitters.groups(),
            speculars,
            has_sky,
        }
    }

    /// Reflectance of a side of a material, padded.
    #[must_use]
    #[inline]
    pub fn rho(&self, material: usize, front: bool) -> &[f32] {
        &self.reflectance[material][usize::from(front)]
    }

    /// Diffuse transmittance of a material, padded.
    #[must_use]
    #[inline]
    pub fn tau(&self, material: usize) -> &[f32] {
        &self.transmittance[material]
    }

    /// What becomes of a path that arrives on a side of a diffuse material: reflected, or passed on to the other side, by
    /// `chance` in `[0, 1)`, which is spread again over its range. The shares by band are to be divided by the odds.
    #[must_use]
    #[inline]
    pub fn scatter(&self, material: usize, front: bool, chance: &mut f64) -> Scatter<'_> {
        let (rho, tau) = (self.rho(material, front), self.tau(material));
        let most = |shares: &[f32]| shares.iter().copied().fold(0.0, f32::max);
        let through = most(tau);
        if through == 0.0 {
            return Scatter { passes: false, shares: rho, odds: 1.0 };
        }
        let through = f64::from(through / (through + most(rho)));
        if *chance < through {
            *chance /= through;
            return Scatter { passes: true, shares: tau, odds: through as f32 };
        }
        *chance = (*chance - through) / (1.0 - through);
        Scatter { passes: false, shares: rho, odds: (1.0 - through) as f32 }
    }

    /// Length of the factors of direct light: one for each group; where panes or mirrors are coloured, then those of
    /// daylight that came by them, band by band: groups, then `DAYLIGHT_GROUPS` times `pad`.
    #[must_use]
    pub fn columns(&self) -> usize {
        let tinted = self.has_sky && self.speculars.are_coloured();
        self.exitance.len() + if tinted { DAYLIGHT_GROUPS * self.pad } else { 0 }
    }

    /// The group of daylight that a column of the factors belongs to.
    pub(super) fn daylight_of(&self, column: usize) -> Option<usize> {
        match column.checked_sub(self.exitance.len()) {
            Some(tinted) => Some(tinted / self.pad),
            None => column.checked_sub(self.lamps),
        }
    }

    /// Irradiance by band, padded, of the factors that came by coloured panes; nothing where there are none.
    pub(super) fn tinted_irradiance(&self, tinted: &[f32]) -> Option<Vec<f32>> {
        if tinted.iter().all(|f| *f == 0.0) {
            return None;
        }
        let mut irradiance = vec![0.0; self.pad];
        for (factors, exitance) in tinted.chunks_exact(self.pad).zip(&self.exitance[self.lamps..]) {
            irradiance.iter_mut().zip(factors.iter().zip(exitance)).for_each(|(e, (f, m))| *e += f * m);
        }
        Some(irradiance)
    }

    /// Factor of a group in a band.
    #[inline]
    fn factor(&self, factors: &[f64], group: usize, band: usize) -> f64 {
        let tinted = group.checked_sub(self.lamps).map(|g| self.exitance.len() + g * self.pad + band);
        factors[group] + tinted.and_then(|k| factors.get(k)).copied().unwrap_or(0.0)
    }

    /// Irradiance of direct light in a band from its factors, W/(m² nm).
    #[must_use]
    #[inline]
    pub fn direct_in_band(&self, factors: &[f64], band: usize) -> f64 {
        let groups = self.exitance.len().min(factors.len());
        (0..groups).map(|g| self.factor(factors, g, band) * f64::from(self.exitance[g][band])).sum()
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.eyes.len()
    }

    /// The lanes of a band: that of each channel.
    pub fn lanes(&self, band: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.channels()).map(move |channel| channel * self.bands.len() + band)
    }

    /// XYZ of direct light from its factors, with a level for each channel.
    #[must_use]
    pub fn xyz_of_direct(&self, factors: &[f64], levels: &[f64]) -> [f64; 3] {
        let in_band = |band: usize| -> f64 {
            self.lanes(band).zip(levels).map(|(lane, level)| level * self.direct_in_band(factors, lane)).sum()
        };
        self.bands.xyz(&(0..self.bands.len()).map(in_band).collect::<Vec<f64>>())
    }

    /// Illuminance of one part of direct light from its factors, lx, with a level for each channel.
    #[must_use]
    pub fn lux_of_direct(&self, factors: &[f64], levels: &[f64], part: LightPart) -> f64 {
        let groups = match part {
            LightPart::Lamps => 0..self.lamps,
            LightPart::Sky => self.lamps + SKY..self.lamps + SKY + 1,
            LightPart::Ground => self.lamps + GROUND..self.lamps + GROUND + 1,
            LightPart::Sun => self.lamps + SUN..self.lamps + SUN + 1,
        };
        let in_band =
            |g: usize, (band, (m, w)): (usize, (&f32, &f32))| self.factor(factors, g, band) * f64::from(m * w);
        let of_group = |g: usize| {
            let lux = self.exitance[g].iter().zip(&self.xyz[1]).enumerate().map(|b| in_band(g, b)).sum::<f64>();
            levels[self.of_group[g]] * lux
        };
        groups.filter(|g| *g < factors.len().min(self.exitance.len())).map(of_group).sum()
    }

    /// The same with each group of light at a level.
    #[must_use]
    pub fn dimmed(&self, levels: &[f64]) -> Self {
        let mut dimmed = self.clone();
        for (exitance, level) in dimmed.exitance.iter_mut().zip(levels) {
            exitance.iter_mut().for_each(|m| *m *= *level as f32);
        }
        dimmed
    }

    /// Levels at which all channels shine as the scene has them.
    #[must_use]
    pub fn full(&self) -> Vec<f64> {
        vec![1.0; self.channels()]
    }

    /// Largest share in any band that a diffuse material in use gives back, by reflection and transmission.
    #[must_use]
    pub fn largest_reflectance(&self, world: &World) -> f64 {
        let mut largest = 0.0f32;
        for s in &world.surfaces.list {
            for side in &self.reflectance[s.material] {
                let both = side.iter().zip(self.tau(s.material)).map(|(r, t)| r + t);
                largest = both.fold(largest, f32::max);
            }
        }
        f64::from(largest)
    }
}
