//! The all-weather sky of Perez, Seals and Michalsky 1993, and the luminous efficacies of Perez et al. 1990.
//!
//! Two numbers of a moment choose the sky: its clearness `ε` (direct against diffuse irradiance) and its brightness `Δ`
//! (diffuse irradiance against what arrives above the air).

use std::f64::consts::PI;

use super::Coefficients;

/// What is known of a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerezInput {
    /// Direct irradiance on a plane that faces the sun, W/m².
    pub direct_normal_w_m2: f64,
    /// Diffuse irradiance of a horizontal plane, W/m².
    pub diffuse_horizontal_w_m2: f64,
    /// The sun's angle from the zenith, degrees.
    pub sun_zenith_deg: f64,
    /// Day of the year, 1 to 366.
    pub day_of_year: u32,
    /// Water above the ground, cm.
    pub precipitable_water_cm: f64,
}

/// Water in the air where nothing is known of it, cm (Perez et al. 1990).
pub const USUAL_WATER_CM: f64 = 2.0;

/// The sky of a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perez {
    /// Clearness `ε`.
    pub clearness: f64,
    /// Brightness `Δ`.
    pub brightness: f64,
    /// The five numbers of its luminance.
    pub coefficients: Coefficients,
    /// Efficacy of the diffuse light, lm/W.
    pub diffuse_lm_w: f64,
    /// Efficacy of the direct light, lm/W.
    pub direct_lm_w: f64,
}

/// Upper ends of the first seven of eight bins of clearness.
const CLEARNESS: [f64; 7] = [1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2];
/// In skies between overcast and clear the fit was made for brightnesses above this.
const LEAST_BRIGHTNESS: f64 = 0.2;
/// Brightest skies of the fit; beyond, some combinations have no light left at all.
const MOST_BRIGHTNESS: f64 = 0.6;
/// Solar constant, W/m², as the model was fitted with.
const SOLAR_CONSTANT: f64 = 1367.0;

impl PerezInput {
    /// Works out the sky. Irradiances must be finite and not negative, the diffuse one positive, the sun up.
    #[must_use]
    pub fn sky(&self) -> Perez {
        let zenith = self.sun_zenith_deg.to_radians();
        let (direct, diffuse) = (self.direct_normal_w_m2, self.diffuse_horizontal_w_m2);
        let cubed = 1.041 * zenith.powi(3);
        let clearness = ((diffuse + direct) / diffuse + cubed) / (1.0 + cubed);
        let mass = relative_air_mass(self.sun_zenith_deg);
        let brightness = mass * diffuse / extraterrestrial_w_m2(self.day_of_year);
        let bin = CLEARNESS.iter().filter(|end| clearness >= **end).count();
        let least = if (1..=4).contains(&bin) { LEAST_BRIGHTNESS } else { 0.0 };
        let held = brightness.clamp(least, MOST_BRIGHTNESS);
        let (diffuse_lm_w, direct_lm_w) = efficacy(bin, brightness, zenith, self.precipitable_water_cm);
        Perez { clearness, brightness: held, coefficients: coefficients(bin, held, zenith), diffuse_lm_w, direct_lm_w }
    }
}

/// Irradiances from illuminances: efficacies depend on the irradiances, so they are found by iteration.
///
/// Returns the direct normal and the diffuse horizontal irradiance, W/m². Bins of clearness make the efficacies jump:
/// where no pair fits exactly, the last one tried is given; it decides the shape of the sky alone, not its amount.
#[must_use]
pub fn irradiance_of(direct_normal_lx: f64, diffuse_horizontal_lx: f64, moment: PerezInput) -> PerezInput {
    let mut guess = moment;
    let (mut direct_lm_w, mut diffuse_lm_w) = (95.0, 120.0);
    for _ in 0..60 {
        guess.direct_normal_w_m2 = direct_normal_lx / direct_lm_w;
        guess.diffuse_horizontal_w_m2 = diffuse_horizontal_lx / diffuse_lm_w;
        let sky = guess.sky();
        let (old_direct, old_diffuse) = (direct_lm_w, diffuse_lm_w);
        // Half steps, within what daylight can have: a low sun sends the fit below zero.
        direct_lm_w = 0.5 * (direct_lm_w + sky.direct_lm_w.clamp(20.0, 150.0));
        diffuse_lm_w = 0.5 * (diffuse_lm_w + sky.diffuse_lm_w.clamp(60.0, 200.0));
        if (direct_lm_w - old_direct).abs() + (diffuse_lm_w - old_diffuse).abs() < 1e-9 {
            break;
        }
    }
    guess
}

