//! Many lamps: what each could give at a place, roughly; far ones are judged in clusters, so that the work grows as their
//! logarithm would rather than as their number.

use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec3;

use super::world::World;
use crate::light::Emitter;

/// Emitting sides from which on far ones are judged together; members of a cluster, at most.
const MANY_SIDES: usize = 64;
const MEMBERS: usize = 8;
/// Distance from which a cluster is judged as a whole, in radii of it and of what looks.
const FAR: f64 = 3.0;
/// Normals that differ by less are one.
const SAME_NORMAL: f64 = 1e-9;
/// Smallest cosine that a lamp is credited with while any of it could be above the horizon.
const LEAST_COSINE: f64 = 0.05;

/// What is looked at, or drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Look {
    /// An emitting side, then a luminaire, by number.
    Source(usize),
    /// One member of a cluster.
    Cluster(usize),
}

/// The emitting sides of a scene, in clusters where they are many.
#[derive(Clone, Debug, Default)]
pub(super) struct Lamps {
    list: Vec<Lamp>,
    clusters: Vec<Cluster>,
    /// Members of the clusters.
    order: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Lamp {
    centre: DVec3,
    normal: DVec3,
    radius: f64,
    area: f64,
    group: usize,
}

/// Lamps of one group that lie near each other and look about the same way.
#[derive(Clone, Debug)]
struct Cluster {
    centre: DVec3,
    radius: f64,
    /// Where all look the same way.
    normal: Option<DVec3>,
    area: f64,
    group: usize,
    members: Range<usize>,
}

impl Lamp {
    fn new(e: &Emitter) -> Self {
        let centre = e.vertices.iter().copied().sum::<DVec3>() / e.vertices.len() as f64;
        let radius = e.vertices.iter().map(|v| v.distance(centre)).fold(0.0, f64::max);
        Self { centre, normal: e.normal, radius, area: e.area, group: e.group }
    }

    /// Configuration factor at a point, roughly: nothing only where the lamp gives nothing.
    fn rough(&self, x: DVec3, normal: DVec3) -> f64 {
        let d = self.centre - x;
        let (height, depth) = (normal.dot(d), -self.normal.dot(d));
        if height + self.radius <= 0.0 || depth <= 0.0 {
            return 0.0;
        }
        let r2 = d.length_squared().max(self.radius * self.radius);
        let r = r2.sqrt();
        self.area * (height / r).max(LEAST_COSINE) * (depth / r).max(LEAST_COSINE) / (PI * r2)
    }
}

impl Cluster {
    fn new(lamps: &[Lamp], order: &[u32], members: Range<usize>) -> Self {
        let own = || order[members.clone()].iter().map(|k| &lamps[*k as usize]);
        let first = &lamps[order[members.start] as usize];
        let low = own().fold(DVec3::INFINITY, |m, l| m.min(l.centre - l.radius));
        let high = own().fold(DVec3::NEG_INFINITY, |m, l| m.max(l.centre + l.radius));
        let alike = own().all(|l| l.normal.distance(first.normal) < SAME_NORMAL);
        Self {
            centre: 0.5 * (low + high),
            radius: 0.5 * (high - low).length(),
            normal: alike.then_some(first.normal),
            area: own().map(|l| l.area).sum(),
            group: first.group,
            members,
        }
    }

