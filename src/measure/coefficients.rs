//! Daylight coefficients: what each patch of the sky gives to each sensor, by the same rows as any other solution.
//!
//! In: a scene and a tolerance. Out: [`Coefficients`], illuminance per unit luminance of a patch (Tregenza and Waters
//! 1983). What a sensor sees of the sky itself is divided finely; what comes by reflection has every patch as a
//! right-hand side of the same system. The four independent sets of rays and their coarse twins are kept apart, so that
//! every hour of a year has an error of its own.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::adaptive::{Adapted, Task, octave, stream};
use super::gather::{Field, Found, Gatherer, REPLICAS, Solved};
use super::probe::{Probe, hidden};
use super::result::Status;
use crate::error::Result;
use crate::light::sky::Patches;
use crate::mesh::Elements;
use crate::solve::{Columns, LANES, Lanes};
use crate::transport::points::{Points, seed};
use crate::transport::{
    DAYLIGHT_GROUPS, DirectScratch, Openings, Optics, Rows, SUN, Seen, Tint, World, sun_factor, sun_through,
    visible_directions,
};

/// Parts of a side of Tregenza's patches into which the sky itself is divided.
const SEEN_PARTS: usize = 4;
/// Directions across a patch.
const ACROSS: f64 = 1.0;
/// Places on an element that look at the sky, in each set.
const PLACES: u32 = 1;
/// Independent estimates: as many of the mesh, then as many of its coarse twin.
pub const ESTIMATES: usize = 2 * REPLICAS;

/// Illuminance of sensors per unit luminance of patches, lx/(cd/m²).
#[derive(Debug)]
pub struct Coefficients {
    /// Patches in which the sky itself is seen.
    pub seen_patches: Patches,
    /// Patches whose reflected light is told apart.
    pub patches: Patches,
    /// Divisions of the light by the blinds that it passes: none, then each. Their columns follow each other.
    pub openings: usize,
    /// By grid.
    pub grids: Vec<GridCoefficients>,
    world: World,
    optics: Optics,
    /// Blind of each surface, from 1; 0 where there is none.
    blinds: Vec<u8>,
    /// Share of each band in the sun's luminance.
    sun_weights: Vec<f64>,
}

/// Column (opening · patches + patch) and coefficient, where it is not zero.
type SeenPatches = Vec<(u32, f32)>;

/// The coefficients of a grid.
#[derive(Debug)]
pub struct GridCoefficients {
    /// The sensors as they look.
    probes: Vec<Probe>,
    /// Where each sensor sees the sky; `None` where rays had to tell.
    openings: Vec<Option<Openings>>,
    /// What each sensor sees of the sky and the ground.
    pub seen: Vec<SeenPatches>,
    /// What comes by reflection, under the spectrum of the sky and under that of the sun (once, where they are the same):
    /// by estimate, `[sensor][column]`.
    pub reflected: Vec<[Vec<f32>; ESTIMATES]>,
}

impl GridCoefficients {
    /// Can the sensor see?
    #[must_use]
    pub fn status(&self, sensor: usize) -> Status {
        self.probes[sensor].status
    }

    /// Coefficients of reflected light of the sun.
    #[must_use]
    pub fn of_sun(&self) -> &[Vec<f32>; ESTIMATES] {
        &self.reflected[self.reflected.len() - 1]
    }
}

impl Coefficients {
    /// Illuminance of a sensor by the sun's disc about `direction`, per unit of its illuminance face on; and the opening by
    /// which it comes.
    #[must_use]
    pub fn sun(&self, grid: usize, sensor: usize, direction: DVec3, scratch: &mut SunScratch) -> (f64, usize) {
        let p = &self.grids[grid].probes[sensor];
        let SunScratch { direct, factors } = scratch;
        factors.clear();
        factors.resize(self.optics.columns() - self.optics.lamps, 0.0);
        let sample = seed(&[grid as u64, sensor as u64]);
        let (world, at) = (&self.world, (p.eye, p.normal));
        match &self.grids[grid].openings[sensor] {
            Some(openings) => sun_through(world, at, openings, direction, direct, factors),
            None => direct.rays += sun_factor(world, at, direction, sample, direct, factors),
        }
        let tinted = factors.get(DAYLIGHT_GROUPS + SUN * self.optics.pad..).unwrap_or_default();
        let tinted: f64 = tinted.iter().zip(&self.sun_weights).map(|(f, w)| f * w).sum();
        let factor = factors[SUN] + tinted;
        (factor, if factor > 0.0 { opening(&self.blinds, direct.panes()) } else { 0 })
    }

