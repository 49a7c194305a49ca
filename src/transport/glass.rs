//! Clear glazing units of one or more panes: what they pass and reflect at any angle.
//!
//! Light that goes to and fro inside a pane and between panes is summed without interference (panes are far thicker than
//! the coherence of daylight), for each polarisation apart: an average taken pane by pane is too dark at high angles.

use crate::scene::{GlassPane, Panes};
use crate::spectrum::SpectralValue;

/// Shares of the light that arrives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// Passed, the same from either side.
    pub passed: f64,
    /// Reflected of what arrives on the back, and on the front.
    pub reflected: [f64; 2],
}

impl Shares {
    /// Mean of two polarisations.
    fn mean([s, p]: [Self; 2]) -> Self {
        let mean = |a: f64, b: f64| 0.5 * (a + b);
        Self {
            passed: mean(s.passed, p.passed),
            reflected: std::array::from_fn(|side| mean(s.reflected[side], p.reflected[side])),
        }
    }

    /// This unit in front of another one, all reflections between them summed.
    ///
    /// `T = T₁T₂/(1 − R_b1 R_f2)`, `R_f = R_f1 + T₁² R_f2/(1 − R_b1 R_f2)`, `R_b` alike (Edwards 1977).
    fn before(self, next: Self) -> Self {
        let ([back1, front1], [back2, front2]) = (self.reflected, next.reflected);
        // Two perfect reflectors pass nothing: whatever is between them stays out of reach.
        let again = 1.0 / (1.0 - back1 * front2).max(f64::MIN_POSITIVE);
        Self {
            passed: self.passed * next.passed * again,
            reflected: [back2 + next.passed.powi(2) * back1 * again, front1 + self.passed.powi(2) * front2 * again],
        }
    }
}

/// One pane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pane {
    /// Uncoated glass.
    Bare {
        /// Index of refraction.
        refractive_index: f64,
        /// Internal transmittance at normal incidence ("transmissivity").
        internal: f64,
    },
    /// Coated glass, by its shares at normal incidence.
    Coated(Shares),
}

impl Pane {
    /// Uncoated glass by its measured transmittance at normal incidence: `T = (1−r)² a / (1 − r² a²)` is solved for `a`.
    #[must_use]
    pub fn bare(transmittance: f64, refractive_index: f64) -> Self {
        let r = normal_reflectance(refractive_index);
        let pass = (1.0 - r).powi(2);
        // r² T a² + (1−r)² a − T = 0, the root in 0..1 written without cancellation.
        let internal = 2.0 * transmittance / (pass + (pass * pass + 4.0 * (r * transmittance).powi(2)).sqrt());
        Self::Bare { refractive_index, internal: internal.clamp(0.0, 1.0) }
    }

    /// Coated glass by its measured transmittance and reflectances (back, front) at normal incidence.
    #[must_use]
    pub fn coated(transmittance: f64, reflected: [f64; 2]) -> Self {
        Self::Coated(Shares { passed: transmittance, reflected })
    }

    fn in_bands(pane: &GlassPane, refractive_index: f64, values: &impl Fn(&SpectralValue) -> Vec<f64>) -> Vec<Self> {
        let passed = values(&pane.transmittance);
        match pane.reflectance.as_ref().map(|sides| sides.each_ref().map(values)) {
            None => passed.iter().map(|t| Self::bare(*t, refractive_index)).collect(),
            Some([back, front]) => {
                passed.iter().zip(back.iter().zip(&front)).map(|(t, (b, f))| Self::coated(*t, [*b, *f])).collect()
            }
        }
    }

    /// Shares for the two polarisations at an angle of incidence.
    fn polarised(&self, cosine: f64) -> [Shares; 2] {
        match self {
            Self::Bare { refractive_index, internal } => bare(*refractive_index, *internal, cosine),
            Self::Coated(normal) => [coated(normal, cosine); 2],
        }
    }
}

/// Reflectance of one face at normal incidence, `r = ((n−1)/(n+1))²`.
fn normal_reflectance(refractive_index: f64) -> f64 {
    ((refractive_index - 1.0) / (refractive_index + 1.0)).powi(2)
}

