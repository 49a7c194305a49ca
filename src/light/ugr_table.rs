//! The table of uncorrected glare ratings of a luminaire (CIE 117 and 190).
//!
//! Rooms of `x` times `y` in units of `H`, the height of the luminaires above the eye. The luminaires lie in an even array:
//! makers print the table for a spacing of `H/4`, CIE 190 has it for `H`. The eye is at the middle of a wall and looks level to the opposite one, along `y`. The background is the
//! mean indirect illuminance of the walls between the eye's plane and that of the luminaires, over π, by the radiosity of the
//! three surfaces of that box. The rating does not depend on `H`: all scales with it but the luminaire, whose light and area
//! both stay.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::guth::position_index;
use super::luminaires::Luminaire;
use super::photometry::{PhotometricType, Photometry};

/// Rooms, `x` and `y` in units of `H`.
const ROOMS: [(u32, u32); 19] = [
    (2, 2),
    (2, 3),
    (2, 4),
    (2, 6),
    (2, 8),
    (2, 12),
    (4, 2),
    (4, 3),
    (4, 4),
    (4, 6),
    (4, 8),
    (4, 12),
    (8, 4),
    (8, 6),
    (8, 8),
    (8, 12),
    (12, 4),
    (12, 6),
    (12, 8),
];

/// Reflectances of ceiling, walls and floor.
pub const UGR_REFLECTANCES: [[f64; 3]; 5] =
    [[0.7, 0.5, 0.2], [0.7, 0.3, 0.2], [0.5, 0.5, 0.2], [0.5, 0.3, 0.2], [0.3, 0.3, 0.2]];

/// Steps of the angles over which direct flux is summed, degrees.
const STEP_DEG: f64 = 2.5;

/// The ratings of one room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UgrRow {
    /// Extent across the line of sight, in units of `H`.
    pub x: u32,
    /// Extent along it.
    pub y: u32,
    /// Rating for each of [`UGR_REFLECTANCES`], for eyes that look along the plane C0.
    pub along_c0: [f64; 5],
    /// The same along the plane C90.
    pub along_c90: [f64; 5],
}

/// How densely the luminaires of a table lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UgrSpacing {
    /// A quarter of `H`: the table that makers of luminaires print.
    Quarter,
    /// `H`: the standard condition of CIE 190.
    Whole,
}

impl UgrSpacing {
    /// Luminaires in a length of `H`.
    fn in_h(self) -> u32 {
        match self {
            Self::Quarter => 4,
            Self::Whole => 1,
        }
    }

    /// Distance of neighbours in units of `H`.
    #[must_use]
    pub fn over_h(self) -> f64 {
        1.0 / f64::from(self.in_h())
    }
}

/// The table; nothing for luminaires without a luminous area, without light from below, or of type A or B.
#[must_use]
pub fn ugr_table(photometry: &Photometry, spacing: UgrSpacing) -> Option<Vec<UgrRow>> {
    if photometry.web.kind() != PhotometricType::C || photometry.web.zone_flux_lm(0.0, 90.0) <= 0.0 {
        return None;
    }
    let web = Arc::new(photometry.web.clone());
    // C0 along the line of sight, which is +y here; then C90.
    let turned = |quarter: f64| {
        let axes = DMat3::from_axis_angle(DVec3::Z, quarter * 0.5 * PI);
        Luminaire::hung(web.clone(), &photometry.opening, DVec3::ZERO, axes, (0, 0))
    };
    let views = [turned(1.0), turned(0.0)];
    ROOMS
        .iter()
        .map(|(x, y)| {
            let of = |l: &Luminaire| ratings(l, &Array { x: *x, y: *y, in_h: spacing.in_h() });
            Some(UgrRow { x: *x, y: *y, along_c0: of(&views[0])?, along_c90: of(&views[1])? })
        })
        .collect()
}

/// Ratings of one room and view, for all reflectances; `H` is one metre.
fn ratings(l: &Luminaire, array: &Array) -> Option<[f64; 5]> {
    let sum = glare_sum(l, array)?;
    let direct = DirectLight::new(l, array);
    let ratings = UGR_REFLECTANCES.map(|rho| 8.0 * (0.25 * PI * sum / direct.indirect_on_walls(rho)).log10());
    ratings.iter().all(|r| r.is_finite()).then_some(ratings)
}

/// A room and the array of luminaires over it.
struct Array {
    x: u32,
    y: u32,
    /// Luminaires in a length of `H`.
    in_h: u32,
}

impl Array {
    /// Where luminaires lie along an extent of the room.
    fn places(&self, extent: u32) -> impl Iterator<Item = f64> + Clone {
        let in_h = self.in_h;
        (0..extent * in_h).map(move |k| (f64::from(k) + 0.5) / f64::from(in_h))
    }

    /// Share of the places along an extent from which a step still ends inside.
    fn inside(&self, extent: u32, step: f64) -> f64 {
        let stay = self.places(extent).filter(|p| (0.0..f64::from(extent)).contains(&(p + step))).count();
        stay as f64 / f64::from(extent * self.in_h)
    }
}

