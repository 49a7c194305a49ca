//! The tolerance loop: solve, judge every sensor, refine what its error blames, and only that.

use std::time::Instant;

use glam::DVec2;
use rayon::prelude::*;

use super::gather::{Field, Gatherer, REPLICAS, SetSums, Solved};
use super::options::{Progress, SolveOptions};
use super::probe::Probe;
use super::receiver::Facing;
use super::result::Status;
use super::statement::{Memory, Readings, Stated, state};
use super::states::Channels;
use crate::error::Result;
use crate::mesh::{ElementKey, Elements, Importance};
use crate::scene::{Grid, Scene};
use crate::solve;
use crate::transport::caster::Ray;
use crate::transport::points::{Points, seed};
use crate::transport::{DirectScratch, Fork, Landing, LightPart, Optics, RowSettings, Rows, Tint, World, follow};

/// Rays of an element, over all replicas: refined by size, never by more rays.
const ROW_RAYS: usize = 32;
/// Rays of a sensor that tell how far it sees, at most.
const DEMAND_RAYS: u32 = 64;
/// Walks that tell what is important, for each cell of the first mesh; at least; at most; and reflections of one.
const WALKS_A_CELL: f64 = 8.0;
const FEWEST_WALKS: usize = 4096;
const MOST_WALKS: usize = 1 << 18;
const MAX_REFLECTIONS: u32 = 16;
/// Tolerance from which half the places on an element tell its direct light well enough.
const ROUGH: f64 = 0.1;
/// Rounds after which what does not hold is told instead.
const MAX_ROUNDS: usize = 10;
/// Rays of one set of one sensor, at most.
const MAX_SET_RAYS: u32 = 1 << 16;
/// How much further the rays of a sensor go on as paths when its elements hide too much, and how many more it takes.
const FURTHER: f64 = 4.0;
const PATHS_WANT: f64 = 2.0;
/// Elements of a mesh, at most; and beyond this number none is refined: what does not hold then is told.
const MAX_ELEMENTS: usize = 2_000_000;
const REFINED_ELEMENTS: usize = 200_000;
/// Share of a grid's sensors that must hold.
pub(super) const HOLD: f64 = 0.95;

/// Where random numbers are used, so that no two uses share a stream.
pub(super) mod stream {
    pub(in crate::measure) const SENSOR: u64 = 1;
    pub(super) const ROWS: u64 = 2;
    pub(super) const TWIN: u64 = 3;
    pub(super) const SHADOW: u64 = 4;
    pub(super) const WALK: u64 = 7;
    pub(in crate::measure) const PATCHES: u64 = 8;
}

/// One sensor on its way to the tolerance.
#[derive(Debug)]
pub(super) struct SensorState {
    pub(super) probe: Probe,
    /// Direct irradiance per unit exitance: by set (one entry where it is exact), by group.
    direct: Vec<Vec<f64>>,
    sums: Vec<SetSums>,
    /// Rays of each set.
    pub(super) done: u32,
    wanted: u32,
    /// Distance within which its rays go on as paths, in the program's frame; never less than an element's size.
    pub(super) near: f64,
    /// Gather rays bring emission too; `direct` is for the report alone.
    glowing: bool,
    /// Illuminance of the scene as it stands, and what is stated of it.
    pub(super) light: Light,
    pub(super) y: Stated,
    /// The same in every state of the lights.
    pub(super) states: Vec<(Light, Stated)>,
    /// Every band, when asked for.
    pub(super) bands: Vec<Stated>,
    /// What earlier rounds told of the noise: Y, states, bands.
    memory: Vec<Memory>,
}

/// Illuminance in one state of the lights, and its parts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Light {
    pub(super) xyz: [f64; 3],
    /// Without diffuse reflection: of emitters, of the sun, of the sky.
    pub(super) direct_y: f64,
    pub(super) sun_y: f64,
    pub(super) sky_y: f64,
    /// Last left the ground or an outside surface.
    pub(super) external_y: f64,
    /// The rest of it.
    pub(super) reflected_y: f64,
}