    /// Most that the cluster could give within `reach` of a point; `None` where it is too near to tell.
    fn most(&self, (x, reach): (DVec3, f64), normal: DVec3) -> Option<f64> {
        let (d, wide) = (self.centre - x, self.radius + reach);
        let r = d.length();
        if r < FAR * wide {
            return None;
        }
        let cosine = |height: f64| ((height + wide) / r).clamp(0.0, 1.0);
        let near2 = (r - wide).powi(2);
        let seen = self.normal.map_or(1.0, |n| cosine(-n.dot(d)));
        Some(self.area * cosine(normal.dot(d)) * seen / (PI * near2))
    }
}

impl Lamps {
    pub(super) fn new(emitters: &[Emitter]) -> Self {
        let list: Vec<Lamp> = emitters.iter().map(Lamp::new).collect();
        let mut lamps = Self { list, ..Self::default() };
        if lamps.list.len() < MANY_SIDES {
            return lamps;
        }
        let key = |k: &u32| {
            let lamp = &lamps.list[*k as usize];
            let axis = lamp.normal.abs().to_array().iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map(|m| m.0);
            let side = axis.map(|axis| (axis, lamp.normal[axis] > 0.0));
            (lamp.group, side, morton(lamp.centre), *k)
        };
        let mut order: Vec<u32> = (0..lamps.list.len() as u32).collect();
        order.sort_by_cached_key(key);
        let mut start = 0;
        for alike in order.chunk_by(|a, b| (key(a).0, key(a).1) == (key(b).0, key(b).1)) {
            for members in alike.chunks(MEMBERS) {
                lamps.clusters.push(Cluster::new(&lamps.list, &order, start..start + members.len()));
                start += members.len();
            }
        }
        lamps.order = order;
        lamps
    }

    /// Emitting sides near a place, and far clusters with the most that they could give there, times the strength of their
    /// groups. `at` is the middle of the place and its reach.
    pub(super) fn survey(
        &self,
        at: (DVec3, f64),
        normal: DVec3,
        strength: &[f64],
        mut side: impl FnMut(usize) -> f64,
        out: &mut Vec<(Look, f64)>,
    ) {
        out.clear();
        if self.clusters.is_empty() {
            out.extend((0..self.list.len()).map(|k| (Look::Source(k), side(k))));
            return;
        }
        for (c, cluster) in self.clusters.iter().enumerate() {
            match cluster.most(at, normal) {
                Some(most) => out.push((Look::Cluster(c), most * strength_of(strength, cluster.group))),
                None => self.open(c, &mut side, out),
            }
        }
    }

    /// Puts the members of the clusters that could give more than `share` of the light of all in their places.
    pub(super) fn open_stronger(&self, share: f64, mut side: impl FnMut(usize) -> f64, looks: &mut Vec<(Look, f64)>) {
        let limit = share * looks.iter().map(|l| l.1).sum::<f64>();
        for at in 0..looks.len() {
            if let (Look::Cluster(c), most) = looks[at]
                && most >= limit
            {
                looks[at].1 = 0.0;
                self.open(c, &mut side, looks);
            }
        }
    }

    fn open(&self, cluster: usize, side: &mut impl FnMut(usize) -> f64, out: &mut Vec<(Look, f64)>) {
        let members = &self.order[self.clusters[cluster].members.clone()];
        out.extend(members.iter().map(|k| (Look::Source(*k as usize), side(*k as usize))));
    }

    /// Configuration factor of a side at a point, roughly.
    pub(super) fn rough(&self, side: usize, x: DVec3, normal: DVec3) -> f64 {
        self.list[side].rough(x, normal)
    }

    /// Draws a member of a cluster for a point by what it could give there: the member, and one over its chance.
    pub(super) fn draw(&self, cluster: usize, x: DVec3, normal: DVec3, want: f64) -> Option<(usize, f64)> {
        let members = &self.order[self.clusters[cluster].members.clone()];
        let light = |k: &u32| self.list[*k as usize].rough(x, normal);
        let all: f64 = members.iter().map(light).sum();
        let mut left = want * all;
        let mut chosen = None;
        for k in members {
            let own = light(k);
            if own > 0.0 {
                chosen = Some((*k as usize, all / own));
                left -= own;
                if left < 0.0 {
                    break;
                }
            }
        }
        chosen
    }

