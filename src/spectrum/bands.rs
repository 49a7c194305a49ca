//! The bands of a run: how the spectrum is divided, and what goes in and comes out.

use std::sync::LazyLock;

use super::action::{self, ALPHA_OPIC};
use super::colour::{self, REC709, reflectance_rgb};
use super::planner::{self, Lamps};
use super::{KM, SpectralValue, Spectrum, cie, illuminant};
use crate::{Error, Result};

/// How the spectrum is divided.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum BandMode {
    /// The fewest bands whose error stays inside the tolerance's share.
    #[default]
    Auto,
    /// One band, photometric.
    Grey,
    /// Three bands, linear Rec.709.
    Rgb,
    /// Bands of equal width.
    Step {
        /// Width of a band, nm.
        step_nm: f64,
        /// Lower end of the first, nm.
        lo_nm: f64,
        /// Upper end of the last, nm.
        hi_nm: f64,
    },
    /// Edges of the bands, nm, increasing.
    Edges(Vec<f64>),
}

/// By what a reflectance is weighted inside a band, besides the scene's light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Weighting {
    /// By the light alone.
    Light,
    /// By light × (x̄ + ȳ + z̄).
    Observer,
    /// By light × ȳ.
    Photopic,
}

/// The bands of a run.
///
/// A band's irradiance (or radiance) is its average per nm; a reflectance is averaged with the scene's light
/// as weight, in wide bands also with the observer.
#[derive(Clone, Debug)]
pub struct Bands {
    limits_nm: Vec<(f64, f64)>,
    spectral: bool,
    /// Lamps are averaged so that each one's luminance is exact, see [`Bands::radiance`].
    photometric: bool,
    weighting: Vec<Weighting>,
    xyz_weights: Vec<[f64; 3]>,
    /// Sum over the emitters of radiance times area.
    light: Spectrum,
}

/// In narrower bands, nm, the observer hardly changes.
const NARROW_NM: f64 = 20.0;
/// More bands than this are a slip of the pen.
const MOST_BANDS: usize = 2000;
/// Wavelengths that bands may cover, nm.
const RANGE_NM: (f64, f64) = (100.0, 10_000.0);
/// Nominal ranges of red, green and blue, nm.
const RGB_NM: [(f64, f64); 3] = [(600.0, 700.0), (500.0, 600.0), (400.0, 500.0)];
/// What falls outside of the bands is mentioned above this share of the flux.
const WORTH_MENTIONING: f64 = 1e-3;

/// XYZ per unit of a red, green and blue band value: scaled so that light of equal energy keeps its luminance
/// with values near its radiance per nm.
static RGB_WEIGHTS: LazyLock<[[f64; 3]; 3]> = LazyLock::new(|| {
    let (matrix, scale) = (REC709.xyz_from_rgb(), rgb_scale());
    std::array::from_fn(|band| std::array::from_fn(|k| scale * matrix[k][band]))
});

fn rgb_scale() -> f64 {
    Spectrum::constant(1.0).luminous()
}

impl Bands {
    /// Chooses the bands.
    ///
    /// `reflectances`: value and area in m² of every material in use; `lights`: radiance in W/(m² sr nm) and
    /// area in m² of every emitter (none: equal energy is assumed); `tolerance` as a fraction. The text says
    /// why these bands; it reads on from their number.
    ///
    /// # Errors
    /// Malformed for a step, range or edges that cannot be; impossible for a light below zero.
    pub fn plan(
        mode: &BandMode,
        reflectances: &[(&SpectralValue, f64)],
        lights: &[(&Spectrum, f64)],
        tolerance: f64,
    ) -> Result<(Self, String)> {
        let lamps = Lamps::new(lights)?;
        match mode {
            BandMode::Auto => {
                let plan = planner::auto(reflectances, &lamps, tolerance)?;
                Ok((Self::whole(&plan.edges_nm, lamps.total), plan.note))
            }
            BandMode::Grey => {
                let mut bands = Self::whole(&[cie::FIRST_NM, cie::LAST_NM], lamps.total);
                bands.weighting = vec![Weighting::Photopic];
                Ok((bands, "as asked".into()))
            }
            BandMode::Rgb => Ok((Self::rgb(lamps.total), "linear Rec.709, as asked".into())),
            BandMode::Step { step_nm, lo_nm, hi_nm } => {
                Self::asked(&step_edges(*step_nm, *lo_nm, *hi_nm)?, lamps.total)
            }
            BandMode::Edges(edges) => Self::asked(edges, lamps.total),
        }
    }

