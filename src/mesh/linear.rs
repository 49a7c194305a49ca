//! Values shown between patches: linear, with the mean of every patch kept.

use glam::DVec2;

use super::uniform::Patches;

/// Patches and their weights in a value.
pub(super) type Weights = [(usize, f64); 4];

/// A node of a rectangle lies this share of its side inside, so that it belongs to no neighbour.
const INSET: f64 = 1e-9;
/// Trapezoidal rule over corner, middle, corner: exact for what is linear on either half.
const RULE: [(f64, f64); 3] = [(INSET, 0.25), (0.5, 0.5), (1.0 - INSET, 0.25)];

/// How the value at a point is made of those of patches.
///
/// Values linear between the middles of patches neither keep the mean of a patch nor stay above zero where they are continued
/// to a border. Their deviation from their own mean over the patch does neither harm: it is added to the patch's value,
/// as much of it as leaves nothing below zero.
#[derive(Clone, Debug)]
pub struct Linear {
    patch: usize,
    between: Option<Between>,
}

#[derive(Clone, Debug)]
struct Between {
    here: Weights,
    nodes: [(Weights, f64); 9],
}

impl Linear {
    /// At a point of a surface's side. The patch alone counts if it is no whole rectangle or has no neighbours.
    /// `None` where no patch lies.
    #[must_use]
    pub fn at(mesh: &(impl Patches + ?Sized), surface: usize, front: bool, uv: DVec2) -> Option<Self> {
        let patch = mesh.find(surface, front, uv)? as usize;
        Some(Self { patch, between: Between::at(mesh, patch, (surface, front), uv) })
    }

    /// The value of the patch under a point, not changed by its neighbours.
    #[must_use]
    pub fn flat(mesh: &(impl Patches + ?Sized), surface: usize, front: bool, uv: DVec2) -> Option<Self> {
        Some(Self { patch: mesh.find(surface, front, uv)? as usize, between: None })
    }

    /// The value, from those of patches, none of which is negative.
    #[must_use]
    pub fn value(&self, of: impl Fn(usize) -> f64) -> f64 {
        let own = of(self.patch);
        let Some(between) = &self.between else { return own };
        let linear = |weights: &Weights| weights.iter().map(|(i, w)| w * of(*i)).sum::<f64>();
        let (mut mean, mut least) = (0.0, f64::INFINITY);
        for (weights, share) in &between.nodes {
            let value = linear(weights);
            mean += share * value;
            least = least.min(value);
        }
        let fall = mean - least;
        let kept = if fall > own { own / fall } else { 1.0 };
        // Rounding alone can bring it below zero.
        (own + kept * (linear(&between.here) - mean)).max(0.0)
    }
}

impl Between {
    fn at(mesh: &(impl Patches + ?Sized), patch: usize, (surface, front): (usize, bool), uv: DVec2) -> Option<Self> {
        let patch = &mesh.list()[patch];
        let low = patch.outline.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let size = patch.outline.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max) - low;
        if patch.area < (1.0 - INSET) * size.x * size.y {
            return None;
        }
        let here = mesh.weights(surface, front, uv)?;
        let mut nodes = [(here, 0.0); 9];
        for (k, node) in nodes.iter_mut().enumerate() {
            let ((u, along), (v, across)) = (RULE[k % 3], RULE[k / 3]);
            *node = (mesh.weights(surface, front, low + size * DVec2::new(u, v))?, along * across);
        }
        Some(Self { here, nodes })
    }
}
