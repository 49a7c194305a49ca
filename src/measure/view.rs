//! Pictures: exact direct light at every pixel, a final gather for the rest, interpolated where it is smooth.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::adaptive::Task;
use super::camera::Camera;
use super::gather::{Field, Gatherer, REPLICAS, SetSums, Solved};
use super::result::ViewResult;
use super::statement::{Readings, Stated, design_effect, median, state};
use crate::scene::View;
use crate::transport::caster::{MISS, Ray};
use crate::transport::points::{Points, seed};
use crate::transport::{Fork, Landing, Optics, SUN, Tint, World, follow};

/// Side of the cells in which reflected light is first interpolated, in pixels.
const CELL: usize = 8;
/// Share of the tolerance that interpolation may take, and that the noise of a pixel's rays may.
const INTERPOLATION: f64 = 0.3;
const NOISE: f64 = 0.35;
/// Exponent by which the variance of well-spread rays falls with their number.
const DECAY: f64 = 1.4;
/// Rays of a first look, and most rays, at one pixel.
const FIRST_RAYS: u32 = 256;
const MOST_RAYS: u32 = 1 << 12;
/// Samples across a pixel that holds an edge.
const ACROSS: usize = 4;
/// Neighbours that differ by more than this in luminance get the finer sampling.
const CONTRAST: f32 = 0.1;
/// Pixels at which the error is stated.
const JUDGED: usize = 400;
const STREAM: u64 = 7;

/// What a pixel's ray meets, along one branch of its chain; for sky and ground the surface is [`MISS`], and `point` the
/// direction to them.
#[derive(Clone, Debug)]
struct Sight {
    surface: u32,
    front: bool,
    point: DVec3,
    normal: DVec3,
    /// The far side of a translucent surface, whose light is seen from the near one.
    through: bool,
    /// By mirror or glass: its tint; plain sights carry none.
    tint: Option<Vec<f32>>,
    /// A luminaire, which is no surface: its group and π times its luminance.
    glow: Option<(usize, f64)>,
}

/// Looks along a ray: one sight for a plain scene, one more for every pane on the way.
fn look(world: &World, optics: &Optics, ray: Ray, sights: &mut Vec<Sight>) {
    sights.clear();
    let hit = world.caster.closest(&ray);
    let direction = DVec3::from_array(ray.direction.map(f64::from));
    if let Some(glow) = world.luminaire_seen(ray.at(0.0), direction, f64::from(hit.t)) {
        let (point, normal) = (direction, direction);
        sights.push(Sight { surface: MISS, front: true, point, normal, through: false, tint: None, glow: Some(glow) });
        return;
    }
    let mut tint = Tint::new(optics.pad);
    let mut panes = 0;
    for branch in (0..=8).rev() {
        // The highest branch goes straight through everything and tells how many panes there are.
        if branch < 8 && branch >= panes {
            continue;
        }
        tint.reset();
        let landing = follow(world, optics, ray, hit, Fork::Branch(branch), &mut tint, &mut 0);
        if branch == 8 {
            panes = tint.panes.min(8);
        }
        let coloured = tint.coloured || tint.scale != 1.0 || tint.panes > 0;
        let own_tint = || coloured.then(|| (0..optics.pad).map(|b| tint.share(b)).collect());
        if let Landing::Escaped { direction, .. } = landing
            && world.daylight().is_some()
        {
            let (point, normal) = (direction, direction);
            let (through, glow) = (false, None);
            sights.push(Sight { surface: MISS, front: true, point, normal, through, tint: own_tint(), glow });
        }
        if let Landing::Surface { surface, front, point, .. } = landing {
            let s = &world.surfaces.list[surface as usize];
            for through in [false, true].into_iter().take(1 + usize::from(world.is_translucent(surface))) {
                let front = front != through;
                let normal = s.side_normal(front);
                let point = world.lift(s.point(s.uv(point)), normal);
                sights.push(Sight { surface, front, point, normal, through, tint: own_tint(), glow: None });
            }
        }
    }
}

