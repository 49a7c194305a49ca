//! Blinds by the hour.
//!
//! Closed blinds let by a share of the light that comes through their windows, and nothing straight from the sun. The
//! share is that of diffuse light; its directions stay those of the sky, as in the simple model of DAYSIM (Reinhart
//! 2004).

use super::climate::Hour;
use super::series::OwnSun;
use crate::scene::{Blind, BlindControl};

/// Sunlight on a point from which LM-83 counts it, lx, and share of the points above which blinds are closed.
const SUNLIT_LX: f32 = 1000.0;
const SUNLIT_SHARE: f64 = 0.02;

/// What each opening lets by in each hour: the first has no blinds.
#[derive(Clone, Debug)]
pub(super) struct Blinds {
    /// `[opening][hour]`: share of the light; `None` where there are no blinds.
    shares: Vec<Option<Vec<f32>>>,
    closed: Vec<Vec<bool>>,
}

impl Blinds {
    /// Works out every hour. `suns` holds the sun's own light by grid and sensor, `lit` the sensors of each grid that see.
    pub(super) fn new(list: &[Blind], hours: &[Hour], suns: &[Vec<OwnSun>], lit: &[usize]) -> Self {
        let mut blinds = Self { shares: vec![None], closed: vec![Vec::new()] };
        for (k, blind) in list.iter().enumerate() {
            let closed: Vec<bool> = match &blind.control {
                BlindControl::Fixed(closed) => vec![*closed; hours.len()],
                BlindControl::Hourly(all) => hours.iter().map(|h| all.get(h.index) == Some(&true)).collect(),
                BlindControl::Sun => sunny(k + 1, hours.len(), suns, lit),
            };
            let share = |closed: &bool| if *closed { blind.transmittance as f32 } else { 1.0 };
            blinds.shares.push(Some(closed.iter().map(share).collect()));
            blinds.closed.push(closed);
        }
        blinds
    }

    /// All open.
    pub(super) fn open(openings: usize) -> Self {
        Self { shares: vec![None; openings], closed: vec![Vec::new(); openings] }
    }

    /// Are the blinds of an opening closed?
    pub(super) fn are_closed(&self, opening: usize, hour: usize) -> bool {
        self.closed[opening].get(hour) == Some(&true)
    }

    /// Share of the hours in which any blinds of each group are closed.
    pub(super) fn closed_hours(&self) -> Vec<usize> {
        self.closed[1..].iter().map(|c| c.iter().filter(|c| **c).count()).collect()
    }

    /// Share of the light of an opening that its blinds let by.
    pub(super) fn share(&self, opening: usize, hour: usize) -> f64 {
        self.shares[opening].as_ref().map_or(1.0, |shares| f64::from(shares[hour]))
    }

    /// Adds the light of an opening as its blinds let it by.
    pub(super) fn add(&self, opening: usize, light: &[f32], to: &mut [f32]) {
        match &self.shares[opening] {
            None => to.iter_mut().zip(light).for_each(|(to, l)| *to += l),
            Some(shares) => to.iter_mut().zip(light).zip(shares).for_each(|((to, l), s)| *to += l * s),
        }
    }
}

/// Hours in which the sun comes through an opening to too many points of some grid.
fn sunny(opening: usize, hours: usize, suns: &[Vec<OwnSun>], lit: &[usize]) -> Vec<bool> {
    let mut closed = vec![false; hours];
    for (sensors, lit) in suns.iter().zip(lit) {
        let mut counts = vec![0usize; hours];
        for (t, through, lux) in sensors.iter().flat_map(|s| &s.straight) {
            counts[*t as usize] += usize::from(*through as usize == opening && *lux >= SUNLIT_LX);
        }
        for (closed, count) in closed.iter_mut().zip(&counts) {
            *closed |= *count as f64 > SUNLIT_SHARE * *lit as f64;
        }
    }
    closed
}
