//! Reflected light known at few places and fitted between them.
//!
//! A record holds the gathered light of one place and the distance over which that may be trusted: a share of the
//! harmonic mean distance to what its rays met (Ward, Rubinstein and Clear 1988), made to grow no faster than with the
//! distance from its neighbours (after Křivánek, Bouatouch, Pattanaik and Žára 2006), and halved where the others do
//! not predict what was gathered. Between records a plane is fitted by weighted least squares: it follows the slope,
//! and it averages the noise of a dozen records.

use glam::DVec2;
use rayon::prelude::*;

use super::tiles::Tiles;
use crate::measure::statement::median;

/// Growth of the reach with distance from a record of less reach.
const GROWTH: f64 = 0.2;
/// Records within so many reaches take part in a fit.
const SUPPORT: f64 = 2.5;
/// A record farther than so many of its own reaches takes part in no fit: `SUPPORT / (1 - SUPPORT * GROWTH)`.
const FARTHEST: f64 = SUPPORT / (1.0 - SUPPORT * GROWTH);
/// Pull of the fitted slope towards zero, against the spread of the records.
const RIDGE: f64 = 0.005;
/// A fit whose shares have a greater sum of squares leans on few records, or beyond them: it proves nothing wrong.
const FREE_HAND: f64 = 0.3;
/// Weight of a record's own difference in its neighbourhood's mean, against one for all others.
const OWN: f64 = 0.4;
/// Share of the median difference by which chance may shift that mean.
const SCATTER: f64 = 0.75;

/// Gathered light of one place.
#[derive(Debug)]
pub(super) struct Record {
    /// The pixel that shows it.
    pub(super) pixel: usize,
    pub(super) sheet: u32,
    pub(super) at: DVec2,
    /// Distance within which a point needs no record of its own, and the least that it may become.
    pub(super) reach: f64,
    pub(super) least: f64,
    /// Reflected irradiance by band.
    pub(super) light: Vec<f32>,
    /// Its illuminance, lx, and that with the direct light.
    pub(super) reflected_y: f64,
    pub(super) all_y: f64,
}

/// Records of a picture, by sheet.
#[derive(Debug)]
pub(super) struct Records {
    pub(super) list: Vec<Record>,
    of_sheet: Vec<Vec<u32>>,
}

/// Share of each record in a fitted value.
pub(super) type Shares = Vec<(u32, f64)>;

impl Records {
    pub(super) fn new(sheets: usize) -> Self {
        Self { list: Vec::new(), of_sheet: vec![Vec::new(); sheets] }
    }

    /// The records of a sheet, in their order.
    pub(super) fn of_sheet(&self, sheet: u32) -> &[u32] {
        &self.of_sheet[sheet as usize]
    }

    /// May a record take part in a fit at a point of its sheet within `radius` of `centre`?
    pub(super) fn reaches(&self, record: u32, centre: DVec2, radius: f64) -> bool {
        let record = &self.list[record as usize];
        record.at.distance(centre) - radius <= FARTHEST * record.reach
    }

    /// Records that may take part in a fit at a point.
    pub(super) fn near(&self, sheet: u32, at: DVec2) -> Vec<u32> {
        self.of_sheet(sheet).iter().copied().filter(|k| self.reaches(*k, at, 0.0)).collect()
    }

    /// Distance of the nearest record, and how far records may be from each other here.
    fn spacing(&self, near: impl Iterator<Item = u32>, at: DVec2) -> (f64, f64) {
        near.fold((f64::INFINITY, f64::INFINITY), |(nearest, spacing), k| {
            let record = &self.list[k as usize];
            let distance = record.at.distance(at);
            (nearest.min(distance), spacing.min(record.reach + GROWTH * distance))
        })
    }

    /// Is there a record near enough?
    pub(super) fn cover(&self, near: &[u32], at: DVec2) -> bool {
        let (nearest, spacing) = self.spacing(near.iter().copied(), at);
        nearest.is_finite() && nearest <= spacing
    }

