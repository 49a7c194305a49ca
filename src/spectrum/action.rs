//! What light does to receptors other than those of photopic vision: rods and the five alpha-opic responses of
//! CIE S 026:2018 (colours and clocks of the body).

use super::tables::action::ACTION;
use super::{Spectrum, cie};

/// First and last wavelength of the table, nm; nothing is defined beyond.
pub(super) const RANGE_NM: (f64, f64) = (380.0, 780.0);

/// An action spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// V'(λ), scotopic vision (CIE 018:2019).
    Scotopic,
    /// Short-wavelength cones.
    SConeOpic,
    /// Medium-wavelength cones.
    MConeOpic,
    /// Long-wavelength cones.
    LConeOpic,
    /// Rods.
    Rhodopic,
    /// Ganglion cells that hold melanopsin.
    Melanopic,
}

/// The alpha-opic action spectra, in the order of the standard's title table.
pub const ALPHA_OPIC: [Action; 5] =
    [Action::SConeOpic, Action::MConeOpic, Action::LConeOpic, Action::Rhodopic, Action::Melanopic];

/// Maximum luminous efficacy for scotopic vision, lm/W (CIE 018:2019).
pub const KM_SCOTOPIC: f64 = 1700.06;

impl Action {
    /// The name, as in column headings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Scotopic => "scotopic",
            Self::SConeOpic => "s_cone_opic",
            Self::MConeOpic => "m_cone_opic",
            Self::LConeOpic => "l_cone_opic",
            Self::Rhodopic => "rhodopic",
            Self::Melanopic => "melanopic",
        }
    }

    /// Value at a wavelength in nm, linear between whole nanometres; zero outside 380 to 780 nm.
    #[must_use]
    pub fn at(self, nm: f64) -> f64 {
        if !(RANGE_NM.0..=RANGE_NM.1).contains(&nm) {
            return 0.0;
        }
        let place = nm - RANGE_NM.0;
        let left = (place as usize).min(ACTION.len() - 2);
        let (t, column) = (place - left as f64, self as usize);
        ACTION[left][column] * (1.0 - t) + ACTION[left + 1][column] * t
    }

    /// `∫ S s dλ` over `lo_nm..=hi_nm`: of an irradiance in W/(m² nm), the alpha-opic irradiance in W/m².
    #[must_use]
    pub fn integral(self, s: &Spectrum, lo_nm: f64, hi_nm: f64) -> f64 {
        let (lo, hi) = (lo_nm.max(RANGE_NM.0), hi_nm.min(RANGE_NM.1));
        cie::nodes(lo, hi, &[s.knots_nm()]).map(|(nm, w)| w * s.at(nm) * self.at(nm)).sum()
    }

    /// Response to daylight D65, W/lm: the alpha-opic efficacy of luminous radiation (CIE S 026:2018, table 3); nothing
    /// for scotopic vision, which has lumens of its own.
    #[must_use]
    pub fn d65_w_lm(self) -> Option<f64> {
        match self {
            Self::Scotopic => None,
            Self::SConeOpic => Some(0.8173e-3),
            Self::MConeOpic => Some(1.4558e-3),
            Self::LConeOpic => Some(1.6289e-3),
            Self::Rhodopic => Some(1.4497e-3),
            Self::Melanopic => Some(1.3262e-3),
        }
    }
}

/// Ratio of scotopic to photopic lumens of a light.
#[must_use]
pub fn scotopic_over_photopic(s: &Spectrum) -> f64 {
    KM_SCOTOPIC * Action::Scotopic.integral(s, RANGE_NM.0, RANGE_NM.1) / s.luminous()
}

/// Alpha-opic irradiance per illuminance over that of D65 (daylight efficacy ratio); for [`Action::Melanopic`] the
/// melanopic equivalent daylight illuminance per lux.
#[must_use]
pub fn daylight_efficacy_ratio(action: Action, s: &Spectrum) -> Option<f64> {
    Some(action.integral(s, RANGE_NM.0, RANGE_NM.1) / s.luminous() / action.d65_w_lm()?)
}

#[cfg(test)]
mod tests {
    use super::super::{KM, illuminant};
    use super::*;

    #[test]
    fn daylight_does_as_daylight() {
        let d65 = illuminant("D65").unwrap();
        for action in ALPHA_OPIC {
            let ratio = daylight_efficacy_ratio(action, &d65).unwrap();
            // The standard's efficacies have five digits and come from sums from 380 to 780 nm; V(λ) sums from 360.
            assert!((ratio - 1.0).abs() < 3e-4, "{action:?} {ratio}");
        }
    }

    #[test]
    fn equal_energy_has_the_published_melanopic_ratio() {
        // CIE S 026 toolbox (2020): melanopic DER of illuminant E 0.906, of illuminant A 0.496.
        for (name, published) in [("E", 0.906), ("A", 0.496)] {
            let ours = daylight_efficacy_ratio(Action::Melanopic, &illuminant(name).unwrap()).unwrap();
            assert!((ours - published).abs() < 1e-3, "{name} {ours}");
        }
    }

    #[test]
    fn scotopic_and_photopic_lumens_meet_at_555_nm() {
        // 540 THz by definition: 683 lm/W for both; in standard air 555 nm is 0.016 nm off.
        assert!((KM_SCOTOPIC * Action::Scotopic.at(555.0) / KM - 1.0).abs() < 2e-3);
        // CIE 015:2018 gives S/P = 1.41 for illuminant A.
        let ours = scotopic_over_photopic(&illuminant("A").unwrap());
        assert!((ours - 1.41).abs() < 6e-3, "{ours}");
    }
}