/// What the loop settled on.
#[derive(Debug)]
pub(super) struct Adapted {
    pub(super) main: Solved,
    pub(super) twin: Solved,
    pub(super) rows: Rows,
    pub(super) twin_rows: Rows,
    pub(super) grids: Vec<Vec<SensorState>>,
    pub(super) mesh_size: f64,
    pub(super) rounds: usize,
    pub(super) rays: u64,
    pub(super) factors: u64,
    pub(super) timings: Vec<(String, f64)>,
    /// Rays per sensor: smallest and largest.
    pub(super) sensor_rays: (u32, u32),
    pub(super) accuracy: f64,
}

/// A landing: surface, side, place on it.
type Landed = (usize, bool, DVec2);

/// What sensors and pixels ask for, at first hand and at any other.
struct Demand {
    landings: Vec<Landed>,
    /// Median distance of what the sensors see, in the program's frame.
    reach: f64,
    /// What they feel of each place.
    importance: Importance,
}

/// A scene with its tolerance, ready to be worked on.
pub(super) struct Task<'a> {
    pub(super) scene: &'a Scene,
    pub(super) world: &'a World,
    pub(super) optics: &'a Optics,
    pub(super) channels: &'a Channels,
    pub(super) options: &'a SolveOptions,
    pub(super) progress: &'a dyn Progress,
}

