//! The final gather: what a point receives, from the radiosities of what its rays meet.
//!
//! Direct light is exact and apart. A ray that lands far away reads the element it lands on, in all replicas of the
//! solution at once; a ray that lands nearer than an element is wide does not trust the element's mean and goes on
//! from there as a path, with exact direct light at every vertex. A landing on an element that was never made is
//! treated the same way, so that no value is ever made up.

use glam::DVec3;

use super::receiver::Facing;
use super::solved::{Solved, dot};
use crate::mesh::NO_ELEMENT;
use crate::transport::caster::{Bundle, Hit, MISS, Ray};
use crate::transport::points::{Points, seed};
use crate::transport::{
    DirectScratch, Fork, Landing, Optics, PANEL_SETS, Tint, World, chance_weight, cosine_direction, deposit, direct,
    direct_at_vertex, follow, through_panes,
};
use crate::vector::wide;

/// Independent ray sets, and independent solutions to look up.
pub(super) const REPLICAS: usize = 4;
/// Longest path of near hits.
const MAX_BOUNCES: u32 = 64;
/// A path this weak is ended or strengthened by chance.
const ROULETTE: f32 = 0.05;
/// Rays cast together.
const BATCH: usize = 256;
/// Every so many rays the squares of all bands are summed as well.
const SQUARES_EVERY: u32 = 4;

/// Everything a gather reads.
#[derive(Debug)]
pub(super) struct Field<'a> {
    pub(super) world: &'a World,
    pub(super) optics: &'a Optics,
    pub(super) main: &'a Solved,
    pub(super) twin: Option<&'a Solved>,
    /// Keep every band, or XYZ alone.
    pub(super) spectral: bool,
    /// Sum the squares of the bands too, for the error of each.
    pub(super) squares: bool,
}

/// Sums over the rays of one set, not yet divided by their number.
#[derive(Clone, Debug)]
pub(super) struct SetSums {
    /// Rays that count.
    pub(super) rays: u32,
    /// `[replica][band]`, main and twin.
    main: Vec<f32>,
    twin: Vec<f32>,
    /// Direct light at path vertices, and emission in mirrors: the same for all replicas.
    shared: Vec<f32>,
    main_xyz: Vec<f32>,
    twin_xyz: Vec<f32>,
    /// Sums of squares of the mean over replicas: Y for every ray, the products of every two channels; bands for every
    /// fourth.
    square_y: Vec<f64>,
    /// Over the rays of which the squares were summed: their number, sum of Y, of its squares, of its cubes.
    powers_y: [f64; 4],
    square_bands: Vec<f64>,
    squared: u32,
    /// Y by channel of rays that saw the sky in a mirror first, and of those that met the ground there or an outside surface
    /// first.
    seen_sky_y: Vec<f64>,
    external_y: Vec<f64>,
}

impl SetSums {
    /// Sums of nothing, for a number of solutions, with room for a twin where one is looked up.
    pub(super) fn new(optics: &Optics, replicas: usize, twin: bool) -> Self {
        let (pad, channels) = (optics.pad, optics.channels());
        let of_twin = if twin { replicas } else { 0 };
        Self {
            rays: 0,
            main: vec![0.0; replicas * pad],
            twin: vec![0.0; of_twin * pad],
            shared: vec![0.0; pad],
            main_xyz: vec![0.0; 4 * replicas * channels],
            twin_xyz: vec![0.0; 4 * of_twin * channels],
            square_y: vec![0.0; channels * channels],
            powers_y: [0.0; 4],
            square_bands: vec![0.0; pad],
            squared: 0,
            seen_sky_y: vec![0.0; channels],
            external_y: vec![0.0; channels],
        }
    }

    /// Mean over the rays in one band, all channels together.
    pub(super) fn band(&self, replica: usize, band: usize, optics: &Optics, twin: bool) -> f64 {
        let values = if twin { &self.twin } else { &self.main };
        let in_lane = |lane: usize| f64::from(values[replica * optics.pad + lane]) + f64::from(self.shared[lane]);
        optics.lanes(band).map(in_lane).sum::<f64>() / f64::from(self.rays.max(1))
    }

