//! What a sensor reads from a solved mesh.

use glam::DVec3;

use super::super::adaptive::Task;
use super::super::options::{Display, Method};
use super::super::probe::{Probe, surface_below};
use super::level::{self, Level};
use crate::scene::Sensor;
use crate::transport::form_factor::{Analytic, Discs, Hemicube, Work, askew};
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

/// How a sensor finds the factors of the patches: as the patches found them among themselves.
enum Eye<'a> {
    Exact(Analytic<'a>),
    Hemicube(Hemicube<'a>),
    Discs(Discs<'a>),
}

/// Reads sensors from one mesh.
pub(super) struct Reader<'a> {
    task: &'a Task<'a>,
    level: &'a Level,
    eye: Eye<'a>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(task: &'a Task<'a>, level: &'a Level) -> Self {
        let (world, mesh) = (task.world, level.mesh.as_ref());
        let eye = match task.options.method {
            Method::Hemicube => Eye::Hemicube(level::hemicube(world, mesh, level.size)),
            Method::Discs => Eye::Discs(level::discs(world, mesh)),
            _ => Eye::Exact(Analytic::new(world, mesh)),
        };
        Self { task, level, eye }
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

    /// The factor of every patch times its radiosity.
    fn gather(&self, x: DVec3, normal: DVec3, work: &mut Work) -> Reading {
        let patches = self.level.mesh.list();
        match &self.eye {
            Eye::Exact(analytic) => {
                let mut reading = self.exact_direct(x, normal, work);
                for j in 0..patches.len() {
                    if self.reflects(j) {
                        self.add(j, analytic.at_point(x, normal, j, work), &mut reading.reflected, None);
                    }
                }
                reading
            }
            Eye::Hemicube(hemicube) => {
                let mut row = vec![0.0; patches.len()];
                hemicube.at_point(x, normal, askew(normal.any_orthonormal_vector(), normal), &mut row, work);
                self.sum(row.into_iter())
            }
            Eye::Discs(discs) => {
                let row: Vec<f64> = patches.iter().map(|p| discs.at_point(x, normal, p, work)).collect();
                self.sum(row.into_iter())
            }
        }
    }

    /// Direct light from the emitters themselves, by exact clipping.
    fn exact_direct(&self, x: DVec3, normal: DVec3, work: &mut Work) -> Reading {
        let (world, bands) = (self.task.world, self.level.system.bands);
        let mut groups = vec![0.0; world.emitters.groups()];
        let stream = seed(&[x.x.to_bits(), x.y.to_bits(), x.z.to_bits()]);
        direct(world, x, normal, stream, &mut work.scratch, &mut groups);
        let mut reading = Reading { direct: vec![0.0; bands], reflected: vec![0.0; bands] };
        for (factor, exitance) in groups.iter().zip(&self.task.optics.exitance) {
            reading.direct.iter_mut().zip(exitance).for_each(|(d, m)| *d += factor * f64::from(*m));
        }
        reading
    }

    fn sum(&self, row: impl Iterator<Item = f64>) -> Reading {
        let bands = self.level.system.bands;
        let mut reading = Reading { direct: vec![0.0; bands], reflected: vec![0.0; bands] };
        for (j, factor) in row.enumerate() {
            self.add(j, factor, &mut reading.reflected, Some(&mut reading.direct));
        }
        reading
    }

    /// Does any of a patch's radiosity come by reflection?
    fn reflects(&self, j: usize) -> bool {
        let own = self.own(j);
        self.level.solved.radiosity[own.clone()] != self.level.system.emitted[own]
    }

    fn own(&self, j: usize) -> std::ops::Range<usize> {
        j * self.level.system.bands..(j + 1) * self.level.system.bands
    }

    /// Adds what patch `j` sends: what it reflects, and apart what it emits, where that is wanted.
    fn add(&self, j: usize, factor: f64, reflected: &mut [f64], direct: Option<&mut Vec<f64>>) {
        if factor <= 0.0 {
            return;
        }
        let (b, m) = (&self.level.solved.radiosity[self.own(j)], &self.level.system.emitted[self.own(j)]);
        for (sum, (b, m)) in reflected.iter_mut().zip(b.iter().zip(m)) {
            *sum += factor * (b - m);
        }
        if let Some(direct) = direct {
            direct.iter_mut().zip(m).for_each(|(sum, m)| *sum += factor * m);
        }
    }

    /// The irradiance of the patch under a sensor, or linear between patches; nothing where no patch lies there.
    fn shown(&self, sensor: &Sensor, bilinear: bool) -> Option<Reading> {
        let world = self.task.world;
        let matrix = self.level.solved.matrix.as_ref()?;
        let position = world.surfaces.frame.to_local(sensor.position);
        let (surface, front) = surface_below(world, position, sensor.normal)?;
        let uv = world.surfaces.list[surface].uv(position);
        let bands = self.level.system.bands;
        let shown = self.level.shown(surface, front, uv, bilinear)?;
        let (whole, direct) = (&matrix.irradiance, &matrix.direct);
        let field = |of: &dyn Fn(usize) -> f64| {
            (0..bands).map(|band| shown.value(|i| of(i * bands + band))).collect::<Vec<f64>>()
        };
        Some(Reading { direct: field(&|k| direct[k]), reflected: field(&|k| (whole[k] - direct[k]).max(0.0)) })
    }
}
