//! How many bands a scene needs.
//!
//! A lumped model of the scene is solved at 5 nm and in the bands on trial: light of each lamp, unreflected,
//! after one reflection at each material, after two at each pair of coloured materials, and after many at the
//! mean of all surfaces. The fewest bands win whose luminance and chromaticity come near enough.

use super::colour::uv_prime;
use super::{Beyond, SpectralValue, Spectrum, cie};
use crate::{Error, Result};

/// The light of a scene.
#[derive(Debug)]
pub(super) struct Lamps {
    /// Sum over the emitters of radiance times area; equal energy if there are none.
    pub(super) total: Spectrum,
    /// The kinds of lamps that differ by more than a factor, strongest first.
    pub(super) kinds: Vec<Spectrum>,
}

/// More kinds of lamps or coloured materials than these are judged by the strongest and the largest alone.
const MOST_KINDS: usize = 4;
const MOST_COLOURS: usize = 24;

impl Lamps {
    pub(super) fn new(lights: &[(&Spectrum, f64)]) -> Result<Self> {
        let mut kinds: Vec<(Spectrum, f64)> = Vec::new();
        for (spectrum, area) in lights {
            check_light(spectrum, *area)?;
            if spectrum.max() <= 0.0 || *area <= 0.0 {
                continue;
            }
            match kinds.iter_mut().find(|(s, _)| proportional(s, spectrum)) {
                // The first of a kind stands for all: its area is enlarged.
                Some((s, a)) => *a += area * spectrum.max() / s.max(),
                None => kinds.push(((*spectrum).clone(), *area)),
            }
        }
        if kinds.is_empty() {
            kinds.push((Spectrum::constant(1.0), 1.0));
        }
        let total = sum(&kinds);
        let mut kinds: Vec<Spectrum> = kinds.iter().map(|(s, a)| s.scaled(*a)).collect();
        kinds.sort_by(|a, b| b.luminous().total_cmp(&a.luminous()));
        kinds.truncate(MOST_KINDS);
        Ok(Self { total, kinds })
    }
}

fn check_light(spectrum: &Spectrum, area: f64) -> Result<()> {
    if spectrum.min() < 0.0 {
        return Err(Error::impossible(format!(
            "a light has the spectral radiance {}, expected none below zero",
            spectrum.min()
        )));
    }
    if !(area.is_finite() && area >= 0.0 && spectrum.max().is_finite()) {
        return Err(Error::impossible(format!(
            "a light of {} W/(m² sr nm) on {area} m² is not finite",
            spectrum.max()
        )));
    }
    Ok(())
}

/// Is one curve the other times a factor, to rounding?
fn proportional(a: &Spectrum, b: &Spectrum) -> bool {
    if a.knots_nm() != b.knots_nm() || a.beyond() != b.beyond() {
        return false;
    }
    let k = b.max() / a.max();
    a.knots_nm().iter().all(|&nm| (a.at(nm) * k - b.at(nm)).abs() <= 1e-12 * b.max())
}

/// Sum of curves times factors. A curve that is zero beyond its ends falls there within one rounding of the
/// wavelength.
fn sum(parts: &[(Spectrum, f64)]) -> Spectrum {
    let mut nm: Vec<f64> = Vec::new();
    for (s, _) in parts {
        let knots = s.knots_nm();
        nm.extend_from_slice(knots);
        if s.beyond() == Beyond::Zero {
            nm.extend([knots[0].next_down(), knots[knots.len() - 1].next_up()]);
        }
    }
    nm.sort_by(f64::total_cmp);
    nm.dedup();
    let value = nm.iter().map(|&nm| parts.iter().map(|(s, k)| k * s.at(nm)).sum()).collect();
    Spectrum::from_knots(nm, value, Beyond::Hold)
}

/// What the planner chose.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) edges_nm: Vec<f64>,
    pub(super) note: String,
}

/// Numbers of bands that are tried.
const TRIALS: [usize; 9] = [3, 4, 6, 9, 12, 16, 20, 31, 40];
/// Width of the model's cells, nm; bands end on their borders.
const CELL_NM: f64 = 5.0;
const CELLS: usize = 94;
/// Range that bands of equal width divide, nm; the outer ones are opened.
const CORE_NM: (f64, f64) = (400.0, 700.0);