impl Sight {
    /// Share of what arrives that leaves towards the eye, and exitance of the surface itself.
    fn leaving<'a>(&self, world: &World, optics: &'a Optics) -> (&'a [f32], Option<&'a Vec<f32>>) {
        let material = world.surfaces.list[self.surface as usize].material;
        if self.through {
            return (optics.tau(material), None);
        }
        let emitted = world.group(self.surface, self.front).map(|g| &optics.exitance[g]);
        (optics.rho(material, self.front), emitted)
    }
}

/// Radiance of sky, sun, ground or a luminaire as a sight shows it, added to `out` with a weight.
fn add_background(world: &World, optics: &Optics, sight: &Sight, weight: f32, out: &mut [f32]) {
    let beyond = || {
        let sun = world.sun_disc(sight.point).map(|l| (optics.lamps + SUN, l));
        [world.background(sight.point), sun]
    };
    let seen = sight.glow.map_or_else(beyond, |glow| [Some(glow), None]);
    for (group, light) in seen.into_iter().flatten() {
        for (band, out) in out.iter_mut().enumerate() {
            let left = sight.tint.as_ref().map_or(1.0, |t| t[band]);
            *out += weight * left * optics.exitance[group][band] * light as f32 * std::f32::consts::FRAC_1_PI;
        }
    }
}

/// Places that the pixels' gather rays land on, for the mesh to be made.
pub(super) fn demand(world: &World, optics: &Optics, view: &View, task: &Task<'_>) -> Vec<(usize, bool, DVec2)> {
    let camera = Camera::new(view, &world.surfaces.frame);
    let step = 4;
    (0..view.height.div_ceil(step))
        .into_par_iter()
        .flat_map_iter(|row| {
            let mut found = Vec::new();
            let mut sights = Vec::new();
            for column in 0..view.width.div_ceil(step) {
                let (x, y) = ((column * step) as f64 + 0.5, (row * step) as f64 + 0.5);
                let Some(direction) = camera.direction(x, y) else { continue };
                look(world, optics, Ray::new(camera.eye(), direction), &mut sights);
                let points = Points::new(seed(&[task.options.seed, STREAM, row as u64, column as u64]));
                for s in sights.iter().filter(|s| s.surface != MISS) {
                    found.extend((0..4).filter_map(|k| task.landing(s.point, s.normal.into(), &points, k)));
                }
            }
            found
        })
        .collect()
}

/// Everything a picture needs.
struct Painter<'a> {
    task: &'a Task<'a>,
    camera: Camera,
    field: &'a Field<'a>,
    noise: Noise,
    stream: u64,
}

/// What decides how many rays a pixel needs.
#[derive(Clone, Copy, Debug)]
struct Noise {
    /// Variance of well-spread rays against independent ones.
    design: f64,
    /// Mean illuminance of what the picture shows, lx.
    mean: f64,
    tolerance: f64,
}

impl Noise {
    /// Rays that keep the noise of an illuminance to its share of the tolerance; `variance` is that of one ray.
    fn rays(&self, variance: f64, illuminance: f64) -> u32 {
        let scale = illuminance.max(0.1 * self.mean);
        if variance <= 0.0 || scale <= 0.0 {
            return FIRST_RAYS;
        }
        let now = self.design * variance / f64::from(FIRST_RAYS);
        let allowed = (NOISE * self.tolerance * scale / 1.96).powi(2);
        let wanted = f64::from(FIRST_RAYS) * (now / allowed).powf(1.0 / DECAY);
        (wanted.min(f64::from(MOST_RAYS)) as u32).next_power_of_two().clamp(FIRST_RAYS, MOST_RAYS)
    }
}

