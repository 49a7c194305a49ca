//! From coefficients and the light of every hour to illuminances, each with its error.

use rayon::prelude::*;

use super::blinds::Blinds;
use super::climate::Hour;
use crate::light::sky::Patches;
use crate::measure::{Coefficients, ESTIMATES, GridCoefficients, Status, SunScratch, student};
use crate::vector::wide;

/// Independent estimates of one mesh.
const SETS: usize = ESTIMATES / 2;
/// Degrees of freedom of a variance of four estimates, and with what the other sensors of the grid lend.
const OWN: f64 = 3.0;
const POOLED: f64 = 3.0;
/// Median of a squared standard normal: turns a median of squares into a mean square.
const MEDIAN_SQUARE: f64 = 0.455;
/// Share of the difference between the light of the sun's own patch and that between patches that is stated as an error.
const BETWEEN: f64 = 0.5;
/// Illuminances of a grid over the hours with sun, `[sensor][hour]`, lx; sensors that see nothing hold zeros.
#[derive(Clone, Debug)]
pub struct Series {
    /// All light, blinds as they are.
    pub lux: Vec<f32>,
    /// Half-width at 95 %.
    pub error: Vec<f32>,
    /// The sun's own light, without reflection, all blinds open.
    pub sun: Vec<f32>,
    /// Number of hours.
    pub hours: usize,
}

impl Series {
    /// The hours of one sensor.
    #[must_use]
    pub fn of(&self, sensor: usize) -> &[f32] {
        &self.lux[sensor * self.hours..(sensor + 1) * self.hours]
    }

    /// The same, of the sun alone.
    #[must_use]
    pub fn sun_of(&self, sensor: usize) -> &[f32] {
        &self.sun[sensor * self.hours..(sensor + 1) * self.hours]
    }

    /// Errors of one sensor.
    #[must_use]
    pub fn error_of(&self, sensor: usize) -> &[f32] {
        &self.error[sensor * self.hours..(sensor + 1) * self.hours]
    }
}

/// Luminance of each patch in each hour, `[patch][hour]`, cd/m²; the ground is the last.
pub(super) struct Luminances {
    values: Vec<f32>,
    hours: usize,
}

impl Luminances {
    /// For a ground of a reflectance that lies in the open. A patch is as bright as in its middle.
    pub(super) fn new(patches: &Patches, hours: &[Hour], ground_reflectance: f64, wanted: &[bool]) -> Self {
        let n = hours.len();
        let mut values = vec![0.0f32; patches.all() * n];
        let (sky, ground) = values.split_at_mut(patches.sky() * n);
        let mut rows: Vec<_> = Vec::new();
        let mut rest = sky;
        for row in patches.rows() {
            let (own, others) = rest.split_at_mut(row.len() * n);
            rows.push((row, own));
            rest = others;
        }
        rows.into_par_iter().for_each(|(row, values)| {
            let z = patches.middle(row.start).z;
            // The height of a row makes the same of all its patches.
            let gradations: Vec<f64> = hours.iter().map(|h| h.sky.map_or(0.0, |s| s.gradation(z))).collect();
            for (p, values) in row.zip(values.chunks_exact_mut(n)).filter(|(p, _)| wanted[*p]) {
                let middle = patches.middle(p);
                for ((value, hour), gradation) in values.iter_mut().zip(hours).zip(&gradations) {
                    let luminance = hour.sky.map_or(0.0, |sky| sky.luminance_at(*gradation, middle));
                    *value = (luminance * hour.diffuse_lx) as f32;
                }
            }
        });
        for (value, hour) in ground.iter_mut().zip(hours) {
            let horizontal = hour.diffuse_lx + hour.direct_lx * hour.sun.z;
            *value = (ground_reflectance * horizontal / std::f64::consts::PI) as f32;
        }
        Self { values, hours: n }
    }

