//! The whole table of glare ratings against a calculation built differently.
//!
//! The product sums direct light over directions and counts where they end; here the floor's light is integrated over the
//! floor's area, by Gauss's rule in cells of the array's own grid. The product takes the form factor of the opposite faces
//! from a closed form and iterates the exchange; here that factor is the mean of the one from a point to a rectangle, and
//! three equations are solved by elimination. Luminances and Guth's index come from the formulas of the intensities
//! and of angles, not from a file.

mod common;

use std::f64::consts::PI;

use clerestory::light::photometry::{Format, Opening, PhotometricType, Photometry, Web};
use clerestory::light::{UGR_REFLECTANCES, UgrRow, UgrSpacing, ugr_table};
use common::guth;

/// Intensity, cd, towards `(u, v, -1)` with `u` along C0 and `v` along C90.
type Intensity = fn(f64, f64) -> f64;

/// A luminous area of 1.2 m x 0.3 m with light from below by a formula, and from above as `up cos γ`, cd.
struct Lamp {
    name: &'static str,
    below: Intensity,
    up: f64,
}

const AREA_M2: f64 = 1.2 * 0.3;

fn r2(u: f64, v: f64) -> f64 {
    u * u + v * v + 1.0
}

const LAMPS: [Lamp; 4] = [
    Lamp { name: "Lambertian", below: |u, v| 1000.0 / r2(u, v).sqrt(), up: 0.0 },
    Lamp { name: "cos³", below: |u, v| 2000.0 / r2(u, v).powf(1.5), up: 0.0 },
    // cos γ (1 + 0.8 sin² γ cos 2C): wider along C0 than across.
    Lamp { name: "long", below: |u, v| 1000.0 / r2(u, v).sqrt() * (1.0 + 0.8 * (u * u - v * v) / r2(u, v)), up: 0.0 },
    // cos γ (0.3 + 2 sin² γ), and a third of a Lambertian lamp's light upwards.
    Lamp {
        name: "wing with light upwards",
        below: |u, v| 1000.0 / r2(u, v).sqrt() * (0.3 + 2.0 * (1.0 - 1.0 / r2(u, v))),
        up: 400.0,
    },
];

impl Lamp {
    /// The same as a file says it.
    fn photometry(&self) -> Photometry {
        let vertical: Vec<f64> = (0..=180).map(f64::from).collect();
        let horizontal: Vec<f64> = (0..=36).map(|k| 2.5 * f64::from(k)).collect();
        let candela = |h: f64, v: f64| {
            let ((s, c), gamma) = (h.to_radians().sin_cos(), v.to_radians());
            if v < 90.0 { (self.below)(gamma.tan() * c, gamma.tan() * s) } else { -self.up * gamma.cos() }
        };
        let all = horizontal.iter().flat_map(|h| vertical.iter().map(move |v| candela(*h, *v).max(0.0))).collect();
        Photometry {
            format: Format::Ies(2002),
            web: Web::new(PhotometricType::C, vertical, horizontal, all).expect("sound"),
            opening: Opening { along_c0_m: 1.2, along_c90_m: 0.3, height_m: 0.0, round: false },
            labels: Vec::new(),
            lamps: 1.0,
            rated_flux_lm: None,
            stated_flux_lm: None,
            power_w: 0.0,
            tilt: None,
            warnings: Vec::new(),
        }
    }
}

/// Gauss's rule of five points on 0 to 1.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_095),
    (0.230_765_344_947_158, 0.239_314_335_249_683),
    (0.5, 0.284_444_444_444_444),
    (0.769_234_655_052_842, 0.239_314_335_249_683),
    (0.953_089_922_969_332, 0.118_463_442_528_095),
];

/// `∫∫ f` over the rectangles from the origin to `(a, b)`, for `a` and `b` of the edges, which begin with zero.
fn from_origin(edges: &[f64], f: impl Fn(f64, f64) -> f64) -> Vec<Vec<f64>> {
    let n = edges.len();
    let mut sums = vec![vec![0.0; n]; n];
    for i in 1..n {
        for j in 1..n {
            let (wide, long) = (edges[i] - edges[i - 1], edges[j] - edges[j - 1]);
            let cell: f64 = GAUSS
                .iter()
                .flat_map(|p| GAUSS.iter().map(move |q| (p, q)))
                .map(|(p, q)| p.1 * q.1 * f(edges[i - 1] + wide * p.0, edges[j - 1] + long * q.0))
                .sum();
            sums[i][j] = cell * wide * long + sums[i - 1][j] + sums[i][j - 1] - sums[i - 1][j - 1];
        }
    }
    sums
}

/// Flux on the floor of a room from all luminaires, lm; `x` runs along C90 where the eye looks along C0, else along C0.
fn floor_lm(lamp: &Lamp, (x, y): (usize, usize), in_h: usize, along_c0: bool) -> f64 {
    // Distances to walls are odd multiples of half a step.
    let step = 0.5 / in_h as f64;
    let edges: Vec<f64> = (0..=2 * in_h * x.max(y)).map(|k| step * k as f64).collect();
    let light = |across: f64, ahead: f64| {
        let (u, v) = if along_c0 { (ahead, across) } else { (across, ahead) };
        (lamp.below)(u, v) / r2(u, v).powf(1.5)
    };
    let sums = from_origin(&edges, light);
    let odd = |extent: usize| (0..in_h * extent).map(|k| 2 * k + 1);
    // A luminaire that sees one wall at 2k + 1 steps sees a corner's rectangle there; its four rectangles are those of
    // four luminaires that lie in mirror to each other.
    odd(x).flat_map(|i| odd(y).map(move |j| (i, j))).map(|(i, j)| 4.0 * sums[i][j]).sum()
}