/// Fresnel at both faces, absorption along the slanted path, all inner reflections summed:
/// `T = (1−r)² a / (1 − r² a²)`, `R = r + r (1−r)² a² / (1 − r² a²)`.
fn bare(n: f64, internal: f64, c: f64) -> [Shares; 2] {
    let inner = (1.0 - (1.0 - c * c) / (n * n)).max(0.0).sqrt();
    let a = internal.powf(1.0 / inner);
    let amplitudes = [(c - n * inner) / (c + n * inner), (n * c - inner) / (n * c + inner)];
    amplitudes.map(|amplitude| {
        let r = amplitude * amplitude;
        let through = (1.0 - r).powi(2) / (1.0 - r * r * a * a);
        Shares { passed: through * a, reflected: [r + r * through * a * a; 2] }
    })
}

/// Normal transmittance above which a coated pane follows clear glass, and below which bronze glass.
const CLEAR: f64 = 0.645;
/// Transmittance over that at normal incidence, and its sum with the reflectance of glass that would reflect nothing at
/// normal incidence, as polynomials in the cosine.
const CLEAR_GLASS: [[f64; 5]; 2] = [[-0.0015, 3.355, -3.840, 1.460, 0.0288], [0.999, -0.563, 2.043, -2.532, 1.054]];
const BRONZE_GLASS: [[f64; 5]; 2] = [[-0.002, 2.813, -2.341, -0.057_25, 0.599], [0.997, -1.868, 6.513, -7.862, 3.225]];

/// A coating's own angular curve is rarely known. WINDOW 4 lets it follow that of clear or bronze glass, by its normal
/// transmittance (Finlayson et al. 1993): `T = T₀ τ(c)`, `R = R₀ (1−ρ(c)) + ρ(c)`. The fits are scaled to meet the
/// measured values at normal incidence and held within what energy allows.
fn coated(normal: &Shares, c: f64) -> Shares {
    let [tau, whole] = (if normal.passed > CLEAR { CLEAR_GLASS } else { BRONZE_GLASS })
        .map(|k| k.iter().rev().fold(0.0, |sum, a| sum * c + a) / k.iter().sum::<f64>());
    let tau = tau.clamp(0.0, 1.0);
    let rho = (whole - tau).clamp(0.0, 1.0 - tau);
    Shares { passed: normal.passed * tau, reflected: normal.reflected.map(|r| r * (1.0 - rho) + rho) }
}

/// A glazing unit: panes from the front of a face to its back.
#[derive(Clone, Debug, PartialEq)]
pub struct GlazingUnit {
    /// The panes.
    pub panes: Vec<Pane>,
    /// Share of what it passes that dirt leaves.
    pub maintenance_factor: f64,
}

impl GlazingUnit {
    /// Equal uncoated panes that together pass `transmittance` at normal incidence.
    #[must_use]
    pub fn alike(count: usize, transmittance: f64, refractive_index: f64) -> Self {
        let unit = |pane| Self { panes: vec![pane; count], maintenance_factor: 1.0 };
        if count == 1 {
            return unit(Pane::bare(transmittance, refractive_index));
        }
        // The unit passes more the more its panes pass; bisection down to rounding.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let internal = 0.5 * (low + high);
            let passed = unit(Pane::Bare { refractive_index, internal }).shares(1.0).passed;
            *(if passed < transmittance { &mut low } else { &mut high }) = internal;
        }
        unit(Pane::Bare { refractive_index, internal: 0.5 * (low + high) })
    }

    /// As it is in each band; `values` averages over the bands.
    pub fn in_bands(panes: &Panes, refractive_index: f64, values: &impl Fn(&SpectralValue) -> Vec<f64>) -> Vec<Self> {
        match panes {
            Panes::Alike { count, transmittance } => {
                values(transmittance).iter().map(|t| Self::alike(*count, *t, refractive_index)).collect()
            }
            Panes::Listed(list) => {
                let by_pane: Vec<Vec<Pane>> =
                    list.iter().map(|p| Pane::in_bands(p, refractive_index, values)).collect();
                let bands = by_pane.first().map_or(0, Vec::len);
                let panes = |b: usize| by_pane.iter().map(|p| p[b]).collect();
                (0..bands).map(|b| Self { panes: panes(b), maintenance_factor: 1.0 }).collect()
            }
        }
    }

    /// The same with dirt on it.
    #[must_use]
    pub fn in_use(self, maintenance_factor: f64) -> Self {
        Self { maintenance_factor, ..self }
    }

    /// Shares at an angle of incidence for light without polarisation.
    #[must_use]
    pub fn shares(&self, cosine: f64) -> Shares {
        let c = cosine.clamp(1e-9, 1.0);
        let clear = Shares { passed: 1.0, reflected: [0.0; 2] };
        let clean = Shares::mean(self.panes.iter().fold([clear; 2], |[s, p], pane| {
            let [next_s, next_p] = pane.polarised(c);
            [s.before(next_s), p.before(next_p)]
        }));
        Shares { passed: self.maintenance_factor * clean.passed, ..clean }
    }

    /// Transmittance for light from all directions alike, `∫ T(c) 2c dc`.
    #[must_use]
    pub fn hemispherical_transmittance(&self) -> f64 {
        // Midpoints: the integrand falls as c² at the horizon, so the rule errs by the order n⁻².
        let n = 512;
        let place = |k: usize| (k as f64 + 0.5) / n as f64;
        (0..n).map(|k| 2.0 * place(k) * self.shares(place(k)).passed).sum::<f64>() / n as f64
    }
}