    /// Bands that together cover all that the observer sees.
    fn whole(edges: &[f64], light: Spectrum) -> Self {
        let mut bands = Self::divided(edges, light);
        bands.photometric = true;
        bands.weighting.fill(Weighting::Observer);
        bands
    }

    /// Narrow bands in place of several that the program has chosen for the eye: what colour and luminance forgive, other
    /// receptors do not. Bands that the user gave, and the single band of grey scenes, stay.
    #[must_use]
    pub fn narrowed(self) -> Self {
        if !(self.spectral && self.photometric) || self.len() < 2 {
            return self;
        }
        Self::whole(&narrow_edges(), self.light)
    }

    /// Alpha-opic irradiances, W/m², per unit of each band's value in W/(m² nm), in the order of [`ALPHA_OPIC`]; `None`
    /// of red, green and blue, which say too little.
    #[must_use]
    pub fn alpha_opic_weights(&self) -> Option<Vec<[f64; 5]>> {
        let weight = |&(lo, hi): &(f64, f64)| {
            let mean = self.light.mean(lo, hi);
            let even = Spectrum::constant(1.0);
            let (light, mean) = if mean > 0.0 { (&self.light, mean) } else { (&even, 1.0) };
            ALPHA_OPIC.map(|action| action.integral(light, lo, hi) / mean)
        };
        self.spectral.then(|| self.limits_nm.iter().map(weight).collect())
    }

    /// Largest share of each alpha-opic irradiance that these bands may miss, for light of each lamp as it is and after
    /// one and two reflections at each material (what is fainter than 0.3 of the direct light counts less). Zero in RGB mode.
    ///
    /// # Errors
    /// Impossible for a light below zero.
    pub fn alpha_opic_miss(
        &self,
        reflectances: &[(&SpectralValue, f64)],
        lights: &[(&Spectrum, f64)],
    ) -> Result<[f64; 5]> {
        let mut worst = [0.0f64; 5];
        let Some(weights) = self.alpha_opic_weights() else { return Ok(worst) };
        let in_bands = |values: &mut dyn Iterator<Item = f64>| -> [f64; 5] {
            values.zip(&weights).fold([0.0; 5], |sum, (v, w)| std::array::from_fn(|k| sum[k] + v * w[k]))
        };
        for lamp in &Lamps::new(lights)?.kinds {
            let radiance = self.radiance(lamp);
            let whole = |of: &dyn Fn(f64) -> f64, knots: &[f64]| {
                ALPHA_OPIC.map(|action| {
                    let (lo, hi) = action::RANGE_NM;
                    let knots = [lamp.knots_nm(), knots];
                    cie::nodes(lo, hi, &knots).map(|(nm, w)| w * lamp.at(nm) * of(nm) * action.at(nm)).sum::<f64>()
                })
            };
            let direct = whole(&|_| 1.0, &[]);
            let mut tell = |exact: [f64; 5], ours: [f64; 5]| {
                for k in (0..5).filter(|&k| direct[k] > 0.0) {
                    let against = exact[k].max(planner::FAINT * direct[k]);
                    worst[k] = worst[k].max((ours[k] - exact[k]).abs() / against);
                }
            };
            tell(direct, in_bands(&mut radiance.iter().copied()));
            for (value, _) in reflectances.iter().filter(|(v, _)| !v.is_grey()) {
                let (curve, rho) = (value.to_spectrum(), self.reflectance(value));
                for bounces in 1..=2 {
                    let exact = whole(&|nm| curve.at(nm).powi(bounces), curve.knots_nm());
                    tell(exact, in_bands(&mut radiance.iter().zip(&rho).map(|(l, r)| l * r.powi(bounces))));
                }
            }
        }
        Ok(worst)
    }

    /// Bands by the user's edges, with what they miss.
    fn asked(edges: &[f64], light: Spectrum) -> Result<(Self, String)> {
        check_edges(edges)?;
        let outside = luminous_share_outside(edges, &light);
        let bands = Self::divided(edges, light);
        let mut note = format!("from {} to {} nm, as asked", edges[0], edges[edges.len() - 1]);
        if outside > WORTH_MENTIONING {
            note.push_str(&format!(
                "; {:.2} % of the emitters' luminous flux lies outside and is lost",
                100.0 * outside
            ));
        }
        Ok((bands, note))
    }

