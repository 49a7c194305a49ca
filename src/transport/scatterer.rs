//! A window element with a BSDF, made ready for rays.
//!
//! Light passes by the BSDF, patch by patch. What does not pass is reflected diffusely, the same share of it from every
//! direction, so that the element's hemispherical reflectance is met: `ρ(ω) = (1 − τ(ω)) ρ_h / (1 − τ_h)`. That conserves
//! energy ray by ray and is reciprocal: the element is a sheet of reflectance `ρ_h / (1 − τ_h)` with holes, a share `τ(ω)` of
//! which is open towards each direction.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::points::{Points, seed};
use crate::mesh::Surface;
use crate::scene::bsdf::{Bsdf, KlemsBasis, Passage, Patch, PatchFinder, Scattering};

/// One of the passages from side to side.
#[derive(Clone, Debug)]
struct Way {
    from: Basis,
    to: Basis,
    /// sr⁻¹: `[to][from]`.
    values: Vec<f64>,
    /// What a reader in each direction finds of light that arrives evenly, `Σ_i f(o, i) Λ_i`, at most 1; and the sums up to
    /// each patch, over the last.
    read: Odds,
    /// What passes of the light that arrives in each patch, `Σ_o f(o, i) Λ_o`, likewise.
    shot: Odds,
}

#[derive(Clone, Debug)]
struct Basis {
    patches: Vec<Patch>,
    finder: PatchFinder,
}

impl Basis {
    fn new(basis: KlemsBasis) -> Self {
        Self { patches: basis.patches(), finder: PatchFinder::new(basis) }
    }
}

#[derive(Clone, Debug)]
struct Odds {
    passed: Vec<f64>,
    /// `[patch][partner]`.
    sums: Vec<f64>,
}

impl Odds {
    /// `weights` are those of the partners for each patch.
    fn new(patches: usize, weights: impl Fn(usize) -> Vec<f64>) -> Self {
        let (mut passed, mut sums) = (Vec::new(), Vec::new());
        for k in 0..patches {
            let mut sum = 0.0;
            let upto: Vec<f64> = weights(k)
                .into_iter()
                .map(|w| {
                    sum += w;
                    sum
                })
                .collect();
            // Files round, and those of WINDOW make up to 4 % of light where it grazes.
            passed.push(sum.min(1.0));
            sums.extend(upto.into_iter().map(|s| if sum > 0.0 { s / sum } else { 0.0 }));
        }
        Self { passed, sums }
    }

    fn partner(&self, patch: usize, chance: f64) -> usize {
        let n = self.sums.len() / self.passed.len();
        self.sums[patch * n..(patch + 1) * n].partition_point(|s| *s <= chance).min(n - 1)
    }
}

impl Way {
    fn new(scattering: &Scattering) -> Self {
        let (from, to) = (Basis::new(scattering.incident), Basis::new(scattering.outgoing));
        let (ins, outs) = (from.patches.len(), to.patches.len());
        let values: Vec<f64> = (0..outs * ins).map(|k| scattering.value(k / ins, k % ins)).collect();
        let of_reader =
            |o: usize| (0..ins).map(|i| values[o * ins + i] * from.patches[i].projected_solid_angle()).collect();
        let of_light =
            |i: usize| (0..outs).map(|o| values[o * ins + i] * to.patches[o].projected_solid_angle()).collect();
        Self { read: Odds::new(outs, of_reader), shot: Odds::new(ins, of_light), from, to, values }
    }
}

/// A window element. Sides are told as back (`false`) and front (`true`).
#[derive(Clone, Debug)]
pub struct Scatterer {
    /// By the side that the light arrives on.
    ways: [Option<Way>; 2],
    /// What is above, in the program's axes.
    up: DVec3,
    /// Mean share of the light from all directions that does not pass, by the side that it arrives on.
    stays: [f64; 2],
    /// Reflectance of what does not pass, by side.
    reflectance: [f64; 2],
}