/// Share of the tolerance that the bands may take.
const SHARE: f64 = 0.1;
/// Least chromaticity error worth avoiding, u'v': a just visible step is about 0.002.
const LEAST_UV: f64 = 2e-3;
/// Light weaker than this share of the direct light counts less: other light drowns it.
pub(super) const FAINT: f64 = 0.3;
/// Highest mean reflectance of the model.
const MOST_MEAN: f64 = 0.99;

/// The bands for a scene.
pub(super) fn auto(reflectances: &[(&SpectralValue, f64)], lamps: &Lamps, tolerance: f64) -> Result<Plan> {
    if !(tolerance.is_finite() && tolerance > 0.0) {
        return Err(Error::malformed(format!("a tolerance of {tolerance}, expected a positive number")));
    }
    let grey = reflectances.iter().all(|(value, _)| value.is_grey());
    let whole = vec![cie::FIRST_NM, cie::LAST_NM];
    if grey && lamps.kinds.len() == 1 {
        return Ok(Plan {
            edges_nm: whole,
            note: "exact: every reflectance is grey and all lamps have one spectrum".into(),
        });
    }
    let model = Model::new(reflectances, lamps);
    let limit = Miss { luminous: SHARE * tolerance, uv: LEAST_UV.max(SHARE * tolerance) };
    if grey {
        let miss = model.miss(&[0, CELLS]);
        if miss.within(&limit) {
            return Ok(plan(&[0, CELLS], &miss, &limit));
        }
    }
    let mut best: Option<(Vec<usize>, Miss)> = None;
    for count in TRIALS {
        for edges in [equal_width(count), model.equal_share(count)] {
            let miss = model.miss(&edges);
            if edges.len() == count + 1 && best.as_ref().is_none_or(|b| miss.over(&limit) < b.1.over(&limit)) {
                best = Some((edges, miss));
            }
        }
        if best.as_ref().is_some_and(|b| b.1.within(&limit)) {
            break;
        }
    }
    let (edges, miss) = best.unwrap_or_else(|| (vec![0, CELLS], model.miss(&[0, CELLS])));
    Ok(plan(&edges, &miss, &limit))
}

fn plan(edges: &[usize], miss: &Miss, limit: &Miss) -> Plan {
    let verdict = if miss.within(limit) { "the fewest that keep" } else { "the most that are tried; they do not keep" };
    Plan {
        edges_nm: edges.iter().map(|&e| edge_nm(e)).collect(),
        note: format!(
            "{verdict} reflected light within {:.2} % in luminance and {:.4} in u'v' (estimated {:.2} % and {:.4})",
            100.0 * limit.luminous,
            limit.uv,
            100.0 * miss.luminous,
            miss.uv
        ),
    }
}

fn edge_nm(cell: usize) -> f64 {
    cie::FIRST_NM + CELL_NM * cell as f64
}

/// Errors of bands, the largest over all light considered.
#[derive(Clone, Copy, Debug, Default)]
struct Miss {
    /// Relative, of the luminance.
    luminous: f64,
    /// Distance in u'v'.
    uv: f64,
}

impl Miss {
    /// How far over the limit; 1 is at the limit.
    fn over(&self, limit: &Self) -> f64 {
        (self.luminous / limit.luminous).max(self.uv / limit.uv)
    }

    fn within(&self, limit: &Self) -> bool {
        self.over(limit) <= 1.0
    }
}

/// Borders, as cell numbers, of bands of equal width with the ends opened.
fn equal_width(count: usize) -> Vec<usize> {
    let (lo, hi) = CORE_NM;
    let inner = (1..count).map(|i| {
        let nm = lo + (hi - lo) * i as f64 / count as f64;
        ((nm - cie::FIRST_NM) / CELL_NM).round() as usize
    });
    std::iter::once(0).chain(inner).chain([CELLS]).collect()
}

/// A way of the light: no reflection, one, two, many.
#[derive(Clone, Copy, Debug)]
enum Way {
    Direct,
    Once(usize),
    Twice(usize, usize),
    Often,
}

/// A reflectance per cell or per band.
type Curve = Vec<f64>;

/// The scene as a closed box with well-mixed light, per cell of 5 nm.
struct Model {
    /// ∫ S cmf dλ of each kind of lamp.
    lamps: Vec<Vec<[f64; 3]>>,
    /// The same of all light.
    total: Vec<[f64; 3]>,
    /// Area mean of the reflectances, then the coloured materials.
    curves: Vec<Curve>,
    ways: Vec<Way>,
}