/// Makes one picture.
pub(super) fn paint(task: &Task<'_>, view: &View, number: usize, main: &Solved, twin: &Solved) -> (ViewResult, u64) {
    let camera = Camera::new(view, &task.world.surfaces.frame);
    let stream = seed(&[task.options.seed, STREAM, 1 + number as u64]);
    let (stated, noise, cast) = judge(task, &camera, main, twin, stream);
    let mean = main.averaged(task.optics);
    let field =
        Field { world: task.world, optics: task.optics, main: &mean, twin: None, spectral: true, squares: false };
    let painter = Painter { task, camera, field: &field, noise, stream };
    task.progress.stage(&format!("picture {}", view.name), camera.height as u64);
    let base = painter.base();
    let (reflected, gathered) = painter.reflected(&base);
    let plain = painter.shade(&base, &reflected);
    let (radiance, more) = painter.smooth(&base, &reflected, plain);
    let mut errors: Vec<f64> = stated.iter().filter(|s| s.value > 0.0).map(|s| s.error / s.value).collect();
    errors.sort_by(f64::total_cmp);
    let n = task.optics.bands.len();
    let result = ViewResult {
        view: view.clone(),
        xyz: radiance
            .chunks_exact(task.optics.pad)
            .map(|l| {
                let bands: Vec<f64> = l[..n].iter().map(|x| f64::from(*x)).collect();
                task.optics.bands.xyz(&bands).map(|x| x as f32)
            })
            .collect(),
        radiance: radiance.chunks_exact(task.optics.pad).flat_map(|l| l[..n].iter().copied()).collect(),
        error_median: median(errors.clone()),
        error_p95: errors.get(errors.len() * 95 / 100).copied().unwrap_or(0.0),
        stages: Vec::new(),
    };
    (result, cast + gathered + more)
}

/// States the error of the irradiance at some pixels, each with the rays that its noise asks for.
fn judge(task: &Task<'_>, camera: &Camera, main: &Solved, twin: &Solved, stream: u64) -> (Vec<Stated>, Noise, u64) {
    let places = judged_places(task, camera);
    let (first, cast) = read_all(task, &places, main, twin, stream, &vec![FIRST_RAYS; places.len()]);
    let values: Vec<f64> = state(&first, 0.0).iter().map(|s| s.value).collect();
    let noise = Noise {
        design: design_effect(&first),
        mean: values.iter().sum::<f64>() / values.len().max(1) as f64,
        tolerance: task.options.tolerance,
    };
    let rays: Vec<u32> =
        first.iter().zip(&values).map(|(r, v)| noise.rays(r.naive * f64::from(FIRST_RAYS), *v)).collect();
    let (second, more) = read_all(task, &places, main, twin, stream, &rays);
    (state(&second, 0.0), noise, cast + more)
}

/// Points seen by pixels spread over the picture, with their normals.
fn judged_places(task: &Task<'_>, camera: &Camera) -> Vec<(DVec3, DVec3)> {
    let pixels = camera.width * camera.height;
    let stride = (pixels as f64 / JUDGED as f64).max(1.0);
    let mut sights = Vec::new();
    (0..pixels.min(JUDGED))
        .filter_map(|k| {
            let pixel = ((k as f64 + 0.5) * stride) as usize % pixels;
            let (x, y) = ((pixel % camera.width) as f64 + 0.5, (pixel / camera.width) as f64 + 0.5);
            look(task.world, task.optics, Ray::new(camera.eye(), camera.direction(x, y)?), &mut sights);
            sights.first().filter(|s| s.surface != MISS).map(|s| (s.point, s.normal))
        })
        .collect()
}

/// Reads every place with its number of rays.
fn read_all(
    task: &Task<'_>,
    places: &[(DVec3, DVec3)],
    main: &Solved,
    twin: &Solved,
    stream: u64,
    rays: &[u32],
) -> (Vec<Readings>, u64) {
    let field =
        Field { world: task.world, optics: task.optics, main, twin: Some(twin), spectral: false, squares: false };
    let readings: Vec<(Readings, u64)> = places
        .par_iter()
        .zip(rays)
        .enumerate()
        .map_init(
            || Gatherer::new(&field),
            |g, (i, ((x, normal), rays))| {
                let before = g.cast + g.scratch.rays;
                let reading = read(task, g, *x, *normal, seed(&[stream, 2, i as u64]), rays / REPLICAS as u32);
                (reading, g.cast + g.scratch.rays - before)
            },
        )
        .collect();
    let cast = readings.iter().map(|r| r.1).sum();
    (readings.into_iter().map(|r| r.0).collect(), cast)
}

