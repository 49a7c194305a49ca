//! What sensors and pixels ask for: where the light comes from that they feel, so that nothing else is meshed.

use glam::DVec2;
use rayon::prelude::*;

use super::adaptive::{Task, stream};
use super::probe::Probe;
use super::receiver::Facing;
use super::result::Status;
use super::sensor_state::SensorState;
use crate::mesh::Importance;
use crate::transport::caster::Ray;
use crate::transport::points::{Points, seed};
use crate::transport::{Fork, Landing, Tint, follow};

/// Rays of a sensor that tell how far it sees, at most.
const DEMAND_RAYS: u32 = 64;
/// Walks that tell what is important, for each cell of the first mesh; at least; at most; and reflections of one.
const WALKS_A_CELL: f64 = 8.0;
const FEWEST_WALKS: usize = 4096;
const MOST_WALKS: usize = 1 << 18;
const MAX_REFLECTIONS: u32 = 16;

/// A landing: surface, side, place on it.
pub(super) type Landed = (usize, bool, DVec2);

/// The importance that landings tell.
fn importance(landings: &[Landed]) -> Importance {
    Importance::new(landings.iter().map(|l| (l.0 as u32, l.2)).collect())
}

/// What sensors and pixels ask for, at first hand and at any other.
pub(super) struct Demand {
    pub(super) landings: Vec<Landed>,
    /// Median distance of what the sensors see, in the program's frame.
    pub(super) reach: f64,
    /// What they feel of each place.
    pub(super) importance: Importance,
}

impl Task<'_> {
    pub(super) fn demand(&self, grids: &[Vec<SensorState>]) -> Demand {
        let probes = grids.iter().flatten().map(|s| &s.probe);
        let sensors: Vec<&Probe> = probes.filter(|p| p.status == Status::Ok).collect();
        let look = |rays: std::ops::Range<u32>| -> Vec<Vec<Landed>> {
            let from = |(i, p): (usize, &&Probe)| {
                let points = Points::new(seed(&[self.options.seed, stream::SENSOR, i as u64]));
                rays.clone().filter_map(|k| self.landing(p.position, p.facing, &points, k)).collect()
            };
            sensors.par_iter().enumerate().map(from).collect()
        };
        let count = (2 * self.first_rays()).min(DEMAND_RAYS);
        let from_sensors = look(0..count);
        let distance =
            |p: &Probe, (surface, _, uv): &Landed| self.world.surfaces.list[*surface].point(*uv).distance(p.position);
        let distances = sensors.iter().zip(&from_sensors).flat_map(|(p, l)| l.iter().map(|l| distance(p, l)));
        let reach = if from_sensors.is_empty() { 1.0 } else { super::statement::median(distances.collect()) };
        let from_views = self.scene.views.iter().map(|v| super::picture::demand(self.world, self.optics, v, self));
        let first: Vec<Landed> = from_sensors.into_iter().chain(from_views).flatten().collect();
        let mut landings = self.walk(&first, 0);
        // What rows take for all that light reaches has to be there: hardly an element may be missed where it matters.
        let size = self.first_size(reach);
        let mut walked = count;
        for least in [FEWEST_WALKS, 0] {
            let felt = importance(&landings).felt_area(&self.world.surfaces, size);
            let walks = ((WALKS_A_CELL * felt / size.powi(2)) as usize).clamp(least, MOST_WALKS);
            let each = walked.max((walks / sensors.len().max(1)) as u32);
            let more: Vec<Landed> = look(walked..each).into_iter().flatten().collect();
            landings.append(&mut self.walk(&more, landings.len()));
            walked = each;
        }
        Demand { reach, importance: importance(&landings), landings }
    }

    /// Where the light that the sensors feel comes from, at first hand and at any other: walks from the first landings,
    /// which go on at each with the chance of its reflectance in the brightest band; numbered from `number` on.
    fn walk(&self, first: &[Landed], number: usize) -> Vec<Landed> {
        let found: Vec<Vec<Landed>> = first
            .par_iter()
            .enumerate()
            .with_min_len(256)
            .map(|(walk, start)| {
                let mut at = *start;
                let mut list = vec![at];
                let points = Points::new(seed(&[self.options.seed, stream::WALK, (number + walk) as u64]));
                for bounce in 0..MAX_REFLECTIONS {
                    let surface = &self.world.surfaces.list[at.0];
                    let mut chance = points.get(bounce, 4);
                    let scatter = self.optics.scatter(surface.material, at.1, &mut chance);
                    let most = scatter.shares.iter().copied().fold(0.0, f32::max);
                    if chance >= f64::from(most / scatter.odds) {
                        break;
                    }
                    let normal = surface.side_normal(at.1 != scatter.passes);
                    let x = self.world.lift(surface.point(at.2), normal);
                    let Some(next) = self.landing(x, normal.into(), &points, bounce) else { break };
                    at = next;
                    list.push(at);
                }
                list
            })
            .collect();
        found.into_iter().flatten().collect()
    }

    /// Where a gather ray lands.
    pub(super) fn landing(&self, x: glam::DVec3, facing: Facing, points: &Points, k: u32) -> Option<Landed> {
        let (a, b) = points.pair(k, 0);
        let ray = Ray::new(x, facing.direction(a, b));
        let hit = self.world.caster.closest(&ray);
        let mut tint = Tint::new(self.optics.pad);
        // A pane's stronger branch will do; a window with a BSDF has as many as directions.
        let fork = Fork::Chance(if self.world.has_bsdf() { points.get(k, 5) } else { 0.5 });
        match follow(self.world, self.optics, ray, hit, fork, &mut tint, &mut 0) {
            Landing::Surface { surface, front, point, .. } => {
                Some((surface as usize, front, self.world.surfaces.list[surface as usize].uv(point)))
            }
            _ => None,
        }
    }
}
