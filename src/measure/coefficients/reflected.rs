//! What sensors receive by reflection and by windows with a BSDF, column by column.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::super::adaptive::{Adapted, Task, octave, stream};
use super::super::gather::{Field, Found, Gatherer, REPLICAS};
use super::super::result::Status;
use super::light::Look;
use super::sums::{Sums, times};
use super::{Columns, ESTIMATES, Side};
use crate::solve::{LANES, Lanes};
use crate::transport::points::seed;
use crate::transport::{DirectScratch, PANEL_SETS, PanelColumns, PanelLook};

/// Where the rays of one set of one sensor are read.
#[derive(Debug, Default)]
pub(super) struct Reads {
    /// Element, element of the twin, weight, and what the way leaves in every band (zero: all).
    entries: Vec<(u32, u32, f32, u32)>,
    tints: Vec<Vec<f32>>,
    /// Daylight found on the way, by source.
    found: Vec<Vec<(u32, f32)>>,
    /// Sky and ground that the first rays see in mirrors, as the sky's light sees them.
    pub(super) mirrored: Vec<(u32, f32)>,
    /// Spots of windows with a BSDF seen by the sensor and on the way, by source.
    spots: Vec<Vec<(u32, f32)>>,
}

/// The sums of one thread.
struct Buffers {
    patches: Sums,
    spots: Sums,
    fine: DirectScratch,
    rough: DirectScratch,
}

