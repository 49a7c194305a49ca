//! Small bodies in place of small planes: cylinders and half cylinders that stand upright.
//!
//! The illuminance of an upright cylinder is the mean over all azimuths of that of a vertical plane (EN 12464-1), of a half
//! cylinder that over the half circle about its direction (EN 13201-3):
//!
//! ```text
//! E_cyl = 1/π ∫ L sin θ dω        E_sc = 1/π ∫ L (1 + cos α) sin θ dω
//! ```
//! `θ` from the vertical, `α` the azimuth from the direction of the half cylinder.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};

use crate::scene::Receiver;
use crate::transport::{DirectScratch, World, cosine_direction};

/// Vertical planes whose direct light is averaged; odd, so that opposite ones do not repeat each other.
const PLANES: u32 = 15;

/// What receives light at a point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Facing {
    /// A plane with its normal.
    Plane(DVec3),
    /// An upright cylinder.
    Cylinder,
    /// Half of one, about a level direction.
    HalfCylinder(DVec2),
}

impl From<DVec3> for Facing {
    fn from(normal: DVec3) -> Self {
        Self::Plane(normal)
    }
}

impl Facing {
    pub(super) fn new(receiver: Receiver, normal: DVec3) -> Self {
        match receiver {
            Receiver::Plane => Self::Plane(normal),
            Receiver::Cylinder => Self::Cylinder,
            Receiver::HalfCylinder => Self::HalfCylinder(normal.truncate().normalize_or(DVec2::X)),
        }
    }

    /// A direction from a point of the unit square, distributed as the receiver's kernel: what comes from there counts alike.
    #[inline]
    pub(super) fn direction(self, a: f64, b: f64) -> DVec3 {
        let (ahead, azimuth) = match self {
            Self::Plane(normal) => return cosine_direction(normal, a, b),
            Self::Cylinder => (DVec2::X, TAU * b),
            // Azimuths are distributed as 1 + cos α.
            Self::HalfCylinder(ahead) => (ahead, PI - kepler(TAU * (1.0 - b))),
        };
        // Angles from the vertical are distributed as sin² θ.
        let theta = 0.5 * kepler(TAU * a);
        (DVec2::from_angle(azimuth).rotate(ahead) * theta.sin()).extend(theta.cos())
    }

    /// The normal of a vertical plane, drawn by `chance`: the mean over all is the receiver.
    pub(super) fn plane(self, chance: f64) -> DVec3 {
        match self {
            Self::Plane(normal) => normal,
            Self::Cylinder => DVec2::from_angle(TAU * chance).extend(0.0),
            Self::HalfCylinder(ahead) => DVec2::from_angle(PI * chance - FRAC_PI_2).rotate(ahead).extend(0.0),
        }
    }

    /// Direct light, added to `out`: of planes exactly, of cylinders as the mean of [`PLANES`] of them.
    ///
    /// Half cylinders by `E_sc = E_cyl + (E(d) − E(−d))/π`, which holds because `∫ L sin θ cos α dω` is the difference of
    /// the illuminances of two opposite planes.
    pub(super) fn direct(self, world: &World, x: DVec3, sample: u64, scratch: &mut DirectScratch, out: &mut [f64]) {
        let mut add = |normal: DVec3, weight: f64, out: &mut [f64]| {
            let mut own = vec![0.0; out.len()];
            crate::transport::direct(world, x, normal, sample, scratch, &mut own);
            out.iter_mut().zip(own).for_each(|(sum, v)| *sum += weight * v);
        };
        if let Self::Plane(normal) = self {
            return add(normal, 1.0, out);
        }
        for k in 0..PLANES {
            let azimuth = TAU * (f64::from(k) + 0.25) / f64::from(PLANES);
            add(DVec2::from_angle(azimuth).extend(0.0), 1.0 / f64::from(PLANES), out);
        }
        if let Self::HalfCylinder(ahead) = self {
            add(ahead.extend(0.0), 1.0 / PI, out);
            add(-ahead.extend(0.0), -1.0 / PI, out);
            out.iter_mut().for_each(|v| *v = v.max(0.0));
        }
    }