/// Share that passes beyond which nothing is there to reflect.
const OPEN: f64 = 1.0 - 1e-6;

impl Scatterer {
    /// From a file; `up` is what its azimuth of 90° points to.
    #[must_use]
    pub fn new(bsdf: &Bsdf, up: DVec3) -> Self {
        let ways = [Passage::TransmissionBack, Passage::TransmissionFront];
        let share = |p: Passage| bsdf.scattering(p).map_or(0.0, Scattering::hemispherical);
        let stays = ways.map(|p| 1.0 - share(p).min(OPEN));
        let reflected = [Passage::ReflectionBack, Passage::ReflectionFront].map(share);
        Self {
            ways: ways.map(|p| bsdf.scattering(p).map(Way::new)),
            up,
            stays,
            reflectance: std::array::from_fn(|side| (reflected[side] / stays[side]).min(1.0)),
        }
    }

    /// Reflectance of what does not pass, of a side.
    #[must_use]
    pub fn reflectance(&self, front: bool) -> f64 {
        self.reflectance[usize::from(front)]
    }

    /// Mean share of the light from all directions that does not pass from a side.
    #[must_use]
    pub fn stays(&self, front: bool) -> f64 {
        self.stays[usize::from(front)]
    }

    /// The way of light that leaves a side.
    fn towards(&self, front: bool) -> Option<&Way> {
        self.ways[usize::from(!front)].as_ref()
    }

    /// The way of light that arrives on a side.
    fn arriving(&self, front: bool) -> Option<&Way> {
        self.ways[usize::from(front)].as_ref()
    }

    /// Axes of azimuth 0 and 90° on a surface: to the right as seen from its back, and upwards.
    fn axes(&self, surface: &Surface) -> [DVec3; 2] {
        let x = surface.normal.cross(self.up).normalize();
        [x, x.cross(surface.normal)]
    }

    fn patch(&self, basis: &Basis, surface: &Surface, travel: DVec3) -> usize {
        let [x, y] = self.axes(surface);
        basis.finder.find(travel.dot(surface.normal), travel.dot(x), travel.dot(y))
    }

    /// Number of patches in which light leaves a side.
    #[must_use]
    pub fn outgoing(&self, front: bool) -> usize {
        self.towards(front).map_or(0, |w| w.to.patches.len())
    }

    /// Number of patches in which light arrives on a side.
    #[must_use]
    pub fn incoming(&self, front: bool) -> usize {
        self.arriving(front).map_or(0, |w| w.from.patches.len())
    }

    /// The patch in which light leaves a side along `travel`.
    #[must_use]
    pub fn outgoing_patch(&self, surface: &Surface, front: bool, travel: DVec3) -> usize {
        self.towards(front).map_or(0, |w| self.patch(&w.to, surface, travel))
    }

    /// The patch in which light arrives on a side along `travel`.
    #[must_use]
    pub fn incoming_patch(&self, surface: &Surface, front: bool, travel: DVec3) -> usize {
        self.arriving(front).map_or(0, |w| self.patch(&w.from, surface, travel))
    }