    /// The share of each record in the value at a point, by a plane through the records about it; without record
    /// `leave`. Returns the sum of squares of the shares (the variance of the value against that of one record), or
    /// `None` where no record is near.
    pub(super) fn fit(&self, near: &[u32], at: DVec2, leave: Option<u32>, shares: &mut Shares) -> Option<f64> {
        shares.clear();
        let others = || near.iter().copied().filter(|k| Some(*k) != leave);
        let (nearest, spacing) = self.spacing(others(), at);
        if !nearest.is_finite() {
            return None;
        }
        let support = SUPPORT * spacing.max(nearest);
        let [mut s, mut su, mut sv, mut suu, mut suv, mut svv] = [0.0; 6];
        for k in others() {
            let away = (self.list[k as usize].at - at) / support;
            let inside = 1.0 - away.length_squared();
            if inside <= 0.0 {
                continue;
            }
            let w = inside * inside;
            shares.push((k, w));
            s += w;
            su += w * away.x;
            sv += w * away.y;
            suu += w * away.x * away.x;
            suv += w * away.x * away.y;
            svv += w * away.y * away.y;
        }
        suu += RIDGE * s;
        svv += RIDGE * s;
        // First column of the inverse of the normal matrix, times its determinant.
        let (a, b, c) = (suu * svv - suv * suv, suv * sv - su * svv, su * suv - suu * sv);
        let determinant = s * a + su * b + sv * c;
        let squares = |shares: &Shares| shares.iter().map(|(_, c)| c * c).sum::<f64>();
        let plane: Shares = shares
            .iter()
            .map(|(k, w)| {
                let away = (self.list[*k as usize].at - at) / support;
                (*k, w * (a + b * away.x + c * away.y) / determinant)
            })
            .collect();
        let of_plane = squares(&plane);
        if of_plane < 1.0 {
            *shares = plane;
            return Some(of_plane);
        }
        // All on one side, or in a row: no slope can be told.
        shares.iter_mut().for_each(|(_, w)| *w /= s);
        Some(squares(shares))
    }

    /// Fitted reflected irradiance by band.
    pub(super) fn light(&self, shares: &Shares, out: &mut [f32]) {
        out.fill(0.0);
        for (k, share) in shares {
            for (sum, light) in out.iter_mut().zip(&self.list[*k as usize].light) {
                *sum += *share as f32 * light;
            }
        }
        // A slope carried too far.
        out.iter_mut().for_each(|x| *x = x.max(0.0));
    }

    /// Takes new records in and keeps the growth of the reach.
    pub(super) fn add(&mut self, new: Vec<Record>) {
        let first = self.list.len();
        for record in new {
            self.of_sheet[record.sheet as usize].push(self.list.len() as u32);
            self.list.push(record);
        }
        self.grade(first);
    }

    /// Lets the reach of no record grow too fast with the distance from another, of which those from `first` on are new.
    fn grade(&mut self, first: usize) {
        let reaches: Vec<f64> = self
            .list
            .par_iter()
            .enumerate()
            .map(|(i, record)| {
                let all = &self.of_sheet[record.sheet as usize];
                let from = if i >= first { 0 } else { all.partition_point(|k| (*k as usize) < first) };
                let bound = |k: &u32| {
                    let other = &self.list[*k as usize];
                    other.reach + GROWTH * other.at.distance(record.at)
                };
                all[from..].iter().map(bound).fold(record.reach, f64::min).max(record.least)
            })
            .collect();
        self.list.iter_mut().zip(reaches).for_each(|(record, reach)| record.reach = reach);
    }

    /// Halves the reach where the other records do not predict what was gathered within `allowed` of it. Returns how many
    /// places there were.
    ///
    /// Noise scatters a neighbourhood's differences about zero; what the fit cannot follow has one sign.
    pub(super) fn doubt(&mut self, tiles: &Tiles, allowed: f64) -> usize {
        let checked: Vec<Option<(f64, Shares)>> =
            (0..self.list.len()).into_par_iter().map(|i| self.check(tiles, i)).collect();
        let is_wrong = |(i, check): (usize, &Option<(f64, Shares)>)| {
            let (own, shares) = check.as_ref()?;
            let record = &self.list[i];
            let others = shares.iter().filter_map(|(k, share)| Some((checked[*k as usize].as_ref()?.0, *share)));
            let (sum, of) =
                others.clone().fold((*own * OWN, OWN), |(sum, of), (off, share)| (sum + off * share, of + share));
            let scatter = median(others.map(|(off, _)| off.abs()).chain([own.abs()]).collect());
            let bias = (sum / of).abs();
            (bias > (allowed * record.all_y).hypot(SCATTER * scatter) && record.reach > record.least).then_some(i)
        };
        let wrong: Vec<usize> = checked.iter().enumerate().filter_map(is_wrong).collect();
        for i in &wrong {
            let record = &mut self.list[*i];
            record.reach = (0.5 * record.reach).max(record.least);
        }
        self.grade(0);
        wrong.len()
    }

    /// What a record has beyond what the others predict there, lx; and who predicts it.
    fn check(&self, tiles: &Tiles, i: usize) -> Option<(f64, Shares)> {
        let record = &self.list[i];
        let mut shares = Shares::new();
        let near = tiles.near(tiles.of(record.pixel), record.sheet)?;
        if self.fit(near, record.at, Some(i as u32), &mut shares)? > FREE_HAND {
            return None;
        }
        let predicted: f64 = shares.iter().map(|(k, share)| share * self.list[*k as usize].reflected_y).sum();
        Some((record.reflected_y - predicted, shares))
    }
}
