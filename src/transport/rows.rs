//! Rows of the transport matrix, sampled by rays: geometry alone, good for every band.
//!
//! Every element casts a few well-spread rays; each ray lands on another element, which is made if nobody has asked
//! for it before. A few waves close the set. In a closed scene the weights of a row sum to one by construction.

use glam::DVec3;
use rayon::prelude::*;

use super::caster::{Bundle, Ray};
use super::chain::{Fork, Landing, Tint, follow};
use super::daylight::{GROUND, SKY, SUN};
use super::direct::{DirectScratch, add_windows};
use super::optics::Optics;
use super::panels::PANEL_SETS;
use super::places::direct_at_place;
use super::points::{Points, seed};
use super::scatterer::Scatterer;
use super::world::{World, cosine_direction};
use crate::mesh::{ElementKey, Elements};

/// Where a ray of a row ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// On an element.
    Element(u32),
    /// Out of the scene.
    Escaped,
    /// In a mirror maze.
    Lost,
    /// The ray began inside a solid: it does not count.
    Covered,
}

/// Elements whose rays are cast before any of them is entered: what they are called does not depend on it, memory does.
const WAVE: usize = 1 << 13;

const ESCAPED: u32 = u32::MAX;
const LOST: u32 = u32::MAX - 1;
const COVERED: u32 = u32::MAX - 2;

impl Target {
    fn pack(self) -> u32 {
        match self {
            Self::Element(e) => e,
            Self::Escaped => ESCAPED,
            Self::Lost => LOST,
            Self::Covered => COVERED,
        }
    }

    fn unpack(raw: u32) -> Self {
        match raw {
            ESCAPED => Self::Escaped,
            LOST => Self::Lost,
            COVERED => Self::Covered,
            e => Self::Element(e),
        }
    }
}

/// How many rays, and from which seed.
#[derive(Clone, Copy, Debug)]
pub struct RowSettings {
    /// Independent sets of rays.
    pub replicas: usize,
    /// Rays of each set, per element.
    pub rays: usize,
    /// Every how manyth of these starts is lit directly.
    pub lit_every: usize,
    /// Seed.
    pub seed: u64,
    /// Elements are not made beyond this number.
    pub max_elements: usize,
}

/// One independent set of rows: for element `i`, the rays `i · rays .. (i + 1) · rays`.
#[derive(Clone, Debug, Default)]
pub struct Replica {
    targets: Vec<u32>,
    /// What mirrors left of each ray: share and tint; empty without mirrors.
    shares: Vec<(f32, u32)>,
    /// Irradiance per unit exitance from each group: `element · groups + group`.
    pub direct: Vec<f32>,
    /// Light seen by mirrors.
    pub mirrored: Vec<Mirrored>,
    /// Daylight that came by coloured panes: element, and irradiance by band, W/(m² nm), padded.
    pub tinted: Vec<(u32, Vec<f32>)>,
}

/// Light that a ray of an element sees in a mirror.
#[derive(Clone, Copy, Debug)]
pub struct Mirrored {
    /// Element.
    pub element: u32,
    /// Group of light.
    pub group: u32,
    /// What the way leaves of it, and the group's own weight in that direction.
    pub share: f32,
    /// See [`Mirrored::share`].
    pub weight: f32,
    /// Tint of the way.
    pub tint: u32,
    /// Direction in which the ray left the scene; zero where it met an emitter.
    pub direction: [f32; 3],
}

/// The rows of all elements.
#[derive(Clone, Debug)]
pub struct Rows {
    /// Rays of each replica, per element.
    pub rays: usize,
    /// Number of groups of emitters.
    pub groups: usize,
    /// The independent sets.
    pub replicas: Vec<Replica>,
    /// Share of each element's samples that are not covered, over all replicas.
    pub valid: Vec<f32>,
    /// Tints by band, padded; tint 0 means none.
    pub tints: Vec<Vec<f32>>,
    /// Rays cast.
    pub rays_cast: u64,
    /// Exact form factors of emitters worked out.
    pub factors: u64,
    /// Elements that were asked for but not made, for want of memory.
    pub refused: u64,
}

/// One ray of one element, before its target has a number.
struct Sample {
    key: Option<ElementKey>,
    target: Target,
    share: f32,
    tint: Option<Vec<f32>>,
    /// Light seen by mirrors: group, weight and direction out.
    emission: Option<(u32, f32, [f32; 3])>,
}

