//! From coefficients and the light of every hour to illuminances, each with its error.

use rayon::prelude::*;

use super::blinds::Blinds;
use super::climate::Hour;
use crate::light::sky::Patches;
use crate::measure::{Coefficients, ESTIMATES, GridCoefficients, Status, SunScratch, student};
use crate::transport::PanelSun;
use crate::vector::wide;

/// Independent estimates of one mesh.
const SETS: usize = ESTIMATES / 2;
/// Degrees of freedom of a variance of four estimates, and with what the other sensors of the grid lend.
const OWN: f64 = 3.0;
const POOLED: f64 = 3.0;
/// Median of a squared standard normal: turns a median of squares into a mean square.
const MEDIAN_SQUARE: f64 = 0.455;
/// Share of the difference between the light of the sun's own patch and that between patches that is stated as an error.
const BETWEEN: f32 = 0.5;
/// Share of the difference between the sun on the zones of windows with a BSDF and the same evenly over each window that is
/// stated as an error: with eight zones a zone is less than half as wide as its window, and what its shadows leave falls with
/// the square of that.
const ZONES: f32 = 0.25;
/// Illuminances of a grid over the hours with sun, `[sensor][hour]`, lx; sensors that see nothing hold zeros.
#[derive(Clone, Debug)]
pub struct Series {
    /// All light, blinds as they are.
    pub lux: Vec<f32>,
    /// Half-width at 95 %.
    pub error: Vec<f32>,
    /// The sun's own light, without reflection, all blinds open; what windows with a BSDF scatter is no part of it.
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
    /// Luminance that it gives to the ground.
    ground: f32,
}

fn sun_at(patches: &Patches, hour: &Hour, ground_reflectance: f64) -> SunAt {
    let luminance = |p: usize, share: f64| (share * hour.direct_lx / patches.solid_angle(p)) as f32;
    let own = patches.of(hour.sun);
    SunAt {
        between: patches.between(hour.sun).map(|(p, share)| (p, luminance(p, share))),
        own: (own, luminance(own, 1.0)),
        ground: (ground_reflectance * hour.direct_lx * hour.sun.z / std::f64::consts::PI) as f32,
    }
}

/// The sun's own light on one sensor: hour, opening, illuminance; and the same by mirrors and panes that throw it on.
#[derive(Clone, Debug, Default)]
pub(super) struct OwnSun {
    pub(super) straight: Vec<(u32, u8, f32)>,
    mirrored: Vec<(u32, u8, f32)>,
}

/// The sun on windows with a BSDF in one hour.
pub(super) struct OnPanel {
    sun: PanelSun,
    opening: usize,
    direct_lx: f64,
}

/// All that is needed for the hours of any grid.
pub(super) struct Light<'a> {
    pub(super) coefficients: &'a Coefficients,
    pub(super) hours: &'a [Hour],
    pub(super) ground_reflectance: f64,
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
    /// Variance of the mean over the sets; what the mesh hides, squared; what lies between patches and between zones.
    variance: Vec<f32>,
    mesh: Vec<f32>,
    between: Vec<f32>,
}

