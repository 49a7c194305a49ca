//! What elements and sensors see of the sky themselves, patch by patch.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::super::adaptive::{Task, stream};
use super::super::gather::REPLICAS;
use super::super::probe::{Probe, hidden};
use super::super::result::Status;
use super::sums::{Row, Sparse, Sums};
use super::{Columns, SeenPatches, opening};
use crate::light::sky::Patches;
use crate::mesh::{Element, Elements};
use crate::transport::points::{Points, seed};
use crate::transport::{DirectScratch, Openings, PANEL_SETS, PanelLook, Rows, Seen, Tint, visible_directions};

/// Directions across a patch.
const ACROSS: f64 = 1.0;
/// Places on an element that look at the sky, in each set.
const PLACES: u32 = 1;

/// How a point looks at the sky.
#[derive(Clone, Copy)]
pub(super) struct Look<'a> {
    pub(super) patches: &'a Patches,
    pub(super) blinds: &'a [u8],
    /// Share of each band in the luminance of the light.
    pub(super) weights: &'a [f64],
}

impl Look<'_> {
    /// What a tint leaves of the light, as the eye sees it.
    pub(super) fn left(&self, tint: &Tint) -> f64 {
        if !tint.coloured {
            return f64::from(tint.scale) * self.weights.iter().sum::<f64>();
        }
        self.weights.iter().enumerate().map(|(b, w)| w * f64::from(tint.share(b))).sum()
    }

    /// Directions finer than this, radians.
    pub(super) fn width(&self) -> f64 {
        self.patches.width() / ACROSS
    }

    /// The column of a direction.
    pub(super) fn column(&self, seen: &Seen<'_>) -> usize {
        opening(self.blinds, seen.panes) * self.patches.all() + self.patches.of(seen.direction)
    }
}

/// Direct irradiance of the elements in one replica.
#[derive(Debug, Default)]
pub(super) struct Received {
    /// Per unit luminance of each patch that is seen, in every band where panes or mirrors are coloured.
    pub(super) patches: Sparse,
    /// Per unit radiance of the spots of windows with a BSDF.
    pub(super) spots: Sparse,
}

/// The sums of one thread: patches, spots.
type Both = [Sums; 2];