    fn divided(edges: &[f64], light: Spectrum) -> Self {
        let limits_nm: Vec<(f64, f64)> = edges.windows(2).map(|w| (w[0], w[1])).collect();
        let of_width = |&(lo, hi): &(f64, f64)| {
            if hi - lo > NARROW_NM { Weighting::Observer } else { Weighting::Light }
        };
        Self {
            spectral: true,
            photometric: false,
            weighting: limits_nm.iter().map(of_width).collect(),
            xyz_weights: limits_nm.iter().map(|&(lo, hi)| xyz_per_mean(&light, lo, hi)).collect(),
            limits_nm,
            light,
        }
    }

    fn rgb(light: Spectrum) -> Self {
        Self {
            limits_nm: RGB_NM.to_vec(),
            spectral: false,
            photometric: true,
            weighting: vec![Weighting::Light; 3],
            xyz_weights: RGB_WEIGHTS.to_vec(),
            light,
        }
    }

    /// Number of bands.
    #[must_use]
    pub fn len(&self) -> usize {
        self.limits_nm.len()
    }

    /// Never: there is at least one band.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.limits_nm.is_empty()
    }

    /// Lower and upper end of each band, nm; nominal ones of red, green and blue in RGB mode.
    #[must_use]
    pub fn limits_nm(&self) -> &[(f64, f64)] {
        &self.limits_nm
    }

    /// Are the bands ranges of wavelengths (and not red, green and blue)?
    #[must_use]
    pub fn is_spectral(&self) -> bool {
        self.spectral
    }

    /// CIE 1931 X, Y, Z per unit of each band's value; Y is in lx for irradiances in W/(m² nm) and in cd/m² for
    /// radiances in W/(m² sr nm).
    #[must_use]
    pub fn xyz_weights(&self) -> &[[f64; 3]] {
        &self.xyz_weights
    }

    /// X, Y, Z of band values, one per band.
    #[must_use]
    pub fn xyz(&self, band_values: &[f64]) -> [f64; 3] {
        debug_assert_eq!(band_values.len(), self.len());
        self.xyz_weights
            .iter()
            .zip(band_values)
            .fold([0.0; 3], |sum, (w, v)| std::array::from_fn(|k| sum[k] + w[k] * v))
    }

    /// Band averages of a reflectance or transmittance.
    #[must_use]
    pub fn reflectance(&self, value: &SpectralValue) -> Vec<f64> {
        match value {
            SpectralValue::Grey(v) => vec![*v; self.len()],
            SpectralValue::Rgb(rgb) if !self.spectral => rgb.to_vec(),
            SpectralValue::Spectrum(s) if !self.spectral => self.rgb_reflectance(s).to_vec(),
            _ => {
                let curve = value.to_spectrum();
                (0..self.len()).map(|b| self.average(&curve, b)).collect()
            }
        }
    }

    /// Band values of an emission, W/(m² sr nm).
    ///
    /// In bands given by the user, the plain average. In bands chosen by the program (and in the single band),
    /// scaled so that `Σ w_Y v` is the exact luminance in each band: the same for a single kind of lamp, and
    /// lamps of different spectra each keep their photometry. In RGB mode, linear Rec.709 of the exact XYZ;
    /// a lamp outside of that gamut has a negative value.
    #[must_use]
    pub fn radiance(&self, spectrum: &Spectrum) -> Vec<f64> {
        if !self.spectral {
            let scale = rgb_scale();
            return colour::linear_srgb(spectrum.xyz()).map(|v| v / scale).to_vec();
        }
        (0..self.len())
            .map(|b| {
                let (lo, hi) = self.limits_nm[b];
                if self.photometric {
                    KM * cie::integral(spectrum, lo, hi)[1] / self.xyz_weights[b][1]
                } else {
                    spectrum.mean(lo, hi)
                }
            })
            .collect()
    }

    /// Average of a curve over a band with the band's weight; without weight if there is no light.
    fn average(&self, curve: &Spectrum, band: usize) -> f64 {
        if curve.is_constant() {
            return curve.at(cie::FIRST_NM);
        }
        let (lo, hi) = self.limits_nm[band];
        let knots = [curve.knots_nm(), self.light.knots_nm()];
        let (mut sum, mut weight) = (0.0, 0.0);
        for (nm, w) in cie::nodes(lo, hi, &knots) {
            let c = cie::cmf(nm);
            let observer = match self.weighting[band] {
                Weighting::Light => 1.0,
                Weighting::Observer => c.iter().sum(),
                Weighting::Photopic => c[1],
            };
            let w = w * self.light.at(nm) * observer;
            sum += w * curve.at(nm);
            weight += w;
        }
        if weight > 0.0 { sum / weight } else { curve.mean(lo, hi) }
    }

    /// Linear Rec.709 of a reflectance under the scene's light, under D65 where that light has hardly any of a
    /// channel. Saturated curves leave the gamut: they are held between the curve's own extremes, so that no
    /// energy is made.
    fn rgb_reflectance(&self, curve: &Spectrum) -> [f64; 3] {
        let d65 = || illuminant("D65").and_then(|d65| reflectance_rgb(curve, &d65));
        reflectance_rgb(curve, &self.light)
            .or_else(d65)
            .unwrap_or([curve.mean(cie::FIRST_NM, cie::LAST_NM); 3])
            .map(|v| v.max(curve.min()).min(curve.max()))
    }
}