    /// Means over the rays, band by band of every channel.
    pub(super) fn bands(&self, replica: usize, pad: usize, twin: bool) -> impl Iterator<Item = f64> + '_ {
        let n = f64::from(self.rays.max(1));
        let values = if twin { &self.twin } else { &self.main };
        values[replica * pad..(replica + 1) * pad]
            .iter()
            .zip(&self.shared)
            .map(move |(v, s)| (f64::from(*v) + f64::from(*s)) / n)
    }

    /// Mean XYZ over the rays, of main or twin, with a level for each channel.
    pub(super) fn xyz(&self, replica: usize, optics: &Optics, levels: &[f64], twin: bool) -> [f64; 3] {
        let far = if twin { &self.twin_xyz } else { &self.main_xyz };
        let n = f64::from(self.rays.max(1));
        let of_replica = &far[replica * 4 * levels.len()..(replica + 1) * 4 * levels.len()];
        let mut xyz = [0.0; 3];
        for (values, level) in of_replica.chunks_exact(4).zip(levels) {
            xyz.iter_mut().zip(values).for_each(|(sum, v)| *sum += level * f64::from(*v) / n);
        }
        let bands = optics.bands.len();
        for (lane, value) in self.bands(replica, optics.pad, twin).enumerate().take(bands * levels.len()) {
            for (sum, w) in xyz.iter_mut().zip(&optics.xyz) {
                *sum += levels[lane / bands] * value * f64::from(w[lane]);
            }
        }
        xyz
    }

    /// Illuminance by way of the sky in mirrors, and by what lies outside, before any other reflection; with a level for
    /// each channel.
    pub(super) fn outside_y(&self, levels: &[f64]) -> (f64, f64) {
        let n = f64::from(self.rays.max(1));
        let sum = |by_channel: &[f64]| by_channel.iter().zip(levels).map(|(y, level)| level * y).sum::<f64>() / n;
        (sum(&self.seen_sky_y), sum(&self.external_y))
    }

    /// Mean square of a ray's Y, with a level for each channel.
    pub(super) fn mean_square_y(&self, levels: &[f64]) -> f64 {
        let rows = self.square_y.chunks_exact(levels.len()).zip(levels);
        let sum: f64 = rows.map(|(row, a)| a * row.iter().zip(levels).map(|(s, b)| s * b).sum::<f64>()).sum();
        sum / f64::from(self.rays.max(1))
    }

    /// Variance of a ray's Y, all channels together, from the rays of which the squares were summed.
    pub(super) fn variance_y(&self) -> f64 {
        let [count, sum, squares, _] = self.powers_y;
        (squares / count.max(1.0) - (sum / count.max(1.0)).powi(2)).max(0.0)
    }

    /// Square of the skewness of Y, all channels together, of one ray of these sets.
    pub(super) fn square_of_skewness(sets: &[Self]) -> f64 {
        let total = |power: usize| sets.iter().map(|s| s.powers_y[power]).sum::<f64>();
        let count = total(0).max(1.0);
        let [mean, square, cube] = [1, 2, 3].map(|power| total(power) / count);
        let variance = square - mean * mean;
        let third = cube - 3.0 * mean * square + 2.0 * mean.powi(3);
        // A spread of rounding alone has no skewness.
        if variance > 1e-12 * square { third * third / variance.powi(3) } else { 0.0 }
    }

    /// Mean square of a ray's value in a band, all channels together.
    pub(super) fn mean_square(&self, band: usize) -> f64 {
        self.square_bands[band] / f64::from(self.squared.max(1))
    }
}

/// Buffers of one thread, and what was done with them.
#[derive(Debug)]
pub(super) struct Gatherer<'a> {
    field: &'a Field<'a>,
    pub(super) scratch: DirectScratch,
    tint: Tint,
    throughput: Vec<f32>,
    value: Vec<f32>,
    /// Y of one ray, by channel.
    eye: Vec<f32>,
    factors: Vec<f64>,
    bundle: Bundle,
    pub(super) cast: u64,
    /// Sum of the inverse distances to what the first rays met, in the program's frame.
    pub(super) nearness: f64,
    /// Distance from which on a first landing may read its element, in the program's frame.
    pub(super) trust: f64,
    /// Rays of which the first landing was too near to trust the element.
    pub(super) near: u64,
    /// What the ray met first.
    first: First,
    /// Places and directions of daylight, with what the way to them leaves in every band: kept apart where this is asked
    /// for.
    found: Option<Vec<(Found, Vec<f32>)>>,
}