impl Task<'_> {
    /// Values that a patch gives to an element: one, or one for each band.
    pub(super) fn each(&self) -> usize {
        if self.optics.speculars.are_coloured() { self.optics.bands.len() } else { 1 }
    }

    pub(super) fn scratch(&self) -> DirectScratch {
        DirectScratch::default().in_bands(self.optics)
    }

    /// Tells what a point sees of the sky: column, projected solid angle and what panes leave; and keeps where, if wanted.
    pub(super) fn look(
        &self,
        at: (DVec3, DVec3),
        sample: u64,
        (look, openings): (Look<'_>, Option<&mut Openings>),
        scratch: &mut DirectScratch,
        mut visit: impl FnMut(usize, f64, &Tint),
    ) {
        let each = &mut |seen: Seen<'_>| visit(look.column(&seen), seen.weight, seen.tint);
        scratch.rays += visible_directions(self.world, at, sample, (look.width(), openings), scratch, each);
    }

    /// Direct irradiance of elements, by replica.
    pub(super) fn element_light(
        &self,
        mesh: &Elements,
        rows: &Rows,
        (look, columns): (Look<'_>, &Columns),
        number: u64,
    ) -> Vec<Received> {
        let of = |(sums, scratch): &mut (Both, DirectScratch), i: usize| {
            self.progress.advance(1);
            self.light_of_element(mesh, (i, rows.valid[i] < 1.0), (look, columns, number), sums, scratch)
        };
        let each = self.each();
        let sums = || [Sums::new(columns.patches, each), Sums::new(columns.spots(), 1)];
        let lists: Vec<[[Row; 2]; REPLICAS]> =
            (0..mesh.len()).into_par_iter().with_min_len(16).map_init(|| (sums(), self.scratch()), of).collect();
        let mut sums = sums();
        (0..REPLICAS)
            .map(|r| {
                let mut received = Received::default();
                let mut mirrored = rows.replicas[r].mirrored.iter().peekable();
                for (i, list) in lists.iter().enumerate() {
                    let [patches, spots] = &list[r];
                    sums[0].add_row(patches);
                    while let Some(seen) = mirrored.next_if(|m| m.element as usize == i) {
                        let direction = DVec3::from_array(seen.direction.map(f64::from));
                        let tint = &rows.tints[seen.tint as usize];
                        if direction != DVec3::ZERO {
                            let share = PI * f64::from(seen.share) / rows.rays as f64;
                            sums[0].add(look.patches.of(direction), |band| share * f64::from(tint[band]));
                        }
                    }
                    received.patches.push(&sums[0].take(1.0));
                    received.spots.push(spots);
                }
                received
            })
            .collect()
    }

    /// The same of one element, by its own places; a replica of which all places are covered takes those of the others.
    fn light_of_element(
        &self,
        mesh: &Elements,
        (index, may_be_covered): (usize, bool),
        (look, columns, number): (Look<'_>, &Columns, u64),
        sums: &mut Both,
        scratch: &mut DirectScratch,
    ) -> [[Row; 2]; REPLICAS] {
        let element: &Element = &mesh.list()[index];
        let surface = &self.world.surfaces.list[element.surface as usize];
        let normal = surface.side_normal(element.front);
        let receiver = self.world.scatterer(element.surface).map(|_| (element.surface, element.front));
        let first = mesh.morton(element).wrapping_mul(PLACES);
        let mut counts = [0u32; REPLICAS];
        let mut lists: [[Row; 2]; REPLICAS] = std::array::from_fn(|r| {
            let stream = seed(&[self.options.seed, stream::PATCHES, number, element.key.family(), r as u64]);
            let points = Points::new(stream);
            let [patches, spots] = &mut *sums;
            for k in 0..PLACES {
                let (a, b) = points.pair(first.wrapping_add(k), 0);
                let x = self.world.lift(element.sample(surface, a, b), normal);
                if may_be_covered && hidden(self.world, x, normal) {
                    continue;
                }
                counts[r] += 1;
                let sample = seed(&[stream, u64::from(first), u64::from(k)]);
                if receiver.is_none() {
                    self.look((x, normal), sample, (look, None), scratch, |column, weight, tint| {
                        patches.add(column, |band| {
                            weight * f64::from(if tint.coloured { tint.share(band) } else { tint.scale })
                        });
                    });
                }
                if let Some(panels) = &columns.panels {
                    let way = PanelLook { set: r % PANEL_SETS, is_vertex: false, receiver };
                    scratch.rays += panels.look(self.world, (x, normal), sample, way, scratch, |spot, weight, tint| {
                        spots.add(spot, |_| weight * look.left(tint));
                    });
                }
            }
            [patches.take(1.0), spots.take(1.0)]
        });
        let all: u32 = counts.iter().sum();
        let means: [Row; 2] = if counts.contains(&0) && all > 0 {
            std::array::from_fn(|part| {
                lists.iter().for_each(|list| sums[part].add_row(&list[part]));
                sums[part].take(1.0 / all as f32)
            })
        } else {
            Default::default()
        };
        for (list, n) in lists.iter_mut().zip(counts) {
            match n {
                0 => list.clone_from(&means),
                n => list.iter_mut().for_each(|row| row.scale(1.0 / n as f32)),
            }
        }
        lists
    }

    /// What sensors see of the sky and the ground themselves, and where they see the sky.
    pub(super) fn seen(
        &self,
        probes: &[Probe],
        look: Look<'_>,
        columns: usize,
    ) -> (Vec<SeenPatches>, Vec<Option<Openings>>) {
        let of = |(sums, scratch): &mut (Sums, DirectScratch), (i, p): (usize, &Probe)| {
            let mut openings = Openings::default();
            if p.status == Status::Ok {
                let sample = seed(&[self.options.seed, i as u64]);
                self.look((p.eye, p.normal), sample, (look, Some(&mut openings)), scratch, |column, weight, tint| {
                    sums.add(column, |_| weight * look.left(tint));
                });
            }
            (sums.take(1.0).pairs().collect::<SeenPatches>(), openings.whole())
        };
        probes.par_iter().enumerate().with_max_len(8).map_init(|| (Sums::new(columns, 1), self.scratch()), of).unzip()
    }
}
