//! Scenes with known answers, built in memory, and comparisons that say how far they are off.

#![allow(dead_code, unreachable_pub, reason = "every test file takes what it needs")]

pub mod bsdf;
pub mod rooms;
pub mod year;

use clerestory::measure::{GridResult, Measurement, Method, SensorResult, Silent, SolveOptions, Status};
pub use clerestory::scene::Build;
use clerestory::scene::{Emission, Material, MaterialKind, Panes, Scene};
use clerestory::spectrum::{SpectralValue, Spectrum};
use clerestory::{Error, measure};
use glam::DVec3;

/// A point, metres.
pub fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Guth's index of a source that lies aside, ahead and above of an eye.
pub fn guth(aside: f64, ahead: f64, above: f64) -> f64 {
    let sigma = (aside.hypot(above) / ahead).atan().to_degrees();
    let tau = (aside.abs() / above).atan().to_degrees();
    let a = 35.2 - 0.31889 * tau - 1.22 * (-2.0 * tau / 9.0).exp();
    let b = 21.0 + 0.26667 * tau - 0.002963 * tau * tau;
    (a * 1e-3 * sigma + b * 1e-5 * sigma * sigma).exp()
}

/// A Lambertian material of one reflectance on both sides.
pub fn diffuse(name: &str, rho: f64) -> Material {
    painted(name, SpectralValue::Grey(rho))
}

/// A Lambertian material of any reflectance.
pub fn painted(name: &str, rho: SpectralValue) -> Material {
    Material {
        name: name.into(),
        kind: MaterialKind::Diffuse { front: rho.clone(), back: rho },
        emission: None,
        outside: false,
    }
}

/// Reflectances in the three bands of [`BandMode::Rgb`].
pub fn rgb(rho: [f64; 3]) -> SpectralValue {
    SpectralValue::Rgb(rho)
}

/// A plane mirror.
pub fn mirror(rho: f64) -> Material {
    let kind = MaterialKind::Mirror { reflectance: SpectralValue::Grey(rho) };
    Material { name: "mirror".into(), kind, emission: None, outside: false }
}

/// A pane of grey glass, index 1.52.
pub fn glass(transmittance: f64) -> Material {
    glazed(1, SpectralValue::Grey(transmittance))
}

/// Equal panes of glass, index 1.52, by the transmittance of all.
pub fn glazed(count: usize, transmittance: SpectralValue) -> Material {
    let kind = MaterialKind::Glass {
        panes: Panes::Alike { count, transmittance },
        refractive_index: 1.52,
        maintenance_factor: 1.0,
    };
    Material { name: "glass".into(), kind, emission: None, outside: false }
}

/// Light of equal energy with an exitance in lm/m².
pub fn white(exitance: f64) -> Emission {
    let per_unit = std::f64::consts::PI * Spectrum::constant(1.0).luminous();
    Emission { radiance: Spectrum::constant(exitance / per_unit), two_sided: false, group: None }
}

/// The material, emitting an exitance in lm/m² from its front.
pub fn lit(mut material: Material, exitance: f64) -> Material {
    material.emission = Some(white(exitance));
    material
}

/// Two unit cubes of one reflectance side by side, joined by a square hole; the ceiling of the first gives 1 lm/m².
pub fn joined_by_a_hole(rho: f64, side: f64) -> Build {
    let mut b = Build::new();
    let (wall, ceiling) = (b.material(diffuse("wall", rho)), b.material(lit(diffuse("ceiling", rho), 1.0)));
    b.room(DVec3::ZERO, DVec3::ONE, [wall, wall, wall, wall, wall, ceiling]);
    b.room(DVec3::X, at(2.0, 1.0, 1.0), [wall; 6]);
    // The wall between them is a frame about the hole.
    b.0.faces.retain(|f| f.vertices.iter().any(|v| (v.x - 1.0).abs() > 1e-9));
    let (lo, hi) = (0.5 - 0.5 * side, 0.5 + 0.5 * side);
    for (y0, y1, z0, z1) in [(0.0, lo, 0.0, 1.0), (hi, 1.0, 0.0, 1.0), (lo, hi, 0.0, lo), (lo, hi, hi, 1.0)] {
        b.rectangle(at(1.0, y0, z0), DVec3::Y * (y1 - y0), DVec3::Z * (z1 - z0), wall);
    }
    b
}