/// Relative optical air mass of an angle from the zenith in degrees (Kasten 1965).
#[must_use]
pub fn relative_air_mass(zenith_deg: f64) -> f64 {
    1.0 / (zenith_deg.to_radians().cos() + 0.15 * (93.885 - zenith_deg).powf(-1.253))
}

/// Irradiance above the air on a plane that faces the sun, W/m² (Spencer 1971).
fn extraterrestrial_w_m2(day_of_year: u32) -> f64 {
    let t = 2.0 * PI * (f64::from(day_of_year) - 1.0) / 365.0;
    SOLAR_CONSTANT
        * (1.00011 + 0.034221 * t.cos() + 0.00128 * t.sin() + 0.000719 * (2.0 * t).cos() + 0.000077 * (2.0 * t).sin())
}

/// `x = x1 + x2 Z + Δ (x3 + x4 Z)`, but for `c` and `d` of overcast skies.
fn coefficients(bin: usize, brightness: f64, zenith: f64) -> Coefficients {
    let linear = |x: &[f64; 4]| x[0] + x[1] * zenith + brightness * (x[2] + x[3] * zenith);
    let [a, b, c, d, e] = &LUMINANCE[bin];
    let (bright, decay) = if bin == 0 {
        (
            (brightness * (c[0] + c[1] * zenith)).powf(c[2]).exp() - c[3],
            -(brightness * (d[0] + d[1] * zenith)).exp() + d[2] + d[3] * brightness,
        )
    } else {
        (linear(c), linear(d))
    };
    Coefficients { a: linear(a), b: linear(b), c: bright, d: decay, e: linear(e) }
}

/// Diffuse and direct efficacy, lm/W (Perez et al. 1990, equations 6 to 8).
fn efficacy(bin: usize, brightness: f64, zenith: f64, water_cm: f64) -> (f64, f64) {
    let [a, b, c, d] = DIFFUSE[bin];
    let diffuse = a + b * water_cm + c * zenith.cos() + d * brightness.ln();
    let [a, b, c, d] = DIRECT[bin];
    let direct = a + b * water_cm + c * (5.73 * zenith - 5.0).exp() + d * brightness;
    (diffuse.max(0.0), direct.max(0.0))
}