fn read(task: &Task<'_>, g: &mut Gatherer<'_>, x: DVec3, normal: DVec3, stream: u64, set: u32) -> Readings {
    let optics = task.optics;
    let factors = g.direct(x, normal, stream);
    let direct = optics.xyz_of_direct(&factors, &[1.0])[1];
    let mut reading = Readings { naive: 0.0, ..Readings::default() };
    let (mut mean, mut square) = (0.0, 0.0);
    for a in 0..REPLICAS {
        let mut sums = SetSums::new(optics, REPLICAS, true);
        g.gather(x, normal.into(), seed(&[stream, a as u64]), (0, set), &mut sums);
        for b in 0..REPLICAS {
            let reflected = sums.xyz(b, optics, &[1.0], false)[1];
            reading.main[a][b] = direct + reflected;
            reading.twin[a][b] = direct + sums.xyz(b, optics, &[1.0], true)[1];
            mean += reflected / (REPLICAS * REPLICAS) as f64;
        }
        square += sums.mean_square_y(&[1.0]) / REPLICAS as f64;
    }
    reading.naive = (square - mean * mean).max(0.0) / f64::from(set * REPLICAS as u32);
    reading
}

/// One plain pass: what the middle of every pixel sees, with its direct light.
struct Base {
    sights: Vec<Vec<Sight>>,
    /// Irradiance without reflection at the first sight, by group.
    direct: Vec<Vec<f64>>,
}

