//! The sky in patches, for daylight coefficients.
//!
//! In: a direction. Out: its patch, or the patches between which it lies. The division is that of Tregenza 1987 (145
//! patches in rows of 12°) and its finer forms by Reinhart 2001 (577, 1,297 and 2,305), all of them of nearly one size.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;

/// Patches in the rows of Tregenza's division, from the horizon up; the last is the cap about the zenith.
const ROWS: [usize; 7] = [30, 30, 24, 24, 18, 12, 6];

/// A division of the sky, and one patch more for all below the horizon.
#[derive(Clone, Debug)]
pub struct Patches {
    /// Height of a row, radians.
    height: f64,
    /// First patch of each row and their number; the cap is the last.
    rows: Vec<(usize, usize)>,
    /// Sine of the altitude at which each row begins.
    sines: Vec<f64>,
}

impl Patches {
    /// Tregenza's division, each side cut in `parts`.
    #[must_use]
    pub fn new(parts: usize) -> Self {
        let mut first = 0;
        let mut rows = Vec::with_capacity(ROWS.len() * parts + 1);
        for count in ROWS.iter().flat_map(|n| std::iter::repeat_n(n * parts, parts)).chain([1]) {
            rows.push((first, count));
            first += count;
        }
        let height = FRAC_PI_2 / (rows.len() as f64 - 0.5);
        let sines = (0..rows.len()).map(|row| (row as f64 * height).sin()).collect();
        Self { height, rows, sines }
    }

    /// The patches of each row, from the horizon up.
    pub fn rows(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        self.rows.iter().map(|(first, count)| *first..first + count)
    }

    /// Number of patches of the sky; the ground has this number as its own.
    #[must_use]
    pub fn sky(&self) -> usize {
        self.rows.last().map_or(0, |(first, count)| first + count)
    }

    /// Number of patches with that of the ground.
    #[must_use]
    pub fn all(&self) -> usize {
        self.sky() + 1
    }

    /// Width of a patch near the horizon, radians.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.height
    }

    /// The patch of a unit direction.
    #[must_use]
    pub fn of(&self, direction: DVec3) -> usize {
        if direction.z < 0.0 {
            return self.sky();
        }
        let row = self.sines.partition_point(|bottom| *bottom <= direction.z) - 1;
        let (first, count) = self.rows[row];
        first + (turn(direction) * count as f64).round() as usize % count
    }

    /// Between which patches a direction of the sky lies, with weights that sum to one: linear in altitude and azimuth
    /// between their middles.
    #[must_use]
    pub fn between(&self, direction: DVec3) -> [(usize, f64); 4] {
        let last = self.rows.len() - 1;
        let at = (direction.z.clamp(0.0, 1.0).asin() / self.height - 0.5).clamp(0.0, last as f64);
        let row = (at as usize).min(last - 1);
        let up = at - row as f64;
        let turn = turn(direction);
        let beside = |row: usize, weight: f64| {
            let (first, count) = self.rows[row];
            let at = turn * count as f64;
            let (k, across) = (at as usize, at.fract());
            [(first + k % count, weight * (1.0 - across)), (first + (k + 1) % count, weight * across)]
        };
        let (low, high) = (beside(row, 1.0 - up), beside(row + 1, up));
        [low[0], low[1], high[0], high[1]]
    }

    /// Solid angle of a patch of the sky, sr.
    #[must_use]
    pub fn solid_angle(&self, patch: usize) -> f64 {
        let row = self.row(patch);
        let (bottom, top) = self.limits(row);
        (top.sin() - bottom.sin()) * TAU / self.rows[row].1 as f64
    }

    /// Direction of the middle of a patch of the sky.
    #[must_use]
    pub fn middle(&self, patch: usize) -> DVec3 {
        let row = self.row(patch);
        if row + 1 == self.rows.len() {
            return DVec3::Z;
        }
        let (bottom, top) = self.limits(row);
        let (first, count) = self.rows[row];
        let (altitude, azimuth) = (0.5 * (bottom + top), TAU * (patch - first) as f64 / count as f64);
        DVec3::new(altitude.cos() * azimuth.sin(), altitude.cos() * azimuth.cos(), altitude.sin())
    }

    /// Patch of a coarser division that holds the middle of each patch of this one; the ground goes to the ground.
    #[must_use]
    pub fn homes(&self, coarser: &Self) -> Vec<usize> {
        (0..self.sky()).map(|p| coarser.of(self.middle(p))).chain([coarser.sky()]).collect()
    }

    /// Directions spread evenly over a patch of the sky: `side²` of them.
    #[cfg(test)]
    fn within(&self, patch: usize, side: usize) -> impl Iterator<Item = DVec3> + '_ {
        let row = self.row(patch);
        let (first, count) = self.rows[row];
        let (bottom, top) = self.limits(row);
        let middle = move |k: usize| (k as f64 + 0.5) / side as f64;
        (0..side * side).map(move |k| {
            let z = bottom.sin() + (top.sin() - bottom.sin()) * middle(k / side);
            let azimuth = TAU * ((patch - first) as f64 - 0.5 + middle(k % side)) / count as f64;
            let across = (1.0 - z * z).max(0.0).sqrt();
            DVec3::new(across * azimuth.sin(), across * azimuth.cos(), z)
        })
    }

    /// A patch and those that touch it.
    pub fn beside(&self, patch: usize) -> impl Iterator<Item = usize> + '_ {
        let row = self.row(patch);
        let (first, count) = self.rows[row];
        let at = (patch - first) as f64 / count as f64;
        let last = self.rows.len() - 1;
        (row.saturating_sub(1)..=(row + 1).min(last)).flat_map(move |r| {
            let (start, number) = self.rows[r];
            // About the zenith all patches of a row are near.
            let reach = if row + 2 >= last { 1.0 } else { 1.5 / count.min(number) as f64 };
            let low = ((at - reach) * number as f64).floor() as i64;
            let high = ((at + reach) * number as f64).ceil() as i64;
            (low..=high.min(low + number as i64 - 1)).map(move |k| start + k.rem_euclid(number as i64) as usize)
        })
    }

    fn row(&self, patch: usize) -> usize {
        self.rows.partition_point(|(first, _)| *first <= patch) - 1
    }

    fn limits(&self, row: usize) -> (f64, f64) {
        (row as f64 * self.height, ((row + 1) as f64 * self.height).min(FRAC_PI_2))
    }
}