/// `Σ L² ω / P²` over the array; nothing where the luminaire shows no area.
fn glare_sum(l: &Luminaire, array: &Array) -> Option<f64> {
    let mut sum = 0.0;
    for across in array.places(array.x).map(|p| p - 0.5 * f64::from(array.x)) {
        for ahead in array.places(array.y) {
            let towards = DVec3::new(across, ahead, 1.0);
            let (r, candela) = (towards.length(), l.intensity(-towards));
            let area = l.projected_area(-towards) / r;
            let Some(index) = position_index(DVec3::Y, towards).filter(|_| candela > 0.0) else { continue };
            if area <= 0.0 {
                return None;
            }
            // L = I/A and ω = A/r².
            sum += candela * candela / (area * r * r * index * index);
        }
    }
    (sum > 0.0).then_some(sum)
}

/// Direct illuminances of the three surfaces of a room.
struct DirectLight {
    /// Ceiling, walls, floor.
    lx: [f64; 3],
    areas: [f64; 3],
    /// Form factor from ceiling to floor.
    across: f64,
}

impl DirectLight {
    fn new(l: &Luminaire, array: &Array) -> Self {
        let mut flux = [0.0; 3];
        let (wide, long) = (f64::from(array.x), f64::from(array.y));
        let count = f64::from(array.x * array.y * array.in_h * array.in_h);
        let (rings, turns) = ((180.0 / STEP_DEG) as u32, (360.0 / STEP_DEG) as u32);
        for ring in 0..rings {
            let edge = |k: u32| (f64::from(k) * STEP_DEG).to_radians().cos();
            let solid_angle = (edge(ring) - edge(ring + 1)) * STEP_DEG.to_radians();
            let gamma = ((f64::from(ring) + 0.5) * STEP_DEG).to_radians();
            for turn in 0..turns {
                let (s, c) = ((f64::from(turn) + 0.5) * STEP_DEG).to_radians().sin_cos();
                let direction = DVec3::new(gamma.sin() * c, gamma.sin() * s, -gamma.cos());
                let lumens = count * l.intensity(direction) * solid_angle;
                if direction.z >= 0.0 {
                    flux[0] += lumens;
                    continue;
                }
                let step = direction / -direction.z;
                let floor = array.inside(array.x, step.x) * array.inside(array.y, step.y);
                flux[2] += lumens * floor;
                flux[1] += lumens * (1.0 - floor);
            }
        }
        let areas = [wide * long, 2.0 * (wide + long), wide * long];
        let lx = [0, 1, 2].map(|k| flux[k] / areas[k]);
        Self { lx, areas, across: opposite(wide, long) }
    }

    /// Indirect illuminance of the walls for reflectances of ceiling, walls and floor: `E = E₀ + F ρ E`.
    fn indirect_on_walls(&self, rho: [f64; 3]) -> f64 {
        let to_walls = 1.0 - self.across;
        let from_walls = to_walls * self.areas[0] / self.areas[1];
        let factors = [
            [0.0, to_walls, self.across],
            [from_walls, 1.0 - 2.0 * from_walls, from_walls],
            [self.across, to_walls, 0.0],
        ];
        let mut lx = self.lx;
        // Each reflection leaves at most 0.7 of the light: below 1e-12 of it in the end.
        for _ in 0..80 {
            lx = [0, 1, 2].map(|i| self.lx[i] + (0..3).map(|j| factors[i][j] * rho[j] * lx[j]).sum::<f64>());
        }
        lx[1] - self.lx[1]
    }
}

/// Form factor between opposite rectangles of sides `x` and `y` at distance one (Howell, configuration C-11).
fn opposite(x: f64, y: f64) -> f64 {
    let (a, b) = (1.0 + x * x, 1.0 + y * y);
    let sum =
        (a * b / (a + y * y)).sqrt().ln() + x * b.sqrt() * (x / b.sqrt()).atan() + y * a.sqrt() * (y / a.sqrt()).atan()
            - x * x.atan()
            - y * y.atan();
    2.0 * sum / (PI * x * y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_sides_of_a_cube_see_a_fifth_of_each_other() {
        // Howell C-11 for X = Y = 1: 0.199825.
        assert!((opposite(1.0, 1.0) - 0.199_825).abs() < 1e-6);
    }

    #[test]
    fn ten_times_the_flux_rates_eight_more() {
        let file = format!("{}/luminaires/panel.ies", env!("CARGO_MANIFEST_DIR"));
        let one = Photometry::read(file.as_ref()).unwrap();
        let ten = Photometry { web: one.web.clone().scaled(10.0), ..one.clone() };
        // UGR = 8 lg(L² ω / L_b): tenfold light is one more in the logarithm.
        let (a, b) = (ugr_table(&one, UgrSpacing::Quarter).unwrap(), ugr_table(&ten, UgrSpacing::Quarter).unwrap());
        for (a, b) in a.iter().zip(&b) {
            a.along_c0.iter().zip(b.along_c0).for_each(|(a, b)| assert!((b - a - 8.0).abs() < 1e-9));
            // A square panel of axial light looks the same from both sides.
            a.along_c0.iter().zip(a.along_c90).for_each(|(p, q)| assert!((p - q).abs() < 1e-9));
        }
    }
}