/// Efficacy of diffuse light: `a + b w + c cos Z + d ln Δ` (Perez et al. 1990, table 4).
const DIFFUSE: [[f64; 4]; 8] = [
    [97.24, -0.46, 12.0, -8.91],
    [107.22, 1.15, 0.59, -3.95],
    [104.97, 2.96, -5.53, -8.77],
    [102.39, 5.59, -13.95, -13.9],
    [100.71, 5.94, -22.75, -23.74],
    [106.42, 3.83, -36.15, -28.83],
    [141.88, 1.9, -53.24, -14.03],
    [152.23, 0.35, -45.27, -7.98],
];
/// Efficacy of direct light: `a + b w + c exp(5.73 Z − 5) + d Δ` (the same).
const DIRECT: [[f64; 4]; 8] = [
    [57.2, -4.55, -2.98, 117.12],
    [98.99, -3.46, -1.21, 12.38],
    [109.83, -4.9, -1.71, -8.81],
    [110.34, -5.84, -1.99, -4.56],
    [106.36, -3.97, -1.75, -6.16],
    [107.19, -1.25, -1.51, -26.73],
    [105.75, 0.77, -1.26, -34.44],
    [101.18, 1.58, -1.1, -8.29],
];
/// The numbers `x1 .. x4` of a, b, c, d and e in each bin of clearness (Perez et al. 1993, table 1).
const LUMINANCE: [[[f64; 4]; 5]; 8] = [
    [
        [1.3525, -0.2576, -0.269, -1.4366],
        [-0.767, 0.0007, 1.2734, -0.1233],
        [2.8, 0.6004, 1.2375, 1.0],
        [1.8734, 0.6297, 0.9738, 0.2809],
        [0.0356, -0.1246, -0.5718, 0.9938],
    ],
    [
        [-1.2219, -0.773, 1.4148, 1.1016],
        [-0.2054, 0.0367, -3.9128, 0.9156],
        [6.975, 0.1774, 6.4477, -0.1239],
        [-1.5798, -0.5081, -1.7812, 0.108],
        [0.2624, 0.0672, -0.219, -0.4285],
    ],
    [
        [-1.1, -0.2515, 0.8952, 0.0156],
        [0.2782, -0.1812, -4.5, 1.1766],
        [24.7219, -13.0812, -37.7, 34.8438],
        [-5.0, 1.5218, 3.9229, -2.6204],
        [-0.0156, 0.1597, 0.4199, -0.5562],
    ],
    [
        [-0.5484, -0.6654, -0.2672, 0.7117],
        [0.7234, -0.6219, -5.6812, 2.6297],
        [33.3389, -18.3, -62.25, 52.0781],
        [-3.5, 0.0016, 1.1477, 0.1062],
        [0.4659, -0.3296, -0.0876, -0.0329],
    ],
    [
        [-0.6, -0.3566, -2.5, 2.325],
        [0.2937, 0.0496, -5.6812, 1.8415],
        [21.0, -4.7656, -21.5906, 7.2492],
        [-3.5, -0.1554, 1.4062, 0.3988],
        [0.0032, 0.0766, -0.0656, -0.1294],
    ],
    [
        [-1.0156, -0.367, 1.0078, 1.4051],
        [0.2875, -0.5328, -3.85, 3.375],
        [14.0, -0.9999, -7.1406, 7.5469],
        [-3.4, -0.1078, -1.075, 1.5702],
        [-0.0672, 0.4016, 0.3017, -0.4844],
    ],
    [
        [-1.0, 0.0211, 0.5025, -0.5119],
        [-0.3, 0.1922, 0.7023, -1.6317],
        [19.0, -5.0, 1.2438, -1.9094],
        [-4.0, 0.025, 0.3844, 0.2656],
        [1.0468, -0.3788, -2.4517, 1.4656],
    ],
    [
        [-1.05, 0.0289, 0.426, 0.359],
        [-0.325, 0.1156, 0.7781, 0.0025],
        [31.0625, -14.5, -46.1148, 55.375],
        [-7.2312, 0.405, 13.35, 0.6234],
        [1.5, -0.6426, 1.8564, 0.5636],
    ],
];

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::{Sky, SkyModel};
    use super::*;

    fn moment(direct: f64, diffuse: f64, zenith: f64) -> PerezInput {
        PerezInput {
            direct_normal_w_m2: direct,
            diffuse_horizontal_w_m2: diffuse,
            sun_zenith_deg: zenith,
            day_of_year: 172,
            precipitable_water_cm: USUAL_WATER_CM,
        }
    }

    #[test]
    fn no_direct_light_is_overcast() {
        for zenith in [0.0, 40.0, 85.0] {
            assert!((moment(0.0, 150.0, zenith).sky().clearness - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn no_sky_is_ever_negative_and_each_has_its_integral() {
        // Some combinations of the fit are negative near the horizon or in the sun's back.
        let mut clamped = 0;
        for zenith in [2.0f64, 30.0, 60.0, 75.0, 85.0, 89.0] {
            for direct in [0.0, 50.0, 200.0, 500.0, 900.0] {
                for diffuse in [10.0, 50.0, 120.0, 300.0] {
                    let perez = moment(direct, diffuse, zenith).sky();
                    let z = zenith.to_radians();
                    let sky = Sky::new(SkyModel::Perez(perez.coefficients), DVec3::new(0.0, -z.sin(), z.cos()));
                    // Midpoints in azimuth and in the root of the height: an integral apart from the one that scales the sky.
                    let (n, m) = (360, 360);
                    let mut sum = 0.0;
                    for i in 0..n {
                        let root = (f64::from(i) + 0.5) / f64::from(n);
                        let sine = root * root;
                        for j in 0..m {
                            let azimuth = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(m);
                            let r = (1.0 - sine * sine).sqrt();
                            let l = sky.luminance(DVec3::new(r * azimuth.sin(), r * azimuth.cos(), sine));
                            assert!(l >= 0.0 && l.is_finite(), "{zenith} {direct} {diffuse}: {l}");
                            clamped += usize::from(l == 0.0);
                            sum += 4.0 * PI * sine * root * l / f64::from(n * m);
                        }
                    }
                    // Midpoint rule across the cusp at the sun: cells of half a degree, slope 4 per radian and more.
                    assert!((sum - 1.0).abs() < 5e-3, "{zenith} {direct} {diffuse}: {sum}");
                }
            }
        }
        assert!(clamped > 0, "the grid holds skies that the fit makes negative");
    }

    #[test]
    fn illuminances_lead_back_to_the_irradiances() {
        for (direct, diffuse, zenith) in [(620.0, 55.0, 76.0), (0.0, 45.0, 68.0), (310.0, 210.0, 50.0)] {
            let truth = moment(direct, diffuse, zenith);
            let sky = truth.sky();
            let found = irradiance_of(direct * sky.direct_lm_w, diffuse * sky.diffuse_lm_w, truth);
            assert!((found.diffuse_horizontal_w_m2 / diffuse - 1.0).abs() < 1e-6, "{found:?}");
            assert!((found.direct_normal_w_m2 - direct).abs() < 1e-6 * direct.max(1.0), "{found:?}");
        }
    }
}