/// Light of the day that a ray found on its way, told apart by direction: in place of its sum ([`Gatherer::found`]).
#[derive(Clone, Copy, Debug)]
pub(super) enum Found {
    /// A vertex of a path: what it sees of the sky counts; and the side of a window with a BSDF where it lies.
    Vertex { position: DVec3, normal: DVec3, receiver: Option<(u32, bool)> },
    /// Sky or ground seen in a mirror, in this direction: by the first ray?
    Mirrored { direction: DVec3, is_first: bool },
}

/// What a ray met first, behind mirrors and panes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum First {
    Inside,
    Sky,
    External,
}

/// Where a ray's light is looked up at last.
enum End {
    Element { main: u32, twin: u32 },
    Dark,
    Covered,
}

impl<'a> Gatherer<'a> {
    pub(super) fn new(field: &'a Field<'a>) -> Self {
        let pad = field.optics.pad;
        Self {
            field,
            scratch: DirectScratch::default().in_bands(field.optics),
            tint: Tint::new(pad),
            throughput: vec![1.0; pad],
            value: vec![0.0; pad],
            eye: vec![0.0; field.optics.channels()],
            factors: vec![0.0; field.optics.columns()],
            bundle: Bundle::default(),
            cast: 0,
            nearness: 0.0,
            trust: field.main.mesh.size,
            near: 0,
            first: First::Inside,
            found: None,
        }
    }

    /// A gatherer that keeps daylight apart by direction, for [`Gatherer::record`].
    pub(super) fn recording(field: &'a Field<'a>) -> Self {
        Self { found: Some(Vec::new()), ..Self::new(field) }
    }

    /// Factors of direct light ([`Optics::columns`]), apart from what the gather rays bring.
    pub(super) fn direct(&mut self, x: DVec3, normal: DVec3, sample: u64) -> Vec<f64> {
        let mut out = vec![0.0; self.field.optics.columns()];
        if !self.field.world.glowing() {
            direct(self.field.world, x, normal, sample, &mut self.scratch, &mut out);
        }
        out
    }

    /// Adds the rays `from..to` of a set to its sums.
    pub(super) fn gather(&mut self, x: DVec3, facing: Facing, stream: u64, range: (u32, u32), sums: &mut SetSums) {
        self.each(x, facing, stream, range, |own, k, end, plain| own.sum(k, end, plain, sums));
    }

    /// Tells `visit` of each ray of a set where its light is read (element, element of the twin), what the way leaves in
    /// every band (`None`: all), and the daylight found on it. Returns the number of rays that count.
    pub(super) fn record(
        &mut self,
        x: DVec3,
        normal: DVec3,
        stream: u64,
        count: u32,
        mut visit: impl FnMut(Option<(u32, u32)>, Option<&[f32]>, &[(Found, Vec<f32>)]),
    ) -> u32 {
        let mut rays = 0;
        self.each(x, normal.into(), stream, (0, count), |own, _, end, plain| {
            let found = own.found.take().unwrap_or_default();
            let read = match end {
                End::Covered => None,
                End::Dark => Some(None),
                End::Element { main, twin } => Some(Some((main, twin))),
            };
            if let Some(read) = read {
                rays += 1;
                visit(read, (!plain).then_some(&own.throughput), &found);
            }
            own.found = Some(found);
        });
        rays
    }