impl Task<'_> {
    /// Relative residual to which the system is solved: a thousandth of the tolerance after amplification, in the mean;
    /// a hundredth is stated, for places much dimmer than the mean.
    pub(super) fn accuracy(&self) -> f64 {
        let loss = (1.0 - self.optics.largest_reflectance(self.world)).max(1e-4);
        (1e-3 * self.options.tolerance * loss).clamp(1e-10, 1e-4)
    }

    /// Error that the residual leaves in a value, relative.
    fn iteration_error(&self) -> f64 {
        0.01 * self.options.tolerance
    }

    /// Solves, judges and refines until the tolerance holds or nothing more can be done.
    pub(super) fn refine(&self) -> Result<Adapted> {
        let mut timings = Vec::new();
        let mut grids = self.prepare();
        let demand = self.demand(&grids);
        let mut size = self.first_size(demand.reach);
        let (mut rays, mut factors) = (0, 0);
        let mut solved: Option<(Solved, Solved, [Rows; 2])> = None;
        let mut round = 0;
        loop {
            round += 1;
            let (main, twin, rows) = match solved.take() {
                Some(s) => s,
                None => {
                    let start = Instant::now();
                    self.progress.stage(&format!("round {round}: elements and rows"), 0);
                    let fresh = self.solve_at(size, &demand)?;
                    rays += fresh.2.iter().map(|r| r.rays_cast).sum::<u64>();
                    factors += fresh.2.iter().map(|r| r.factors).sum::<u64>();
                    grids.iter_mut().flatten().for_each(|s| s.restart(self.optics));
                    timings.push((format!("round {round}: rows and solve"), start.elapsed().as_secs_f64()));
                    fresh
                }
            };
            let start = Instant::now();
            let (cast, exact) = self.gather(&main, &twin, &mut grids, round);
            rays += cast;
            factors += exact;
            for grid in &mut grids {
                self.judge(grid);
            }
            timings.push((format!("round {round}: gather and judge"), start.elapsed().as_secs_f64()));
            let plan = self.plan(&mut grids, &mut size, main.mesh.len());
            if plan == Plan::Stop || round == MAX_ROUNDS {
                let counts = grids.iter().flatten().filter(|s| s.probe.status == Status::Ok);
                let sensor_rays = counts.fold((u32::MAX, 0), |(lo, hi), s| (lo.min(s.done), hi.max(s.done)));
                let accuracy = self.accuracy();
                let [rows, twin_rows] = rows;
                return Ok(Adapted {
                    main,
                    twin,
                    rows,
                    twin_rows,
                    grids,
                    mesh_size: size,
                    rounds: round,
                    rays,
                    factors,
                    timings,
                    sensor_rays: (sensor_rays.0.min(sensor_rays.1), sensor_rays.1),
                    accuracy,
                });
            }
            if plan == Plan::Gather {
                solved = Some((main, twin, rows));
            }
        }
    }

    /// First element size, in the program's frame: at 5 % a 24th of the scene, or an eighth of the distance at which
    /// sensors meet surfaces where that is less; finer for less.
    fn first_size(&self, reach: f64) -> f64 {
        let wanted = (self.options.tolerance / 0.05).powf(0.4).clamp(0.1, 2.0);
        let wanted = wanted * (1.0 / 24.0f64).min(reach / 8.0);
        let area: f64 = self.world.surfaces.list.iter().map(|s| s.area).sum();
        // Pictures show every contact: there the rays of finer elements cost less than the paths of near hits.
        let wanted = if self.scene.views.is_empty() { wanted } else { 0.5 * wanted };
        wanted.max((area / 200_000.0).sqrt())
    }

    fn first_rays(&self) -> u32 {
        let wanted = 128.0 * (0.05 / self.options.tolerance).powf(1.5);
        (wanted.clamp(16.0, f64::from(MAX_SET_RAYS)) as u32).next_power_of_two().min(MAX_SET_RAYS)
    }

    fn prepare(&self) -> Vec<Vec<SensorState>> {
        let world = self.world;
        let first = self.first_rays();
        let grid = |(g, grid): (usize, &Grid)| {
            grid.sensors
                .par_iter()
                .enumerate()
                .map_init(
                    || DirectScratch::for_tolerance(self.options.tolerance).in_bands(self.optics),
                    |scratch, (i, sensor)| {
                        let probe = Probe::new(world, sensor, grid.receiver);
                        let mut direct = Vec::new();
                        if probe.status == Status::Ok {
                            for a in 0..REPLICAS {
                                let sample = seed(&[self.options.seed, stream::SHADOW, g as u64, i as u64, a as u64]);
                                let mut f = vec![0.0; self.optics.columns()];
                                let before = scratch.rays;
                                probe.facing.direct(world, probe.eye, sample, scratch, &mut f);
                                direct.push(f);
                                if scratch.rays == before {
                                    break; // exact
                                }
                            }
                        }
                        SensorState {
                            probe,
                            direct,
                            sums: (0..REPLICAS).map(|_| SetSums::new(self.optics, REPLICAS, true)).collect(),
                            done: 0,
                            wanted: first,
                            near: 0.0,
                            glowing: world.glowing(),
                            light: Light::default(),
                            y: Stated::default(),
                            states: vec![Default::default(); self.channels.states.len()],
                            bands: Vec::new(),
                            memory: Vec::new(),
                        }
                    },
                )
                .collect()
        };
        self.scene.grids.iter().enumerate().map(grid).collect()
    }

    /// Meshes at `size` and twice that, asked for by the sensors and pixels, with their solutions.
    fn solve_at(&self, size: f64, demand: &Demand) -> Result<(Solved, Solved, [Rows; 2])> {
        let build = |size: f64, purpose: u64| -> Result<(Solved, Rows)> {
            let mut mesh = Elements::new(&self.world.surfaces, size, &demand.importance);
            let keys: Vec<ElementKey> =
                demand.landings.par_iter().map(|(s, front, uv)| mesh.key_at(*s, *front, *uv)).collect();
            for key in keys {
                mesh.make(&self.world.surfaces, key);
            }
            let settings = RowSettings {
                replicas: REPLICAS,
                rays: ROW_RAYS / REPLICAS,
                lit_every: if self.options.tolerance < ROUGH { 1 } else { 2 },
                seed: seed(&[self.options.seed, purpose]),
                max_elements: MAX_ELEMENTS,
            };
            let rows = Rows::expand(self.world, self.optics, &mut mesh, &settings);
            let solution = solve::solve(self.world, self.optics, &mesh, &rows, self.accuracy())?;
            Ok((Solved::new(mesh, solution, self.optics), rows))
        };
        let (main, rows) = build(size, stream::ROWS)?;
        let (twin, twin_rows) = build(2.0 * size, stream::TWIN)?;
        Ok((main, twin, [rows, twin_rows]))
    }

    /// Where the first rays of the sensors and of some pixels land.
    fn demand(&self, grids: &[Vec<SensorState>]) -> Demand {
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
        // What rows take for all that light reaches has to be there: hardly an element may be missed.
        let area: f64 = self.world.surfaces.list.iter().map(|s| s.area).sum();
        let cells = area / self.first_size(reach).powi(2);
        let walks = ((WALKS_A_CELL * cells) as usize).clamp(FEWEST_WALKS, MOST_WALKS);
        let more = look(count..count.max((walks / sensors.len().max(1)) as u32));
        let from_views = self.scene.views.iter().map(|v| super::picture::demand(self.world, self.optics, v, self));
        let first: Vec<Landed> = from_sensors.into_iter().chain(more).chain(from_views).flatten().collect();
        let landings = self.walk(&first);
        let importance = Importance::new(landings.iter().map(|l| (l.0 as u32, l.2)).collect());
        Demand { landings, reach, importance }
    }

    /// Where the light that the sensors feel comes from, at first hand and at any other: walks from the first landings,
    /// which go on at each with the chance of its reflectance in the brightest band.
    fn walk(&self, first: &[Landed]) -> Vec<Landed> {
        let found: Vec<Vec<Landed>> = first
            .par_iter()
            .enumerate()
            .with_min_len(256)
            .map(|(walk, start)| {
                let mut at = *start;
                let mut list = vec![at];
                let points = Points::new(seed(&[self.options.seed, stream::WALK, walk as u64]));
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
        match follow(self.world, self.optics, ray, hit, Fork::Chance(0.5), &mut tint, &mut 0) {
            Landing::Surface { surface, front, point, .. } => {
                Some((surface as usize, front, self.world.surfaces.list[surface as usize].uv(point)))
            }
            _ => None,
        }
    }

    fn gather(&self, main: &Solved, twin: &Solved, grids: &mut [Vec<SensorState>], round: usize) -> (u64, u64) {
        let field = Field {
            world: self.world,
            optics: self.optics,
            main,
            twin: Some(twin),
            spectral: self.options.spectral,
            squares: self.options.spectral,
        };
        let pending = |s: &SensorState| s.probe.status == Status::Ok && s.done < s.wanted;
        let count = grids.iter().flatten().filter(|s| pending(s)).count();
        self.progress.stage(&format!("round {round}: final gather at sensors"), count as u64);
        let mut work = (0, 0);
        for (g, grid) in grids.iter_mut().enumerate() {
            let done: Vec<(u64, u64)> = grid
                .par_iter_mut()
                .enumerate()
                .with_max_len(8)
                .filter(|(_, s)| pending(s))
                .map_init(
                    || Gatherer::new(&field),
                    |gatherer, (i, s)| {
                        let before = (gatherer.cast + gatherer.scratch.rays, gatherer.scratch.factors);
                        gatherer.trust = s.near.max(main.mesh.size);
                        for a in 0..REPLICAS {
                            // Each mesh is read by rays of its own: what one round took for noise, the next tells anew.
                            let mesh = octave(main.mesh.size);
                            let parts =
                                [self.options.seed, stream::SENSOR, mesh, octave(s.near), g as u64, i as u64, a as u64];
                            let range = (s.done, s.wanted);
                            gatherer.gather(s.probe.position, s.probe.facing, seed(&parts), range, &mut s.sums[a]);
                        }
                        s.done = s.wanted;
                        self.progress.advance(1);
                        let after = (gatherer.cast + gatherer.scratch.rays, gatherer.scratch.factors);
                        (after.0 - before.0, after.1 - before.1)
                    },
                )
                .collect();
            for (rays, factors) in done {
                work = (work.0 + rays, work.1 + factors);
            }
        }
        work
    }

    /// States value and error of every sensor of a grid.
    fn judge(&self, grid: &mut [SensorState]) {
        let optics = self.optics;
        let lit: Vec<usize> = (0..grid.len()).filter(|i| grid[*i].probe.status == Status::Ok).collect();
        let iteration = self.iteration_error();
        let full = optics.full();
        let mut judge = |levels: &[f64], quantity: usize| {
            let y: Vec<Readings> = lit.iter().map(|i| grid[*i].readings_y(optics, levels, quantity)).collect();
            for (i, mut stated) in lit.iter().zip(state(&y, iteration)) {
                let light = grid[*i].light(optics, levels);
                stated.error += grid[*i].probe.facing.planes_error() * (light.direct_y + light.sun_y + light.sky_y);
                match quantity.checked_sub(1) {
                    None => (grid[*i].light, grid[*i].y) = (light, stated),
                    Some(k) => grid[*i].states[k] = (light, stated),
                }
            }
        };
        judge(&full, 0);
        for (k, of_state) in self.channels.states.iter().enumerate() {
            judge(&of_state.levels, 1 + k);
        }
        if !self.options.spectral {
            return;
        }
        let by_band: Vec<Vec<Stated>> = (0..optics.bands.len())
            .into_par_iter()
            .map(|band| {
                let readings: Vec<Readings> = lit.iter().map(|i| grid[*i].readings(optics, band)).collect();
                state(&readings, iteration)
            })
            .collect();
        for (k, i) in lit.iter().enumerate() {
            grid[*i].bands = by_band.iter().map(|b| b[k]).collect();
        }
    }

    /// Decides what to refine: rays of sensors whose own noise fails them; for the others the mesh, or how far their
    /// rays go on as paths, whichever is cheaper.
    fn plan(&self, grids: &mut [Vec<SensorState>], size: &mut f64, elements: usize) -> Plan {
        let tolerance = self.options.tolerance;
        let open: Vec<Vec<usize>> = grids.iter().map(|g| self.open_quantities(g)).collect();
        if open.iter().all(Vec::is_empty) {
            return Plan::Stop;
        }
        let rays = |s: &SensorState| REPLICAS as f64 * f64::from(s.wanted);
        let lit = || grids.iter().flatten().filter(|s| s.probe.status == Status::Ok);
        let (all_rays, lit): (f64, usize) = (lit().map(rays).sum(), lit().count());
        let mut again = false;
        let mut blaming = Vec::new();
        for (s, quantities) in grids.iter_mut().zip(&open).flat_map(|(g, q)| g.iter_mut().map(move |s| (s, q))) {
            let Some(worst) = s.worst(quantities, tolerance) else { continue };
            let excess = worst.error / (tolerance * worst.scale);
            if worst.rays >= worst.rows.max(worst.mesh) {
                again |= s.ask_rays(excess);
            } else {
                blaming.push((s, excess));
            }
        }
        let excess = super::statement::median(blaming.iter().map(|b| b.1).collect());
        let bold = excess > 1.6 && 4 * elements <= REFINED_ELEMENTS;
        let growth = if bold { 4.0 } else { 2.0 };
        // In rays: those of the elements and their coarse twins, each with its direct light, and all sensors anew.
        let cost_of_mesh = 2.0 * 1.25 * growth * (elements * ROW_RAYS) as f64 + all_rays;
        let cost_of_paths: f64 = blaming.iter().map(|(s, _)| 2.0 * PATHS_WANT * rays(s)).sum();
        let may_refine = 2 * elements <= REFINED_ELEMENTS;
        // What most sensors blame on the mesh is no matter of corners.
        let few = 2 * blaming.len() <= lit && cost_of_paths < cost_of_mesh;
        let further = (few || !may_refine)
            && blaming.iter_mut().fold(false, |any, (s, _)| s.look_further(*size, self.optics) || any);
        if may_refine && !further && !blaming.is_empty() {
            *size /= growth.sqrt();
            grids.iter_mut().flatten().for_each(|s| s.remember_mesh(1.0 / growth));
            return Plan::Mesh;
        }
        if !further && !again {
            return Plan::Stop;
        }
        grids.iter_mut().flatten().filter(|s| s.done > 0 && s.wanted > s.done).for_each(SensorState::remember_rays);
        Plan::Gather
    }
}

/// A length for seeds: the same for lengths that differ by rounding, so that a room moved far away keeps its rays.
pub(super) fn octave(length: f64) -> u64 {
    (8.0 * length.log2()).round() as i64 as u64
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Plan {
    Stop,
    /// More rays, or rays that go further, in the same solution.
    Gather,
    /// A finer mesh, and everything anew.
    Mesh,
}

impl Task<'_> {
    /// Number of lit sensors of a grid that hold the tolerance, in the quantity (Y, or a band) where the fewest do.
    pub(super) fn holding(&self, grid: &[SensorState]) -> usize {
        let of_states = 1..=self.channels.states.len();
        let own = self.quantities(grid).into_iter().filter(|q| !of_states.contains(q));
        own.map(|q| holding_in(grid, q, self.options.tolerance)).min().unwrap_or(0)
    }

    /// The same in a state of the lights.
    pub(super) fn holding_in_state(&self, grid: &[SensorState], state: usize) -> usize {
        holding_in(grid, 1 + state, self.options.tolerance)
    }

    /// Quantities that are held to the tolerance: Y is number 0, states and bands follow.
    fn quantities(&self, grid: &[SensorState]) -> Vec<usize> {
        let Some(first) = grid.iter().find(|s| s.probe.status == Status::Ok) else { return Vec::new() };
        let states = self.channels.states.len();
        (0..=self.channels.held).chain((0..first.bands.len()).map(|band| 1 + states + band)).collect()
    }

    /// Quantities of a grid in which too few sensors hold.
    fn open_quantities(&self, grid: &[SensorState]) -> Vec<usize> {
        let lit = grid.iter().filter(|s| s.probe.status == Status::Ok).count();
        let is_open = |q: &usize| (holding_in(grid, *q, self.options.tolerance) as f64) < HOLD * lit as f64;
        self.quantities(grid).into_iter().filter(is_open).collect()
    }
}

/// Number of lit sensors that hold the tolerance in one quantity: Y is number 0, states and bands follow.
fn holding_in(grid: &[SensorState], quantity: usize, tolerance: f64) -> usize {
    grid.iter().filter(|s| s.probe.status == Status::Ok && s.stated(quantity).holds(tolerance)).count()
}

impl SensorState {
    fn restart(&mut self, optics: &Optics) {
        self.sums.iter_mut().for_each(|s| *s = SetSums::new(optics, REPLICAS, true));
        self.done = 0;
    }

    /// Wants more rays for an error `excess` times too large. `false`: it has as many as may be.
    fn ask_rays(&mut self, excess: f64) -> bool {
        // Noise of a well-spread set falls nearly as n^-0.75.
        let factor = (excess.powf(1.5).ceil() as u32).next_power_of_two().clamp(2, 16);
        let before = self.wanted;
        self.wanted = self.done.saturating_mul(factor).min(MAX_SET_RAYS);
        self.wanted > before
    }

    /// Lets rays go on as paths from further away, and begins anew: that trades what elements of size `size` hide for
    /// noise of rays. `false`: all go on already.
    fn look_further(&mut self, size: f64, optics: &Optics) -> bool {
        let near = self.near.max(size);
        if near >= 1.0 {
            return false;
        }
        self.near = FURTHER * near;
        self.wanted = ((f64::from(self.wanted) * PATHS_WANT) as u32).min(MAX_SET_RAYS);
        self.restart(optics);
        let keep = |m: &Memory| Memory { design: m.design.scaled(1.0), ..Memory::default() };
        self.memory = self.all_stated().map(|s| keep(&s.memory)).collect();
        true
    }

    /// Keeps what this round told, for one with finer elements, whose area is `area` times what it was.
    fn remember_mesh(&mut self, area: f64) {
        let keep = |m: &Memory| Memory { rows: m.rows.scaled(area), design: m.design.scaled(1.0) };
        self.memory = self.all_stated().map(|s| keep(&s.memory)).collect();
    }

    /// Keeps what this round told, for one with more rays in the same solution.
    fn remember_rays(&mut self) {
        let rows: Vec<_> = (0..self.all_stated().count()).map(|q| self.memory(q).rows).collect();
        let design = self.all_stated().map(|s| s.memory.design.scaled(1.0));
        self.memory = design.zip(rows).map(|(design, rows)| Memory { rows, design }).collect();
    }

    fn all_stated(&self) -> impl Iterator<Item = &Stated> {
        std::iter::once(&self.y).chain(self.states.iter().map(|s| &s.1)).chain(&self.bands)
    }

    fn memory(&self, quantity: usize) -> Memory {
        self.memory.get(quantity).copied().unwrap_or_default()
    }

    fn stated(&self, quantity: usize) -> &Stated {
        match quantity {
            0 => &self.y,
            q if q <= self.states.len() => &self.states[q - 1].1,
            q => &self.bands[q - 1 - self.states.len()],
        }
    }

    /// The quantity furthest beyond the tolerance among those that matter, if any is.
    fn worst(&self, quantities: &[usize], tolerance: f64) -> Option<Stated> {
        if self.probe.status != Status::Ok {
            return None;
        }
        let excess = |s: &Stated| s.error / s.scale;
        quantities
            .iter()
            .map(|q| self.stated(*q))
            .filter(|s| !s.holds(tolerance))
            .max_by(|a, b| excess(a).total_cmp(&excess(b)))
            .copied()
    }

    fn direct(&self, set: usize) -> &[f64] {
        &self.direct[set % self.direct.len()]
    }

    fn direct_band(&self, optics: &Optics, set: usize, band: usize) -> f64 {
        if self.glowing {
            return 0.0;
        }
        optics.lanes(band).map(|lane| optics.direct_in_band(self.direct(set), lane)).sum()
    }

    fn direct_xyz(&self, optics: &Optics, levels: &[f64], set: usize) -> [f64; 3] {
        if self.glowing { [0.0; 3] } else { optics.xyz_of_direct(self.direct(set), levels) }
    }

    /// Illuminance with a level for each channel.
    fn light(&self, optics: &Optics, levels: &[f64]) -> Light {
        let mut light = Light::default();
        let share = 1.0 / REPLICAS as f64;
        for a in 0..REPLICAS {
            let direct = self.direct_xyz(optics, levels, a);
            let part = |part| share * optics.lux_of_direct(self.direct(a), levels, part);
            let (in_mirrors, outside) = self.sums[a].outside_y(levels);
            light.direct_y += part(LightPart::Lamps);
            light.sun_y += part(LightPart::Sun);
            light.sky_y += part(LightPart::Sky) + share * in_mirrors;
            light.external_y += part(LightPart::Ground) + share * outside;
            light.reflected_y -= share * (in_mirrors + outside);
            for b in 0..REPLICAS {
                let reflected = self.sums[a].xyz(b, optics, levels, false);
                light.reflected_y += share * share * reflected[1];
                for k in 0..3 {
                    light.xyz[k] += share * share * (direct[k] + reflected[k]);
                }
            }
        }
        if self.glowing {
            // Direct light is part of what the rays brought: take it out for the report.
            let direct: f64 = (0..REPLICAS).map(|a| optics.xyz_of_direct(self.direct(a), levels)[1]).sum();
            light.direct_y = (direct / REPLICAS as f64).min(light.xyz[1]);
            light.reflected_y = light.xyz[1] - light.direct_y;
        }
        light
    }

    fn total_rays(&self) -> f64 {
        self.sums.iter().map(|s| f64::from(s.rays)).sum::<f64>().max(1.0)
    }

    fn readings_y(&self, optics: &Optics, levels: &[f64], quantity: usize) -> Readings {
        let mut r = Readings { memory: self.memory(quantity), ..Readings::default() };
        let (mut mean, mut square) = (0.0, 0.0);
        for a in 0..REPLICAS {
            let direct = self.direct_xyz(optics, levels, a)[1];
            for b in 0..REPLICAS {
                let reflected = self.sums[a].xyz(b, optics, levels, false)[1];
                r.main[a][b] = direct + reflected;
                r.twin[a][b] = direct + self.sums[a].xyz(b, optics, levels, true)[1];
                mean += reflected / (REPLICAS * REPLICAS) as f64;
            }
            square += self.sums[a].mean_square_y(levels) / REPLICAS as f64;
        }
        r.naive = (square - mean * mean).max(0.0) / self.total_rays();
        r
    }

    fn readings(&self, optics: &Optics, band: usize) -> Readings {
        let mut r = Readings { memory: self.memory(1 + self.states.len() + band), ..Readings::default() };
        let (mut mean, mut square) = (0.0, 0.0);
        for a in 0..REPLICAS {
            let direct = self.direct_band(optics, a, band);
            for b in 0..REPLICAS {
                let reflected = self.sums[a].band(b, band, optics, false);
                r.main[a][b] = direct + reflected;
                r.twin[a][b] = direct + self.sums[a].band(b, band, optics, true);
                mean += reflected / (REPLICAS * REPLICAS) as f64;
            }
            square += self.sums[a].mean_square(band) / REPLICAS as f64;
        }
        r.naive = (square - mean * mean).max(0.0) / self.total_rays();
        r
    }
}
