//! A mesh with its solution, as a gather reads it.

use crate::mesh::Elements;
use crate::solve::Solution;
use crate::transport::Optics;

/// A mesh with its solution, and its XYZ per element.
#[derive(Debug)]
pub(super) struct Solved {
    pub(super) mesh: Elements,
    pub(super) solution: Solution,
    /// `[element][replica][channel][x, y, z, 0]`.
    xyz: Vec<f32>,
    channels: usize,
}

impl Solved {
    pub(super) fn new(mesh: Elements, solution: Solution, optics: &Optics) -> Self {
        let channels = optics.channels();
        let mut xyz = Vec::with_capacity(mesh.len() * solution.replicas * channels * 4);
        for bands in solution.radiosity.chunks_exact(optics.pad) {
            optics.eyes.iter().for_each(|eye| xyz.extend_from_slice(&project(bands, eye)));
        }
        Self { mesh, solution, xyz, channels }
    }

    /// The same mesh with all channels of its optics added up: a solution of `whole` optics of one channel.
    pub(super) fn joined(&self, optics: &Optics, whole: &Optics) -> Self {
        let n = optics.bands.len();
        let mut radiosity = vec![0.0f32; self.solution.radiosity.len() / optics.pad * whole.pad];
        for (to, from) in radiosity.chunks_exact_mut(whole.pad).zip(self.solution.radiosity.chunks_exact(optics.pad)) {
            to[..n].iter_mut().enumerate().for_each(|(band, b)| *b = optics.lanes(band).map(|lane| from[lane]).sum());
        }
        let fluxes = |all: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let of_band = |of: &[f64], band: usize| optics.lanes(band).map(|lane| of[lane]).sum::<f64>();
            all.iter().map(|of| (0..n).map(|band| of_band(of, band)).collect()).collect()
        };
        let solution = Solution {
            radiosity,
            pad: whole.pad,
            absorbed: fluxes(&self.solution.absorbed),
            escaped: fluxes(&self.solution.escaped),
            lost: fluxes(&self.solution.lost),
            ..self.solution
        };
        Self::new(self.mesh.clone(), solution, whole)
    }

    /// The same mesh with the mean over the replicas: a single solution, for pictures.
    pub(super) fn averaged(&self, optics: &Optics) -> Self {
        let (r, pad) = (self.solution.replicas, optics.pad);
        let mut radiosity = Vec::with_capacity(self.solution.radiosity.len() / r);
        for element in self.solution.radiosity.chunks_exact(r * pad) {
            radiosity.extend((0..pad).map(|b| (0..r).map(|k| element[k * pad + b]).sum::<f32>() / r as f32));
        }
        let solution = Solution {
            radiosity,
            replicas: 1,
            pad,
            absorbed: Vec::new(),
            escaped: Vec::new(),
            lost: Vec::new(),
            ..self.solution
        };
        Self::new(self.mesh.clone(), solution, optics)
    }

    /// Of an element: `[replica][channel][x, y, z, 0]`.
    pub(super) fn xyz(&self, element: u32) -> &[f32] {
        let n = self.solution.replicas * self.channels * 4;
        &self.xyz[element as usize * n..(element as usize + 1) * n]
    }
}

fn project(bands: &[f32], eye: &[Vec<f32>; 3]) -> [f32; 4] {
    [dot(bands, &eye[0]), dot(bands, &eye[1]), dot(bands, &eye[2]), 0.0]
}

/// Sum of products, in eight lanes: the vectors are padded to a multiple of eight.
#[inline]
pub(super) fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut lanes = [0.0f32; 8];
    for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
        for k in 0..8 {
            lanes[k] += a[k] * b[k];
        }
    }
    lanes.iter().sum()
}