impl Task<'_> {
    /// Where the rays of a grid's sensors are read: the rays of the last round.
    pub(super) fn reads(
        &self,
        adapted: &Adapted,
        g: usize,
        (look, columns): (Look<'_>, &Columns),
        weights: &[Vec<f64>],
    ) -> Vec<[Reads; REPLICAS]> {
        let field = Field {
            world: self.world,
            optics: self.optics,
            main: &adapted.main,
            twin: Some(&adapted.twin),
            spectral: false,
            squares: false,
        };
        let buffers = || Buffers {
            patches: Sums::new(columns.patches, 1),
            spots: Sums::new(columns.spots(), 1),
            fine: DirectScratch::for_tolerance(self.options.tolerance).in_bands(self.optics),
            rough: self.scratch(),
        };
        adapted.grids[g]
            .par_iter()
            .enumerate()
            .with_max_len(8)
            .map_init(
                || (Gatherer::recording(&field), buffers()),
                |(gatherer, buffers), (i, s)| {
                    self.progress.advance(1);
                    gatherer.trust = s.near.max(adapted.main.mesh.size);
                    let mesh = octave(adapted.main.mesh.size);
                    std::array::from_fn(|a| {
                        if s.probe.status != Status::Ok {
                            return Reads::default();
                        }
                        let own = self.options.seed;
                        let parts = [own, stream::SENSOR, mesh, octave(s.near), g as u64, i as u64, a as u64];
                        let rays = (s.probe.position, s.probe.normal, seed(&parts), s.done);
                        let mut reads = self.read(gatherer, rays, (look, columns, a), weights, buffers);
                        if let Some(panels) = &columns.panels {
                            let sample = seed(&[own, stream::SHADOW, g as u64, i as u64, a as u64]);
                            let at = (s.probe.eye, s.probe.normal);
                            let way = PanelLook { set: a % PANEL_SETS, is_vertex: false, receiver: None };
                            for (source, spots) in weights.iter().zip(&mut reads.spots) {
                                let look = Look { weights: source, ..look };
                                let Buffers { spots: sums, fine, .. } = &mut *buffers;
                                fine.rays += panels.look(self.world, at, sample, way, fine, |spot, weight, tint| {
                                    sums.add(spot, |_| weight * look.left(tint));
                                });
                                spots.extend(sums.take(1.0).pairs());
                            }
                        }
                        reads
                    })
                },
            )
            .collect()
    }

    fn read(
        &self,
        gatherer: &mut Gatherer<'_>,
        (x, normal, stream, count): (DVec3, DVec3, u64, u32),
        (look, columns, set): (Look<'_>, &Columns, usize),
        weights: &[Vec<f64>],
        buffers: &mut Buffers,
    ) -> Reads {
        let mut reads = Reads { tints: vec![Vec::new()], ..Reads::default() };
        let mut found: Vec<(Found, Vec<f32>)> = Vec::new();
        let rays = gatherer.record(x, normal, stream, count, |end, left, seen| {
            if let Some((main, twin)) = end {
                let tint = left.map_or(0, |t| {
                    reads.tints.push(t.to_vec());
                    reads.tints.len() as u32 - 1
                });
                let twin = if twin == crate::mesh::NO_ELEMENT { u32::MAX } else { twin };
                reads.entries.push((main, twin, 1.0, tint));
            }
            found.extend_from_slice(seen);
        });
        let share = 1.0 / rays.max(1) as f32;
        reads.merge(share);
        let Buffers { patches, spots, rough: scratch, .. } = buffers;
        for (number, source) in weights.iter().enumerate() {
            for (k, (what, tint)) in found.iter().enumerate() {
                // What panes leave where it enters and what the way leaves belong together, band by band.
                let left: Vec<f64> = source.iter().zip(tint).map(|(w, t)| w * f64::from(*t)).collect();
                let look = Look { weights: &left, ..look };
                match *what {
                    Found::Vertex { position, normal, receiver } => {
                        let (at, sample) = ((position, normal), seed(&[stream, k as u64]));
                        if receiver.is_none() {
                            self.look(at, sample, (look, None), scratch, |column, weight, tint| {
                                patches.add(column, |_| weight * look.left(tint));
                            });
                        }
                        if let Some(panels) = &columns.panels {
                            let way = PanelLook { set: set % PANEL_SETS, is_vertex: true, receiver };
                            scratch.rays += panels.look(self.world, at, sample, way, scratch, |spot, weight, tint| {
                                spots.add(spot, |_| weight * look.left(tint));
                            });
                        }
                    }
                    Found::Mirrored { direction, is_first: false } => {
                        patches.add(look.patches.of(direction), |_| PI * left.iter().sum::<f64>());
                    }
                    Found::Mirrored { .. } => {}
                }
            }
            reads.found.push(patches.take(share).pairs().collect());
            reads.spots.push(spots.take(share).pairs().collect());
            for (what, tint) in found.iter().filter(|_| number == 0) {
                if let Found::Mirrored { direction, is_first: true } = what {
                    let left: f64 = source.iter().zip(tint).map(|(w, t)| w * f64::from(*t)).sum();
                    patches.add(look.patches.of(*direction), |_| PI * left);
                }
            }
            reads.mirrored.extend(patches.take(share).pairs());
        }
        reads
    }

    /// Coefficients of light that patches give by reflection, by source and estimate: `[sensor][column]`.
    pub(super) fn by_patches(
        &self,
        sides: &[Side<'_>; 2],
        reads: &[[Reads; REPLICAS]],
        columns: usize,
        weights: &[Vec<f64>],
    ) -> Vec<[Vec<f32>; ESTIMATES]> {
        let mut all = self.blocks(sides, reads, (columns, None), weights);
        for (source, estimates) in all.iter_mut().enumerate() {
            for (k, values) in estimates.iter_mut().enumerate() {
                for (row, reads) in values.chunks_exact_mut(columns).zip(reads) {
                    for (p, v) in reads[k % REPLICAS].found.get(source).into_iter().flatten() {
                        row[*p as usize] += v;
                    }
                }
            }
        }
        all
    }

    /// The same of light that windows with a BSDF send on, directly and by reflection.
    pub(super) fn by_panels(
        &self,
        sides: &[Side<'_>; 2],
        reads: &[[Reads; REPLICAS]],
        panels: &PanelColumns,
        weights: &[Vec<f64>],
    ) -> Vec<[Vec<f32>; ESTIMATES]> {
        self.blocks(sides, reads, (panels.count().iter().sum(), Some(panels)), weights)
    }

    fn blocks(
        &self,
        sides: &[Side<'_>; 2],
        reads: &[[Reads; REPLICAS]],
        (width, panels): (usize, Option<&PanelColumns>),
        weights: &[Vec<f64>],
    ) -> Vec<[Vec<f32>; ESTIMATES]> {
        let count = width.div_ceil(LANES);
        let of = |block: usize| self.block(sides, reads, (block, panels), weights);
        let blocks: Vec<Vec<Lanes>> = (0..count).into_par_iter().map(of).collect();
        weights
            .iter()
            .enumerate()
            .map(|(source, _)| {
                std::array::from_fn(|estimate| {
                    let mut all = vec![0.0f32; reads.len() * width];
                    for (block, values) in blocks.iter().enumerate() {
                        let own = &values[(source * ESTIMATES + estimate) * reads.len()..][..reads.len()];
                        for (row, lanes) in all.chunks_exact_mut(width).zip(own) {
                            let part = &mut row[block * LANES..width.min((block + 1) * LANES)];
                            part.iter_mut().zip(lanes).for_each(|(to, from)| *to = *from as f32);
                        }
                    }
                    all
                })
            })
            .collect()
    }

    /// Eight columns, of patches or of windows with a BSDF: values by source, estimate and sensor.
    fn block(
        &self,
        sides: &[Side<'_>; 2],
        reads: &[[Reads; REPLICAS]],
        (block, panels): (usize, Option<&PanelColumns>),
        weights: &[Vec<f64>],
    ) -> Vec<Lanes> {
        let count = reads.len();
        let mut out = vec![[0.0; LANES]; weights.len() * ESTIMATES * count];
        let each = if panels.is_some() { 1 } else { self.each() };
        for replica in 0..REPLICAS {
            let spots = panels.map(|p| p.block(self.world, replica % PANEL_SETS, block));
            let direct_in = |value: usize| -> Vec<Vec<Lanes>> {
                let of = |side: &Side<'_>, e: usize| {
                    let light = &side.light[replica];
                    match &spots {
                        Some(spots) => light.spots.times(e, spots),
                        None => light.patches.lanes(e, block, (value, each)),
                    }
                };
                sides.iter().map(|side| (0..side.solved.mesh.len()).map(|e| of(side, e)).collect()).collect()
            };
            let mut direct = direct_in(0);
            for band in 0..self.optics.bands.len() {
                if each > 1 && band > 0 {
                    direct = direct_in(band);
                }
                if direct.iter().flatten().flatten().all(|v| *v == 0.0) {
                    continue;
                }
                let solve = |k: usize| sides[k].columns.solve(replica, band, &direct[k]);
                let (main, twin) = (solve(0), solve(1));
                for (source, weights) in weights.iter().enumerate() {
                    let at = (source * ESTIMATES + replica) * count;
                    let (first, second) = out[at..].split_at_mut(REPLICAS * count);
                    for (i, reads) in reads.iter().enumerate() {
                        let reads = &reads[replica];
                        for (e, other, weight, tint) in &reads.entries {
                            let left = reads.tints[*tint as usize].get(band).map_or(1.0, |t| f64::from(*t));
                            let weight = f64::from(*weight) * weights[band] * left;
                            let twin = if *other == u32::MAX { &main[*e as usize] } else { &twin[*other as usize] };
                            for l in 0..LANES {
                                first[i][l] += weight * main[*e as usize][l];
                                second[i][l] += weight * twin[l];
                            }
                        }
                    }
                }
            }
            let Some(spots) = &spots else { continue };
            for source in 0..weights.len() {
                for (i, reads) in reads.iter().enumerate() {
                    let seen = reads[replica].spots.get(source).into_iter().flatten().copied();
                    let light = times(seen, spots);
                    for set in [replica, REPLICAS + replica] {
                        let sum = &mut out[(source * ESTIMATES + set) * count + i];
                        sum.iter_mut().zip(light).for_each(|(sum, v)| *sum += v);
                    }
                }
            }
        }
        out
    }
}

impl Reads {
    /// Joins what is read at one element, and takes the mean over rays.
    fn merge(&mut self, share: f32) {
        self.entries.sort_unstable_by_key(|e| (e.3, e.0, e.1));
        let mut joined: Vec<(u32, u32, f32, u32)> = Vec::with_capacity(self.entries.len());
        for e in self.entries.drain(..) {
            match joined.last_mut() {
                Some(last) if e.3 == 0 && (last.0, last.1, last.3) == (e.0, e.1, e.3) => last.2 += 1.0,
                _ => joined.push(e),
            }
        }
        joined.iter_mut().for_each(|e| e.2 *= share);
        self.entries = joined;
    }
}