impl Painter<'_> {
    fn pixels(&self) -> usize {
        self.camera.width * self.camera.height
    }

    fn base(&self) -> Base {
        let (world, optics) = (self.task.world, self.task.optics);
        let (sights, direct) = (0..self.pixels())
            .into_par_iter()
            .with_min_len(64)
            .map_init(
                || Gatherer::new(self.field),
                |g, pixel| {
                    let mut sights = Vec::new();
                    let (x, y) = ((pixel % self.camera.width) as f64, (pixel / self.camera.width) as f64);
                    if let Some(direction) = self.camera.direction(x + 0.5, y + 0.5) {
                        look(world, optics, Ray::new(self.camera.eye(), direction), &mut sights);
                    }
                    let direct = sights
                        .first()
                        .filter(|s| s.surface != MISS)
                        .map_or_else(Vec::new, |s| g.direct(s.point, s.normal, seed(&[self.stream, pixel as u64])));
                    (sights, direct)
                },
            )
            .unzip();
        Base { sights, direct }
    }

    /// Reflected irradiance at the first sight of every pixel, by band.
    fn reflected(&self, base: &Base) -> (Vec<Vec<f32>>, u64) {
        let (w, h) = (self.camera.width, self.camera.height);
        let columns = w.div_ceil(CELL);
        let corners: Vec<usize> =
            (0..h).step_by(CELL).flat_map(|y| (0..w).step_by(CELL).map(move |x| y * w + x)).collect();
        let at_corners: Vec<_> = corners
            .par_iter()
            .map_init(
                || Gatherer::new(self.field),
                |g, pixel| {
                    let before = g.cast + g.scratch.rays;
                    (self.value(g, base, *pixel), g.cast + g.scratch.rays - before)
                },
            )
            .collect();
        let mut rays: u64 = at_corners.iter().map(|c| c.1).sum();
        let blocks: Vec<_> = (0..corners.len())
            .into_par_iter()
            .map_init(
                || Gatherer::new(self.field),
                |g, block| {
                    let (x, y) = (block % columns * CELL, block / columns * CELL);
                    let before = g.cast + g.scratch.rays;
                    let mut cell =
                        Cell { painter: self, base, corners: &at_corners, gatherer: g, known: BTreeMap::new() };
                    cell.fill(x, y, CELL);
                    let found = cell.known;
                    if block % columns == 0 {
                        self.task.progress.advance(CELL.min(h - y) as u64);
                    }
                    (found, g.cast + g.scratch.rays - before)
                },
            )
            .collect();
        let mut image = vec![Vec::new(); w * h];
        for (block, (found, cast)) in blocks.into_iter().enumerate() {
            rays += cast;
            let (x, y) = (block % columns * CELL, block / columns * CELL);
            for (pixel, value) in found {
                // A block may have looked at its neighbours' pixels; it fills its own alone.
                if (x..x + CELL).contains(&(pixel % w)) && (y..y + CELL).contains(&(pixel / w)) {
                    image[pixel] = value;
                }
            }
        }
        (image, rays)
    }

    /// Gathered reflected light of a pixel.
    fn value(&self, g: &mut Gatherer<'_>, base: &Base, pixel: usize) -> Vec<f32> {
        match base.sights[pixel].first() {
            Some(sight) if sight.surface != MISS => self.gather(g, sight, pixel as u64, &base.direct[pixel], 1.0),
            _ => vec![0.0; self.task.optics.pad],
        }
    }

    /// Reflected irradiance at a sight by band, with the rays that its noise asks for; `share` of them for samples that
    /// are averaged with others.
    fn gather(&self, g: &mut Gatherer<'_>, sight: &Sight, stream: u64, direct: &[f64], share: f64) -> Vec<f32> {
        let optics = self.task.optics;
        let mut sums = SetSums::new(optics, 1, false);
        let stream = seed(&[self.stream, 3, stream]);
        let first = (f64::from(FIRST_RAYS) * share) as u32;
        g.gather(sight.point, sight.normal.into(), stream, (0, first), &mut sums);
        let mean = sums.xyz(0, optics, &[1.0], false)[1];
        let variance = sums.mean_square_y(&[1.0]) - mean * mean;
        let wanted = self.noise.rays(variance, mean + optics.xyz_of_direct(direct, &[1.0])[1]);
        let wanted = (f64::from(wanted) * share) as u32;
        g.gather(sight.point, sight.normal.into(), stream, (first, wanted.max(first)), &mut sums);
        sums.bands(0, optics.pad, false).map(|x| x as f32).collect()
    }

    /// Radiance of a sight from its irradiance, added to `out` with a weight.
    fn radiance(&self, sight: &Sight, direct: &[f64], reflected: &[f32], weight: f32, out: &mut [f32]) {
        let (world, optics) = (self.task.world, self.task.optics);
        if sight.surface == MISS {
            return add_background(world, optics, sight, weight, out);
        }
        let (shares, emitted) = sight.leaving(world, optics);
        for band in 0..optics.pad {
            let arriving: f32 = reflected[band] + optics.direct_in_band(direct, band) as f32;
            let leaving = shares[band] * arriving + emitted.map_or(0.0, |m| m[band]);
            let left = sight.tint.as_ref().map_or(1.0, |t| t[band]);
            out[band] += weight * left * leaving * std::f32::consts::FRAC_1_PI;
        }
    }

    /// The picture with one sample in the middle of each pixel.
    fn shade(&self, base: &Base, reflected: &[Vec<f32>]) -> Vec<f32> {
        let pad = self.task.optics.pad;
        let mut picture = vec![0.0f32; self.pixels() * pad];
        picture.par_chunks_exact_mut(pad).enumerate().with_min_len(64).for_each_init(
            || Gatherer::new(self.field),
            |g, (pixel, out)| {
                for (k, sight) in base.sights[pixel].iter().enumerate() {
                    if k == 0 || sight.surface == MISS {
                        self.radiance(sight, &base.direct[pixel], &reflected[pixel], 1.0, out);
                    } else {
                        let stream = (k as u64) << 40 | pixel as u64;
                        let direct = g.direct(sight.point, sight.normal, seed(&[self.stream, stream]));
                        let light = self.gather(g, sight, stream, &direct, 1.0);
                        self.radiance(sight, &direct, &light, 1.0, out);
                    }
                }
            },
        );
        picture
    }

    /// Samples the pixels that hold an edge more finely.
    fn smooth(&self, base: &Base, reflected: &[Vec<f32>], plain: Vec<f32>) -> (Vec<f32>, u64) {
        let pad = self.task.optics.pad;
        let y: Vec<f32> = plain
            .par_chunks_exact(pad)
            .map(|l| l.iter().zip(&self.task.optics.xyz[1]).map(|(l, w)| l * w).sum())
            .collect();
        let edges: Vec<usize> = (0..self.pixels()).filter(|p| self.is_edge(*p, base, &y)).collect();
        let finer: Vec<(Vec<f32>, u64)> = edges
            .par_iter()
            .map_init(
                || Gatherer::new(self.field),
                |g, pixel| {
                    let before = g.cast + g.scratch.rays;
                    let value = self.supersample(g, *pixel, base, reflected);
                    (value, g.cast + g.scratch.rays - before)
                },
            )
            .collect();
        let mut picture = plain;
        let mut rays = 0;
        for (pixel, (value, cast)) in edges.iter().zip(finer) {
            picture[pixel * pad..(pixel + 1) * pad].copy_from_slice(&value);
            rays += cast;
        }
        (picture, rays)
    }

    fn neighbours(&self, pixel: usize) -> impl Iterator<Item = usize> + '_ {
        let (w, h) = (self.camera.width as isize, self.camera.height as isize);
        let (x, y) = (pixel as isize % w, pixel as isize / w);
        (-1..=1)
            .flat_map(move |dy| (-1..=1).map(move |dx| (x + dx, y + dy)))
            .filter_map(move |(x, y)| ((0..w).contains(&x) && (0..h).contains(&y)).then_some((y * w + x) as usize))
    }

    fn is_edge(&self, pixel: usize, base: &Base, y: &[f32]) -> bool {
        let key = |p: usize| base.sights[p].first().map(|s| (s.surface, s.front, base.sights[p].len()));
        let own = key(pixel);
        self.neighbours(pixel).any(|p| {
            let (a, b) = (y[pixel], y[p]);
            (key(p) != own && (a != b)) || (a - b).abs() > CONTRAST * a.max(b)
        })
    }

    fn supersample(&self, g: &mut Gatherer<'_>, pixel: usize, base: &Base, reflected: &[Vec<f32>]) -> Vec<f32> {
        let (world, optics) = (self.task.world, self.task.optics);
        let mut out = vec![0.0; optics.pad];
        let weight = 1.0 / (ACROSS * ACROSS) as f32;
        let mut sights = Vec::new();
        for k in 0..ACROSS * ACROSS {
            let place = |j: usize| (j as f64 + 0.5) / ACROSS as f64;
            let x = (pixel % self.camera.width) as f64 + place(k % ACROSS);
            let y = (pixel / self.camera.width) as f64 + place(k / ACROSS);
            let Some(direction) = self.camera.direction(x, y) else { continue };
            look(world, optics, Ray::new(self.camera.eye(), direction), &mut sights);
            for (branch, sight) in sights.iter().enumerate() {
                if sight.surface == MISS {
                    add_background(world, optics, sight, weight, &mut out);
                    continue;
                }
                let stream = seed(&[pixel as u64, k as u64, branch as u64]);
                let direct = g.direct(sight.point, sight.normal, stream);
                let same = |p: &usize| {
                    branch == 0
                        && sight.tint.is_none()
                        && base.sights[*p]
                            .first()
                            .is_some_and(|s| s.surface == sight.surface && s.front == sight.front && s.tint.is_none())
                };
                let near = std::iter::once(pixel).chain(self.neighbours(pixel)).find(same);
                match near {
                    Some(p) => self.radiance(sight, &direct, &reflected[p], weight, &mut out),
                    None => {
                        let light = self.gather(g, sight, stream, &direct, 0.25);
                        self.radiance(sight, &direct, &light, weight, &mut out);
                    }
                }
            }
        }
        out
    }
}