    /// Relative error of direct light by the mean of planes, at most: for a point source at the worst azimuth.
    ///
    /// The kernel `max(0, cos φ)` has the harmonics `2/π (−1)^{k+1}/(4k² − 1)` of order `2k` beside the first; the mean of an
    /// odd number `n` of planes leaves those of multiples of `2n`, of which the first is `2/(4n² − 1)` of the mean, the
    /// others together below `1 + 1/4 + 1/9 + … = π²/6` times that.
    pub(super) fn planes_error(self) -> f64 {
        match self {
            Self::Plane(_) => 0.0,
            Self::Cylinder | Self::HalfCylinder(_) => PI * PI / 6.0 * 2.0 / (4.0 * f64::from(PLANES * PLANES) - 1.0),
        }
    }
}

/// The `u` with `u − sin u = m`, `0 ≤ m ≤ 2π`: Kepler's equation for an eccentricity of one, by Newton's method.
fn kepler(m: f64) -> f64 {
    let small = m.min(TAU - m).max(0.0);
    // The first term of the series lies below the root; from above it Newton's steps on a convex function only fall.
    let mut u = (6.0 * small).cbrt();
    for _ in 0..6 {
        let slope = 1.0 - u.cos();
        if slope > 0.0 {
            u = (u - (u - u.sin() - small) / slope).min(PI);
        }
    }
    if m <= PI { u } else { TAU - u }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kepler_solves_its_equation_everywhere() {
        for k in 0..=1000 {
            let m = TAU * f64::from(k) / 1000.0;
            let u = kepler(m);
            assert!((u - u.sin() - m).abs() < 1e-12, "{m}: {u}");
        }
    }

    #[test]
    fn directions_follow_the_kernels() {
        // Cylinder: the mean of cos² θ is ∫ sin² θ cos² θ / ∫ sin² θ = 1/4, that of sin θ is (4/3)/(π/2) = 8/(3π).
        // Half cylinder: the mean of cos α is ∫ cos² α / 2π = 1/2. The midpoint rule errs by n^-2, but
        // by n^-4/3 = 6e-4 for sin θ, which rises as a third root of its number from the pole.
        let half = Facing::HalfCylinder(DVec2::new(0.6, 0.8));
        let (mut square, mut sine, mut ahead) = (0.0, 0.0, 0.0);
        let n = 256;
        for i in 0..n {
            for j in 0..n {
                let place = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
                let d = Facing::Cylinder.direction(place(i), place(j));
                assert!((d.length() - 1.0).abs() < 1e-12);
                square += d.z * d.z;
                sine += d.truncate().length();
                ahead += half.direction(place(i), place(j)).truncate().normalize().dot(DVec2::new(0.6, 0.8));
            }
        }
        let count = f64::from(n * n);
        assert!((square / count - 0.25).abs() < 1e-4);
        assert!((sine / count - 8.0 / (3.0 * PI)).abs() < 1e-3);
        assert!((ahead / count - 0.5).abs() < 1e-4);
    }

    #[test]
    fn the_mean_of_planes_stays_within_its_bound() {
        let worst = (0..1000)
            .map(|k| {
                let source = TAU * f64::from(k) / 1000.0;
                let plane = |k: u32| (source - TAU * (f64::from(k) + 0.25) / f64::from(PLANES)).cos().max(0.0);
                let mean = (0..PLANES).map(plane).sum::<f64>() / f64::from(PLANES);
                (mean * PI - 1.0).abs()
            })
            .fold(0.0, f64::max);
        assert!(worst <= Facing::Cylinder.planes_error() && worst > 0.5 * Facing::Cylinder.planes_error(), "{worst}");
    }
}