/// Share of a whole turn from +y over +x.
fn turn(direction: DVec3) -> f64 {
    let share = direction.x.atan2(direction.y) / TAU;
    if share < 0.0 { share + 1.0 } else { share }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_divisions_have_the_known_numbers_of_patches_and_cover_the_hemisphere() {
        for (parts, count) in [(1, 145), (2, 577), (3, 1297), (4, 2305)] {
            let patches = Patches::new(parts);
            assert_eq!(patches.sky(), count);
            let all: f64 = (0..count).map(|p| patches.solid_angle(p)).sum();
            assert!((all - TAU).abs() < 1e-12, "{all}");
        }
    }

    #[test]
    fn every_direction_lies_in_its_own_patch() {
        for parts in [1, 2, 4] {
            let patches = Patches::new(parts);
            for p in 0..patches.sky() {
                for d in patches.within(p, 3) {
                    assert_eq!(patches.of(d), p, "{d}");
                }
            }
        }
        assert_eq!(Patches::new(1).of(-DVec3::Z), 145);
    }

    #[test]
    fn all_directions_near_a_patch_lie_in_it_or_beside_it() {
        for parts in [1, 4] {
            let patches = Patches::new(parts);
            for p in 0..patches.sky() {
                let beside: Vec<usize> = patches.beside(p).collect();
                for d in patches.within(p, 2) {
                    let (u, v) = d.any_orthonormal_pair();
                    for aside in [u, -u, v, -v] {
                        let near = (d + aside * (0.7 * patches.width())).normalize();
                        assert!(near.z < 0.0 || beside.contains(&patches.of(near)), "{p}: {near}");
                    }
                }
            }
        }
    }

    #[test]
    fn between_patches_a_linear_field_is_met_at_their_middles() {
        let patches = Patches::new(2);
        for p in 0..patches.sky() - 1 {
            let weights = patches.between(patches.middle(p));
            let own: f64 = weights.iter().filter(|(k, _)| *k == p).map(|(_, w)| w).sum();
            assert!((own - 1.0).abs() < 1e-9, "{p}: {weights:?}");
            assert!((weights.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }
}