/// A square of pixels in which reflected light is interpolated or gathered.
struct Cell<'p, 'g, 'f> {
    painter: &'p Painter<'p>,
    base: &'p Base,
    /// Values at the corners of all cells.
    corners: &'p [(Vec<f32>, u64)],
    gatherer: &'g mut Gatherer<'f>,
    known: BTreeMap<usize, Vec<f32>>,
}

impl Cell<'_, '_, '_> {
    /// Fills the pixels `x..x+size`, `y..y+size`; corners on the far sides belong to the neighbours.
    fn fill(&mut self, x: usize, y: usize, size: usize) {
        let (w, h) = (self.painter.camera.width, self.painter.camera.height);
        if x >= w || y >= h {
            return;
        }
        if size == 1 {
            self.value(x, y);
            return;
        }
        if self.is_one_surface(x, y, size) && self.interpolate(x, y, size) {
            return;
        }
        if size == 2 {
            return self.share(x, y);
        }
        let half = size / 2;
        for (dx, dy) in [(0, 0), (half, 0), (0, half), (half, half)] {
            self.fill(x + dx, y + dy, half);
        }
    }

    /// Four pixels at an edge: those that see one surface share a value, taken where the first of them looks.
    fn share(&mut self, x: usize, y: usize) {
        let (w, h) = (self.painter.camera.width, self.painter.camera.height);
        let block: Vec<(usize, usize)> = [(0, 0), (1, 1), (1, 0), (0, 1)]
            .map(|(dx, dy)| (x + dx, y + dy))
            .into_iter()
            .filter(|(x, y)| *x < w && *y < h)
            .collect();
        let key = |(x, y): (usize, usize)| match &self.base.sights[y * w + x][..] {
            [s] if s.tint.is_none() => Some((s.surface, s.front)),
            _ => None,
        };
        let keys: Vec<_> = block.iter().map(|p| key(*p)).collect();
        for (k, (x, y)) in block.iter().enumerate() {
            let same = keys[..k].iter().position(|other| keys[k].is_some() && *other == keys[k]);
            let value = match same {
                Some(first) => self.value(block[first].0, block[first].1),
                None => self.value(*x, *y),
            };
            self.known.insert(y * w + x, value);
        }
    }

    fn is_one_surface(&self, x: usize, y: usize, size: usize) -> bool {
        let (w, h) = (self.painter.camera.width, self.painter.camera.height);
        if x + size >= w || y + size >= h {
            return false;
        }
        let key = |p: usize| match &self.base.sights[p][..] {
            [s] if s.tint.is_none() => Some((s.surface, s.front)),
            _ => None,
        };
        let first = key(y * w + x);
        first.is_some() && (y..=y + size).all(|j| (x..=x + size).all(|i| key(j * w + i) == first))
    }

    fn interpolate(&mut self, x: usize, y: usize, size: usize) -> bool {
        let w = self.painter.camera.width;
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| self.value(x + i * size, y + j * size));
        let middle = self.value(x + size / 2, y + size / 2);
        let optics = self.painter.task.optics;
        let luminous = |v: &[f32]| v.iter().zip(&optics.xyz[1]).map(|(v, w)| f64::from(v * w)).sum::<f64>();
        let direct = optics.xyz_of_direct(&self.base.direct[(y + size / 2) * w + x + size / 2], &[1.0])[1];
        let mean = corners.iter().map(|c| luminous(c)).sum::<f64>() / 4.0;
        let here = luminous(&middle);
        // The difference holds the noise of both sides as well.
        let allowed = INTERPOLATION.hypot(NOISE) * self.painter.task.options.tolerance * (here + direct);
        if (mean - here).abs() > allowed {
            return false;
        }
        for j in 0..size {
            for i in 0..size {
                let (s, t) = (i as f32 / size as f32, j as f32 / size as f32);
                let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
                let value = (0..optics.pad).map(|b| (0..4).map(|k| weights[k] * corners[k][b]).sum()).collect();
                self.known.entry((y + j) * w + x + i).or_insert(value);
            }
        }
        true
    }

    /// Gathered reflected light of a pixel, remembered.
    fn value(&mut self, x: usize, y: usize) -> Vec<f32> {
        let w = self.painter.camera.width;
        let pixel = y * w + x;
        if let Some(known) = self.known.get(&pixel) {
            return known.clone();
        }
        let value = if x.is_multiple_of(CELL) && y.is_multiple_of(CELL) {
            self.corners[y / CELL * w.div_ceil(CELL) + x / CELL].0.clone()
        } else {
            self.painter.value(self.gatherer, self.base, pixel)
        };
        self.known.insert(pixel, value.clone());
        value
    }
}