    fn each(
        &mut self,
        x: DVec3,
        facing: Facing,
        stream: u64,
        range: (u32, u32),
        mut visit: impl FnMut(&mut Self, u32, End, bool),
    ) {
        let points = Points::new(stream);
        let mut from = range.0;
        while from < range.1 {
            let to = (from + BATCH as u32).min(range.1);
            let mut bundle = std::mem::take(&mut self.bundle);
            bundle.rays.clear();
            bundle.rays.extend((from..to).map(|k| {
                let (a, b) = points.pair(k, 0);
                Ray::new(x, facing.direction(a, b))
            }));
            bundle.cast(&self.field.world.caster);
            self.cast += bundle.rays.len() as u64;
            let met = bundle.hits.iter().filter(|h| h.surface != MISS && h.t > 0.0);
            self.nearness += met.map(|h| 1.0 / f64::from(h.t)).sum::<f64>();
            for (i, (ray, hit)) in bundle.rays.iter().zip(&bundle.hits).enumerate() {
                let k = from + i as u32;
                let (end, plain) = self.trace(*ray, *hit, &points, k, stream);
                visit(self, k, end, plain);
            }
            self.bundle = bundle;
            from = to;
        }
    }

    fn sum(&mut self, k: u32, end: End, plain: bool, sums: &mut SetSums) {
        let wants_squares = self.field.spectral && k.is_multiple_of(SQUARES_EVERY);
        if plain && wants_squares {
            self.value.fill(0.0);
        }
        if matches!(end, End::Covered) {
            return;
        }
        sums.rays += 1;
        let channels = self.field.optics.channels();
        self.eye.fill(0.0);
        if !plain {
            for (s, v) in sums.shared.iter_mut().zip(&self.value) {
                *s += v;
            }
        }
        if let End::Element { main, twin } = end {
            let field = self.field;
            let other = field.twin.unwrap_or(field.main);
            let (main, twin, twin_of) = if twin == NO_ELEMENT { (main, main, field.main) } else { (main, twin, other) };
            if plain && !field.spectral {
                let values = field.main.xyz(main);
                add(&mut sums.main_xyz, values);
                add(&mut sums.twin_xyz, twin_of.xyz(twin));
                let replicas = (values.len() / (4 * channels)) as f32;
                for (channel, y) in self.eye.iter_mut().enumerate() {
                    *y += values.chunks_exact(4).skip(channel).step_by(channels).map(|v| v[1]).sum::<f32>() / replicas;
                }
            } else if plain {
                let values = field.main.solution.of(main);
                add(&mut sums.main, values);
                add(&mut sums.twin, twin_of.solution.of(twin));
                self.add_mean(values, wants_squares);
            } else {
                let values = field.main.solution.of(main);
                add_weighted(&mut sums.main, values, &self.throughput);
                add_weighted(&mut sums.twin, twin_of.solution.of(twin), &self.throughput);
                self.add_weighted_mean(values);
            }
        }
        if !plain || wants_squares {
            for (y, eye) in self.eye.iter_mut().zip(&self.field.optics.eyes) {
                *y += dot(&self.value, &eye[1]);
            }
        }
        let add_y = |sums: &mut [f64]| sums.iter_mut().zip(&self.eye).for_each(|(sum, y)| *sum += f64::from(*y));
        match self.first {
            First::Inside => {}
            First::Sky => add_y(&mut sums.seen_sky_y),
            First::External => add_y(&mut sums.external_y),
        }
        if self.field.spectral && !wants_squares {
            return;
        }
        let times = if self.field.spectral { f64::from(SQUARES_EVERY) } else { 1.0 };
        for (row, a) in sums.square_y.chunks_exact_mut(channels).zip(&self.eye) {
            row.iter_mut().zip(&self.eye).for_each(|(s, b)| *s += f64::from(*a) * f64::from(*b) * times);
        }
        let y = self.eye.iter().map(|y| f64::from(*y)).sum::<f64>();
        sums.powers_y.iter_mut().zip([1.0, y, y * y, y * y * y]).for_each(|(sum, power)| *sum += power);
        if self.field.spectral && self.field.squares {
            sums.squared += 1;
            for (band, s) in sums.square_bands.iter_mut().take(self.field.optics.bands.len()).enumerate() {
                let value: f64 = self.field.optics.lanes(band).map(|lane| f64::from(self.value[lane])).sum();
                *s += value * value;
            }
        }
    }

    fn add_mean(&mut self, values: &[f32], wanted: bool) {
        if wanted {
            let share = self.value.len() as f32 / values.len() as f32;
            for replica in values.chunks_exact(self.value.len()) {
                self.value.iter_mut().zip(replica).for_each(|(s, v)| *s += v * share);
            }
        }
    }

