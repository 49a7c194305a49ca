//! Pictures: exact direct light at every pixel; reflected light gathered at few places and fitted between them.

mod judge;
mod paths;
mod records;
mod sheets;
mod sight;
mod survey;
mod tiles;

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

use self::judge::{Noise, judge};
use self::records::{Records, Shares};
use self::sheets::Sheets;
use self::sight::{Sight, add_background, look};
use self::tiles::Tiles;
use super::adaptive::Task;
use super::camera::Camera;
use super::gather::{Field, Gatherer, SetSums};
use super::result::ViewResult;
use super::solved::Solved;
use super::statement::median;
use crate::scene::View;
use crate::transport::caster::{MISS, Ray};
use crate::transport::points::{Points, seed};
use crate::transport::{Optics, World};

pub(super) use self::paths::trace;

/// Samples across a pixel that holds an edge.
const ACROSS: usize = 4;
/// Neighbours that differ by more than this in luminance get the finer sampling.
const CONTRAST: f32 = 0.1;
/// Rays of a sample that no record is near to, as a share of a record's.
const ALONE: f64 = 0.25;
/// Share of the tolerance by which neighbouring pixels may be off a plane for their direct light to serve between them.
const EVEN: f64 = 0.25;
const STREAM: u64 = 7;

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

/// One plain pass: what the middle of every pixel sees, with its direct light.
struct Base {
    sights: Vec<Vec<Sight>>,
    /// Irradiance without reflection at the first sight, by group.
    direct: Vec<Vec<f64>>,
    sheets: Sheets,
}

/// Makes one picture. Returns the rays it took too.
pub(super) fn paint(task: &Task<'_>, view: &View, number: usize, main: &Solved, twin: &Solved) -> (ViewResult, u64) {
    let camera = Camera::new(view, &task.world.surfaces.frame);
    let stream = seed(&[task.options.seed, STREAM, 1 + number as u64]);
    let judged = judge(task, &camera, main, twin, stream);
    let mean = main.averaged(task.optics);
    let field =
        Field { world: task.world, optics: task.optics, main: &mean, twin: None, spectral: true, squares: false };
    let painter = Painter { task, camera, field: &field, noise: judged.noise, stream };
    let base = painter.base();
    let (lit, gathered) = painter.survey(&base);
    task.progress.stage(&format!("picture {}: shade", view.name), camera.height as u64);
    let plain = painter.shade(&lit);
    let (radiance, more) = painter.smooth(&lit, plain);
    let mut errors: Vec<f64> = judged
        .places
        .iter()
        .zip(&judged.stated)
        .filter(|(_, s)| s.scale > 0.0)
        .map(|(place, s)| s.error.hypot(painter.fitted(&lit, place) - s.value) / s.scale)
        .collect();
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
    (result, judged.rays + gathered + more)
}

/// What sights are shaded with: the plain pass, and the reflected light known for it.
struct Lit<'a> {
    base: &'a Base,
    records: Records,
    tiles: Tiles,
}

/// The same, in one square of the picture.
#[derive(Clone, Copy)]
struct Known<'a> {
    lit: &'a Lit<'a>,
    tile: usize,
}

/// Buffers of one thread.
struct Brush<'a> {
    gatherer: Gatherer<'a>,
    shares: Shares,
    reflected: Vec<f32>,
    sights: Vec<Sight>,
}

impl<'a> Painter<'a> {
    fn pixels(&self) -> usize {
        self.camera.width * self.camera.height
    }