    /// The patches of the sky that a sensor sees, and those beside them: the sun shines on it from nowhere else.
    #[must_use]
    pub fn sunny_patches(&self, grid: usize, sensor: usize) -> Vec<bool> {
        let patches = &self.seen_patches;
        let mut sunny = vec![false; patches.all()];
        for (column, _) in &self.grids[grid].seen[sensor] {
            let p = *column as usize % patches.all();
            if p < patches.sky() {
                patches.beside(p).for_each(|q| sunny[q] = true);
            }
        }
        sunny
    }

    /// Buffers for [`Coefficients::sun`].
    #[must_use]
    pub fn scratch(&self) -> SunScratch {
        SunScratch { direct: DirectScratch::default().in_bands(&self.optics), factors: Vec::new() }
    }
}

/// Buffers of one thread.
#[derive(Debug)]
pub struct SunScratch {
    direct: DirectScratch,
    factors: Vec<f64>,
}

/// The opening to which a way through panes belongs: the first pane with a blind tells.
fn opening(blinds: &[u8], panes: &[u32]) -> usize {
    panes.iter().map(|p| usize::from(blinds[*p as usize])).find(|b| *b > 0).unwrap_or(0)
}

/// Values by patch, few of which are not zero.
#[derive(Clone, Debug, Default)]
struct Sparse {
    start: Vec<u32>,
    entries: Vec<(u32, f32)>,
}

impl Sparse {
    fn of(&self, row: usize) -> &[(u32, f32)] {
        &self.entries[self.start[row] as usize..self.start[row + 1] as usize]
    }

    /// Eight neighbouring columns of a row.
    fn lanes(&self, row: usize, block: usize) -> Lanes {
        let row = self.of(row);
        let first = row.partition_point(|(c, _)| (*c as usize) < block * LANES);
        let mut lanes = [0.0; LANES];
        for (c, v) in row[first..].iter().take_while(|(c, _)| (*c as usize) < (block + 1) * LANES) {
            lanes[*c as usize % LANES] = f64::from(*v);
        }
        lanes
    }

    fn push(&mut self, row: &[(u32, f32)]) {
        if self.start.is_empty() {
            self.start.push(0);
        }
        self.entries.extend_from_slice(row);
        self.start.push(self.entries.len() as u32);
    }
}

/// Sums by patch, of one thread.
#[derive(Debug)]
struct Sums {
    values: Vec<f32>,
    touched: Vec<u32>,
}

impl Sums {
    fn new(columns: usize) -> Self {
        Self { values: vec![0.0; columns], touched: Vec::new() }
    }

    fn add(&mut self, patch: usize, value: f64) {
        if self.values[patch] == 0.0 {
            self.touched.push(patch as u32);
        }
        self.values[patch] += value as f32;
    }

    /// What was added, in order, times a factor; the sums are empty again.
    fn take(&mut self, factor: f32) -> Vec<(u32, f32)> {
        self.touched.sort_unstable();
        self.touched.dedup();
        let values = &mut self.values;
        self.touched.drain(..).map(|p| (p, factor * std::mem::take(&mut values[p as usize]))).collect()
    }
}

/// How a point looks at the sky.
#[derive(Clone, Copy)]
struct Look<'a> {
    patches: &'a Patches,
    blinds: &'a [u8],
    /// Share of each band in the luminance of the light.
    weights: &'a [f64],
}

impl Look<'_> {
    /// What a tint leaves of the light, as the eye sees it.
    fn left(&self, tint: &Tint) -> f64 {
        if !tint.coloured {
            return f64::from(tint.scale);
        }
        self.weights.iter().enumerate().map(|(b, w)| w * f64::from(tint.share(b))).sum()
    }
}

/// One mesh with its rows, ready for any sky.
struct Side<'a> {
    solved: &'a Solved,
    columns: Columns,
    /// Direct irradiance of each element per unit luminance of each patch, by replica.
    light: Vec<Sparse>,
}