impl Light<'_> {
    /// The sun's own light on every sensor of a grid, all blinds open.
    pub(super) fn own_suns(&self, g: usize) -> Vec<OwnSun> {
        let count = self.coefficients.grids[g].seen.len();
        let homes: Vec<usize> = self.hours.iter().map(|h| self.coefficients.seen_patches.of(h.sun)).collect();
        let straight = |scratch: &mut SunScratch, i: usize| self.own_sun(g, i, &homes, scratch);
        let scratch = || self.coefficients.scratch();
        let straight = (0..count).into_par_iter().with_max_len(4).map_init(scratch, straight);
        let mut suns: Vec<OwnSun> = straight.map(|straight| OwnSun { straight, mirrored: Vec::new() }).collect();
        if self.coefficients.has_images() {
            let mirrored = |scratch: &mut SunScratch, hour: &Hour| self.mirrored_suns(g, hour, scratch);
            let by_hour: Vec<_> = self.hours.par_iter().with_max_len(16).map_init(scratch, mirrored).collect();
            for (t, found) in by_hour.into_iter().enumerate() {
                found.into_iter().for_each(|(i, opening, lux)| suns[i].mirrored.push((t as u32, opening, lux)));
            }
        }
        suns
    }

    /// The sun's light by mirrors and panes in one hour: sensor, opening, illuminance.
    fn mirrored_suns(&self, g: usize, hour: &Hour, scratch: &mut SunScratch) -> Vec<(usize, u8, f32)> {
        let mut list = Vec::new();
        if hour.direct_lx <= 0.0 {
            return list;
        }
        let images = self.coefficients.images(hour.sun);
        let grid = &self.coefficients.grids[g];
        let mut by_opening = vec![0.0; self.coefficients.openings];
        for i in (0..grid.seen.len()).filter(|i| grid.status(*i) == Status::Ok) {
            by_opening.fill(0.0);
            self.coefficients.mirrored_sun(g, i, &images, scratch, &mut by_opening);
            let lit = by_opening.iter().enumerate().filter(|(_, factor)| **factor > 0.0);
            list.extend(lit.map(|(opening, factor)| (i, opening as u8, (hour.direct_lx * factor) as f32)));
        }
        list
    }

    /// The sun on windows with a BSDF, by hour.
    pub(super) fn suns_on_panels(&self) -> Vec<Vec<OnPanel>> {
        if !self.coefficients.has_panels() {
            return Vec::new();
        }
        let of = |scratch: &mut SunScratch, hour: &Hour| -> Vec<OnPanel> {
            let direct_lx = hour.direct_lx;
            if direct_lx <= 0.0 {
                return Vec::new();
            }
            let suns = self.coefficients.suns_on_panels(hour.sun, scratch).into_iter();
            suns.map(|(sun, opening)| OnPanel { sun, opening, direct_lx }).collect()
        };
        self.hours.par_iter().with_max_len(16).map_init(|| self.coefficients.scratch(), of).collect()
    }

    /// The sun's own light, where it can come from; `homes` are the patches in which the sun stands.
    fn own_sun(&self, g: usize, i: usize, homes: &[usize], scratch: &mut SunScratch) -> Vec<(u32, u8, f32)> {
        let sunny = self.coefficients.sunny_patches(g, i);
        let mut list = Vec::new();
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
    pub(super) fn series(&self, g: usize, (suns, on_panels): (&[OwnSun], &[Vec<OnPanel>]), blinds: &Blinds) -> Series {
        let grid = &self.coefficients.grids[g];
        let place = |h: &Hour| sun_at(&self.coefficients.patches, h, self.ground_reflectance);
        let places: Vec<SunAt> = self.hours.iter().map(place).collect();
        let count = grid.seen.len();
        let raw = |i: usize| self.raw((grid, i), (&suns[i], &places, on_panels), blinds);
        let raw: Vec<Raw> = (0..count).into_par_iter().with_max_len(4).map(raw).collect();
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

    fn raw(
        &self,
        (grid, i): (&GridCoefficients, usize),
        (own, places, on_panels): (&OwnSun, &[SunAt], &[Vec<OnPanel>]),
        blinds: &Blinds,
    ) -> Raw {
        let n = self.hours.len();
        let zeros = || vec![0.0f32; n];
        let mut raw = Raw { lux: zeros(), sun: zeros(), variance: zeros(), mesh: zeros(), between: zeros() };
        if grid.status(i) != Status::Ok {
            return raw;
        }
        for (t, _, lux) in &own.straight {
            raw.sun[*t as usize] = *lux;
        }
        for (t, opening, lux) in own.straight.iter().chain(&own.mirrored) {
            if !blinds.are_closed(*opening as usize, *t as usize) {
                raw.lux[*t as usize] += lux;
            }
        }
        let mut estimates: [Vec<f32>; ESTIMATES] = std::array::from_fn(|_| zeros());
        let mut between = [zeros(), zeros()];
        let (fine, patches) = (self.coefficients.seen_patches.all(), self.coefficients.patches.all());
        let (openings, width) = (self.coefficients.openings, self.coefficients.sheets * patches);
        let of_sky: [_; ESTIMATES] = std::array::from_fn(|k| grid.of_sky(k, i, width));
        let of_suns: [_; ESTIMATES] = std::array::from_fn(|k| &grid.of_sun()[k][i * width..(i + 1) * width]);
        let (mut part, mut rough) = (zeros(), vec![0.0f32; self.rough.luminances.patches()]);
        let mut terms = Vec::new();
        for sheet in 0..self.coefficients.sheets {
            let (opening, columns) = (sheet % openings, sheet * patches..(sheet + 1) * patches);
            let mut light = |luminances: &Luminances, of: &mut dyn Iterator<Item = (usize, f32)>, to: &mut [f32]| {
                terms.clear();
                terms.extend(of.filter(|(_, c)| *c != 0.0));
                to.fill(0.0);
                luminances.add(&terms, to);
            };
            // What windows with a BSDF send on is seen neither directly nor under the sun's patches.
            let is_plain = sheet < openings;
            if is_plain {
                let own = (sheet * fine) as u32..((sheet + 1) * fine) as u32;
                let seen = grid.seen[i].iter().filter(|(c, _)| own.contains(c));
                light(self.seen, &mut seen.map(|(column, c)| (*column as usize - sheet * fine, *c)), &mut part);
                blinds.add(opening, &part, &mut raw.lux);
            }
            let mut means = (columns.clone()).map(|c| (c - columns.start, mean(|k| of_sky[k][c])));
            light(self.reflected, &mut means, &mut part);
            blinds.add(opening, &part, &mut raw.lux);
            for (k, estimate) in estimates.iter_mut().enumerate() {
                self.rough.joined(&of_sky[k][columns.clone()], &mut rough);
                light(self.rough.luminances, &mut rough.iter().copied().enumerate(), &mut part);
                if is_plain {
                    let of_sun = &of_suns[k][columns.clone()];
                    for (value, sun) in part.iter_mut().zip(places) {
                        *value += sun.between.iter().map(|(p, l)| l * of_sun[*p]).sum::<f32>();
                    }
                }
                blinds.add(opening, &part, estimate);
            }
            if grid.reflected.len() > 1 {
                // The sun lights the ground with its own spectrum.
                let ground = columns.end - 1;
                let (sun, sky) = (mean(|k| of_suns[k][ground]), mean(|k| of_sky[k][ground]));
                let seen = |of: &[(u32, f32)]| {
                    let own = of.iter().filter(|(c, _)| is_plain && *c as usize == (sheet + 1) * fine - 1);
                    own.map(|(_, c)| *c).sum::<f32>()
                };
                let more = sun - sky + seen(&grid.seen_of_sun[i]) - seen(&grid.seen[i]);
                part.iter_mut().zip(places).for_each(|(value, sun)| *value = more * sun.ground);
                blinds.add(opening, &part, &mut raw.lux);
            }
            if !is_plain {
                continue;
            }
            let of_sun: Vec<f32> = columns.clone().map(|c| mean(|k| of_suns[k][c])).collect();
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
        let zones = self.add_suns_on_panels((grid, i), on_panels, blinds, (&mut raw.lux, &mut estimates));
        for t in 0..n {
            let values: [f64; ESTIMATES] = std::array::from_fn(|k| f64::from(estimates[k][t]));
            let (_, variance) = mean_and_variance(&values[..SETS]);
            let differences: [f64; SETS] = std::array::from_fn(|k| values[k] - values[SETS + k]);
            let (difference, its_variance) = mean_and_variance(&differences);
            raw.variance[t] = variance as f32;
            raw.mesh[t] = (difference * difference - its_variance) as f32;
            raw.between[t] = (BETWEEN * (between[0][t] - between[1][t])).hypot(ZONES * zones[t]);
        }
        raw
    }

    /// Adds the sun by way of windows with a BSDF to the light and its estimates. Returns what it makes that it does not fall
    /// evenly on them.
    fn add_suns_on_panels(
        &self,
        (grid, i): (&GridCoefficients, usize),
        on_panels: &[Vec<OnPanel>],
        blinds: &Blinds,
        (lux, estimates): (&mut [f32], &mut [Vec<f32>; ESTIMATES]),
    ) -> Vec<f32> {
        let of: [&[f32]; ESTIMATES] = std::array::from_fn(|k| grid.by_panels(k, i));
        let mut uneven = vec![0.0; self.hours.len()];
        for (t, panel) in on_panels.iter().enumerate().flat_map(|(t, list)| list.iter().map(move |p| (t, p))) {
            let light = panel.direct_lx * blinds.share(panel.opening, t);
            let own = panel.sun.first..panel.sun.first + panel.sun.irradiance.len();
            let mut even = 0.0;
            for (k, estimate) in estimates.iter_mut().enumerate() {
                let zones = of[k][own.clone()].iter().zip(&panel.sun.irradiance);
                let value = light * zones.map(|(c, e)| f64::from(*c) * e).sum::<f64>();
                estimate[t] += value as f32;
                if k < SETS {
                    lux[t] += (value / SETS as f64) as f32;
                    let all: f64 = of[k][own.clone()].iter().map(|c| f64::from(*c)).sum();
                    even += (light * panel.sun.mean * all - value) / SETS as f64;
                }
            }
            uneven[t] += even as f32;
        }
        uneven
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
                let between = f64::from(r.between[t]);
                let square = (quantile * quantile * noise + mesh.max(typical)) * scale * scale + between * between;
                (square.sqrt() + self.iteration * f64::from(r.lux[t])) as f32
            })
            .collect()
    }
}

/// Mean over the estimates of the finer mesh.
fn mean(of: impl Fn(usize) -> f32) -> f32 {
    (0..SETS).map(of).sum::<f32>() / SETS as f32
}

/// Mean of independent estimates, and the variance of that mean.
fn mean_and_variance(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)))
}
