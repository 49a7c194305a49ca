//! The tolerance loop: solve, judge every sensor, refine what its error blames, and only that.

use std::time::Instant;

use rayon::prelude::*;

use super::demand::Demand;
use super::gather::{Field, Gatherer, REPLICAS, SetSums};
use super::memory::{self, Budget};
use super::options::{Progress, SolveOptions};
use super::probe::Probe;
use super::result::Status;
use super::sensor_state::{Light, MAX_SET_RAYS, PATHS_WANT, SensorState};
use super::solved::Solved;
use super::statement::{Readings, Stated, state};
use super::states::Channels;
use crate::error::Result;
use crate::mesh::{ElementKey, Elements};
use crate::scene::{Grid, Scene};
use crate::solve;
use crate::transport::points::seed;
use crate::transport::{DirectScratch, Optics, PANEL_SETS, RowSettings, Rows, World};

/// Rays of an element, over all replicas: refined by size, never by more rays.
pub(super) const ROW_RAYS: usize = 32;
/// Tolerance from which a quarter of the places on an element tell its direct light well enough; half of them do below.
const ROUGH: f64 = 0.05;
/// Rounds after which what does not hold is told instead.
const MAX_ROUNDS: usize = 10;
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
    pub(in crate::measure) const SHADOW: u64 = 4;
    pub(in crate::measure) const WALK: u64 = 7;
    pub(in crate::measure) const PATCHES: u64 = 8;
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
    /// Most bytes planned for.
    pub(super) planned_bytes: u64,
    /// Would the next finer mesh be beyond the memory allowed?
    pub(super) held_by_memory: bool,
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
        let budget = Budget::new(self);
        budget.check()?;
        let mut planned_bytes = 0;
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
                    let fresh = self.solve_at(size, &demand, &budget)?;
                    planned_bytes = planned_bytes.max(fresh.3);
                    let fresh = (fresh.0, fresh.1, fresh.2);
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
            let plan = self.plan(&mut grids, &mut size, (main.mesh.len(), budget.most_elements()));
            if plan == Plan::Stop || round == MAX_ROUNDS {
                let counts = grids.iter().flatten().filter(|s| s.probe.status == Status::Ok);
                let sensor_rays = counts.fold((u32::MAX, 0), |(lo, hi), s| (lo.min(s.done), hi.max(s.done)));
                let accuracy = self.accuracy();
                let [rows, twin_rows] = rows;
                let finer = 2 * main.mesh.len();
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
                    planned_bytes,
                    held_by_memory: finer > budget.most_elements() && finer <= REFINED_ELEMENTS,
                });
            }
            if plan == Plan::Gather {
                solved = Some((main, twin, rows));
            }
        }
    }

    /// First element size, in the program's frame: at 5 % a 24th of the scene, or an eighth of the distance at which
    /// sensors meet surfaces where that is less; finer for less.
    pub(super) fn first_size(&self, reach: f64) -> f64 {
        let wanted = (self.options.tolerance / 0.05).powf(0.4).clamp(0.1, 2.0);
        let wanted = wanted * (1.0 / 24.0f64).min(reach / 8.0);
        let area: f64 = self.world.surfaces.list.iter().map(|s| s.area).sum();
        // Pictures show every contact: there the rays of finer elements cost less than the paths of near hits.
        let wanted = if self.scene.views.is_empty() { wanted } else { 0.5 * wanted };
        wanted.max((area / 200_000.0).sqrt())
    }

    pub(super) fn first_rays(&self) -> u32 {
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
                                scratch.set = a % PANEL_SETS;
                                probe.facing.direct(world, probe.eye, sample, scratch, &mut f);
                                direct.push(f);
                                if scratch.rays == before && !world.has_bsdf() {
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

    /// Meshes at `size` and twice that, asked for by the sensors and pixels, with their solutions, and the bytes planned.
    fn solve_at(&self, size: f64, demand: &Demand, budget: &Budget) -> Result<(Solved, Solved, [Rows; 2], u64)> {
        let most = budget.most_elements();
        let build = |size: f64, purpose: u64| -> Result<(Solved, Rows, u64)> {
            let mut mesh = Elements::new(&self.world.surfaces, size, &demand.importance);
            let keys: Vec<ElementKey> =
                demand.landings.par_iter().map(|(s, front, uv)| mesh.key_at(*s, *front, *uv)).collect();
            for key in keys {
                mesh.make(&self.world.surfaces, key);
            }
            let settings = RowSettings {
                replicas: REPLICAS,
                rays: ROW_RAYS / REPLICAS,
                lit_every: if self.options.tolerance < ROUGH { 2 } else { 4 },
                seed: seed(&[self.options.seed, purpose]),
                max_elements: MAX_ELEMENTS.min(most),
            };
            let rows = Rows::expand(self.world, self.optics, &mut mesh, &settings);
            if rows.refused > 0 && mesh.len() >= most {
                return Err(budget.exceeded(mesh.capacity()));
            }
            let way = budget.way(mesh.len())?;
            let planned = budget.peak(mesh.len(), way);
            if purpose == stream::ROWS {
                let (count, told) = (mesh.len(), memory::size(planned));
                self.progress.note(&format!("{count} elements: {told} of memory at the peak, by plan"));
            }
            let solution = solve::solve(self.world, self.optics, &mesh, &rows, (self.accuracy(), way))?;
            Ok((Solved::new(mesh, solution, self.optics), rows, planned))
        };
        let (main, rows, planned) = build(size, stream::ROWS)?;
        let (twin, twin_rows, _) = build(2.0 * size, stream::TWIN)?;
        Ok((main, twin, [rows, twin_rows], planned))
    }

    /// Where the first rays of the sensors and of some pixels land.
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
    fn plan(&self, grids: &mut [Vec<SensorState>], size: &mut f64, (elements, most): (usize, usize)) -> Plan {
        let most = REFINED_ELEMENTS.min(most);
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
        let bold = excess > 1.6 && 4 * elements <= most;
        let growth = if bold { 4.0 } else { 2.0 };
        // In rays: those of the elements and their coarse twins, each with its direct light, and all sensors anew.
        let cost_of_mesh = 2.0 * 1.25 * growth * (elements * ROW_RAYS) as f64 + all_rays;
        let cost_of_paths: f64 = blaming.iter().map(|(s, _)| 2.0 * PATHS_WANT * rays(s)).sum();
        let may_refine = 2 * elements <= most;
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