/// Edges of [`Bands::narrowed`]: 10 nm where receptors are, open at the ends.
fn narrow_edges() -> Vec<f64> {
    let inner = (38..=72).map(|tens| 10.0 * f64::from(tens));
    std::iter::once(cie::FIRST_NM).chain(inner).chain(std::iter::once(cie::LAST_NM)).collect()
}

/// `K_m ∫ S cmf dλ` over the mean of S; S is constant where there is no light.
fn xyz_per_mean(light: &Spectrum, lo: f64, hi: f64) -> [f64; 3] {
    let mean = light.mean(lo, hi);
    if mean > 0.0 {
        cie::integral(light, lo, hi).map(|v| KM * v / mean)
    } else {
        cie::integral(&Spectrum::constant(1.0), lo, hi).map(|v| KM * v)
    }
}

fn luminous_share_outside(edges: &[f64], light: &Spectrum) -> f64 {
    let whole = cie::integral(light, cie::FIRST_NM, cie::LAST_NM)[1];
    let inside = cie::integral(light, edges[0], edges[edges.len() - 1])[1];
    if whole > 0.0 { 1.0 - inside / whole } else { 0.0 }
}

/// Edges of bands of equal width; the last band ends with the range.
fn step_edges(step: f64, lo: f64, hi: f64) -> Result<Vec<f64>> {
    if !(step.is_finite() && step > 0.0) {
        return Err(Error::malformed(format!("a band step of {step} nm, expected a positive number")));
    }
    check_range(lo, hi)?;
    let exact = (hi - lo) / step;
    let whole = exact.round();
    let count = if (exact - whole).abs() < 1e-6 { whole.max(1.0) } else { exact.ceil() };
    if count > MOST_BANDS as f64 {
        return Err(too_many(count));
    }
    let mut edges: Vec<f64> = (0..count as usize).map(|i| lo + step * i as f64).collect();
    edges.push(hi);
    Ok(edges)
}

fn check_edges(edges: &[f64]) -> Result<()> {
    if edges.len() < 2 {
        return Err(Error::malformed(format!("{} band edges, expected at least two", edges.len())));
    }
    if edges.len() - 1 > MOST_BANDS {
        return Err(too_many((edges.len() - 1) as f64));
    }
    if let Some(w) = edges.windows(2).find(|w| !matches!(w[0].partial_cmp(&w[1]), Some(std::cmp::Ordering::Less))) {
        return Err(Error::malformed(format!(
            "the band edge {} nm follows {} nm, expected increasing edges",
            w[1], w[0]
        )));
    }
    check_range(edges[0], edges[edges.len() - 1])
}

fn too_many(count: f64) -> Error {
    Error::malformed(format!("{count} bands are more than the {MOST_BANDS} that are allowed")).mend("take a wider step")
}

fn check_range(lo: f64, hi: f64) -> Result<()> {
    let (least, most) = RANGE_NM;
    if lo >= least && hi <= most && lo < hi {
        return Ok(());
    }
    Err(Error::malformed(format!(
        "bands from {lo} to {hi} nm, expected an increasing range within {least} to {most} nm"
    )))
}