    /// Radiance that leaves the other side in each of its patches for each unit of irradiance that arrives on a side in a
    /// patch, sr⁻¹.
    pub(super) fn sends(&self, front: bool, patch: usize) -> impl Iterator<Item = f64> + '_ {
        let way = self.arriving(front);
        way.into_iter().flat_map(move |w| w.values.chunks_exact(w.from.patches.len()).map(move |row| row[patch]))
    }

    /// Radiance that leaves the other side in each of its patches for irradiances that arrive on a side, by patch.
    pub(super) fn pass_on(&self, front: bool, irradiances: &[f64], mut radiance: impl FnMut(usize, f64)) {
        let Some(way) = self.arriving(front) else { return };
        for (o, row) in way.values.chunks_exact(irradiances.len()).enumerate() {
            radiance(o, row.iter().zip(irradiances).map(|(f, e)| f * e).sum());
        }
    }

    /// Radiance along `out` for each unit of irradiance that arrives on the other side along `travel`, sr⁻¹: both are ways of
    /// the light, `out` leaves the side.
    #[must_use]
    pub fn value(&self, surface: &Surface, front: bool, out: DVec3, travel: DVec3) -> f64 {
        let Some(way) = self.towards(front) else { return 0.0 };
        let (o, i) = (self.patch(&way.to, surface, out), self.patch(&way.from, surface, travel));
        way.values[o * way.from.patches.len() + i]
    }

    /// What a reader finds who looks at a side along `-out`, of light that arrives evenly on the other.
    #[must_use]
    pub fn passed(&self, surface: &Surface, front: bool, out: DVec3) -> f64 {
        self.towards(front).map_or(0.0, |w| w.read.passed[self.patch(&w.to, surface, out)])
    }

    /// Share that passes of light that arrives on a side along `travel`.
    #[must_use]
    pub fn lets_by(&self, surface: &Surface, front: bool, travel: DVec3) -> f64 {
        self.arriving(front).map_or(0.0, |w| w.shot.passed[self.patch(&w.from, surface, travel)])
    }

    /// Share that passes of the light that arrives on a side in a patch.
    pub(super) fn lets_by_in(&self, front: bool, patch: usize) -> f64 {
        self.arriving(front).map_or(0.0, |w| w.shot.passed[patch])
    }

    /// Share of light that arrives on a side along `travel` that does not pass, over its mean.
    #[must_use]
    pub fn keeps(&self, surface: &Surface, front: bool, travel: DVec3) -> f64 {
        (1.0 - self.lets_by(surface, front, travel)) / self.stays(front)
    }

    /// A way on through the element for a reader who looks at a side along `look`: `chance` draws the patch.
    #[must_use]
    pub fn read_on(&self, surface: &Surface, front: bool, look: DVec3, chance: f64) -> DVec3 {
        self.towards(front).map_or(look, |w| {
            let partner = w.read.partner(self.patch(&w.to, surface, -look), chance);
            -self.within(&w.from.patches[partner], surface, !front, (look, chance))
        })
    }

    /// The same for light that arrives on a side along `travel`.
    #[must_use]
    pub fn shoot_on(&self, surface: &Surface, front: bool, travel: DVec3, chance: f64) -> DVec3 {
        self.arriving(front).map_or(travel, |w| {
            let partner = w.shot.partner(self.patch(&w.from, surface, travel), chance);
            self.within(&w.to.patches[partner], surface, front, (travel, chance))
        })
    }

    /// A way of light within a patch, distributed as the cosine, for light that comes in by a side. Chance comes from what
    /// made it so far: every ray has its own direction.
    fn within(&self, patch: &Patch, surface: &Surface, front: bool, (before, chance): (DVec3, f64)) -> DVec3 {
        let parts = [before.x, before.y, before.z, chance].map(f64::to_bits);
        let (a, b) = Points::new(seed(&parts)).pair(0, 0);
        let [low, high] = patch.theta.map(|t| t.sin().powi(2));
        let squared_sine = low + a * (high - low);
        let (sine, cosine) = (squared_sine.sqrt(), (1.0 - squared_sine).sqrt());
        let phi = (patch.phi + (b - 0.5) * patch.width).rem_euclid(TAU);
        let [x, y] = self.axes(surface);
        x * (sine * phi.cos()) + y * (sine * phi.sin()) - surface.side_normal(front) * cosine
    }

    /// Hemispherical transmittance from a side.
    #[must_use]
    pub fn hemispherical(&self, front: bool) -> f64 {
        let Some(way) = self.arriving(front) else { return 0.0 };
        let passed = way.from.patches.iter().zip(&way.shot.passed);
        passed.map(|(p, share)| p.projected_solid_angle() * share).sum::<f64>() / PI
    }
}
