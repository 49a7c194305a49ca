//! The settings at which every method runs: fixed in advance, one rule for all.

use crate::measure::{Display, Method, SolveOptions};

/// Paths of the run that tells how fast paths are traced here.
pub(super) const LEAST_PATHS: u64 = 1024;

/// One setting of one method.
#[derive(Clone, Debug)]
pub(super) struct Rung {
    pub(super) setting: String,
    pub(super) options: SolveOptions,
}

/// What runs, and how often.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// Method by method, cheap settings first.
    pub(super) ladders: Vec<(&'static str, Vec<Rung>)>,
    /// Runs of each setting; the seed goes up by one each.
    pub(super) repeats: u64,
    /// Wall time after which a setting is not repeated, and beyond which a ladder ends, s.
    pub(super) patience_s: f64,
    pub(super) longest_s: f64,
    /// Wall time that the reference may take, s.
    pub(super) reference_s: f64,
}

impl Plan {
    pub(super) fn new(full: bool) -> Self {
        let upto = |short: usize, list: &[u32]| list[..if full { list.len() } else { short }].to_vec();
        let patches = upto(4, &[2, 4, 6, 8, 12, 16]);
        let tolerances = upto(6, &[300, 200, 100, 50, 20, 10, 5]);
        let paths = upto(4, &[64, 256, 1024, 4096, 16_384, 65_536]);
        let shots = upto(4, &[24, 100, 400, 1600, 6400]);
        let classic = |method: Method, display: Display| {
            let rung = |n: &u32| Rung {
                setting: format!("{n} patches a side"),
                options: SolveOptions { method, display, patches: Some(*n), ..SolveOptions::default() },
            };
            patches.iter().map(rung).collect::<Vec<_>>()
        };
        let gathered = |method: Method| (method.name(), classic(method, Display::Gather));
        let auto = tolerances.iter().map(|t| Rung {
            setting: format!("tolerance {} %", f64::from(*t) / 10.0),
            options: SolveOptions { tolerance: f64::from(*t) / 1000.0, ..SolveOptions::default() },
        });
        let traced = paths.iter().map(|n| Rung {
            setting: format!("{n} paths a point"),
            options: SolveOptions {
                method: Method::PathTracing,
                paths: Some(u64::from(*n)),
                ..SolveOptions::default()
            },
        });
        let progressive = shots.iter().map(|n| Rung {
            setting: format!("{n} shots, 6 patches a side"),
            options: SolveOptions {
                method: Method::Progressive,
                shots: Some(u64::from(*n)),
                patches: Some(6),
                ..SolveOptions::default()
            },
        });
        Self {
            ladders: vec![
                (Method::Auto.name(), auto.collect()),
                (Method::PathTracing.name(), traced.collect()),
                gathered(Method::FullMatrix),
                gathered(Method::Gathering),
                gathered(Method::Shooting),
                (Method::Progressive.name(), progressive.collect()),
                gathered(Method::ConjugateGradients),
                gathered(Method::Hemicube),
                gathered(Method::Discs),
                gathered(Method::Hierarchical),
                ("full-matrix, flat patches", classic(Method::FullMatrix, Display::Constant)),
                ("full-matrix, bilinear", classic(Method::FullMatrix, Display::Bilinear)),
            ],
            repeats: if full { 5 } else { 3 },
            patience_s: 3.0,
            longest_s: 15.0,
            reference_s: if full { 600.0 } else { 50.0 },
        }
    }
}