#[cfg(test)]
mod tests {
    use super::super::{Beyond, from_cct};
    use super::*;

    fn step(step_nm: f64, lo_nm: f64, hi_nm: f64) -> BandMode {
        BandMode::Step { step_nm, lo_nm, hi_nm }
    }

    fn red() -> SpectralValue {
        SpectralValue::Rgb([0.6, 0.1, 0.08])
    }

    fn modes() -> Vec<BandMode> {
        vec![
            BandMode::Auto,
            BandMode::Grey,
            BandMode::Rgb,
            step(5.0, 360.0, 830.0),
            step(100.0, 360.0, 830.0),
            BandMode::Edges(vec![360.0, 471.3, 590.0, 830.0]),
        ]
    }

    fn plan(mode: &BandMode, reflectance: &SpectralValue, lamp: &Spectrum) -> (Bands, String) {
        Bands::plan(mode, &[(reflectance, 10.0)], &[(lamp, 1.0)], 0.05).unwrap()
    }

    #[test]
    fn a_lamp_alone_has_the_same_xyz_in_every_mode() {
        for name in ["D65", "A", "F11", "LED-B3", "HP1", "E"] {
            let lamp = illuminant(name).unwrap().scaled(1e-3);
            let exact = lamp.xyz();
            for mode in modes() {
                let (bands, _) = plan(&mode, &red(), &lamp);
                let xyz = bands.xyz(&bands.radiance(&lamp));
                for k in 0..3 {
                    // Rounding: the sums are exact.
                    let miss = (xyz[k] - exact[k]).abs() / exact[1];
                    assert!(miss < 1e-9, "{name} {mode:?} {k} {miss}");
                }
            }
        }
    }

    #[test]
    fn lamps_of_different_colour_each_keep_their_luminance() {
        let (a, b) = (illuminant("A").unwrap(), illuminant("LED-B5").unwrap());
        let lights = [(&a, 1.0), (&b, 3.0)];
        for mode in [BandMode::Auto, BandMode::Grey, BandMode::Rgb] {
            let (bands, _) = Bands::plan(&mode, &[(&red(), 1.0)], &lights, 0.05).unwrap();
            for lamp in [&a, &b] {
                let y = bands.xyz(&bands.radiance(lamp))[1];
                assert!((y / lamp.luminous() - 1.0).abs() < 1e-9, "{mode:?}");
            }
        }
    }

    #[test]
    fn band_averages_are_exact_for_linear_curves() {
        let ramp = Spectrum::new(vec![400.0, 700.0], vec![0.0, 0.6], Beyond::Hold).unwrap();
        let lamp = Spectrum::constant(2.0);
        let (bands, _) = plan(&step(10.0, 400.0, 700.0), &red(), &lamp);
        assert_eq!(bands.len(), 30);
        for (b, v) in bands.reflectance(&SpectralValue::Spectrum(ramp.clone())).iter().enumerate() {
            let expected = 0.002 * (10.0 * b as f64 + 5.0);
            assert!((v - expected).abs() < 1e-13, "{b} {v}");
        }
        let v = bands.radiance(&ramp);
        assert!((v[29] - 0.59).abs() < 1e-13);
    }

    #[test]
    fn what_a_surface_reflects_first_has_exact_luminance_in_one_band() {
        let lamp = illuminant("F11").unwrap();
        let paint = red();
        let (bands, _) = plan(&BandMode::Grey, &paint, &lamp);
        let rho = bands.reflectance(&paint)[0];
        let curve = paint.to_spectrum();
        let knots = [curve.knots_nm(), lamp.knots_nm()];
        let (mut sum, mut whole) = (0.0, 0.0);
        for (nm, w) in cie::nodes(360.0, 830.0, &knots) {
            sum += w * lamp.at(nm) * curve.at(nm) * cie::cmf(nm)[1];
            whole += w * lamp.at(nm) * cie::cmf(nm)[1];
        }
        assert!((rho - sum / whole).abs() < 1e-12);
    }