/// One picture by path tracing: `paths` paths from every pixel.
pub(super) fn trace(task: &Task<'_>, view: &View, number: usize, paths: u64) -> ViewResult {
    let (world, optics) = (task.world, task.optics);
    let camera = Camera::new(view, &world.surfaces.frame);
    let odds = super::path_tracing::emitter_odds(world, optics);
    let stream = seed(&[task.options.seed, STREAM, 100 + number as u64]);
    let samples = ACROSS * ACROSS;
    let each = (paths / samples as u64).max(1) as u32;
    let n = optics.bands.len();
    task.progress.stage(&format!("picture {}", view.name), camera.height as u64);
    let mut radiance = vec![0.0f32; camera.width * camera.height * n];
    let errors: Vec<f64> = radiance
        .par_chunks_exact_mut(n)
        .enumerate()
        .with_min_len(16)
        .map_init(
            || super::path_tracing::Tracer::new(world, optics, &odds),
            |tracer, (pixel, out)| {
                let mut values = Vec::with_capacity(samples);
                for k in 0..samples {
                    let mut own = vec![0.0f32; optics.pad];
                    pixel_sample(
                        task,
                        &camera,
                        tracer,
                        (pixel, k),
                        seed(&[stream, pixel as u64, k as u64]),
                        each,
                        &mut own,
                    );
                    values.push(own.iter().zip(&optics.xyz[1]).map(|(l, w)| f64::from(l * w)).sum::<f64>());
                    out.iter_mut().zip(&own).for_each(|(o, v)| *o += v / samples as f32);
                }
                if pixel % camera.width == 0 {
                    task.progress.advance(1);
                }
                let mean = values.iter().sum::<f64>() / samples as f64;
                let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (samples - 1) as f64;
                let half = super::statement::student((samples - 1) as f64) * (variance / samples as f64).sqrt();
                if mean > 0.0 { half / mean } else { 0.0 }
            },
        )
        .collect();
    let mut sorted: Vec<f64> = errors.into_iter().filter(|e| *e > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    ViewResult {
        view: view.clone(),
        xyz: radiance
            .chunks_exact(n)
            .map(|l| optics.bands.xyz(&l.iter().map(|x| f64::from(*x)).collect::<Vec<_>>()).map(|x| x as f32))
            .collect(),
        radiance,
        error_median: sorted.get(sorted.len() / 2).copied().unwrap_or(0.0),
        error_p95: sorted.get(sorted.len() * 95 / 100).copied().unwrap_or(0.0),
        stages: Vec::new(),
    }
}

fn pixel_sample(
    task: &Task<'_>,
    camera: &Camera,
    tracer: &mut super::path_tracing::Tracer<'_>,
    (pixel, k): (usize, usize),
    stream: u64,
    paths: u32,
    out: &mut [f32],
) {
    let place = |j: usize| (j as f64 + 0.5) / ACROSS as f64;
    let x = (pixel % camera.width) as f64 + place(k % ACROSS);
    let y = (pixel / camera.width) as f64 + place(k / ACROSS);
    let Some(direction) = camera.direction(x, y) else { return };
    let mut sights = Vec::new();
    look(task.world, task.optics, Ray::new(camera.eye(), direction), &mut sights);
    for (branch, sight) in sights.iter().enumerate() {
        if sight.surface == MISS {
            add_background(task.world, task.optics, sight, 1.0, out);
            continue;
        }
        let light = tracer.irradiance(sight.point, sight.normal, seed(&[stream, branch as u64]), paths);
        let (shares, emitted) = sight.leaving(task.world, task.optics);
        for band in 0..out.len() {
            let leaving = shares[band] * light[band] + emitted.map_or(0.0, |m| m[band]);
            out[band] += leaving * sight.tint.as_ref().map_or(1.0, |t| t[band]) * std::f32::consts::FRAC_1_PI;
        }
    }
}
