//! Where reflected light is gathered for a picture.
//!
//! From wide steps to narrow ones, every pixel that no record covers gets one of its own; then records that the others
//! do not predict are told to stand closer, and the gaps that this makes are filled.

use rayon::prelude::*;

use super::records::{Record, Records};
use super::sight::Sight;
use super::tiles::Tiles;
use super::{Base, Lit, Painter, seen_from};
use crate::measure::gather::Gatherer;

/// Share of the tolerance that the fit between records may take.
const INTERPOLATION: f64 = 0.7;
/// Share of the rays of a lone reading: a fit averages about as many records as this divides by.
const AVERAGED: f64 = 1.0 / 6.0;
/// Widest and least distance of records, in pixels.
const WIDEST: f64 = 20.0;
const LEAST: f64 = 1.5;
/// First step, in pixels; it is halved down to one.
const STEP: usize = 16;
/// Most rounds of doubt.
const ROUNDS: usize = 4;

impl Painter<'_> {
    /// Gathers at as many places as the picture needs. Returns the rays too.
    pub(super) fn survey<'b>(&self, base: &'b Base) -> (Lit<'b>, u64) {
        let tiles = Tiles::new((self.camera.width, self.camera.height), &base.sights, &base.sheets);
        let mut lit = Lit { base, records: Records::new(base.sheets.len()), tiles };
        let allowed = INTERPOLATION * self.noise.tolerance;
        let mut rays = self.fill(&mut lit);
        for _ in 0..ROUNDS {
            if lit.records.doubt(&lit.tiles, allowed) == 0 {
                break;
            }
            lit.tiles.update(&lit.records);
            rays += self.fill(&mut lit);
        }
        (lit, rays)
    }

    /// Adds records until every sight of every pixel has one near enough.
    fn fill(&self, lit: &mut Lit<'_>) -> u64 {
        let mut rays = self.pass(lit, (0, 0, STEP));
        let mut step = STEP;
        while step > 1 {
            let half = step / 2;
            for (x, y) in [(half, half), (half, 0), (0, half)] {
                rays += self.pass(lit, (x, y, step));
            }
            step = half;
        }
        rays
    }

    /// Adds records at the pixels `x, y` modulo `step` where none is near enough.
    fn pass(&self, lit: &mut Lit<'_>, (x, y, step): (usize, usize, usize)) -> u64 {
        let (base, records, tiles) = (lit.base, &lit.records, &lit.tiles);
        let w = self.camera.width;
        let is_open = &|tile: usize, sight: &Sight| {
            base.sheets
                .place(sight)
                .is_some_and(|(sheet, at)| tiles.near(tile, sheet).is_none_or(|near| !records.cover(near, at)))
        };
        let open: Vec<(usize, usize)> = (0..tiles.count())
            .into_par_iter()
            .flat_map_iter(|tile| {
                let pixels = tiles.pixels(tile).filter(|p| p % w % step == x && p / w % step == y);
                let sights = pixels.flat_map(|pixel| (0..base.sights[pixel].len()).map(move |k| (pixel, k)));
                sights.filter(move |(pixel, k)| is_open(tile, &base.sights[*pixel][*k]))
            })
            .collect();
        let new: Vec<(Option<Record>, u64)> = open
            .par_iter()
            .map_init(
                || Gatherer::new(self.field),
                |g, (pixel, k)| {
                    let before = g.cast + g.scratch.rays;
                    (self.record(g, base, *pixel, *k), g.cast + g.scratch.rays - before)
                },
            )
            .collect();
        let rays = new.iter().map(|n| n.1).sum();
        if !new.is_empty() {
            lit.records.add(new.into_iter().filter_map(|n| n.0).collect());
            lit.tiles.update(&lit.records);
        }
        rays
    }

    /// Gathers at one sight of a pixel.
    fn record(&self, g: &mut Gatherer<'_>, base: &Base, pixel: usize, k: usize) -> Option<Record> {
        let sight = &base.sights[pixel][k];
        let (sheet, at) = base.sheets.place(sight)?;
        let stream = (k as u64) << 40 | pixel as u64;
        let own;
        let direct = if k == 0 {
            &base.direct[pixel]
        } else {
            own = g.direct(sight.point, sight.normal, stream);
            &own
        };
        let found = self.gather(g, sight, stream, direct, AVERAGED);
        let (distance, cosine) = seen_from(self.camera.eye(), sight);
        let (x, y) = self.corner(pixel);
        let pixel_width = distance * self.camera.pixel_angle(x, y) / cosine.max(0.05).sqrt();
        let (least, widest) = (LEAST * pixel_width, WIDEST * pixel_width);
        // Light that changes over the distance R errs by half of (reach / R)² between records.
        let smooth = (2.0 * INTERPOLATION * self.noise.tolerance).sqrt();
        let reach = (smooth / found.nearness.max(1e-12)).clamp(least, widest);
        Some(Record {
            pixel,
            sheet,
            at,
            reach,
            least,
            light: found.sums.bands(0, self.task.optics.pad, false).map(|x| x as f32).collect(),
            reflected_y: found.reflected_y,
            all_y: found.reflected_y + found.direct_y,
        })
    }
}
