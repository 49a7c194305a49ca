//! What a person asks for.

/// How a scene is to be solved.
#[derive(Clone, Debug, PartialEq)]
pub struct SolveOptions {
    /// Stated error asked for, as a fraction of `max(E, E_mean of the grid / 10)`.
    pub tolerance: f64,
    /// Which method.
    pub method: Method,
    /// Report every band, and hold the tolerance in every band.
    pub spectral: bool,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Paths per sensor for [`Method::PathTracing`]; chosen from the tolerance when absent.
    pub paths: Option<u64>,
}

impl Default for SolveOptions {
    fn default() -> Self {
        Self { tolerance: 0.05, method: Method::Auto, spectral: false, seed: 1, paths: None }
    }
}

/// The ways to solve a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Method {
    /// Sensor-driven, lazily meshed, ray-sampled radiosity with a final gather.
    #[default]
    Auto,
    /// The unbiased reference.
    PathTracing,
}

/// Told how the work goes on.
pub trait Progress: Sync {
    /// A stage of `total` steps begins.
    fn stage(&self, name: &str, total: u64);
    /// `n` steps are done.
    fn advance(&self, n: u64);
    /// Something worth knowing.
    fn note(&self, text: &str);
}

/// Tells nobody.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn stage(&self, _: &str, _: u64) {}
    fn advance(&self, _: u64) {}
    fn note(&self, _: &str) {}
}
