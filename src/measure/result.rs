//! What a run hands to the reports.

use glam::DVec3;

use super::alpha_opic::AlphaOpicScale;
use super::appraisal::Appraisal;
use crate::scene::{GridLayout, View};
use crate::spectrum::Bands;

/// Everything measured in one run.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// The bands of all spectral values below.
    pub bands: Bands,
    /// One entry per grid of the scene.
    pub grids: Vec<GridResult>,
    /// States of the lights: those that the scene names, then daylight and electric light apart where there are both.
    pub states: Vec<StateResult>,
    /// One entry per view of the scene.
    pub views: Vec<ViewResult>,
    /// Horizontal illuminance in the open, lx, where a sky is the only light: what daylight factors refer to.
    pub outdoor_lx: Option<f64>,
    /// Glare of luminaires, for the grids that ask for it.
    pub glare: Vec<Glare>,
    /// Requirements, watts, surfaces of the room.
    pub appraisal: Appraisal,
    /// How to read alpha-opic irradiances, where they were asked for.
    pub alpha_opic: Option<AlphaOpicScale>,
    /// Where the light went, per band.
    pub ledger: Ledger,
    /// What was chosen and why, for the user to read.
    pub record: Record,
}

/// Illuminance in a state of the lights.
#[derive(Clone, Debug)]
pub struct StateResult {
    /// Name of the state.
    pub name: String,
    /// Is it held to the tolerance, as the states that the scene names are?
    pub held: bool,
    /// One entry per grid of the scene.
    pub grids: Vec<GridResult>,
}

/// Discomfort glare of luminaires for an eye at a sensor that looks along its normal.
#[derive(Clone, Debug)]
pub struct Glare {
    /// Name of the grid.
    pub grid: String,
    /// Number of the sensor in it.
    pub point: usize,
    /// Name of the state of the lights; empty for the scene as it stands.
    pub state: String,
    /// Luminance of the background: illuminance at the eye without that of lamps, over π, cd/m².
    pub background_cd_m2: f64,
    /// Unified glare rating (CIE 117); `None` where no luminaire shines into the eye, or the background is black.
    pub ugr: Option<f64>,
    /// Half-width of its 95 % interval, by the error of the background.
    pub error: f64,
}

/// Illuminance at the points of a grid.
#[derive(Clone, Debug)]
pub struct GridResult {
    /// Name of the grid.
    pub name: String,
    /// How the sensors lie.
    pub layout: GridLayout,
    /// One entry per sensor, in the user's order.
    pub sensors: Vec<SensorResult>,
    /// Number of lit (status ok) sensors whose stated error is inside the tolerance; where bands were asked for, in the
    /// band in which the fewest are.
    pub holding: usize,
}

/// Is there anything to read at a sensor?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Yes.
    Ok,
    /// It lies on a surface, beneath something that stands there.
    Covered,
    /// It lies inside a solid.
    Inside,
}

/// What a sensor reads. All illuminances in lx; the five parts sum to the whole.
#[derive(Clone, Debug)]
pub struct SensorResult {
    /// Metres, z up.
    pub position: DVec3,
    /// Unit vector.
    pub normal: DVec3,
    /// Area it stands for, m².
    pub area_m2: Option<f64>,
    /// Whether the values below mean anything.
    pub status: Status,
    /// CIE 1931 X, Y, Z of the irradiance; Y is the illuminance in lx.
    pub xyz: [f64; 3],
    /// Half-width of the 95 % interval of the illuminance, lx.
    pub error_lx: f64,
    /// From emitters without diffuse reflection.
    pub direct_lx: f64,
    /// From the sun's disc without diffuse reflection.
    pub sun_lx: f64,
    /// From the sky without diffuse reflection.
    pub sky_lx: f64,
    /// Last left the ground or an outside surface.
    pub external_lx: f64,
    /// The rest.
    pub reflected_lx: f64,
    /// Spectral irradiance and its 95 % half-width per band, W/(m² nm); empty unless asked for.
    pub spectral: Vec<BandValue>,
}

/// A value with its error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BandValue {
    /// W/(m² nm).
    pub irradiance: f64,
    /// Half-width of the 95 % interval, W/(m² nm).
    pub error: f64,
}

/// A picture in radiance.
#[derive(Clone, Debug)]
pub struct ViewResult {
    /// The view it was made for.
    pub view: View,
    /// Row by row from the top left, band fastest; W/(m² sr nm).
    pub radiance: Vec<f32>,
    /// Row by row from the top left: CIE 1931 X, Y, Z with Y the luminance in cd/m².
    pub xyz: Vec<[f32; 3]>,
    /// Stated relative error of the luminance (95 %): median over the pixels on diffuse surfaces.
    pub error_median: f64,
    /// The same, 95th percentile.
    pub error_p95: f64,
    /// How progressive refinement came to the picture, where that was asked for; otherwise empty.
    pub stages: Vec<PictureStage>,
}

/// The picture as progressive refinement shows it after some shots, with the ambient term.
#[derive(Clone, Debug)]
pub struct PictureStage {
    /// What has been shot.
    pub name: String,
    /// Number of shots.
    pub shots: usize,
    /// Unshot flux, as a share of what is emitted; the largest over the bands.
    pub unshot: f64,
    /// As [`ViewResult::xyz`].
    pub xyz: Vec<[f32; 3]>,
}

/// Where the light went; each line is summed on its own, never by subtraction. W/nm per band.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    /// Flux that emitters give off.
    pub emitted: Vec<f64>,
    /// Flux that surfaces absorb.
    pub absorbed: Vec<f64>,
    /// Flux that leaves the scene.
    pub escaped: Vec<f64>,
    /// Most that could sit on surfaces that were not modelled.
    pub unexpanded: Vec<f64>,
    /// Stated sampling error of the balance (99 %).
    pub sampling_error: Vec<f64>,
}

/// What was chosen and why; goes to `run.json` and to the terminal.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct Record {
    /// Name of the method.
    pub method: String,
    /// The seed of all random numbers.
    pub seed: u64,
    /// The tolerance asked for, as a fraction.
    pub tolerance: f64,
    /// Settings chosen, each with its reason.
    pub settings: Vec<Setting>,
    /// Physics left out, and the most that it could have mattered.
    pub left_out: Vec<LeftOut>,
    /// Counts of the work done.
    pub counts: Vec<(String, u64)>,
    /// Seconds of wall time of each stage.
    pub timings_s: Vec<(String, f64)>,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// Bytes of memory planned for the peak; none for the classic methods and for a year.
    pub planned_bytes: Option<u64>,
    /// Bytes allowed.
    pub max_memory: Option<u64>,
}

/// A setting the tool chose.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct Setting {
    /// What was set.
    pub name: String,
    /// To what.
    pub value: String,
    /// Why.
    pub why: String,
}

/// Physics left out.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct LeftOut {
    /// What.
    pub what: String,
    /// The most that it could have mattered, in words and numbers.
    pub bound: String,
}

impl SensorResult {
    /// A sensor without a reading yet.
    #[must_use]
    pub fn new(sensor: &crate::scene::Sensor, status: Status) -> Self {
        Self {
            position: sensor.position,
            normal: sensor.normal,
            area_m2: sensor.area_m2,
            status,
            xyz: [0.0; 3],
            error_lx: 0.0,
            direct_lx: 0.0,
            sun_lx: 0.0,
            sky_lx: 0.0,
            external_lx: 0.0,
            reflected_lx: 0.0,
            spectral: Vec::new(),
        }
    }
}
