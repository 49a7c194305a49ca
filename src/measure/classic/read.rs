//! What a sensor reads from a solved mesh.

use glam::DVec3;

use super::super::adaptive::Task;
use super::super::options::Display;
use super::super::probe::{Probe, surface_below};
use super::level::Level;
use crate::scene::Sensor;
use crate::transport::form_factor::{Analytic, Work};
use crate::transport::{direct, points::seed};

/// Irradiance of a sensor, W/(m² nm), band by band.
#[derive(Clone, Debug)]
pub(super) struct Reading {
    pub(super) direct: Vec<f64>,
    pub(super) reflected: Vec<f64>,
}

impl Reading {
    pub(super) fn whole(&self) -> Vec<f64> {
        self.direct.iter().zip(&self.reflected).map(|(d, r)| d + r).collect()
    }
}

/// Reads sensors from one mesh.
pub(super) struct Reader<'a> {
    task: &'a Task<'a>,
    level: &'a Level,
    analytic: Analytic<'a>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(task: &'a Task<'a>, level: &'a Level) -> Self {
        Self { task, level, analytic: Analytic::new(task.world, &level.mesh) }
    }

    /// By the display asked for where the sensor lies on a patch, by a gather elsewhere.
    pub(super) fn read(&self, sensor: &Sensor, probe: &Probe, work: &mut Work) -> Reading {
        let shown = match self.task.options.display {
            Display::Gather => None,
            Display::Constant => self.shown(sensor, false),
            Display::Bilinear => self.shown(sensor, true),
        };
        shown.unwrap_or_else(|| self.gather(probe.position, probe.normal, work))
    }

    /// The exact factor of every patch times its radiosity; direct light from the emitters themselves.
    fn gather(&self, x: DVec3, normal: DVec3, work: &mut Work) -> Reading {
        let bands = self.level.system.bands;
        let world = self.task.world;
        let mut groups = vec![0.0; world.emitters.groups()];
        let stream = seed(&[x.x.to_bits(), x.y.to_bits(), x.z.to_bits()]);
        direct(world, x, normal, stream, &mut work.scratch, &mut groups);
        let mut reading = Reading { direct: vec![0.0; bands], reflected: vec![0.0; bands] };
        for (factor, exitance) in groups.iter().zip(&self.task.optics.exitance) {
            reading.direct.iter_mut().zip(exitance).for_each(|(d, m)| *d += factor * f64::from(*m));
        }
        let own = |j: usize| j * bands..(j + 1) * bands;
        for j in 0..self.level.mesh.list.len() {
            let (b, m) = (&self.level.solved.radiosity[own(j)], &self.level.system.emitted[own(j)]);
            if b == m {
                continue; // reflects nothing
            }
            let factor = self.analytic.at_point(x, normal, j, work);
            if factor > 0.0 {
                for (sum, (b, m)) in reading.reflected.iter_mut().zip(b.iter().zip(m)) {
                    *sum += factor * (b - m);
                }
            }
        }
        reading
    }

    /// The irradiance of the patch under a sensor, or linear between patches; nothing where no patch lies there.
    fn shown(&self, sensor: &Sensor, bilinear: bool) -> Option<Reading> {
        let world = self.task.world;
        let matrix = self.level.solved.matrix.as_ref()?;
        let position = world.surfaces.frame.to_local(sensor.position);
        let (surface, front) = surface_below(world, position, sensor.normal)?;
        let uv = world.surfaces.list[surface].uv(position);
        let bands = self.level.system.bands;
        let value = |field: &[f64], band: usize| {
            let at = |i: usize| field[i * bands + band];
            let flat = || self.level.mesh.find(surface, front, uv).map(|i| at(i as usize));
            if bilinear { self.level.mesh.interpolate(surface, front, uv, at).or_else(flat) } else { flat() }
        };
        let field = |f: &[f64]| (0..bands).map(|b| value(f, b)).collect::<Option<Vec<f64>>>();
        let (whole, direct) = (field(&matrix.irradiance)?, field(&matrix.direct)?);
        let reflected = whole.iter().zip(&direct).map(|(w, d)| w - d).collect();
        Some(Reading { direct, reflected })
    }
}