/// Where the rays of one set of one sensor are read.
#[derive(Debug, Default)]
struct Reads {
    /// Element, element of the twin, weight, and what the way leaves in every band (zero: all).
    entries: Vec<(u32, u32, f32, u32)>,
    tints: Vec<Vec<f32>>,
    /// Daylight found on the way, by source.
    found: Vec<Vec<(u32, f32)>>,
}

impl Task<'_> {
    /// The coefficients of all sensors, for a sky in `parts` of Tregenza's patches a side.
    pub(super) fn coefficients(&self, adapted: &Adapted, parts: usize) -> Result<Coefficients> {
        let (patches, seen_patches) = (Patches::new(parts), Patches::new(SEEN_PARTS));
        let weights = self.source_weights();
        let sides = [
            self.side(&adapted.main, &adapted.rows, &patches, 0)?,
            self.side(&adapted.twin, &adapted.twin_rows, &patches, 1)?,
        ];
        let grids = adapted
            .grids
            .iter()
            .enumerate()
            .map(|(g, states)| {
                let probes: Vec<Probe> = states.iter().map(|s| s.probe).collect();
                let (seen, openings) = self.seen(&probes, &seen_patches, &weights[0]).into_iter().unzip();
                self.progress.stage(&format!("grid {}: rays", self.scene.grids[g].name), states.len() as u64);
                let reads: Vec<[Reads; REPLICAS]> = self.reads(adapted, g, &patches, &weights);
                self.progress.stage(&format!("grid {}: patches of the sky", self.scene.grids[g].name), 0);
                GridCoefficients {
                    probes,
                    openings,
                    seen,
                    reflected: self.reflected(&sides, &reads, &patches, &weights),
                }
            })
            .collect();
        Ok(Coefficients {
            seen_patches,
            patches,
            openings: 1 + self.scene.blinds.len(),
            grids,
            world: self.world.clone(),
            optics: self.optics.clone(),
            blinds: self.blinds(),
            sun_weights: weights.into_iter().next_back().unwrap_or_default(),
        })
    }

    /// Columns of a division of the sky: every patch, by every opening.
    fn columns(&self, patches: &Patches) -> usize {
        (1 + self.scene.blinds.len()) * patches.all()
    }

    /// Blind of each surface, from 1; 0 where there is none.
    fn blinds(&self) -> Vec<u8> {
        let of = |face: &crate::scene::Face| {
            let at = self.scene.blinds.iter().position(|b| b.covers(self.scene, face));
            at.map_or(0, |k| k as u8 + 1)
        };
        self.scene.faces.iter().map(of).collect()
    }

    /// Share of each band in the luminance of the sky, and of the sun where that differs.
    fn source_weights(&self) -> Vec<Vec<f64>> {
        let Some(light) = self.world.daylight() else { return Vec::new() };
        let shares = |spectrum| -> Vec<f64> {
            let radiance = self.optics.bands.radiance(spectrum);
            let parts: Vec<f64> = radiance.iter().zip(&self.optics.xyz[1]).map(|(r, y)| r * f64::from(*y)).collect();
            let sum: f64 = parts.iter().sum();
            parts.iter().map(|p| p / sum).collect()
        };
        let (sky, sun) = (shares(&light.sky_irradiance), shares(&light.sun_irradiance));
        let is_same = sky.iter().zip(&sun).all(|(a, b)| (a - b).abs() < 1e-6);
        if is_same { vec![sky] } else { vec![sky, sun] }
    }

    fn side<'a>(&self, solved: &'a Solved, rows: &Rows, patches: &Patches, number: u64) -> Result<Side<'a>> {
        let columns = Columns::new(self.world, self.optics, &solved.mesh, rows, self.accuracy())?;
        self.progress.stage("sky seen by the elements", solved.mesh.len() as u64);
        Ok(Side { solved, columns, light: self.element_light(&solved.mesh, rows, patches, number) })
    }

    /// Direct irradiance of elements per unit luminance of each patch, by replica.
    fn element_light(&self, mesh: &Elements, rows: &Rows, patches: &Patches, number: u64) -> Vec<Sparse> {
        let weights = self.source_weights();
        let blinds = self.blinds();
        let look = Look { patches, blinds: &blinds, weights: &weights[0] };
        let of = |(sums, scratch): &mut (Sums, DirectScratch), i: usize| {
            self.progress.advance(1);
            self.light_of_element(mesh, i, rows.valid[i] < 1.0, (look, number), sums, scratch)
        };
        let lists: Vec<[Vec<(u32, f32)>; REPLICAS]> = (0..mesh.len())
            .into_par_iter()
            .with_min_len(16)
            .map_init(|| (Sums::new(self.columns(patches)), self.scratch()), of)
            .collect();
        let mut sums = Sums::new(self.columns(patches));
        (0..REPLICAS)
            .map(|r| {
                let mut sparse = Sparse::default();
                let mut mirrored = rows.replicas[r].mirrored.iter().peekable();
                for (i, list) in lists.iter().enumerate() {
                    list[r].iter().for_each(|(p, v)| sums.add(*p as usize, f64::from(*v)));
                    // A mirror's colour counts as the sky's light sees it.
                    while let Some(seen) = mirrored.next_if(|m| m.element as usize == i) {
                        let direction = DVec3::from_array(seen.direction.map(f64::from));
                        let tint = &rows.tints[seen.tint as usize];
                        let left: f64 = weights[0].iter().zip(tint).map(|(w, t)| w * f64::from(*t)).sum();
                        if direction != DVec3::ZERO {
                            let share = PI * f64::from(seen.share) * left / rows.rays as f64;
                            sums.add(patches.of(direction), share);
                        }
                    }
                    sparse.push(&sums.take(1.0));
                }
                sparse
            })
            .collect()
    }

    /// The same of one element, by its own places; a replica of which all places are covered takes those of the others.
    fn light_of_element(
        &self,
        mesh: &Elements,
        index: usize,
        may_be_covered: bool,
        (look, number): (Look<'_>, u64),
        sums: &mut Sums,
        scratch: &mut DirectScratch,
    ) -> [Vec<(u32, f32)>; REPLICAS] {
        let element = &mesh.list()[index];
        let surface = &self.world.surfaces.list[element.surface as usize];
        let normal = surface.side_normal(element.front);
        let first = mesh.morton(element).wrapping_mul(PLACES);
        let mut counts = [0u32; REPLICAS];
        let mut lists: [Vec<(u32, f32)>; REPLICAS] = std::array::from_fn(|r| {
            let stream = seed(&[self.options.seed, stream::PATCHES, number, element.key.family(), r as u64]);
            let points = Points::new(stream);
            for k in 0..PLACES {
                let (a, b) = points.pair(first.wrapping_add(k), 0);
                let x = self.world.lift(element.sample(surface, a, b), normal);
                if may_be_covered && hidden(self.world, x, normal) {
                    continue;
                }
                counts[r] += 1;
                let sample = seed(&[stream, u64::from(first), u64::from(k)]);
                self.look((x, normal), sample, (look, None), scratch, |p, weight| sums.add(p, weight));
            }
            sums.take(1.0)
        });
        let all: u32 = counts.iter().sum();
        let mean = if counts.contains(&0) && all > 0 {
            lists.iter().flatten().for_each(|(p, v)| sums.add(*p as usize, f64::from(*v)));
            sums.take(1.0 / all as f32)
        } else {
            Vec::new()
        };
        for (list, n) in lists.iter_mut().zip(counts) {
            match n {
                0 => list.clone_from(&mean),
                n => list.iter_mut().for_each(|(_, v)| *v /= n as f32),
            }
        }
        lists
    }

    fn scratch(&self) -> DirectScratch {
        DirectScratch::default().in_bands(self.optics)
    }

    /// Tells the columns that a point sees, each with its projected solid angle times what panes leave, as the eye weighs
    /// the sky's light.
    fn look(
        &self,
        at: (DVec3, DVec3),
        sample: u64,
        (look, openings): (Look<'_>, Option<&mut Openings>),
        scratch: &mut DirectScratch,
        mut visit: impl FnMut(usize, f64),
    ) {
        let width = look.patches.width() / ACROSS;
        let all = look.patches.all();
        let each = &mut |seen: Seen<'_>| {
            let column = opening(look.blinds, seen.panes) * all + look.patches.of(seen.direction);
            visit(column, seen.weight * look.left(seen.tint));
        };
        scratch.rays += visible_directions(self.world, at, sample, (width, openings), scratch, each);
    }

    /// What sensors see of sky and ground by patch, and where they see the sky.
    fn seen(&self, probes: &[Probe], patches: &Patches, weights: &[f64]) -> Vec<(SeenPatches, Option<Openings>)> {
        let blinds = self.blinds();
        let look = Look { patches, blinds: &blinds, weights };
        let of = |(sums, scratch): &mut (Sums, DirectScratch), (i, p): (usize, &Probe)| {
            let mut openings = Openings::default();
            if p.status == Status::Ok {
                let sample = seed(&[self.options.seed, i as u64]);
                self.look((p.eye, p.normal), sample, (look, Some(&mut openings)), scratch, |p, w| sums.add(p, w));
            }
            (sums.take(1.0), openings.whole())
        };
        probes
            .par_iter()
            .enumerate()
            .with_max_len(8)
            .map_init(|| (Sums::new(self.columns(patches)), self.scratch()), of)
            .collect()
    }

    /// Where the rays of a grid's sensors are read: the rays of the last round.
    fn reads(&self, adapted: &Adapted, g: usize, patches: &Patches, weights: &[Vec<f64>]) -> Vec<[Reads; REPLICAS]> {
        let field = Field {
            world: self.world,
            optics: self.optics,
            main: &adapted.main,
            twin: Some(&adapted.twin),
            spectral: false,
            squares: false,
        };
        let blinds = self.blinds();
        adapted.grids[g]
            .par_iter()
            .enumerate()
            .with_max_len(8)
            .map_init(
                || (Gatherer::recording(&field), Sums::new(self.columns(patches)), self.scratch()),
                |(gatherer, sums, scratch), (i, s)| {
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
                        self.read(gatherer, rays, (patches, &blinds), weights, sums, scratch)
                    })
                },
            )
            .collect()
    }

    fn read(
        &self,
        gatherer: &mut Gatherer<'_>,
        (x, normal, stream, count): (DVec3, DVec3, u64, u32),
        (patches, blinds): (&Patches, &[u8]),
        weights: &[Vec<f64>],
        sums: &mut Sums,
        scratch: &mut DirectScratch,
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
        for source in weights {
            let look = Look { patches, blinds, weights: source };
            let left = |t: &[f32]| source.iter().zip(t).map(|(w, t)| w * f64::from(*t)).sum::<f64>();
            for (k, (what, tint)) in found.iter().enumerate() {
                let left = left(tint);
                match what {
                    Found::Vertex { position, normal } => {
                        let sample = seed(&[stream, k as u64]);
                        self.look((*position, *normal), sample, (look, None), scratch, |p, w| sums.add(p, w * left));
                    }
                    Found::Mirrored { direction } => sums.add(patches.of(*direction), PI * left),
                }
            }
            reads.found.push(sums.take(share));
        }
        reads
    }

    /// Coefficients of reflected light, by source and estimate.
    fn reflected(
        &self,
        sides: &[Side<'_>; 2],
        reads: &[[Reads; REPLICAS]],
        patches: &Patches,
        weights: &[Vec<f64>],
    ) -> Vec<[Vec<f32>; ESTIMATES]> {
        let width = self.columns(patches);
        let blocks: Vec<Vec<Lanes>> =
            (0..width.div_ceil(LANES)).into_par_iter().map(|block| self.block(sides, reads, block, weights)).collect();
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
                    for (row, reads) in all.chunks_exact_mut(width).zip(reads) {
                        for (p, v) in reads[estimate % REPLICAS].found.get(source).into_iter().flatten() {
                            row[*p as usize] += v;
                        }
                    }
                    all
                })
            })
            .collect()
    }

    /// Eight patches: values by source, estimate and sensor.
    fn block(
        &self,
        sides: &[Side<'_>; 2],
        reads: &[[Reads; REPLICAS]],
        block: usize,
        weights: &[Vec<f64>],
    ) -> Vec<Lanes> {
        let count = reads.len();
        let mut out = vec![[0.0; LANES]; weights.len() * ESTIMATES * count];
        for replica in 0..REPLICAS {
            let direct: Vec<Vec<Lanes>> = sides
                .iter()
                .map(|side| (0..side.solved.mesh.len()).map(|e| side.light[replica].lanes(e, block)).collect())
                .collect();
            if direct.iter().flatten().flatten().all(|v| *v == 0.0) {
                continue;
            }
            for band in 0..self.optics.bands.len() {
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
