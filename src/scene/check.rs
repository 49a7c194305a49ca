//! What is wrong with a scene.
use super::Scene;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The results would be wrong.
    Error,
}

/// A finding.
#[derive(Clone, Debug)]
pub struct Diagnostic;

/// All findings.
#[must_use]
pub fn check(_: &Scene) -> Vec<Diagnostic> {
    Vec::new()
}