    #[test]
    fn rgb_mode_takes_rgb_reflectances_as_they_are() {
        let (bands, _) = plan(&BandMode::Rgb, &red(), &illuminant("D65").unwrap());
        assert!(!bands.is_spectral());
        assert_eq!(bands.reflectance(&red()), [0.6, 0.1, 0.08]);
        let upsampled = SpectralValue::Spectrum(red().to_spectrum());
        for (a, b) in bands.reflectance(&upsampled).iter().zip([0.6, 0.1, 0.08]) {
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
    }

    #[test]
    fn rgb_mode_makes_no_energy_of_saturated_curves() {
        let deep = Spectrum::new(vec![600.0, 605.0], vec![0.02, 0.9], Beyond::Hold).unwrap();
        for name in ["D65", "A", "HP1"] {
            let (bands, _) = plan(&BandMode::Rgb, &red(), &illuminant(name).unwrap());
            for v in bands.reflectance(&SpectralValue::Spectrum(deep.clone())) {
                assert!((0.02..=0.9).contains(&v), "{name} {v}");
            }
        }
    }

    #[test]
    fn the_last_step_is_shortened_and_never_overshoots() {
        let edges = step_edges(10.0, 400.0, 425.0).unwrap();
        assert_eq!(edges, [400.0, 410.0, 420.0, 425.0]);
        let edges = step_edges(0.1, 400.0, 401.0).unwrap();
        assert_eq!(edges.len(), 11);
        assert_eq!(edges[10], 401.0);
        assert_eq!(step_edges(500.0, 400.0, 700.0).unwrap(), [400.0, 700.0]);
    }

    #[test]
    fn impossible_divisions_are_refused() {
        let lamp = Spectrum::constant(1.0);
        for mode in [
            step(0.0, 400.0, 700.0),
            step(-5.0, 400.0, 700.0),
            step(f64::NAN, 400.0, 700.0),
            step(f64::INFINITY, 400.0, 700.0),
            step(5.0, 700.0, 400.0),
            step(5.0, f64::NAN, 400.0),
            step(5.0, 0.4, 0.7),
            step(0.1, 400.0, 700.0),
            BandMode::Edges(vec![]),
            BandMode::Edges(vec![500.0]),
            BandMode::Edges(vec![400.0, 500.0, 500.0]),
            BandMode::Edges(vec![400.0, f64::NAN, 500.0]),
        ] {
            let result = Bands::plan(&mode, &[], &[(&lamp, 1.0)], 0.05);
            assert!(result.is_err(), "{mode:?}");
        }
        let negative = Spectrum::constant(-1.0);
        assert!(Bands::plan(&BandMode::Auto, &[], &[(&negative, 1.0)], 0.05).is_err());
        assert!(Bands::plan(&BandMode::Auto, &[], &[], f64::NAN).is_err());
    }

    #[test]
    fn light_outside_of_the_bands_is_mentioned() {
        let lamp = illuminant("A").unwrap();
        let (_, note) = plan(&step(10.0, 400.0, 600.0), &red(), &lamp);
        assert!(note.contains("% of the emitters' luminous flux"), "{note}");
        let (_, note) = plan(&step(5.0, 380.0, 780.0), &red(), &lamp);
        assert!(!note.contains('%'), "{note}");
    }

    #[test]
    fn the_dark_is_no_trouble() {
        let dark = Spectrum::constant(0.0);
        for lights in [vec![], vec![(&dark, 1.0)]] {
            for mode in modes() {
                let (bands, note) = Bands::plan(&mode, &[(&red(), 1.0)], &lights, 0.05).unwrap();
                let values = bands.reflectance(&red());
                assert!(values.iter().all(|v| (0.0..=1.0).contains(v)), "{note}");
                assert!(bands.xyz_weights().iter().flatten().all(|v| v.is_finite()));
            }
        }
    }

    #[test]
    fn warm_and_cold_light_of_one_luminance_agree_in_one_band() {
        let (warm, cold) = (from_cct(2700.0).unwrap(), from_cct(6500.0).unwrap());
        let lights = [(&warm.scaled(1.0 / warm.luminous()), 1.0), (&cold.scaled(1.0 / cold.luminous()), 1.0)];
        let (bands, _) = Bands::plan(&BandMode::Grey, &[(&SpectralValue::Grey(0.5), 1.0)], &lights, 0.05).unwrap();
        let [a, b] = lights.map(|(s, _)| bands.radiance(s)[0]);
        assert!((a / b - 1.0).abs() < 1e-12);
    }
}
