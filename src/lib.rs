//! clerestory: physically calibrated daylighting and lighting simulation.
//!
//! Geometry, photometric sources and spectral reflectances go in together with a tolerance; illuminance
//! maps and luminance images with honest error bars come out. The modules stand in the order in which
//! the data flows:
//!
//! | stage | takes | gives |
//! |---|---|---|
//! | [`spectrum`] | curves, RGB, lamp names | spectra, bands, colour |
//! | [`scene`] | TOML, OBJ, CSV | a checked [`scene::Scene`] in metres, z up |
//! | [`mesh`] | faces | elements, made on demand, cut along contact lines |
//! | [`light`] | emitting faces, photometric files, sky | direct irradiance at a point |
//! | [`transport`] | scene, elements | who sees whom: rays, rows |
//! | [`solve`] | rows, reflectances, direct light | radiosity of every element in every band |
//! | [`measure`] | everything above, a tolerance | sensors and pixels, each with its error |
//! | [`annual`] | a scene, weather | every hour of the year with its error, climate-based metrics |
//! | [`chart`] | a scene | speed against accuracy of every method on it |
//! | [`report`] | a [`measure::Measurement`] | CSV, maps, EXR, HDR, PNG, `run.json` |
//! | [`compare`] | a result, measured values | bias, RMS, share within the uncertainties |
//! | [`validate`] | names of suites | cases: computed against known values, with a report |
//!
//! # Glossary
//!
//! | quantity | letter | unit | note |
//! |---|---|---|---|
//! | radiosity, exitance | `B`, `M` | W/m² per nm, lm/m² | leaves a surface; `M` is the emitted part |
//! | irradiance, illuminance | `E` | W/m² per nm, lx | arrives at a surface |
//! | radiance, luminance | `L` | W/(m² sr nm), cd/m² | `L = B/π` for a Lambertian surface |
//! | reflectance | `ρ` | 1 | |
//! | form factor | `F_ij` | 1 | share of what leaves *i* that arrives at *j*; `A_i F_ij = A_j F_ji` |
//!
//! # What the program leaves out
//!
//! Surfaces are Lambertian reflectors, plane mirrors or thin clear glass. There is no fluorescence, no
//! polarisation (except inside the Fresnel formulas of glass) and no participating medium.

pub mod annual;
pub mod chart;
pub mod cli;
pub mod compare;
pub mod error;
pub mod light;
pub mod measure;
pub mod mesh;
pub mod report;
pub mod scene;
pub mod solve;
pub mod spectrum;
pub mod transport;
pub mod validate;
mod vector;

pub use error::{Error, Result};
