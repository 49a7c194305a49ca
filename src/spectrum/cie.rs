//! The observers of the CIE and the one quadrature rule of this module.
//!
//! The colour-matching functions are taken as linear between their entries at 1 nm, as every other curve is
//! linear between its knots. On a stretch without knots a product of up to three curves is then a cubic at
//! most, which Gauss's rule with two points integrates exactly.

use super::Spectrum;
use super::tables::{cie1931, cie1964};

/// First wavelength of the observer's table, nm.
pub const FIRST_NM: f64 = 360.0;
/// Last wavelength of the observer's table, nm.
pub const LAST_NM: f64 = 830.0;

/// A standard observer of the CIE.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observer {
    /// Of 1931, for fields of 2°: that of photometry.
    Cie1931,
    /// Of 1964, for fields of 10°.
    Cie1964,
}

impl Observer {
    /// Colour-matching functions x̄, ȳ, z̄ at a wavelength in nm, linear between whole nanometres; zero outside 360 to
    /// 830 nm. Source: CIE 018:2019, ISO/CIE 11664-1:2019.
    #[must_use]
    pub fn cmf(self, nm: f64) -> [f64; 3] {
        if !(FIRST_NM..=LAST_NM).contains(&nm) {
            return [0.0; 3];
        }
        let table = match self {
            Self::Cie1931 => &cie1931::CMF,
            Self::Cie1964 => &cie1964::CMF,
        };
        let place = nm - FIRST_NM;
        let left = (place as usize).min(table.len() - 2);
        let t = place - left as f64;
        std::array::from_fn(|c| table[left][c] * (1.0 - t) + table[left + 1][c] * t)
    }
}

/// [`Observer::cmf`] of the 1931 observer.
#[must_use]
pub fn cmf(nm: f64) -> [f64; 3] {
    Observer::Cie1931.cmf(nm)
}

/// Sum of the products of the curves with x̄, ȳ, z̄ at `lo_nm`, `lo_nm + step_nm`, … `hi_nm`: how tables of colour are
/// made (CIE 15:2018, section 7.2, allows steps up to 5 nm). Light itself is integrated, see [`integral`].
#[must_use]
pub fn sum(observer: Observer, curves: &[&Spectrum], lo_nm: f64, hi_nm: f64, step_nm: f64) -> [f64; 3] {
    let last = ((hi_nm - lo_nm) / step_nm).round().max(0.0) as usize;
    (0..=last).map(|i| lo_nm + step_nm * i as f64).fold([0.0; 3], |sum, nm| {
        let v: f64 = curves.iter().map(|s| s.at(nm)).product();
        let c = observer.cmf(nm);
        std::array::from_fn(|k| sum[k] + v * c[k])
    })
}

/// `∫ S x̄ dλ`, `∫ S ȳ dλ`, `∫ S z̄ dλ` over `lo_nm..=hi_nm`, without K_m.
#[must_use]
pub fn integral(s: &Spectrum, lo_nm: f64, hi_nm: f64) -> [f64; 3] {
    let (lo, hi) = (lo_nm.max(FIRST_NM), hi_nm.min(LAST_NM));
    nodes(lo, hi, &[s.knots_nm()]).fold([0.0; 3], |sum, (nm, w)| {
        let (v, c) = (w * s.at(nm), cmf(nm));
        std::array::from_fn(|k| sum[k] + v * c[k])
    })
}

/// Places and weights, both in nm, that integrate over `lo..=hi` any product of three curves which are linear
/// between the given knots and the whole nanometres of the observer's table.
pub(super) fn nodes(lo: f64, hi: f64, knots: &[&[f64]]) -> impl Iterator<Item = (f64, f64)> {
    let breaks = breaks(lo, hi, knots);
    let stretches = breaks.len().saturating_sub(1);
    // Gauss-Legendre with two points: half a width to either side of the middle, over √3.
    (0..stretches).flat_map(move |i| {
        let (middle, half) = (0.5 * (breaks[i] + breaks[i + 1]), 0.5 * (breaks[i + 1] - breaks[i]));
        let off = half / 3f64.sqrt();
        [(middle - off, half), (middle + off, half)]
    })
}

/// `lo`, `hi`, the knots between them and the whole nanometres of the observer's table between them.
fn breaks(lo: f64, hi: f64, knots: &[&[f64]]) -> Vec<f64> {
    if lo >= hi || !(hi - lo).is_finite() {
        return Vec::new();
    }
    let mut all = vec![lo, hi];
    let first = lo.max(FIRST_NM).ceil() as i64;
    let last = hi.min(LAST_NM).floor() as i64;
    all.extend((first..=last).map(|nm| nm as f64));
    for list in knots {
        let a = list.partition_point(|&nm| nm <= lo);
        let b = list.partition_point(|&nm| nm < hi);
        all.extend_from_slice(&list[a..b.max(a)]);
    }
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

#[cfg(test)]
mod tests {
    use super::super::{Beyond, KM, illuminant};
    use super::*;

    #[test]
    fn equal_energy_has_the_published_sums() {
        // CIE 018:2019: the sums at 1 nm are 106.865, 106.857, 106.892.
        let sums = integral(&Spectrum::constant(1.0), FIRST_NM, LAST_NM);
        for (sum, published) in sums.iter().zip([106.865, 106.857, 106.892]) {
            assert!((sum - published).abs() < 6e-4, "{sum} {published}");
        }
    }

    #[test]
    fn one_watt_at_555_nm_gives_km_lumens() {
        // A line of 0.02 nm: V(555 nm) = 1 in the table, flat there to 1e-5.
        let line = Spectrum::new(vec![554.99, 555.01], vec![50.0, 50.0], Beyond::Zero).unwrap();
        assert!((line.luminous() / KM - 1.0).abs() < 1e-5);
    }

    #[test]
    fn d65_has_its_white_point() {
        let [x, y, z] = illuminant("D65").unwrap().xyz();
        let sum = x + y + z;
        // Published to four decimals.
        assert!((x / sum - 0.3127).abs() < 5e-5, "{}", x / sum);
        assert!((y / sum - 0.3290).abs() < 5e-5, "{}", y / sum);
    }

    #[test]
    fn the_parts_of_a_range_sum_to_the_whole() {
        let s = illuminant("F11").unwrap();
        let whole = integral(&s, FIRST_NM, LAST_NM);
        let cuts = [360.0, 433.3, 545.01, 546.0, 612.7, 830.0];
        let parts = cuts
            .windows(2)
            .map(|w| integral(&s, w[0], w[1]))
            .fold([0.0; 3], |sum, p| std::array::from_fn(|k| sum[k] + p[k]));
        for k in 0..3 {
            assert!((parts[k] / whole[k] - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn a_broken_range_has_no_light() {
        assert_eq!(integral(&Spectrum::constant(1.0), 500.0, 400.0), [0.0; 3]);
        assert_eq!(cmf(f64::NAN), [0.0; 3]);
    }
}
