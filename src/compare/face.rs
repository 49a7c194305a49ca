//! What a face sends out, by the light that arrives on it in every band and by its reflectance.

use std::f64::consts::PI;

use crate::spectrum::{KM, Spectrum, cie};

/// The mean irradiance of a band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandIrradiance {
    /// Ends of the band, nm.
    pub limits_nm: (f64, f64),
    /// W/(m² nm).
    pub irradiance: f64,
}

/// CIE 1931 X, Y, Z of the light that leaves a Lambertian face of a reflectance, Y in cd/m²: in each band the even
/// irradiance times the reflectance, over π. `illuminance_lx` is what arrives in all; the sum is scaled to it.
#[must_use]
pub fn face_xyz(bands: &[BandIrradiance], illuminance_lx: f64, reflectance: &Spectrum) -> [f64; 3] {
    let total = |curve: &Spectrum| {
        bands.iter().fold([0.0; 3], |sum, b| {
            let weights = cie::integral(curve, b.limits_nm.0, b.limits_nm.1);
            std::array::from_fn(|k| sum[k] + KM * b.irradiance * weights[k])
        })
    };
    let arriving = total(&Spectrum::constant(1.0))[1];
    if arriving <= 0.0 {
        return [0.0; 3];
    }
    total(reflectance).map(|v| v * illuminance_lx / (arriving * PI))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Beyond;

    #[test]
    fn a_grey_face_keeps_the_colour_and_a_filter_takes_its_band() {
        let bands: Vec<BandIrradiance> = (0..40)
            .map(|i| BandIrradiance {
                limits_nm: (380.0 + 10.0 * f64::from(i), 390.0 + 10.0 * f64::from(i)),
                irradiance: 0.01,
            })
            .collect();
        let grey = face_xyz(&bands, 100.0, &Spectrum::constant(0.5));
        assert!((grey[1] - 50.0 / PI).abs() < 1e-12, "L = ρ E / π: {grey:?}");
        // Equal energy is white: x = y = 1/3, but for the tails beyond 380 and 780 nm.
        assert!((grey[0] / grey.iter().sum::<f64>() - 1.0 / 3.0).abs() < 1e-4, "{grey:?}");
        // A paint that reflects nothing below 600 nm, all above: its luminance is the share of V there, 0.326 of equal energy.
        let red = Spectrum::new(vec![599.999, 600.0], vec![0.0, 1.0], Beyond::Hold).unwrap();
        let share = PI * face_xyz(&bands, 1.0, &red)[1];
        let exact = cie::integral(&Spectrum::constant(1.0), 600.0, 780.0)[1]
            / cie::integral(&Spectrum::constant(1.0), 380.0, 780.0)[1];
        assert!((share - exact).abs() < 1e-5, "{share} {exact}");
        assert_eq!(face_xyz(&[], 100.0, &red), [0.0; 3]);
    }
}