/// A unit cube of one reflectance whose ceiling emits 1 lm/m².
pub fn cube(rho: f64) -> Build {
    let mut b = Build::new();
    let wall = b.material(diffuse("wall", rho));
    let ceiling = b.material(lit(diffuse("ceiling", rho), 1.0));
    b.room(DVec3::ZERO, DVec3::ONE, [wall, wall, wall, wall, wall, ceiling]);
    b
}

/// A room of 4 × 3 × 2.5 m with a lamp of 1 m² at the ceiling and a box on the floor, walls of three colours.
pub fn furnished() -> Build {
    furnished_below(2.45)
}

/// The same with its lamp at another height.
pub fn furnished_below(lamp_m: f64) -> Build {
    let mut b = Build::new();
    let grey = b.material(painted("grey", rgb([0.7, 0.7, 0.7])));
    let red = b.material(painted("red", rgb([0.65, 0.1, 0.08])));
    let blue = b.material(painted("blue", rgb([0.1, 0.15, 0.6])));
    let lamp = b.material(lit(diffuse("lamp", 0.0), 3000.0));
    b.room(DVec3::ZERO, at(4.0, 3.0, 2.5), [red, blue, grey, grey, grey, grey]);
    b.block(at(2.4, 1.1, 0.0), at(3.1, 1.9, 1.2), grey);
    b.lamp(at(1.5, 1.5, lamp_m), 1.0, lamp);
    b
}

/// Options for a tolerance.
pub fn within(tolerance: f64) -> SolveOptions {
    SolveOptions { tolerance, ..SolveOptions::default() }
}

/// Options for path tracing with a number of paths per sensor.
pub fn paths(count: u64) -> SolveOptions {
    SolveOptions { method: Method::PathTracing, paths: Some(count), ..SolveOptions::default() }
}

/// Solves a scene that has a solution.
pub fn solve(scene: &Scene, options: &SolveOptions) -> Measurement {
    measure::solve(scene, options, &Silent).expect("the scene has a solution")
}

/// The error of a scene that has none.
pub fn refusal(scene: &Scene) -> Error {
    measure::solve(scene, &within(0.05), &Silent).expect_err("the scene has no solution")
}

/// The sensors of the only grid.
pub fn only(m: &Measurement) -> &[SensorResult] {
    assert_eq!(m.grids.len(), 1, "one grid");
    &m.grids[0].sensors
}

/// Illuminances of the only grid.
pub fn lux(m: &Measurement) -> Vec<f64> {
    only(m).iter().map(|s| s.xyz[1]).collect()
}

/// Does every grid hold its tolerance at 95 % of its lit sensors?
pub fn assert_holding(m: &Measurement) {
    for g in &m.grids {
        let lit = g.sensors.iter().filter(|s| s.status == Status::Ok).count();
        assert!(g.holding * 100 >= lit * 95, "{}: {} of {lit} hold", g.name, g.holding);
    }
}

/// `|a − b| ≤ limit`; NaN is never near anything.
#[track_caller]
pub fn assert_near(a: f64, b: f64, limit: f64, what: &str) {
    assert!((a - b).abs() <= limit, "{what}: {a} against {b}, further than {limit:e}");
}

/// `|a − b| ≤ limit · |b|`; NaN is never near anything.
#[track_caller]
pub fn assert_ratio(a: f64, b: f64, limit: f64, what: &str) {
    assert_near(a, b, limit * b.abs(), what);
}

/// How many intervals of a level of 95 % may miss before it is no accident: the least `k` for which more than `k`
/// misses of `n` have a chance below 1 in 1,000 (binomial, misses independent with a chance of 5 %).
pub fn misses_allowed(n: usize) -> usize {
    let mut term = 0.95f64.powi(i32::try_from(n).expect("few"));
    let mut below = term;
    let mut k = 0;
    while below < 0.999 && k < n {
        term *= (n - k) as f64 / (k + 1) as f64 * (0.05 / 0.95);
        below += term;
        k += 1;
    }
    k
}