impl Model {
    fn new(reflectances: &[(&SpectralValue, f64)], lamps: &Lamps) -> Self {
        let mut mean = vec![0.0; CELLS];
        let mut area_m2 = 0.0;
        let mut coloured: Vec<(Curve, f64)> = Vec::new();
        for (value, area) in reflectances {
            let curve = cells_of(value);
            for (m, v) in mean.iter_mut().zip(&curve) {
                *m += v * area;
            }
            area_m2 += area;
            if !value.is_grey() {
                coloured.push((curve, *area));
            }
        }
        if area_m2 > 0.0 {
            mean.iter_mut().for_each(|m| *m /= area_m2);
        }
        coloured.sort_by(|a, b| b.1.total_cmp(&a.1));
        coloured.truncate(MOST_COLOURS);
        let curves: Vec<Curve> = std::iter::once(mean).chain(coloured.into_iter().map(|c| c.0)).collect();
        Self {
            lamps: lamps.kinds.iter().map(light_of).collect(),
            total: light_of(&lamps.total),
            ways: ways(curves.len()),
            curves,
        }
    }

    /// Borders of bands that hold equal shares of light × (x̄ + ȳ + z̄).
    fn equal_share(&self, count: usize) -> Vec<usize> {
        let weight: Vec<f64> = self.total.iter().map(|c| c.iter().sum()).collect();
        let whole: f64 = weight.iter().sum();
        let mut edges = vec![0];
        let mut sum = 0.0;
        for (i, w) in weight.iter().enumerate() {
            sum += w;
            let wanted = whole * edges.len() as f64 / count as f64;
            if sum >= wanted && edges.len() < count && i + 1 < CELLS {
                edges.push(i + 1);
            }
        }
        edges.push(CELLS);
        edges
    }

    /// The largest errors of bands with these borders.
    fn miss(&self, edges: &[usize]) -> Miss {
        let bands: Vec<std::ops::Range<usize>> = edges.windows(2).map(|w| w[0]..w[1]).collect();
        let curves: Vec<Curve> =
            self.curves.iter().map(|c| bands.iter().map(|b| self.average(c, b.clone())).collect()).collect();
        let mut worst = Miss::default();
        for lamp in &self.lamps {
            let banded: Vec<[f64; 3]> = bands.iter().map(|b| self.banded(lamp, b.clone())).collect();
            let direct: f64 = lamp.iter().map(|c| c[1]).sum();
            for &way in &self.ways {
                let truth = received(lamp, &factors(way, &self.curves));
                let found = received(&banded, &factors(way, &curves));
                let miss = miss_of(truth, found, direct);
                worst.luminous = worst.luminous.max(miss.luminous);
                worst.uv = worst.uv.max(miss.uv);
            }
        }
        worst
    }

    /// Average as [`super::Bands::reflectance`] takes it.
    fn average(&self, curve: &Curve, band: std::ops::Range<usize>) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for i in band.clone() {
            let w: f64 = self.total[i].iter().sum();
            sum += w * curve[i];
            weight += w;
        }
        if weight > 0.0 { sum / weight } else { curve[band.clone()].iter().sum::<f64>() / band.len() as f64 }
    }

    /// XYZ that the band of a lamp has with the weights of all light, luminance exact.
    fn banded(&self, lamp: &[[f64; 3]], band: std::ops::Range<usize>) -> [f64; 3] {
        let sum =
            |light: &[[f64; 3]]| light[band.clone()].iter().fold([0.0; 3], |s, c| std::array::from_fn(|k| s[k] + c[k]));
        let (own, all) = (sum(lamp), sum(&self.total));
        if all[1] > 0.0 { all.map(|v| v * own[1] / all[1]) } else { own }
    }
}

fn ways(curves: usize) -> Vec<Way> {
    let mut ways = vec![Way::Direct, Way::Often];
    for i in 1..curves {
        ways.push(Way::Once(i));
        ways.extend((i..curves).map(|j| Way::Twice(i, j)));
    }
    ways
}

/// What a way multiplies the light by, per cell or band.
fn factors(way: Way, curves: &[Curve]) -> Curve {
    match way {
        Way::Direct => vec![1.0; curves[0].len()],
        Way::Once(i) => curves[i].clone(),
        Way::Twice(i, j) => curves[i].iter().zip(&curves[j]).map(|(a, b)| a * b).collect(),
        Way::Often => curves[0].iter().map(|m| m.clamp(0.0, MOST_MEAN)).map(|m| m / (1.0 - m)).collect(),
    }
}