    fn brush(&self) -> Brush<'a> {
        Brush {
            gatherer: Gatherer::new(self.field),
            shares: Shares::new(),
            reflected: vec![0.0; self.task.optics.pad],
            sights: Vec::new(),
        }
    }

    fn base(&self) -> Base {
        let (world, optics) = (self.task.world, self.task.optics);
        let (sights, direct): (Vec<Vec<Sight>>, Vec<Vec<f64>>) = (0..self.pixels())
            .into_par_iter()
            .with_min_len(64)
            .map_init(
                || Gatherer::new(self.field),
                |g, pixel| {
                    let mut sights = Vec::new();
                    let (x, y) = self.corner(pixel);
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
        let sheets = Sheets::new(world, sights.iter().flatten());
        Base { sights, direct, sheets }
    }

    /// Upper left corner of a pixel.
    fn corner(&self, pixel: usize) -> (f64, f64) {
        ((pixel % self.camera.width) as f64, (pixel / self.camera.width) as f64)
    }

    /// Reflected irradiance at a sight by band, into the brush: fitted, or gathered where no record is near.
    fn reflected(&self, known: Known<'_>, sight: &Sight, (stream, direct): (u64, &[f64]), brush: &mut Brush<'_>) {
        if let Some((sheet, at)) = known.lit.base.sheets.place(sight) {
            let own;
            let near = match known.lit.tiles.near(known.tile, sheet) {
                Some(near) => near,
                None => {
                    own = known.lit.records.near(sheet, at);
                    &own
                }
            };
            if known.lit.records.fit(near, at, None, &mut brush.shares).is_some() {
                known.lit.records.light(&brush.shares, &mut brush.reflected);
                return;
            }
        }
        let gathered = self.gather(&mut brush.gatherer, sight, stream, direct, ALONE);
        let bands = gathered.sums.bands(0, self.task.optics.pad, false);
        brush.reflected.iter_mut().zip(bands).for_each(|(out, x)| *out = x as f32);
    }

    /// Illuminance that the picture has at a judged place, lx.
    fn fitted(&self, lit: &Lit<'_>, place: &judge::Place) -> f64 {
        let Some(sight) = lit.base.sights[place.pixel].first() else { return 0.0 };
        let direct = &lit.base.direct[place.pixel];
        let known = Known { lit, tile: lit.tiles.of(place.pixel) };
        let mut brush = self.brush();
        self.reflected(known, sight, (place.pixel as u64, direct), &mut brush);
        let weights = &self.task.optics.xyz[1];
        let reflected: f32 = brush.reflected.iter().zip(weights).map(|(l, w)| l * w).sum();
        f64::from(reflected) + self.task.optics.xyz_of_direct(direct, &[1.0])[1]
    }

    /// Radiance of a sight from its irradiance, added to `out` with a weight.
    fn radiance(&self, sight: &Sight, direct: &[f64], reflected: &[f32], weight: f32, out: &mut [f32]) {
        let (world, optics) = (self.task.world, self.task.optics);
        let (shares, emitted) = sight.leaving(world, optics);
        for band in 0..optics.pad {
            let arriving: f32 = reflected[band] + optics.direct_in_band(direct, band) as f32;
            let leaving = shares[band] * arriving + emitted.map_or(0.0, |m| m[band]);
            let left = sight.tint.as_ref().map_or(1.0, |t| t[band]);
            out[band] += weight * left * leaving * std::f32::consts::FRAC_1_PI;
        }
    }

    /// Adds what is seen along one ray; `first` is the direct light at its first sight, where known.
    fn shine(
        &self,
        known: Known<'_>,
        (sights, first): (&[Sight], Option<&[f64]>),
        (sample, weight): (u64, f32),
        brush: &mut Brush<'_>,
        out: &mut [f32],
    ) {
        for (k, sight) in sights.iter().enumerate() {
            if sight.surface == MISS {
                add_background(self.task.world, self.task.optics, sight, weight, out);
                continue;
            }
            let stream = seed(&[self.stream, sample, k as u64]);
            let own;
            let direct = match first.filter(|_| k == 0) {
                Some(direct) => direct,
                None => {
                    own = brush.gatherer.direct(sight.point, sight.normal, stream);
                    &own
                }
            };
            self.reflected(known, sight, (stream, direct), brush);
            self.radiance(sight, direct, &brush.reflected, weight, out);
        }
    }

    /// The picture with one sample in the middle of each pixel.
    fn shade(&self, lit: &Lit<'_>) -> Vec<f32> {
        let pad = self.task.optics.pad;
        let tiles: Vec<Vec<f32>> = (0..lit.tiles.count())
            .into_par_iter()
            .map_init(
                || self.brush(),
                |brush, tile| {
                    let known = Known { lit, tile };
                    let mut out = vec![0.0; lit.tiles.pixels(tile).count() * pad];
                    for (pixel, out) in lit.tiles.pixels(tile).zip(out.chunks_exact_mut(pad)) {
                        let seen = (&lit.base.sights[pixel][..], Some(&lit.base.direct[pixel][..]));
                        self.shine(known, seen, (pixel as u64, 1.0), brush, out);
                    }
                    self.task.progress.advance(lit.tiles.rows_done(tile));
                    out
                },
            )
            .collect();
        let mut picture = vec![0.0f32; self.pixels() * pad];
        for (tile, values) in tiles.iter().enumerate() {
            for (pixel, value) in lit.tiles.pixels(tile).zip(values.chunks_exact(pad)) {
                picture[pixel * pad..(pixel + 1) * pad].copy_from_slice(value);
            }
        }
        picture
    }

    /// Samples the pixels that hold an edge more finely.
    fn smooth(&self, lit: &Lit<'_>, plain: Vec<f32>) -> (Vec<f32>, u64) {
        let pad = self.task.optics.pad;
        let y: Vec<f32> = plain
            .par_chunks_exact(pad)
            .map(|l| l.iter().zip(&self.task.optics.xyz[1]).map(|(l, w)| l * w).sum())
            .collect();
        let finer: Vec<Vec<(usize, Vec<f32>, u64)>> = (0..lit.tiles.count())
            .into_par_iter()
            .map_init(
                || self.brush(),
                |brush, tile| {
                    let edges: Vec<usize> = lit.tiles.pixels(tile).filter(|p| self.is_edge(*p, lit.base, &y)).collect();
                    let known = Known { lit, tile };
                    let sample = |pixel: usize| {
                        let before = brush.gatherer.cast + brush.gatherer.scratch.rays;
                        let value = self.supersample(pixel, known, &y, brush);
                        (pixel, value, brush.gatherer.cast + brush.gatherer.scratch.rays - before)
                    };
                    edges.into_iter().map(sample).collect()
                },
            )
            .collect();
        let mut picture = plain;
        let mut rays = 0;
        for (pixel, value, cast) in finer.into_iter().flatten() {
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
        let own = key(&base.sights[pixel]);
        self.neighbours(pixel).any(|p| {
            let (a, b) = (y[pixel], y[p]);
            (key(&base.sights[p]) != own && (a != b)) || (a - b).abs() > CONTRAST * a.max(b)
        })
    }

    /// Direct light of a sample at a place from the middle of its pixel, in pixels, told by the neighbours whose middles
    /// show the same face: along the plane through their luminances, where none is off it by more than a share of the
    /// tolerance. A shadow's edge is no plane.
    fn direct_beside(&self, pixel: usize, (sights, at): (&[Sight], DVec2), base: &Base, y: &[f32]) -> Option<Vec<f64>> {
        sights.first().filter(|s| s.surface != MISS)?;
        let own = key(sights);
        let (column, row) = self.corner(pixel);
        let middle = DVec2::new(column, row);
        let alike: Vec<(usize, DVec2)> = self
            .neighbours(pixel)
            .filter(|p| key(&base.sights[*p]) == own)
            .map(|p| (p, DVec2::from(self.corner(p)) - middle))
            .collect();
        let plane = Plane::new(alike.iter().map(|(_, at)| *at))?;
        let told = |at: DVec2, of: &dyn Fn(usize) -> f64| -> f64 {
            alike.iter().map(|(p, from)| plane.weight(*from, at) * of(*p)).sum()
        };
        let luminance = |p: usize| f64::from(y[p]);
        let high = alike.iter().map(|(p, _)| luminance(*p)).fold(0.0, f64::max);
        let allowed = EVEN * self.noise.tolerance * high;
        let is_even = alike.iter().all(|(p, at)| (told(*at, &luminance) - luminance(*p)).abs() <= allowed);
        is_even.then(|| {
            let columns = self.task.optics.columns();
            (0..columns).map(|c| told(at, &|p| base.direct[p][c]).max(0.0)).collect()
        })
    }

    fn supersample(&self, pixel: usize, known: Known<'_>, y: &[f32], brush: &mut Brush<'_>) -> Vec<f32> {
        let (world, optics) = (self.task.world, self.task.optics);
        let mut out = vec![0.0; optics.pad];
        let samples = ACROSS * ACROSS;
        let mut sights = std::mem::take(&mut brush.sights);
        for k in 0..samples {
            let place = DVec2::new((k % ACROSS) as f64 + 0.5, (k / ACROSS) as f64 + 0.5) / ACROSS as f64;
            let (left, top) = self.corner(pixel);
            let direction = self.camera.direction(left + place.x, top + place.y);
            let Some(direction) = direction else { continue };
            look(world, optics, Ray::new(self.camera.eye(), direction), &mut sights);
            let sample = seed(&[pixel as u64, 1 + k as u64]);
            let first = self.direct_beside(pixel, (&sights, place - 0.5), known.lit.base, y);
            self.shine(known, (&sights, first.as_deref()), (sample, 1.0 / samples as f32), brush, &mut out);
        }
        brush.sights = sights;
        out
    }
}

/// The plane of least squares through values at places.
struct Plane {
    mean: DVec2,
    count: f64,
    /// Of the covariance of the places.
    inverse: DMat2,
}

impl Plane {
    /// `None` where the places are too few to say whether the values lie on a plane.
    fn new(places: impl ExactSizeIterator<Item = DVec2> + Clone) -> Option<Self> {
        let count = places.len() as f64;
        let mean = places.clone().sum::<DVec2>() / count;
        let outer = |d: DVec2| DMat2::from_cols(d * d.x, d * d.y);
        let spread = places.clone().map(|p| outer(p - mean)).fold(DMat2::ZERO, |a, b| a + b);
        (places.len() > 3 && spread.determinant() > 0.1).then(|| Self { mean, count, inverse: spread.inverse() })
    }

    /// Weight that the value at one place has in the plane at another.
    fn weight(&self, from: DVec2, at: DVec2) -> f64 {
        1.0 / self.count + (at - self.mean).dot(self.inverse * (from - self.mean))
    }
}

/// What tells the face that a pixel shows from another.
fn key(sights: &[Sight]) -> Option<(u32, bool, usize)> {
    sights.first().map(|s| (s.surface, s.front, sights.len()))
}

/// What the rays of one place brought.
struct Gathered {
    sums: SetSums,
    /// Mean of the inverse distances to what they met, in the program's frame.
    nearness: f64,
    /// Reflected and direct illuminance, lx.
    reflected_y: f64,
    direct_y: f64,
}

impl Painter<'_> {
    /// Gathers reflected light at a sight, with a share of the rays that its noise asks for.
    fn gather(&self, g: &mut Gatherer<'_>, sight: &Sight, stream: u64, direct: &[f64], share: f64) -> Gathered {
        let optics = self.task.optics;
        let mut sums = SetSums::new(optics, 1, false);
        let stream = seed(&[self.stream, 3, stream]);
        let before = g.nearness;
        g.gather(sight.point, sight.normal.into(), stream, (0, judge::FIRST_RAYS / 2), &mut sums);
        let mean = sums.xyz(0, optics, &[1.0], false)[1];
        let direct_y = optics.xyz_of_direct(direct, &[1.0])[1];
        let wanted = self.noise.rays(sums.variance_y(), mean + direct_y, share);
        g.gather(sight.point, sight.normal.into(), stream, (judge::FIRST_RAYS / 2, wanted), &mut sums);
        let cast = f64::from(wanted.max(judge::FIRST_RAYS / 2));
        let reflected_y = sums.xyz(0, optics, &[1.0], false)[1];
        Gathered { nearness: (g.nearness - before) / cast, sums, reflected_y, direct_y }
    }
}

/// Distance from the eye and cosine of a sight's plane against the view, for the size of a pixel there.
fn seen_from(eye: DVec3, sight: &Sight) -> (f64, f64) {
    let way = sight.point - eye;
    let distance = way.length();
    (distance, way.dot(sight.normal).abs() / distance.max(1e-300))
}