/// Form factor from ceiling to floor at distance one: the mean over the ceiling of that from a point.
fn across(x: f64, y: f64) -> f64 {
    let corner = |a: f64, b: f64| {
        let (p, q) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
        (a / p * (b / p).atan() + b / q * (a / q).atan()) / (2.0 * PI)
    };
    let cells = 48;
    let edges = |extent: f64| (0..=cells).map(|k| extent * f64::from(k) / f64::from(cells)).collect::<Vec<_>>();
    let (across, along) = (edges(x), edges(y));
    let mut sum = 0.0;
    for i in 1..across.len() {
        for j in 1..along.len() {
            for (p, wp) in GAUSS {
                for (q, wq) in GAUSS {
                    let a = across[i - 1] + (across[i] - across[i - 1]) * p;
                    let b = along[j - 1] + (along[j] - along[j - 1]) * q;
                    sum += wp * wq * 4.0 * corner(a, b);
                }
            }
        }
    }
    sum / f64::from(cells * cells)
}

/// Indirect illuminance of the walls by elimination: unknown are the illuminances of ceiling, walls and floor.
fn indirect_lx(direct: [f64; 3], f: f64, ratio: f64, rho: [f64; 3]) -> f64 {
    let (to_walls, from_walls) = (1.0 - f, (1.0 - f) * ratio);
    let [c, w, g] = rho;
    let mut m = [
        [1.0, -to_walls * w, -f * g, direct[0]],
        [-from_walls * c, 1.0 - (1.0 - 2.0 * from_walls) * w, -from_walls * g, direct[1]],
        [-f * c, -to_walls * w, 1.0, direct[2]],
    ];
    for k in 0..3 {
        for row in 0..3 {
            if row != k {
                let factor = m[row][k] / m[k][k];
                (0..4).for_each(|col| m[row][col] -= factor * m[k][col]);
            }
        }
    }
    m[1][3] / m[1][1] - direct[1]
}

/// `Σ L² ω / P²` over the array.
fn glare(lamp: &Lamp, (x, y): (usize, usize), in_h: usize, along_c0: bool) -> f64 {
    let at = |k: usize| (k as f64 + 0.5) / in_h as f64;
    let mut sum = 0.0;
    for i in 0..x * in_h {
        for j in 0..y * in_h {
            let (aside, ahead) = (at(i) - 0.5 * x as f64, at(j));
            let (u, v) = if along_c0 { (ahead, aside) } else { (aside, ahead) };
            let projected = AREA_M2 / r2(u, v).sqrt();
            let luminance = (lamp.below)(u, v) / projected;
            sum += luminance * luminance * projected / r2(u, v) / guth(aside, ahead, 1.0).powi(2);
        }
    }
    sum
}

/// Flux downwards, lm: `∫ I dω` in the tangents, as far as the last degree but one.
fn below_lm(lamp: &Lamp) -> f64 {
    // Steps that grow from the nadir outwards: sinh spreads them.
    let edges: Vec<f64> = (0..=120).map(|k| (f64::from(k) * 0.06).sinh()).collect();
    4.0 * from_origin(&edges, |u, v| (lamp.below)(u, v) / r2(u, v).powf(1.5))[120][120]
}

/// Ratings of a room for all reflectances.
fn expected(lamp: &Lamp, row: &UgrRow, in_h: usize, along_c0: bool) -> [f64; 5] {
    let room = (row.x as usize, row.y as usize);
    let (x, y) = (f64::from(row.x), f64::from(row.y));
    let (count, floor) = (x * y * (in_h * in_h) as f64, floor_lm(lamp, room, in_h, along_c0));
    let walls_m2 = 2.0 * (x + y);
    let direct = [count * PI * lamp.up / (x * y), (count * below_lm(lamp) - floor) / walls_m2, floor / (x * y)];
    let (f, sum) = (across(x, y), glare(lamp, room, in_h, along_c0));
    UGR_REFLECTANCES.map(|rho| 8.0 * (0.25 * PI * sum / indirect_lx(direct, f, x * y / walls_m2, rho)).log10())
}

#[test]
fn every_entry_of_the_table_is_that_of_another_calculation() {
    for (spacing, in_h) in [(UgrSpacing::Quarter, 4), (UgrSpacing::Whole, 1)] {
        for lamp in &LAMPS {
            let table = ugr_table(&lamp.photometry(), spacing).expect("it has an area");
            assert_eq!(table.len(), 19);
            let mut worst = 0.0f64;
            for row in &table {
                for (found, along_c0) in [(row.along_c0, true), (row.along_c90, false)] {
                    for (k, want) in expected(lamp, row, in_h, along_c0).into_iter().enumerate() {
                        let off = found[k] - want;
                        assert!(
                            off.abs() < 0.2,
                            "{}, {}H x {}H, reflectances {k}, along C0 {along_c0}: {} against {want}",
                            lamp.name,
                            row.x,
                            row.y,
                            found[k]
                        );
                        worst = worst.max(off.abs());
                    }
                }
            }
            println!("{}, spacing {} H: {worst:.3} at most", lamp.name, spacing.over_h());
        }
    }
}

#[test]
fn the_other_calculation_knows_closed_forms() {
    // A Lambertian lamp of I gives π I downwards; opposite sides of a cube see 0.199825 of each other (Howell C-11).
    assert!((below_lm(&LAMPS[0]) / (1000.0 * PI) - 1.0).abs() < 2e-3);
    assert!((across(1.0, 1.0) - 0.199_825).abs() < 1e-6);
}