    /// Means over larger patches.
    pub(super) fn joined(&self, fine: &Patches, coarse: &Patches) -> Self {
        let mut values = vec![0.0f32; coarse.all() * self.hours];
        let mut solid_angles = vec![0.0; coarse.all()];
        let homes = fine.homes(coarse);
        for (p, home) in homes.iter().enumerate().take(fine.sky()) {
            solid_angles[*home] += fine.solid_angle(p);
        }
        for (p, home) in homes.iter().enumerate().take(fine.sky()) {
            let share = (fine.solid_angle(p) / solid_angles[*home]) as f32;
            self.add(&[(p, share)], &mut values[home * self.hours..(home + 1) * self.hours]);
        }
        self.add(&[(fine.sky(), 1.0)], &mut values[coarse.sky() * self.hours..]);
        Self { values, hours: self.hours }
    }

    fn patches(&self) -> usize {
        self.values.len() / self.hours
    }

    /// Adds the light of patches, each with its coefficient, to all hours.
    fn add(&self, terms: &[(usize, f32)], to: &mut [f32]) {
        add_terms(&self.values, terms, to);
    }
}

wide! {
    /// Adds rows of a matrix, each with its factor, to a row: four at a time, over columns that stay in the nearest cache.
    fn add_terms(matrix: &[f32], terms: &[(usize, f32)], to: &mut [f32]) {
        const PART: usize = 2048;
        let width = to.len();
        for (part, to) in to.chunks_mut(PART).enumerate() {
            let hours = to.len();
            let of = |row: usize| &matrix[row * width + part * PART..][..hours];
            let (fours, rest) = terms.as_chunks::<4>();
            for four in fours {
                let [(p, a), (q, b), (r, c), (s, d)] = *four;
                let (p, q, r, s) = (of(p), of(q), of(r), of(s));
                for h in 0..hours {
                    to[h] += (a * p[h] + b * q[h]) + (c * r[h] + d * s[h]);
                }
            }
            for (p, a) in rest {
                let luminances = of(*p);
                to.iter_mut().zip(luminances).for_each(|(to, luminance)| *to += a * luminance);
            }
        }
    }
}

/// The patches among which the sun stands in an hour, with its illuminance over their solid angles; and its own.
struct SunAt {
    between: [(usize, f32); 4],
    own: (usize, f32),
}

fn sun_at(patches: &Patches, hour: &Hour) -> SunAt {
    let luminance = |p: usize, share: f64| (share * hour.direct_lx / patches.solid_angle(p)) as f32;
    let own = patches.of(hour.sun);
    SunAt {
        between: patches.between(hour.sun).map(|(p, share)| (p, luminance(p, share))),
        own: (own, luminance(own, 1.0)),
    }
}

/// The sun's own light on one sensor: hour, opening, illuminance.
pub(super) type OwnSun = Vec<(u32, u8, f32)>;

/// All that is needed for the hours of any grid.
pub(super) struct Light<'a> {
    pub(super) coefficients: &'a Coefficients,
    pub(super) hours: &'a [Hour],
    pub(super) seen: &'a Luminances,
    pub(super) reflected: &'a Luminances,
    /// Over Tregenza's patches: finer ones do not tell more of the errors.
    pub(super) rough: Rough<'a>,
    /// Relative error left by the solver.
    pub(super) iteration: f64,
}

/// Tregenza's patches: which one holds the middle of each patch of reflected light, and their luminances.
#[derive(Clone, Copy)]
pub(super) struct Rough<'a> {
    pub(super) homes: &'a [usize],
    pub(super) luminances: &'a Luminances,
}

impl Rough<'_> {
    /// Coefficients over Tregenza's patches.
    fn joined(&self, row: &[f32], to: &mut [f32]) {
        to.fill(0.0);
        for (home, c) in self.homes.iter().zip(row) {
            to[*home] += c;
        }
    }
}

/// One sensor before its errors are pooled.
struct Raw {
    lux: Vec<f32>,
    sun: Vec<f32>,
    /// Variance of the mean over the sets; what the mesh hides, squared; what lies between patches.
    variance: Vec<f32>,
    mesh: Vec<f32>,
    between: Vec<f32>,
}

