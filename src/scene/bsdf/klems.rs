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

#[cfg(test)]
mod tests {
    use super::*;

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