/// Intervals against true values.
#[derive(Clone, Debug, Default)]
pub struct Cover {
    /// Value, stated half-width, truth, what it is.
    pub list: Vec<(f64, f64, f64, String)>,
}

impl Cover {
    /// Enters one. `slack` is what is not known of the truth.
    pub fn enter(&mut self, value: f64, error: f64, slack: f64, truth: f64, what: impl Into<String>) {
        assert!(value.is_finite() && error.is_finite() && truth.is_finite(), "{value} ± {error} against {truth}");
        self.list.push((value, error + slack, truth, what.into()));
    }

    /// Enters the only grid of a measurement against one truth for each sensor.
    pub fn enter_all(&mut self, m: &Measurement, truth: &[f64], what: &str) {
        let sensors = only(m);
        assert_eq!(sensors.len(), truth.len());
        for (i, (s, t)) in sensors.iter().zip(truth).enumerate() {
            self.enter(s.xyz[1], s.error_lx, 0.0, *t, format!("{what} {i}"));
        }
    }

    /// Enters two independent measurements of one thing: their errors add in quadrature.
    pub fn enter_pair(&mut self, a: &GridResult, b: &GridResult, what: &str) {
        assert_eq!(a.sensors.len(), b.sensors.len());
        for (i, (a, b)) in a.sensors.iter().zip(&b.sensors).enumerate() {
            self.enter(a.xyz[1], a.error_lx.hypot(b.error_lx), 0.0, b.xyz[1], format!("{what} {i}"));
        }
    }

    /// Those that miss, in words.
    pub fn misses(&self) -> Vec<String> {
        let missed = |r: &&(f64, f64, f64, String)| (r.0 - r.2).abs() > r.1;
        self.list.iter().filter(missed).map(|(v, e, t, w)| format!("{w}: {v} ± {e}, truth {t}")).collect()
    }

    /// Share of intervals that hold the truth.
    pub fn share(&self) -> f64 {
        1.0 - self.misses().len() as f64 / self.list.len() as f64
    }

    /// Median of stated over true error.
    pub fn median_ratio(&self) -> f64 {
        let mut ratios: Vec<f64> = self.list.iter().map(|(v, e, t, _)| e / (v - t).abs().max(1e-300)).collect();
        ratios.sort_by(f64::total_cmp);
        ratios[ratios.len() / 2]
    }

    /// No more misses than a level of 95 % explains.
    #[track_caller]
    pub fn assert(&self) {
        assert!(!self.list.is_empty());
        let misses = self.misses();
        assert!(
            misses.len() <= misses_allowed(self.list.len()),
            "{} of {}: {misses:#?}",
            misses.len(),
            self.list.len()
        );
    }

    /// At least 95 % hold, as the claim says.
    #[track_caller]
    pub fn assert_95(&self) {
        let misses = self.misses();
        assert!(misses.len() * 20 <= self.list.len(), "{} of {}: {misses:#?}", misses.len(), self.list.len());
    }
}

/// The energy balance closes, in every band, within 0.1 % or its stated sampling error.
#[track_caller]
pub fn assert_balanced(m: &Measurement) {
    let l = &m.ledger;
    assert!(!l.emitted.is_empty(), "there is a balance");
    for band in 0..l.emitted.len() {
        let rest = l.emitted[band] - l.absorbed[band] - l.escaped[band] - l.unexpanded[band];
        let allowed = (1e-3 * l.emitted[band]).max(l.sampling_error[band]);
        assert!(rest.abs() <= allowed, "band {band}: open by {rest:e} of {:e}, allowed {allowed:e}", l.emitted[band]);
    }
}

/// Is a warning there that holds all these words?
pub fn warned(m: &Measurement, words: &[&str]) -> bool {
    m.record.warnings.iter().any(|w| words.iter().all(|x| w.contains(x)))
}
