//! Klems's bases: a hemisphere of directions in rings and patches of about equal projected solid angle.

use std::f64::consts::PI;

/// A division of the hemisphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KlemsBasis {
    /// 145 patches.
    Full,
    /// 73 patches.
    Half,
    /// 41 patches.
    Quarter,
}

/// One patch: polar angles from the normal, azimuths about it, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Least and largest polar angle.
    pub theta: [f64; 2],
    /// Azimuth of its middle.
    pub phi: f64,
    /// Width in azimuth.
    pub width: f64,
}

impl Patch {
    /// `∫ cos θ dω = (sin²θ₂ − sin²θ₁) Δφ/2`, sr.
    #[must_use]
    pub fn projected_solid_angle(&self) -> f64 {
        let [low, high] = self.theta.map(|t| t.sin().powi(2));
        0.5 * self.width * (high - low)
    }
}

impl KlemsBasis {
    /// By the name in a file.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "LBNL/Klems Full" => Some(Self::Full),
            "LBNL/Klems Half" => Some(Self::Half),
            "LBNL/Klems Quarter" => Some(Self::Quarter),
            _ => None,
        }
    }

    /// Rings from the pole: largest polar angle in degrees, and patches. The first patch of each lies at azimuth 0.
    fn rings(self) -> &'static [(f64, usize)] {
        match self {
            Self::Full => &[
                (5.0, 1),
                (15.0, 8),
                (25.0, 16),
                (35.0, 20),
                (45.0, 24),
                (55.0, 24),
                (65.0, 24),
                (75.0, 16),
                (90.0, 12),
            ],
            Self::Half => &[(6.5, 1), (19.5, 8), (32.5, 12), (46.5, 16), (61.5, 20), (76.5, 12), (90.0, 4)],
            Self::Quarter => &[(9.0, 1), (27.0, 8), (46.0, 12), (66.0, 12), (90.0, 8)],
        }
    }

    /// The patches, in the order of files.
    #[must_use]
    pub fn patches(self) -> Vec<Patch> {
        let mut low = 0.0;
        let mut patches = Vec::new();
        for (high_deg, count) in self.rings() {
            let high = high_deg.to_radians();
            let width = 2.0 * PI / *count as f64;
            patches.extend((0..*count).map(|k| Patch { theta: [low, high], phi: k as f64 * width, width }));
            low = high;
        }
        patches
    }
}

/// Finds the patch of a direction.
#[derive(Clone, Debug)]
pub struct PatchFinder {
    /// Of each ring from the pole: square of the sine of its largest polar angle, its first patch, patches.
    rings: Vec<(f64, usize, usize)>,
}

impl PatchFinder {
    /// For a basis.
    #[must_use]
    pub fn new(basis: KlemsBasis) -> Self {
        let mut first = 0;
        let ring = |(high_deg, count): &(f64, usize)| {
            first += count;
            (high_deg.to_radians().sin().powi(2), first - count, *count)
        };
        Self { rings: basis.rings().iter().map(ring).collect() }
    }

    /// The patch of a direction: its part along the normal (of either sign), and along the axes of azimuth 0 and 90°.
    #[must_use]
    pub fn find(&self, normal: f64, x: f64, y: f64) -> usize {
        let squared_sine = 1.0 - normal * normal;
        let last = self.rings.len() - 1;
        let ring = self.rings.iter().position(|r| squared_sine <= r.0).unwrap_or(last);
        let (_, first, count) = self.rings[ring];
        // The first patch of a ring lies about azimuth 0, half of it before.
        let place = (y.atan2(x) / (2.0 * PI) * count as f64).round().rem_euclid(count as f64);
        first + (place as usize).min(count - 1)
    }

    /// The patch whose directions are those of another one backwards: half a turn about the normal.
    #[must_use]
    pub fn opposite(&self, patch: usize) -> usize {
        let ring = self.rings.iter().rfind(|r| r.1 <= patch).unwrap_or(&self.rings[0]);
        ring.1 + (patch - ring.1 + ring.2 / 2) % ring.2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_patch_holds_its_own_directions_and_its_opposite_holds_them_backwards() {
        for basis in [KlemsBasis::Full, KlemsBasis::Half, KlemsBasis::Quarter] {
            let finder = PatchFinder::new(basis);
            for (k, patch) in basis.patches().iter().enumerate() {
                for (u, v) in [(0.01, -0.49), (0.5, 0.0), (0.99, 0.49)] {
                    let theta = patch.theta[0] + u * (patch.theta[1] - patch.theta[0]);
                    let phi = patch.phi + v * patch.width;
                    let (x, y) = (theta.sin() * phi.cos(), theta.sin() * phi.sin());
                    assert_eq!(finder.find(theta.cos(), x, y), k, "{basis:?}");
                    assert_eq!(finder.find(-theta.cos(), -x, -y), finder.opposite(k), "{basis:?}");
                }
            }
        }
    }

    #[test]
    fn the_patches_of_a_basis_fill_the_hemisphere() {
        for (basis, count) in [(KlemsBasis::Full, 145), (KlemsBasis::Half, 73), (KlemsBasis::Quarter, 41)] {
            let patches = basis.patches();
            assert_eq!(patches.len(), count);
            let sum: f64 = patches.iter().map(Patch::projected_solid_angle).sum();
            assert!((sum - PI).abs() < 1e-14, "{basis:?}: {sum}");
        }
    }
}