/// Steps of the root of the cosine in a [`Glazing`]'s table.
const STEPS: usize = 1024;

/// A glazing unit in the bands of a run: its shares by angle, linear between 1,025 cosines that lie closer at grazing angles,
/// exact at normal incidence. Between them it errs by less than 1e-5.
#[derive(Clone, Debug)]
pub struct Glazing {
    /// Mean over the bands, then each band of coloured ones: `[cosine][column][passed, reflected back, front]`.
    table: Vec<[f32; 3]>,
    columns: usize,
}

impl Glazing {
    /// From the unit as it is in each band; a grey one is the same in all.
    #[must_use]
    pub fn new(by_band: &[GlazingUnit], grey: bool) -> Self {
        let units = if grey { &by_band[..1] } else { by_band };
        let columns = if grey { 1 } else { 1 + units.len() };
        let mut table = Vec::with_capacity((STEPS + 1) * columns);
        for step in 0..=STEPS {
            let cosine = (step as f64 / STEPS as f64).powi(2);
            let values: Vec<[f64; 3]> =
                units.iter().map(|u| u.shares(cosine)).map(|s| [s.passed, s.reflected[0], s.reflected[1]]).collect();
            let mean = std::array::from_fn(|k| values.iter().map(|v| v[k]).sum::<f64>() / values.len() as f64);
            let rows = std::iter::once(mean).chain(values.iter().copied().filter(|_| !grey));
            table.extend(rows.map(|v: [f64; 3]| v.map(|x| x as f32)));
        }
        Self { table, columns }
    }

    /// The same at every wavelength?
    #[must_use]
    pub fn is_grey(&self) -> bool {
        self.columns == 1
    }

    /// Number of bands of a coloured one; 1 of a grey one.
    #[must_use]
    pub fn bands(&self) -> usize {
        (self.columns - 1).max(1)
    }

    fn look_up(&self, cosine: f64, column: usize) -> Shares {
        let place = cosine.clamp(0.0, 1.0).sqrt() * STEPS as f64;
        let step = (place as usize).min(STEPS - 1);
        // Linear in the cosine between nodes at (step/STEPS)².
        let t = (place * place - (step * step) as f64) / (2 * step + 1) as f64;
        let (a, b) = (self.table[step * self.columns + column], self.table[(step + 1) * self.columns + column]);
        let [passed, back, front] = std::array::from_fn(|k| f64::from(a[k]) * (1.0 - t) + f64::from(b[k]) * t);
        Shares { passed, reflected: [back, front] }
    }

    /// Mean shares of the bands.
    #[must_use]
    pub fn mean(&self, cosine: f64) -> Shares {
        self.look_up(cosine, 0)
    }