impl Sample {
    fn covered() -> Self {
        Self { key: None, target: Target::Covered, share: 1.0, tint: None, emission: None }
    }
}

struct Expanded {
    samples: Vec<Sample>,
    /// Samples that say nothing of what is covered: along what passes a window with a BSDF, or not worth a ray.
    unused: usize,
    direct: Vec<f32>,
    rays: u64,
    factors: u64,
}

impl Rows {
    /// Casts the rows of all elements of the mesh, and of all that these ask for.
    #[must_use]
    pub fn expand(world: &World, optics: &Optics, mesh: &mut Elements, settings: &RowSettings) -> Self {
        let groups = world.groups();
        let mut rows = Self {
            rays: settings.rays,
            groups,
            replicas: vec![Replica::default(); settings.replicas],
            valid: Vec::new(),
            tints: vec![vec![1.0; optics.pad]],
            rays_cast: 0,
            factors: 0,
            refused: 0,
        };
        let mut done = 0;
        while done < mesh.len() {
            let to = mesh.len().min(done + WAVE);
            let wave: Vec<Expanded> = (done..to)
                .into_par_iter()
                .with_min_len(16)
                .map_init(|| Worker::new(world, optics, settings), |worker, i| worker.expand(mesh, i))
                .collect();
            for (i, expanded) in (done..to).zip(wave) {
                rows.enter(world, optics, mesh, settings, (i as u32, expanded));
            }
            done = to;
        }
        rows
    }

    fn enter(
        &mut self,
        world: &World,
        optics: &Optics,
        mesh: &mut Elements,
        settings: &RowSettings,
        (i, e): (u32, Expanded),
    ) {
        self.rays_cast += e.rays;
        self.factors += e.factors;
        let mut covered = 0;
        for (k, s) in e.samples.iter().enumerate() {
            let tint = match &s.tint {
                Some(t) => {
                    self.tints.push(t.clone());
                    self.tints.len() as u32 - 1
                }
                None => 0,
            };
            let mut target = s.target;
            if let Some(key) = s.key {
                let mut id = mesh.find(key);
                if id == crate::mesh::NO_ELEMENT && mesh.len() < settings.max_elements {
                    id = mesh.make(&world.surfaces, key);
                }
                target = if id == crate::mesh::NO_ELEMENT { Target::Lost } else { Target::Element(id) };
                self.refused += u64::from(id == crate::mesh::NO_ELEMENT);
            }
            covered += usize::from(target == Target::Covered);
            let replica = &mut self.replicas[k / settings.rays];
            replica.targets.push(target.pack());
            if world.has_specular() {
                replica.shares.push((s.share, tint));
            }
            if let Some((group, weight, direction)) = s.emission {
                replica.mirrored.push(Mirrored { element: i, group, share: s.share, weight, tint, direction });
            }
        }
        let (key, surface) = (mesh.list()[i as usize].key, mesh.list()[i as usize].surface);
        if world.is_translucent(surface) {
            // What one side receives leaves the other: neither can be without its twin.
            mesh.make(&world.surfaces, key.other_side());
        }
        let stays = world.scatterer(surface).map_or(1.0, |s| s.stays(mesh.list()[i as usize].front) as f32);
        self.valid.push(stays * (1.0 - (covered - e.unused) as f32 / (e.samples.len() - e.unused).max(1) as f32));
        for (r, d) in self.replicas.iter_mut().zip(e.direct.chunks_exact(optics.columns().max(1))) {
            r.direct.extend_from_slice(&d[..self.groups]);
            if let Some(irradiance) = optics.tinted_irradiance(&d[self.groups..]) {
                r.tinted.push((i, irradiance));
            }
        }
    }

    /// Bytes that the rows of an element take with so many rays in all.
    #[must_use]
    pub fn bytes_per_element(replicas: usize, rays: usize, groups: usize, specular: bool) -> usize {
        let per_ray = size_of::<u32>() + if specular { size_of::<(f32, u32)>() } else { 0 };
        rays * per_ray + replicas * groups * size_of::<f32>() + size_of::<f32>()
    }

    /// Bytes that rays take before they are entered.
    #[must_use]
    pub fn bytes_of_a_wave(rays: usize) -> usize {
        WAVE * (rays * size_of::<Sample>() + size_of::<Expanded>())
    }