    fn add_weighted_mean(&mut self, values: &[f32]) {
        let share = self.value.len() as f32 / values.len() as f32;
        for replica in values.chunks_exact(self.value.len()) {
            for ((s, v), t) in self.value.iter_mut().zip(replica).zip(&self.throughput) {
                *s += v * t * share;
            }
        }
    }

    /// Follows a ray to where its light can be read. `true`: nothing was taken from it on the way and nothing added.
    fn trace(&mut self, mut ray: Ray, mut hit: Hit, points: &Points, k: u32, stream: u64) -> (End, bool) {
        let field = self.field;
        let (world, optics) = (field.world, field.optics);
        let mut plain = true;
        let mut vertex = None;
        self.first = First::Inside;
        if let Some(found) = &mut self.found {
            found.clear();
        }
        for bounce in 0..MAX_BOUNCES {
            self.tint.reset();
            let choice = if world.has_glass() || world.has_bsdf() { points.get(k, 4 * bounce + 4) } else { 0.5 };
            let landing = follow(world, optics, ray, hit, Fork::Chance(choice), &mut self.tint, &mut self.cast);
            let (surface, front, point, distance, mirrored) = match landing {
                Landing::Surface { surface, front, point, distance, mirrored } => {
                    (surface, front, point, distance, mirrored)
                }
                // Only the first ray can tell that the point itself is covered; later ones slipped under an edge.
                Landing::Covered if bounce == 0 => return (End::Covered, true),
                Landing::Escaped { direction, mirrored } => {
                    let weight = match vertex {
                        _ if mirrored => 1.0,
                        // All that a vertex sees is kept apart.
                        Some(_) if self.found.is_some() => return (End::Dark, plain),
                        // The start of all has its exact direct light already.
                        None => return (End::Dark, plain),
                        Some(vertex) => chance_weight(world, vertex, direction),
                    };
                    self.dim(&mut plain);
                    self.add_background(direction, weight, bounce == 0, &mut plain);
                    return (End::Dark, plain);
                }
                _ => return (End::Dark, plain),
            };
            self.dim(&mut plain);
            if bounce == 0 && world.is_outside(surface) {
                self.first = First::External;
                self.spoil(&mut plain); // so that its own Y is known
            }
            let glowing = world.glowing();
            if mirrored && !glowing {
                self.add_emission(surface, front, &mut plain);
            }
            let s = &world.surfaces.list[surface as usize];
            let uv = s.uv(point);
            let key = field.main.mesh.key_at(surface as usize, front, uv);
            let element = field.main.mesh.find(key);
            let trust = if bounce == 0 { self.trust } else { field.main.mesh.size };
            if distance >= trust * field.main.mesh.block_side(key) && element != NO_ELEMENT {
                let twin = field.twin.map_or(NO_ELEMENT, |t| t.mesh.find(t.mesh.key_at(surface as usize, front, uv)));
                return (End::Element { main: element, twin }, plain);
            }
            self.near += u64::from(bounce == 0);
            self.spoil(&mut plain);
            if glowing {
                self.add_emission(surface, front, &mut plain);
            }
            let mut chance = points.get(k, 4 * bounce + 5);
            let scatter = optics.scatter(s.material, front, &mut chance);
            let mut strongest = 0.0f32;
            for (t, share) in self.throughput.iter_mut().zip(scatter.shares) {
                *t *= share / scatter.odds;
                strongest = if *t > strongest { *t } else { strongest };
            }
            if strongest < ROULETTE {
                // Same expected value, fewer hopeless paths.
                let survival = strongest / ROULETTE;
                if chance >= f64::from(survival) {
                    return (End::Dark, plain);
                }
                self.throughput.iter_mut().for_each(|t| *t /= survival);
            }
            let normal = s.side_normal(front != scatter.passes);
            let x = world.lift(s.point(uv), normal);
            let scatterer = world.scatterer(surface);
            if self.found.is_some() {
                let receiver = scatterer.map(|_| (surface, front));
                self.keep(Found::Vertex { position: x, normal, receiver });
                vertex = Some((x, normal));
            } else if !glowing {
                self.factors.fill(0.0);
                let shadow = seed(&[stream, u64::from(k), u64::from(bounce)]);
                self.scratch.set = k as usize % PANEL_SETS;
                self.scratch.receiver = scatterer.map(|_| (surface, front));
                direct_at_vertex(world, (x, normal), shadow, &mut self.scratch, &mut self.factors);
                // A window with a BSDF knows its sky already.
                vertex = None;
                if scatterer.is_none() {
                    // One ray is enough of the sky: the vertex is one of many.
                    let place =
                        (points.get(k, 4 * bounce + 6), points.get(k, 4 * bounce + 7), points.get(k, 4 * bounce + 8));
                    self.tint.reset();
                    let (panes, tint) = (&optics.speculars, &mut self.tint);
                    if let Some((group, factor)) = through_panes(world, panes, (x, normal), place, tint, &mut self.cast)
                    {
                        deposit(&mut self.factors[optics.lamps..], group - optics.lamps, factor, tint);
                    }
                    vertex = Some((x, normal));
                }
                for (band, (sum, t)) in self.value.iter_mut().zip(&self.throughput).enumerate() {
                    *sum += t * optics.direct_in_band(&self.factors, band) as f32;
                }
            }
            let (a, b) = points.pair(k, 4 * bounce + 2);
            ray = Ray::new(x, cosine_direction(normal, a, b));
            if let Some(scatterer) = scatterer {
                let kept = scatterer.keeps(s, front, -ray.along()) as f32;
                self.throughput.iter_mut().for_each(|t| *t *= kept);
            }
            hit = world.caster.closest(&ray);
            self.cast += 1;
        }
        (End::Dark, plain)
    }