    /// Shares in a band.
    #[must_use]
    pub fn in_band(&self, cosine: f64, band: usize) -> Shares {
        self.look_up(cosine, if self.is_grey() { 0 } else { 1 + band })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pane that absorbs nothing.
    const CLEAR_PANE: Pane = Pane::Bare { refractive_index: 1.52, internal: 1.0 };

    fn unit(panes: &[Pane]) -> GlazingUnit {
        GlazingUnit { panes: panes.to_vec(), maintenance_factor: 1.0 }
    }

    #[test]
    fn normal_transmittance_comes_back() {
        for t in [0.0, 0.3, 0.65, 0.75] {
            for count in 1..=3 {
                let unit = GlazingUnit::alike(count, t, 1.52);
                assert!((unit.shares(1.0).passed - t).abs() < 1e-12, "{count} panes of {t}");
            }
        }
    }

    #[test]
    fn panes_that_absorb_nothing_pass_what_stokes_found() {
        for count in 1..=5 {
            let shares = unit(&vec![CLEAR_PANE; count]).shares(1.0);
            // 2N faces of r = (0.52/2.52)² (Stokes 1862).
            let r = normal_reflectance(1.52);
            let exact = (1.0 - r) / (1.0 + (2 * count - 1) as f64 * r);
            assert!((shares.passed - exact).abs() < 1e-14, "{count}");
        }
    }

    #[test]
    fn clear_panes_absorb_nothing_at_any_angle() {
        for count in 1..=3 {
            let unit = unit(&vec![CLEAR_PANE; count]);
            for c in [1.0, 0.7, 0.3, 0.05, 0.0] {
                let s = unit.shares(c);
                assert!((s.passed + s.reflected[0] - 1.0).abs() < 1e-8, "{count} panes at {c}");
            }
        }
    }

    #[test]
    fn a_polariser_is_made_of_panes_at_brewsters_angle() {
        // p-polarised light is not reflected at tan θ = n: however many panes, half of the light passes unhindered; the
        // other half passes 2N faces, r = ((n²−1)/(n²+1))².
        let n: f64 = 1.52;
        let cosine = 1.0 / (1.0 + n * n).sqrt();
        let r = ((n * n - 1.0) / (n * n + 1.0)).powi(2);
        for count in 1..=3 {
            let exact = 0.5 * (1.0 + (1.0 - r) / (1.0 + (2 * count - 1) as f64 * r));
            let found = unit(&vec![CLEAR_PANE; count]).shares(cosine).passed;
            assert!((found - exact).abs() < 1e-12, "{count}: {found} {exact}");
        }
    }

    #[test]
    fn a_unit_turned_around_passes_the_same_and_swaps_its_reflectances() {
        let tinted = Pane::bare(0.5, 1.52);
        let one = unit(&[tinted, Pane::coated(0.82, [0.11, 0.05])]);
        let turned = unit(&[Pane::coated(0.82, [0.05, 0.11]), tinted]);
        for c in [1.0, 0.6, 0.2] {
            let (a, b) = (one.shares(c), turned.shares(c));
            assert!((a.passed - b.passed).abs() < 1e-15, "{c}");
            assert!((a.reflected[0] - b.reflected[1]).abs() < 1e-15 && (a.reflected[1] - b.reflected[0]).abs() < 1e-15);
            assert!((a.reflected[0] - a.reflected[1]).abs() > 1e-2, "the coating lies behind the tint or before it");
        }
    }

    #[test]
    fn coated_glass_keeps_its_normal_values_and_never_makes_light() {
        for (t, reflected) in [(0.82, [0.11, 0.05]), (0.4, [0.3, 0.5]), (0.7, [0.3, 0.3]), (0.645, [0.1, 0.355])] {
            let unit = unit(&[Pane::coated(t, reflected)]);
            let normal = unit.shares(1.0);
            assert!((normal.passed - t).abs() < 1e-15);
            assert!((normal.reflected[0] - reflected[0]).abs() < 1e-15);
            for k in 0..=1000 {
                let s = unit.shares(f64::from(k) / 1000.0);
                let most = s.passed + s.reflected[0].max(s.reflected[1]);
                assert!(s.passed >= 0.0 && most <= 1.0 + 1e-12, "{t} at {k}: {s:?}");
            }
            assert!(unit.shares(0.0).reflected[0] > 0.99, "grazing light is reflected");
        }
    }

    #[test]
    fn the_table_keeps_the_unit() {
        let by_band = [GlazingUnit::alike(3, 0.7, 1.52), GlazingUnit::alike(3, 0.4, 1.52)];
        let table = Glazing::new(&by_band, false);
        assert!(!table.is_grey());
        for k in 0..=4999 {
            let c = f64::from(k) / 4999.0;
            for (band, unit) in by_band.iter().enumerate() {
                let (found, exact) = (table.in_band(c, band), unit.shares(c));
                assert!((found.passed - exact.passed).abs() < 1e-5, "{c}: {found:?} {exact:?}");
                assert!((found.reflected[0] - exact.reflected[0]).abs() < 1e-5, "{c}: {found:?} {exact:?}");
            }
            let mean = 0.5 * (table.in_band(c, 0).passed + table.in_band(c, 1).passed);
            assert!((table.mean(c).passed - mean).abs() < 1e-6);
        }
    }
}