    /// The rays of one element in one replica: target, share, tint.
    pub fn row(&self, replica: usize, element: usize) -> impl Iterator<Item = (Target, f32, u32)> + '_ {
        let r = &self.replicas[replica];
        (element * self.rays..(element + 1) * self.rays).map(|k| {
            let (share, tint) = r.shares.get(k).copied().unwrap_or((1.0, 0));
            (Target::unpack(r.targets[k]), share, tint)
        })
    }
}

/// The points of an element's rays in one replica.
struct Set {
    stream: u64,
    points: Points,
    /// Number of the first.
    first: u32,
    /// Which of the rays looks at the sky.
    turn: usize,
}

impl Set {
    /// Neighbours take neighbouring stretches of one sequence: together their rays are as well spread as one element's, and
    /// their errors cancel where a sensor sees many of them.
    fn new(settings: &RowSettings, (family, replica): (u64, usize), morton: u32, used: usize) -> Self {
        let stream = seed(&[settings.seed, family, replica as u64]);
        // Points of one number modulo the rays lie on one side of every element: neighbours take turns.
        let turn = (stream as u32).wrapping_add(morton.wrapping_mul(3)) as usize % settings.rays;
        let first = morton.wrapping_mul(settings.rays as u32).wrapping_add((turn - turn % used) as u32);
        Self { stream, points: Points::new(stream), first, turn: turn % used }
    }
}

/// Buffers of one thread.
struct Worker<'a> {
    world: &'a World,
    optics: &'a Optics,
    settings: &'a RowSettings,
    scratch: DirectScratch,
    tint: Tint,
    bundle: Bundle,
    factors: Vec<f64>,
}

impl<'a> Worker<'a> {
    fn new(world: &'a World, optics: &'a Optics, settings: &'a RowSettings) -> Self {
        Self {
            world,
            optics,
            settings,
            scratch: DirectScratch::default().in_bands(optics),
            tint: Tint::new(optics.pad),
            bundle: Bundle::default(),
            factors: vec![0.0; optics.columns()],
        }
    }

    fn expand(&mut self, mesh: &Elements, index: usize) -> Expanded {
        let element = &mesh.list()[index];
        let surface = &self.world.surfaces.list[element.surface as usize];
        let normal = surface.side_normal(element.front);
        let columns = self.optics.columns();
        let (replicas, rays) = (self.settings.replicas, self.settings.rays);
        let mut out = Expanded {
            samples: Vec::with_capacity(replicas * rays),
            unused: 0,
            direct: vec![0.0; replicas * columns.max(1)],
            rays: 0,
            factors: 0,
        };
        let mut counted = vec![0u32; replicas];
        let (mut suns, mut skies) = (vec![0u32; replicas], vec![0u32; replicas]);
        let (rays_before, factors_before) = (self.scratch.rays, self.scratch.factors);
        // What is worth less than an element is worth fewer rays, and what is worth fewer elements fewer places.
        let used = ((rays as f64 * mesh.worth(element)).ceil() as usize).next_power_of_two().min(rays);
        let lit_every = (self.settings.lit_every * mesh.block_side(element.key) as usize).min(used);
        let outline: Vec<DVec3> = element.outline.iter().map(|uv| surface.point(*uv)).collect();
        let scatterer = self.world.scatterer(element.surface);
        self.scratch.receiver = scatterer.map(|_| (element.surface, element.front));
        self.scratch.within(self.world, &outline, normal, lit_every, used);
        let (morton, family) = (mesh.morton(element), element.key.family());
        let sets: Vec<Set> = (0..replicas).map(|r| Set::new(self.settings, (family, r), morton, used)).collect();
        self.bundle.rays.clear();
        for set in &sets {
            self.bundle.rays.extend((0..used as u32).map(|k| {
                let (a, b) = set.points.pair(set.first.wrapping_add(k), 0);
                let (c, d) = set.points.pair(set.first.wrapping_add(k), 2);
                let start = self.world.lift(element.sample(surface, a, b), normal);
                Ray::new(start, cosine_direction(normal, c, d))
            }));
        }
        self.bundle.cast(&self.world.caster);
        out.rays += (replicas * used) as u64;
        let mut through = vec![0.0; columns];
        for (r, Set { stream, points, first, turn }) in sets.into_iter().enumerate() {
            through.fill(0.0);
            self.scratch.set = r % PANEL_SETS;
            for k in 0..used {
                let number = first.wrapping_add(k as u32);
                let ray = self.bundle.rays[r * used + k];
                let along = ray.along();
                // What passes is no light of the element's own.
                let passes = |s: &Scatterer| points.get(number, 5) < s.passed(surface, element.front, along);
                let sample = if scatterer.is_some_and(passes) {
                    out.unused += 1;
                    Sample::covered()
                } else {
                    self.sample(mesh, r * used + k, points.get(number, 4), &mut out.rays)
                };
                if sample.target != Target::Covered && !self.world.glowing() {
                    counted[r] += 1;
                    self.factors.fill(0.0);
                    let x = ray.at(0.0);
                    let shadow = seed(&[stream, u64::from(first), 1 + k as u64]);
                    // Sky and ground change slowly across an element: one place in each set is enough.
                    let sky = skies[r] == 0 && k >= turn;
                    let sun = sky || (k + turn).is_multiple_of(lit_every);
                    skies[r] += u32::from(sky);
                    suns[r] += u32::from(sun);
                    let place = ((x, normal), k + turn);
                    let (scratch, factors) = (&mut self.scratch, &mut self.factors);
                    direct_at_place(self.world, place.0, place.1, shadow, (sky, sun), scratch, factors);
                    if sky {
                        add_windows(self.world, place.0, shadow, false, scratch, &mut through);
                    }
                    for (sum, f) in out.direct[r * columns..].iter_mut().zip(&self.factors) {
                        *sum += *f as f32;
                    }
                }
                out.samples.push(sample);
            }
            out.unused += rays - used;
            out.samples.extend((used..rays).map(|_| Sample::covered()));
            if counted[r] > 0 {
                // The mean over the element's samples, of which some may be covered, takes in all that arrives.
                let (times, sample) = (used as f64, seed(&[stream, u64::from(first)]));
                let to = &mut out.direct[r * columns..];
                self.scratch.add_close(self.world, (&outline, element.area), normal, (times, sample), to);
            }
            // What windows with a BSDF send is looked at from one place in each set, the sun's light too.
            for (column, light) in through.iter().enumerate().filter(|(_, light)| **light > 0.0) {
                let places = if self.optics.daylight_of(column) == Some(SUN) { suns[r] } else { skies[r] };
                out.direct[r * columns + column] += (light * f64::from(places)) as f32;
            }
        }
        average_direct(&mut out.direct, columns, |column| match self.optics.daylight_of(column) {
            Some(SKY | GROUND) => &skies,
            Some(_) => &suns,
            None => &counted,
        });
        out.rays += self.scratch.rays - rays_before;
        out.factors = self.scratch.factors - factors_before;
        out
    }