    /// Takes what mirrors and panes took.
    fn dim(&mut self, plain: &mut bool) {
        if self.tint.scale != 1.0 || self.tint.coloured {
            self.spoil(plain);
            for (band, t) in self.throughput.iter_mut().enumerate() {
                *t *= self.tint.share(band);
            }
        }
    }

    /// Adds sky or ground as the ray sees them.
    fn add_background(&mut self, direction: DVec3, weight: f64, is_first: bool, plain: &mut bool) {
        let Some((group, light)) = self.field.world.background(direction) else { return };
        if is_first {
            self.first = if direction.z < 0.0 { First::External } else { First::Sky };
        }
        self.spoil(plain);
        if self.found.is_some() {
            self.keep(Found::Mirrored { direction, is_first });
            return;
        }
        add_product(&mut self.value, &self.field.optics.exitance[group], &self.throughput, (weight * light) as f32);
    }

    fn keep(&mut self, what: Found) {
        let left = self.throughput.clone();
        if let Some(found) = &mut self.found {
            found.push((what, left));
        }
    }

    /// Adds what the surface emits.
    fn add_emission(&mut self, surface: u32, front: bool, plain: &mut bool) {
        if let Some(group) = self.field.world.group(surface, front) {
            self.spoil(plain);
            add_product(&mut self.value, &self.field.optics.exitance[group], &self.throughput, 1.0);
        }
    }

    /// From here on the ray carries a spectrum of its own.
    fn spoil(&mut self, plain: &mut bool) {
        if *plain {
            *plain = false;
            self.throughput.fill(1.0);
            self.value.fill(0.0);
        }
    }
}

wide! {
    fn add(sums: &mut [f32], values: &[f32]) {
        for (s, v) in sums.iter_mut().zip(values) {
            *s += v;
        }
    }
}

wide! {
    fn add_weighted(sums: &mut [f32], values: &[f32], weights: &[f32]) {
        let pad = weights.len();
        for (sums, values) in sums.chunks_exact_mut(pad).zip(values.chunks_exact(pad)) {
            for ((s, v), w) in sums.iter_mut().zip(values).zip(weights) {
                *s += v * w;
            }
        }
    }
}

#[inline]
fn add_product(sums: &mut [f32], a: &[f32], b: &[f32], factor: f32) {
    for ((s, x), y) in sums.iter_mut().zip(a).zip(b) {
        *s += x * y * factor;
    }
}
