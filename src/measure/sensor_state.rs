//! One sensor on its way to the tolerance: what its rays brought, what is stated of it, what it asks for next.

use super::gather::{REPLICAS, SetSums};
use super::probe::Probe;
use super::result::Status;
use super::statement::{Memory, Readings, Stated};
use crate::transport::{LightPart, Optics};

/// Rays of one set of one sensor, at most.
pub(super) const MAX_SET_RAYS: u32 = 1 << 16;
/// How much further the rays of a sensor go on as paths when its elements hide too much, and how many more it takes.
const FURTHER: f64 = 4.0;
pub(super) const PATHS_WANT: f64 = 2.0;

/// One sensor on its way to the tolerance.
#[derive(Debug)]
pub(super) struct SensorState {
    pub(super) probe: Probe,
    /// Direct irradiance per unit exitance: by set (one entry where it is exact), by group.
    pub(super) direct: Vec<Vec<f64>>,
    pub(super) sums: Vec<SetSums>,
    /// Rays of each set.
    pub(super) done: u32,
    pub(super) wanted: u32,
    /// Distance within which its rays go on as paths, in the program's frame; never less than an element's size.
    pub(super) near: f64,
    /// Gather rays bring emission too; `direct` is for the report alone.
    pub(super) glowing: bool,
    /// Illuminance of the scene as it stands, and what is stated of it.
    pub(super) light: Light,
    pub(super) y: Stated,
    /// The same in every state of the lights.
    pub(super) states: Vec<(Light, Stated)>,
    /// Every band, when asked for.
    pub(super) bands: Vec<Stated>,
    /// What earlier rounds told of the noise: Y, states, bands.
    pub(super) memory: Vec<Memory>,
}

/// Illuminance in one state of the lights, and its parts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Light {
    pub(super) xyz: [f64; 3],
    /// Without diffuse reflection: of emitters, of the sun, of the sky.
    pub(super) direct_y: f64,
    pub(super) sun_y: f64,
    pub(super) sky_y: f64,
    /// Last left the ground or an outside surface.
    pub(super) external_y: f64,
    /// The rest of it.
    pub(super) reflected_y: f64,
}

impl SensorState {
    pub(super) fn restart(&mut self, optics: &Optics) {
        self.sums.iter_mut().for_each(|s| *s = SetSums::new(optics, REPLICAS, true));
        self.done = 0;
    }

    /// Wants more rays for an error `excess` times too large. `false`: it has as many as may be.
    pub(super) fn ask_rays(&mut self, excess: f64) -> bool {
        // Noise of a well-spread set falls nearly as n^-0.75.
        let factor = (excess.powf(1.5).ceil() as u32).next_power_of_two().clamp(2, 16);
        let before = self.wanted;
        self.wanted = self.done.saturating_mul(factor).min(MAX_SET_RAYS);
        self.wanted > before
    }

    /// Lets rays go on as paths from further away, and begins anew: that trades what elements of size `size` hide for
    /// noise of rays. `false`: all go on already.
    pub(super) fn look_further(&mut self, size: f64, optics: &Optics) -> bool {
        let near = self.near.max(size);
        if near >= 1.0 {
            return false;
        }
        self.near = FURTHER * near;
        self.wanted = ((f64::from(self.wanted) * PATHS_WANT) as u32).min(MAX_SET_RAYS);
        self.restart(optics);
        let keep = |m: &Memory| Memory { design: m.design.scaled(1.0), ..Memory::default() };
        self.memory = self.all_stated().map(|s| keep(&s.memory)).collect();
        true
    }

    /// Keeps what this round told, for one with finer elements, whose area is `area` times what it was.
    pub(super) fn remember_mesh(&mut self, area: f64) {
        let keep = |m: &Memory| Memory { rows: m.rows.scaled(area), design: m.design.scaled(1.0) };
        self.memory = self.all_stated().map(|s| keep(&s.memory)).collect();
    }

    /// Keeps what this round told, for one with more rays in the same solution.
    pub(super) fn remember_rays(&mut self) {
        let rows: Vec<_> = (0..self.all_stated().count()).map(|q| self.memory(q).rows).collect();
        let design = self.all_stated().map(|s| s.memory.design.scaled(1.0));
        self.memory = design.zip(rows).map(|(design, rows)| Memory { rows, design }).collect();
    }

    pub(super) fn all_stated(&self) -> impl Iterator<Item = &Stated> {
        std::iter::once(&self.y).chain(self.states.iter().map(|s| &s.1)).chain(&self.bands)
    }

    pub(super) fn memory(&self, quantity: usize) -> Memory {
        self.memory.get(quantity).copied().unwrap_or_default()
    }

    pub(super) fn stated(&self, quantity: usize) -> &Stated {
        match quantity {
            0 => &self.y,
            q if q <= self.states.len() => &self.states[q - 1].1,
            q => &self.bands[q - 1 - self.states.len()],
        }
    }