    fn sample(&mut self, mesh: &Elements, k: usize, choice: f64, rays: &mut u64) -> Sample {
        self.tint.reset();
        let (ray, hit) = (self.bundle.rays[k], self.bundle.hits[k]);
        let landing = follow(self.world, self.optics, ray, hit, Fork::Chance(choice), &mut self.tint, rays);
        let mut sample = Sample {
            key: None,
            target: Target::Escaped,
            share: self.tint.scale,
            tint: self.tint.coloured.then(|| self.tint.bands.clone()),
            emission: None,
        };
        match landing {
            Landing::Surface { surface, front, point, mirrored, .. } => {
                let uv = self.world.surfaces.list[surface as usize].uv(point);
                sample.key = Some(mesh.key_at(surface as usize, front, uv));
                if mirrored && !self.world.glowing() {
                    sample.emission = self.world.group(surface, front).map(|g| (g as u32, 1.0, [0.0; 3]));
                }
            }
            Landing::Escaped { direction, mirrored } if mirrored => {
                let light = self.world.background(direction);
                sample.emission = light.map(|(g, weight)| (g as u32, weight as f32, direction.as_vec3().to_array()));
            }
            Landing::Escaped { .. } | Landing::Scattered { .. } => {}
            Landing::Covered => sample.target = Target::Covered,
            Landing::Lost => sample.target = Target::Lost,
        }
        sample
    }
}

/// Sums to means, column by column; a replica none of whose samples count takes the mean of the others.
fn average_direct<'a>(direct: &mut [f32], columns: usize, counted: impl Fn(usize) -> &'a [u32]) {
    for g in 0..columns {
        let counted = counted(g);
        let all: u32 = counted.iter().sum();
        let total: f32 = (0..counted.len()).map(|r| direct[r * columns + g]).sum();
        for (r, n) in counted.iter().enumerate() {
            let d = &mut direct[r * columns + g];
            *d = if *n > 0 { *d / *n as f32 } else { total / all.max(1) as f32 };
        }
    }
}
