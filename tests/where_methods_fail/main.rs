//! Scenes at which radiosity and form-factor programs are known to fail, and what this one does instead.

#[path = "../common/mod.rs"]
mod common;
mod form_factors;
mod geometry;
mod solver;
mod sources;
mod tools;