    /// The quantity furthest beyond the tolerance among those that matter, if any is.
    pub(super) fn worst(&self, quantities: &[usize], tolerance: f64) -> Option<Stated> {
        if self.probe.status != Status::Ok {
            return None;
        }
        let excess = |s: &Stated| s.error / s.scale;
        quantities
            .iter()
            .map(|q| self.stated(*q))
            .filter(|s| !s.holds(tolerance))
            .max_by(|a, b| excess(a).total_cmp(&excess(b)))
            .copied()
    }

    pub(super) fn direct(&self, set: usize) -> &[f64] {
        &self.direct[set % self.direct.len()]
    }

    pub(super) fn direct_band(&self, optics: &Optics, set: usize, band: usize) -> f64 {
        if self.glowing {
            return 0.0;
        }
        optics.lanes(band).map(|lane| optics.direct_in_band(self.direct(set), lane)).sum()
    }

    pub(super) fn direct_xyz(&self, optics: &Optics, levels: &[f64], set: usize) -> [f64; 3] {
        if self.glowing { [0.0; 3] } else { optics.xyz_of_direct(self.direct(set), levels) }
    }

    /// Illuminance with a level for each channel.
    pub(super) fn light(&self, optics: &Optics, levels: &[f64]) -> Light {
        let mut light = Light::default();
        let share = 1.0 / REPLICAS as f64;
        for a in 0..REPLICAS {
            let direct = self.direct_xyz(optics, levels, a);
            let part = |part| share * optics.lux_of_direct(self.direct(a), levels, part);
            let (in_mirrors, outside) = self.sums[a].outside_y(levels);
            light.direct_y += part(LightPart::Lamps);
            light.sun_y += part(LightPart::Sun);
            light.sky_y += part(LightPart::Sky) + share * in_mirrors;
            light.external_y += part(LightPart::Ground) + share * outside;
            light.reflected_y -= share * (in_mirrors + outside);
            for b in 0..REPLICAS {
                let reflected = self.sums[a].xyz(b, optics, levels, false);
                light.reflected_y += share * share * reflected[1];
                for k in 0..3 {
                    light.xyz[k] += share * share * (direct[k] + reflected[k]);
                }
            }
        }
        if self.glowing {
            // Direct light is part of what the rays brought: take it out for the report.
            let direct: f64 = (0..REPLICAS).map(|a| optics.xyz_of_direct(self.direct(a), levels)[1]).sum();
            light.direct_y = (direct / REPLICAS as f64).min(light.xyz[1]);
            light.reflected_y = light.xyz[1] - light.direct_y;
        }
        light
    }

    pub(super) fn total_rays(&self) -> f64 {
        self.sums.iter().map(|s| f64::from(s.rays)).sum::<f64>().max(1.0)
    }

    /// Square of the skewness of the mean of all rays.
    fn skewness(&self) -> f64 {
        SetSums::square_of_skewness(&self.sums) / self.total_rays()
    }

    pub(super) fn readings_y(&self, optics: &Optics, levels: &[f64], quantity: usize) -> Readings {
        let mut r = Readings { memory: self.memory(quantity), ..Readings::default() };
        let (mut mean, mut square) = (0.0, 0.0);
        for a in 0..REPLICAS {
            let direct = self.direct_xyz(optics, levels, a)[1];
            for b in 0..REPLICAS {
                let reflected = self.sums[a].xyz(b, optics, levels, false)[1];
                r.main[a][b] = direct + reflected;
                r.twin[a][b] = direct + self.sums[a].xyz(b, optics, levels, true)[1];
                mean += reflected / (REPLICAS * REPLICAS) as f64;
            }
            square += self.sums[a].mean_square_y(levels) / REPLICAS as f64;
        }
        r.naive = (square - mean * mean).max(0.0) / self.total_rays();
        r.skewness = self.skewness();
        r
    }

    pub(super) fn readings(&self, optics: &Optics, band: usize) -> Readings {
        let mut r = Readings { memory: self.memory(1 + self.states.len() + band), ..Readings::default() };
        let (mut mean, mut square) = (0.0, 0.0);
        for a in 0..REPLICAS {
            let direct = self.direct_band(optics, a, band);
            for b in 0..REPLICAS {
                let reflected = self.sums[a].band(b, band, optics, false);
                r.main[a][b] = direct + reflected;
                r.twin[a][b] = direct + self.sums[a].band(b, band, optics, true);
                mean += reflected / (REPLICAS * REPLICAS) as f64;
            }
            square += self.sums[a].mean_square(band) / REPLICAS as f64;
        }
        r.naive = (square - mean * mean).max(0.0) / self.total_rays();
        r.skewness = self.skewness();
        r
    }
}
