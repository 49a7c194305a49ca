//! A thin clear pane: Fresnel reflection at both faces, absorption along the slanted path between them.

/// A pane of one transmittance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pane {
    refractive_index: f64,
    /// Internal transmittance at normal incidence.
    internal: f64,
}

impl Pane {
    /// From the measured transmittance at normal incidence: `T = (1−r)² a / (1 − r² a²)` is solved for `a`.
    #[must_use]
    pub fn new(transmittance: f64, refractive_index: f64) -> Self {
        let r = ((refractive_index - 1.0) / (refractive_index + 1.0)).powi(2);
        let pass = (1.0 - r).powi(2);
        // r² T a² + (1−r)² a − T = 0, the root in 0..1 written without cancellation.
        let internal = 2.0 * transmittance / (pass + (pass * pass + 4.0 * (r * transmittance).powi(2)).sqrt());
        Self { refractive_index, internal: internal.clamp(0.0, 1.0) }
    }

    /// Transmittance at an angle of incidence, both polarisations averaged.
    #[must_use]
    pub fn transmittance(&self, cosine: f64) -> f64 {
        self.by_angle(cosine).0
    }

    /// Transmittance and reflectance at an angle of incidence.
    ///
    /// `T = (1−r)² a / (1 − r² a²)`, `R = r + r (1−r)² a² / (1 − r² a²)`, mean over both polarisations (Fresnel; all
    /// inner reflections summed).
    #[must_use]
    pub fn by_angle(&self, cosine: f64) -> (f64, f64) {
        let c = cosine.clamp(1e-9, 1.0);
        let n = self.refractive_index;
        let inner = (1.0 - (1.0 - c * c) / (n * n)).max(0.0).sqrt();
        let a = self.internal.powf(1.0 / inner);
        let amplitudes = [(c - n * inner) / (c + n * inner), (n * c - inner) / (n * c + inner)];
        let mut sums = (0.0, 0.0);
        for amplitude in amplitudes {
            let r = amplitude * amplitude;
            let through = (1.0 - r).powi(2) / (1.0 - r * r * a * a);
            sums.0 += 0.5 * through * a;
            sums.1 += 0.5 * (r + r * through * a * a);
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::Pane;

    #[test]
    fn normal_transmittance_comes_back() {
        for t in [0.0, 0.3, 0.65, 0.88, 0.917] {
            assert!((Pane::new(t, 1.52).transmittance(1.0) - t).abs() < 1e-12, "{t}");
        }
    }

    #[test]
    fn clear_pane_absorbs_nothing_at_any_angle() {
        let r: f64 = (0.52f64 / 2.52).powi(2);
        let pane = Pane::new((1.0 - r) / (1.0 + r), 1.52);
        for c in [1.0, 0.7, 0.3, 0.05] {
            let (t, r) = pane.by_angle(c);
            assert!((t + r - 1.0).abs() < 1e-12, "{c}");
        }
    }
}