    /// Is the side so small as seen from a point that one place on it stands for all of it?
    pub(super) fn is_small(&self, side: usize, x: DVec3, ratio: f64) -> bool {
        let lamp = &self.list[side];
        2.0 * lamp.radius < ratio * lamp.centre.distance(x)
    }
}

/// Strength of a group; the same for all where none are given.
pub(super) fn strength_of(strength: &[f64], group: usize) -> f64 {
    strength.get(group).copied().unwrap_or(1.0)
}

/// What a source could give at a point, roughly, times the strength of its group; in the units of a configuration factor.
pub(super) fn rough(world: &World, source: usize, x: DVec3, normal: DVec3, strength: &[f64]) -> f64 {
    let sides = &world.emitters.list;
    if source < sides.len() {
        return strength_of(strength, sides[source].group) * world.lamps().rough(source, x, normal);
    }
    let luminaire = &world.emitters.luminaires[source - sides.len()];
    strength_of(strength, luminaire.group) * luminaire.rough(x, normal) / world.surfaces.frame.area_m2()
}

/// Number of a place of the unit cube about the origin along a curve that keeps neighbours together (Morton 1966).
fn morton(place: DVec3) -> u64 {
    let spread = |x: f64| {
        let cell = ((x + 0.5).clamp(0.0, 1.0) * 1023.0) as u64;
        (0..10).fold(0, |bits, k| bits | ((cell >> k) & 1) << (3 * k))
    };
    spread(place.x) | spread(place.y) << 1 | spread(place.z) << 2
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lamp(x: f64, y: f64) -> Emitter {
        let vertices =
            [(0.0, 0.0), (0.0, 0.002), (0.002, 0.002), (0.002, 0.0)].map(|(u, v)| DVec3::new(x + u, y + v, 0.1));
        Emitter { surface: 0, front: true, vertices: vertices.to_vec(), normal: DVec3::NEG_Z, group: 0, area: 4e-6 }
    }

    fn field() -> Lamps {
        let place = |k: usize| 0.9 * ((k as f64 + 0.5) / 32.0 - 0.5);
        Lamps::new(&(0..1024).map(|k| lamp(place(k % 32), place(k / 32))).collect::<Vec<_>>())
    }

    #[test]
    fn every_lamp_is_looked_at_alone_or_in_one_cluster() {
        let lamps = field();
        let mut looks = Vec::new();
        lamps.survey((DVec3::ZERO, 0.01), DVec3::Z, &[], |_| 1.0, &mut looks);
        lamps.open_stronger(0.02, |_| 1.0, &mut looks);
        let mut seen = vec![0; 1024];
        for (look, light) in &looks {
            match look {
                Look::Source(k) => seen[*k] += 1,
                Look::Cluster(c) if *light > 0.0 => {
                    lamps.order[lamps.clusters[*c].members.clone()].iter().for_each(|k| seen[*k as usize] += 1);
                }
                Look::Cluster(_) => {}
            }
        }
        assert!(seen.iter().all(|n| *n == 1));
        assert!(looks.len() < 512, "{} looks for 1,024 lamps", looks.len());
    }

    #[test]
    fn clusters_are_not_credited_with_less_than_their_lamps_give() {
        let lamps = field();
        for (x, normal) in [(DVec3::ZERO, DVec3::Z), (DVec3::new(0.4, -0.3, 0.0), DVec3::X)] {
            for cluster in &lamps.clusters {
                let own = lamps.order[cluster.members.clone()].iter().map(|k| &lamps.list[*k as usize]);
                let exact: f64 = own
                    .map(|l| {
                        let d = l.centre - x;
                        l.area * normal.dot(d).max(0.0) * d.z / (PI * d.length_squared().powi(2))
                    })
                    .sum();
                assert!(cluster.most((x, 0.0), normal).is_none_or(|most| most >= exact));
            }
        }
    }

    #[test]
    fn chances_of_a_cluster_sum_to_one() {
        let lamps = field();
        let (x, n) = (DVec3::new(0.3, 0.2, -0.2), DVec3::Z);
        let mut sum = 0.0;
        let mut last = None;
        for i in 0..20_000 {
            let drawn = lamps.draw(3, x, n, (f64::from(i) + 0.5) / 20_000.0);
            let (k, times) = drawn.expect("a lamp in front");
            if last != Some(k) {
                sum += 1.0 / times;
                last = Some(k);
            }
        }
        assert!((sum - 1.0).abs() < 1e-12);
    }
}