fn received(light: &[[f64; 3]], factors: &[f64]) -> [f64; 3] {
    light.iter().zip(factors).fold([0.0; 3], |sum, (c, f)| std::array::from_fn(|k| sum[k] + c[k] * f))
}

/// Errors of light `found` against `truth`, less where it is faint against the direct luminance.
fn miss_of(truth: [f64; 3], found: [f64; 3], direct: f64) -> Miss {
    let floor = FAINT * direct;
    let scale = truth[1].max(floor);
    if scale <= 0.0 {
        return Miss::default();
    }
    let uv = match (uv_prime(truth), uv_prime(found)) {
        (Some(a), Some(b)) => (a[0] - b[0]).hypot(a[1] - b[1]),
        _ => 0.0,
    };
    Miss { luminous: (found[1] - truth[1]).abs() / scale, uv: uv * (truth[1] / floor).min(1.0) }
}

fn cells_of(value: &SpectralValue) -> Curve {
    let curve = value.to_spectrum();
    (0..CELLS).map(|i| curve.mean(edge_nm(i), edge_nm(i + 1))).collect()
}

fn light_of(light: &Spectrum) -> Vec<[f64; 3]> {
    (0..CELLS).map(|i| cie::integral(light, edge_nm(i), edge_nm(i + 1))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::illuminant;
    use super::*;

    fn lamps(names: &[&str]) -> Lamps {
        let spectra: Vec<Spectrum> = names.iter().map(|n| illuminant(n).unwrap()).collect();
        let lights: Vec<(&Spectrum, f64)> = spectra.iter().map(|s| (s, 1.0)).collect();
        Lamps::new(&lights).unwrap()
    }

    fn count(reflectances: &[SpectralValue], names: &[&str], tolerance: f64) -> usize {
        let list: Vec<(&SpectralValue, f64)> = reflectances.iter().map(|r| (r, 1.0)).collect();
        auto(&list, &lamps(names), tolerance).unwrap().edges_nm.len() - 1
    }

    #[test]
    fn grey_scenes_with_one_kind_of_lamp_take_one_band() {
        let greys = [SpectralValue::Grey(0.2), SpectralValue::Rgb([0.8; 3])];
        assert_eq!(count(&greys, &["F11"], 0.01), 1);
    }

    #[test]
    fn grey_scenes_with_lamps_of_different_colour_take_more() {
        let greys = [SpectralValue::Grey(0.2)];
        assert!(count(&greys, &["A", "D75"], 0.05) > 1);
    }

    #[test]
    fn a_tighter_tolerance_never_takes_fewer_bands() {
        let paints =
            [SpectralValue::Rgb([0.6, 0.1, 0.08]), SpectralValue::Rgb([0.1, 0.5, 0.12]), SpectralValue::Grey(0.7)];
        for lamp in ["D65", "F11", "LED-B3"] {
            let counts = [0.2, 0.05, 0.01].map(|t| count(&paints, &[lamp], t));
            assert!(counts.is_sorted(), "{lamp} {counts:?}");
            assert!(counts[0] >= 3);
        }
    }

    #[test]
    fn lamps_that_differ_by_a_factor_are_one_kind() {
        let a = illuminant("A").unwrap();
        let b = a.scaled(3.0);
        let lamps = Lamps::new(&[(&a, 1.0), (&b, 2.0)]).unwrap();
        assert_eq!(lamps.kinds.len(), 1);
        assert!((lamps.total.luminous() / a.luminous() - 7.0).abs() < 1e-9);
    }

    #[test]
    fn a_sum_of_lamps_has_the_sum_of_their_light() {
        let [a, b] = ["D65", "F2"].map(|n| illuminant(n).unwrap());
        let total = sum(&[(a.clone(), 2.0), (b.clone(), 0.5)]);
        let expected = 2.0 * a.luminous() + 0.5 * b.luminous();
        // The falls at the ends of the tables are one rounding wide.
        assert!((total.luminous() / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn equal_shares_of_light_are_in_order_and_cover_the_range() {
        let model = Model::new(&[], &lamps(&["HP1"]));
        for count in TRIALS {
            for edges in [equal_width(count), model.equal_share(count)] {
                assert!(edges.is_sorted_by(|a, b| a < b), "{edges:?}");
                assert_eq!((edges[0], edges[edges.len() - 1]), (0, CELLS));
            }
            assert_eq!(equal_width(count).len(), count + 1);
        }
    }
}
