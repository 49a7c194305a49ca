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
    /// Report what the light does to the receptors of CIE S 026; measures every band as `spectral` does.
    pub alpha_opic: bool,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Paths per sensor for [`Method::PathTracing`]; chosen from the tolerance when absent.
    pub paths: Option<u64>,
    /// Patches along the longest side of any surface, for the classic methods; chosen from the tolerance when absent.
    pub patches: Option<u32>,
    /// Shots for [`Method::Progressive`]; chosen from the tolerance when absent.
    pub shots: Option<u64>,
    /// Keep the pictures of [`Method::Progressive`] on its way.
    pub stages: bool,
    /// Bytes of memory that a run may take at its peak, by plan; as many as it wants when absent. For [`Method::Auto`] and
    /// [`Method::PathTracing`].
    pub max_memory: Option<u64>,
    /// How the classic methods read sensors that lie on a patch.
    pub display: Display,
}

impl Default for SolveOptions {
    fn default() -> Self {
        Self {
            tolerance: 0.05,
            method: Method::Auto,
            spectral: false,
            alpha_opic: false,
            seed: 1,
            paths: None,
            patches: None,
            shots: None,
            stages: false,
            max_memory: None,
            display: Display::Gather,
        }
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
    /// Analytic form factors, Gaussian elimination (Goral et al. 1984).
    FullMatrix,
    /// Analytic form factors, Gauss-Seidel gathering.
    Gathering,
    /// Analytic form factors, Southwell shooting.
    Shooting,
    /// Shooting with form factors on demand and the ambient term (Cohen et al. 1988).
    Progressive,
    /// Analytic form factors, conjugate gradients.
    ConjugateGradients,
    /// Hemicube form factors, gathering (Cohen and Greenberg 1985).
    Hemicube,
    /// Ray-traced discs, shooting (Wallace et al. 1989).
    Discs,
    /// Links between patches of all sizes, refined by what they carry (Hanrahan et al. 1991).
    Hierarchical,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Auto,
        Self::PathTracing,
        Self::FullMatrix,
        Self::Gathering,
        Self::Shooting,
        Self::Progressive,
        Self::ConjugateGradients,
        Self::Hemicube,
        Self::Discs,
        Self::Hierarchical,
    ];

    /// The name a user knows it by.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::PathTracing => "path-tracing",
            Self::FullMatrix => "full-matrix",
            Self::Gathering => "gathering",
            Self::Shooting => "shooting",
            Self::Progressive => "progressive",
            Self::ConjugateGradients => "conjugate-gradients",
            Self::Hemicube => "hemicube",
            Self::Discs => "discs",
            Self::Hierarchical => "hierarchical",
        }
    }
}

/// What a sensor on a patch shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Display {
    /// A gather from all patches at the sensor itself.
    #[default]
    Gather,
    /// Linear between the middles of patches.
    Bilinear,
    /// The patch's own value.
    Constant,
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