impl Light<'_> {
    /// The sun's own light on every sensor of a grid, all blinds open.
    pub(super) fn own_suns(&self, g: usize) -> Vec<OwnSun> {
        let count = self.coefficients.grids[g].seen.len();
        let homes: Vec<usize> = self.hours.iter().map(|h| self.coefficients.seen_patches.of(h.sun)).collect();
        (0..count)
            .into_par_iter()
            .with_max_len(4)
            .map_init(|| self.coefficients.scratch(), |scratch, i| self.own_sun(g, i, &homes, scratch))
            .collect()
    }

    /// The sun's own light, where it can come from; `homes` are the patches in which the sun stands.
    fn own_sun(&self, g: usize, i: usize, homes: &[usize], scratch: &mut SunScratch) -> OwnSun {
        let sunny = self.coefficients.sunny_patches(g, i);
        let mut list = OwnSun::new();
        for (t, (hour, home)) in self.hours.iter().zip(homes).enumerate() {
            if hour.direct_lx > 0.0 && sunny[*home] {
                let (factor, opening) = self.coefficients.sun(g, i, hour.sun, scratch);
                if factor > 0.0 {
                    list.push((t as u32, opening as u8, (hour.direct_lx * factor) as f32));
                }
            }
        }
        list
    }

    /// The hours of a grid.
    pub(super) fn series(&self, g: usize, suns: &[OwnSun], blinds: &Blinds) -> Series {
        let grid = &self.coefficients.grids[g];
        let places: Vec<SunAt> = self.hours.iter().map(|h| sun_at(&self.coefficients.patches, h)).collect();
        let count = grid.seen.len();
        let raw: Vec<Raw> =
            (0..count).into_par_iter().with_max_len(4).map(|i| self.raw(grid, i, &suns[i], &places, blinds)).collect();
        let n = self.hours.len();
        let lit: Vec<usize> = (0..count).filter(|i| grid.status(*i) == Status::Ok).collect();
        let by_hour: Vec<Vec<f32>> =
            (0..n).into_par_iter().with_min_len(64).map(|t| self.errors(&raw, &lit, t)).collect();
        let mut series = Series {
            lux: Vec::with_capacity(count * n),
            error: vec![0.0; count * n],
            sun: Vec::with_capacity(count * n),
            hours: n,
        };
        for r in &raw {
            series.lux.extend_from_slice(&r.lux);
            series.sun.extend_from_slice(&r.sun);
        }
        for (t, errors) in by_hour.iter().enumerate() {
            for (i, e) in lit.iter().zip(errors) {
                series.error[i * n + t] = *e;
            }
        }
        series
    }

    fn raw(&self, grid: &GridCoefficients, i: usize, own: &OwnSun, places: &[SunAt], blinds: &Blinds) -> Raw {
        let n = self.hours.len();
        let zeros = || vec![0.0f32; n];
        let mut raw = Raw { lux: zeros(), sun: zeros(), variance: zeros(), mesh: zeros(), between: zeros() };
        if grid.status(i) != Status::Ok {
            return raw;
        }
        for (t, opening, lux) in own {
            raw.sun[*t as usize] = *lux;
            if !blinds.are_closed(*opening as usize, *t as usize) {
                raw.lux[*t as usize] += lux;
            }
        }
        let mut estimates: [Vec<f32>; ESTIMATES] = std::array::from_fn(|_| zeros());
        let mut between = [zeros(), zeros()];
        let (fine, patches) = (self.coefficients.seen_patches.all(), self.coefficients.patches.all());
        let width = self.coefficients.openings * patches;
        let (mut part, mut rough) = (zeros(), vec![0.0f32; self.rough.luminances.patches()]);
        let mut terms = Vec::new();
        for opening in 0..self.coefficients.openings {
            let mut light = |luminances: &Luminances, of: &mut dyn Iterator<Item = (usize, f32)>, to: &mut [f32]| {
                terms.clear();
                terms.extend(of.filter(|(_, c)| *c != 0.0));
                to.fill(0.0);
                luminances.add(&terms, to);
            };
            let columns = (opening * fine) as u32..((opening + 1) * fine) as u32;
            let seen = grid.seen[i].iter().filter(|(c, _)| columns.contains(c));
            light(self.seen, &mut seen.map(|(column, c)| (*column as usize - opening * fine, *c)), &mut part);
            blinds.add(opening, &part, &mut raw.lux);
            let row = i * width + opening * patches..i * width + (opening + 1) * patches;
            let mean_of = |of: &[Vec<f32>; ESTIMATES], p: usize| {
                of[..SETS].iter().map(|k| k[row.start + p]).sum::<f32>() / SETS as f32
            };
            let mut means = (0..patches).map(|p| (p, mean_of(&grid.reflected[0], p)));
            light(self.reflected, &mut means, &mut part);
            blinds.add(opening, &part, &mut raw.lux);
            for (k, estimate) in estimates.iter_mut().enumerate() {
                self.rough.joined(&grid.reflected[0][k][row.clone()], &mut rough);
                light(self.rough.luminances, &mut rough.iter().copied().enumerate(), &mut part);
                let of_sun = &grid.of_sun()[k][row.clone()];
                for (value, sun) in part.iter_mut().zip(places) {
                    *value += sun.between.iter().map(|(p, l)| l * of_sun[*p]).sum::<f32>();
                }
                blinds.add(opening, &part, estimate);
            }
            let of_sun: Vec<f32> = (0..patches).map(|p| mean_of(grid.of_sun(), p)).collect();
            for (value, sun) in part.iter_mut().zip(places) {
                *value = of_sun[sun.own.0] * sun.own.1;
            }
            blinds.add(opening, &part, &mut between[0]);
            for (value, sun) in part.iter_mut().zip(places) {
                *value = sun.between.iter().map(|(p, l)| l * of_sun[*p]).sum();
            }
            blinds.add(opening, &part, &mut between[1]);
            blinds.add(opening, &part, &mut raw.lux);
        }
        for t in 0..n {
            let values: [f64; ESTIMATES] = std::array::from_fn(|k| f64::from(estimates[k][t]));
            let (_, variance) = mean_and_variance(&values[..SETS]);
            let differences: [f64; SETS] = std::array::from_fn(|k| values[k] - values[SETS + k]);
            let (difference, its_variance) = mean_and_variance(&differences);
            raw.variance[t] = variance as f32;
            raw.mesh[t] = (difference * difference - its_variance) as f32;
            raw.between[t] = (between[0][t] - between[1][t]).abs();
        }
        raw
    }

    /// Errors of the sensors that see, in one hour: as [`crate::measure`] states them, with what the grid lends.
    fn errors(&self, raw: &[Raw], lit: &[usize], t: usize) -> Vec<f32> {
        let count = lit.len().max(1) as f64;
        let mean = lit.iter().map(|i| f64::from(raw[*i].lux[t])).sum::<f64>() / count;
        if mean <= 0.0 {
            return vec![0.0; lit.len()];
        }
        let scales: Vec<f64> = lit.iter().map(|i| f64::from(raw[*i].lux[t]).max(0.1 * mean)).collect();
        let relative = |f: &dyn Fn(&Raw) -> f32| -> Vec<f64> {
            lit.iter().zip(&scales).map(|(i, s)| f64::from(f(&raw[*i])) / (s * s)).collect()
        };
        let variances = relative(&|r| r.variance[t]);
        let meshes = relative(&|r| r.mesh[t]);
        let of_grid = variances.iter().sum::<f64>() / count;
        let mut sorted: Vec<f64> = meshes.iter().map(|x| x.max(0.0)).collect();
        let middle = sorted.len() / 2;
        let typical = (*sorted.select_nth_unstable_by(middle, f64::total_cmp).1 / MEDIAN_SQUARE)
            .min(meshes.iter().sum::<f64>() / count)
            .max(0.0);
        let quantile = student(OWN + POOLED);
        lit.iter()
            .zip(&scales)
            .zip(variances.iter().zip(&meshes))
            .map(|((i, scale), (own, mesh))| {
                let r = &raw[*i];
                let noise = ((OWN * own + POOLED * of_grid) / (OWN + POOLED)).max(*own);
                let between = BETWEEN * f64::from(r.between[t]);
                let square = (quantile * quantile * noise + mesh.max(typical)) * scale * scale + between * between;
                (square.sqrt() + self.iteration * f64::from(r.lux[t])) as f32
            })
            .collect()
    }
}

/// Mean of independent estimates, and the variance of that mean.
fn mean_and_variance(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)))
}
