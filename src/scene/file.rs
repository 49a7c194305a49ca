//! The scene file as written: TOML keys into plain structures, nothing judged but form.
//!
//! Unknown keys and words are errors with the line and the nearest valid name. [`json_schema`] is made
//! from the same structures, for editors. What the values mean is decided next door (`material.rs`,
//! `grid.rs`, `view.rs`).

use std::collections::BTreeMap;
use std::path::Path;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Deserializer};

use super::dimming::StateDef;
use super::luminaire::LuminaireDef;
use super::requirement::{EmergencyDef, PowerDef, RequirementDef};
use super::sky::{SiteDef, SkyDef};
use super::suggest;
use super::usage::{AnnualDef, BlindDef};
use crate::{Error, Result};

/// A value and where it stands in the file, as a byte offset.
#[derive(Clone, Debug)]
pub(crate) struct At<T> {
    pub(crate) value: T,
    pub(crate) offset: usize,
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for At<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        let spanned = toml::Spanned::<T>::deserialize(deserializer)?;
        Ok(Self { offset: spanned.span().start, value: spanned.into_inner() })
    }
}

impl<T: JsonSchema> JsonSchema for At<T> {
    fn inline_schema() -> bool {
        T::inline_schema()
    }
    fn schema_name() -> std::borrow::Cow<'static, str> {
        T::schema_name()
    }
    fn schema_id() -> std::borrow::Cow<'static, str> {
        T::schema_id()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        T::json_schema(generator)
    }
}

/// A text with its file name: turns offsets into errors with a line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'a> {
    pub(crate) path: &'a Path,
    pub(crate) text: &'a str,
}

impl Source<'_> {
    /// Line of a byte offset, counted from one.
    pub(crate) fn line(&self, offset: usize) -> usize {
        let end = offset.min(self.text.len());
        1 + self.text.as_bytes()[..end].iter().filter(|b| **b == b'\n').count()
    }

    /// Names file and line, unless the error names another file already.
    pub(crate) fn place(&self, offset: usize, error: Error) -> Error {
        error.in_file(self.path).at_line(self.line(offset))
    }

    /// Malformed input at `offset`.
    pub(crate) fn malformed(&self, offset: usize, message: impl Into<String>) -> Error {
        self.place(offset, Error::malformed(message))
    }

    /// An impossible scene at `offset`.
    pub(crate) fn impossible(&self, offset: usize, message: impl Into<String>) -> Error {
        self.place(offset, Error::impossible(message))
    }
}

/// A lighting scene: geometry, materials, and what is asked of them.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "clerestory scene")]
pub(crate) struct SceneFile {
    /// Title, for reports.
    pub(crate) title: Option<String>,
    /// Geometry files and how to read them.
    pub(crate) geometry: At<GeometryDef>,
    /// How the spectrum is divided.
    pub(crate) bands: Option<BandsDef>,
    /// One table for each material name (`usemtl`) of the OBJ files.
    #[serde(default)]
    pub(crate) materials: BTreeMap<String, At<MaterialDef>>,
    /// Points at which illuminance is asked.
    #[serde(default)]
    pub(crate) grids: Vec<At<GridDef>>,
    /// Pictures asked for.
    #[serde(default)]
    pub(crate) views: Vec<At<ViewDef>>,
    /// The sky, the sun and the ground.
    pub(crate) sky: Option<At<SkyDef>>,
    /// Place and time.
    pub(crate) site: Option<At<SiteDef>>,
    /// Luminaires: photometric files and where they hang.
    #[serde(default)]
    pub(crate) luminaires: Vec<At<LuminaireDef>>,
    /// What the watts of the luminaires refer to.
    pub(crate) power: Option<At<PowerDef>>,
    /// States of the lights, reported beside the scene as it stands.
    #[serde(default)]
    pub(crate) states: Vec<At<StateDef>>,
    /// What a year of daylight is judged by.
    pub(crate) annual: Option<At<AnnualDef>>,
    /// Blinds before windows, for a year of daylight.
    #[serde(default)]
    pub(crate) blinds: Vec<At<BlindDef>>,
}

/// Geometry files and how to read them.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GeometryDef {
    /// OBJ files, relative to the scene file.
    pub(crate) files: Vec<At<String>>,
    /// Unit of the coordinates in the OBJ files.
    pub(crate) unit: Unit,
    /// The axis that points up.
    pub(crate) up: Up,
    /// True north in degrees, clockwise from +Y (z up).
    pub(crate) north_deg: Option<At<f64>>,
}

/// Unit of length.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Unit {
    /// Metre.
    M,
    /// Centimetre.
    Cm,
    /// Millimetre.
    Mm,
    /// International foot, 0.3048 m.
    Ft,
    /// International inch, 25.4 mm.
    In,
}

impl Unit {
    /// The unit in metres.
    pub(crate) fn metres(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 0.01,
            Self::Mm => 0.001,
            Self::Ft => 0.3048,
            Self::In => 0.0254,
        }
    }

    /// Converts with one rounding: millimetres are divided by 1000, not multiplied by an inexact 0.001.
    pub(crate) fn to_metres(self, p: glam::DVec3) -> glam::DVec3 {
        match self {
            Self::M => p,
            Self::Cm => p / 100.0,
            Self::Mm => p / 1000.0,
            Self::Ft | Self::In => p * self.metres(),
        }
    }
}

/// The axis that points up.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Up {
    /// z points up.
    Z,
    /// y points up.
    Y,
}

/// How the spectrum is divided.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BandsDef {
    /// "auto" lets the program choose.
    pub(crate) mode: Option<At<ModeDef>>,
}

/// A name, or a division by step or by edges.
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum ModeDef {
    /// A named division.
    Name(ModeName),
    /// Equal steps or explicit edges.
    Division(DivisionDef),
}

/// A named division of the spectrum.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ModeName {
    /// The program chooses.
    Auto,
    /// One band.
    Grey,
    /// Three bands: red, green, blue.
    Rgb,
}

/// Equal steps over a range, or explicit edges; nanometres.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DivisionDef {
    /// Width of a band, nm; wants `range_nm`.
    pub(crate) step_nm: Option<f64>,
    /// From and to, nm.
    pub(crate) range_nm: Option<[f64; 2]>,
    /// Increasing edges, nm.
    pub(crate) edges_nm: Option<Vec<f64>>,
}

/// What a surface does with light.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MaterialDef {
    /// "diffuse" unless given.
    pub(crate) kind: Option<At<Kind>>,
    /// Reflectance, 0 to 1.
    pub(crate) reflectance: Option<At<ValueDef>>,
    /// Reflectance of the back where it differs, 0 to 1.
    pub(crate) reflectance_back: Option<At<ValueDef>>,
    /// Transmittance, 0 to 1: of clear glass, measured at normal incidence on the whole unit; of a translucent material,
    /// diffuse.
    pub(crate) transmittance: Option<At<ValueDef>>,
    /// Panes of clear glass: their number (1 unless given) if they are equal, or a list from the front of the faces to
    /// their back, which then tells the transmittance of each.
    pub(crate) panes: Option<At<PanesDef>>,
    /// Index of refraction of clear glass; 1.52 unless given.
    #[serde(alias = "n")]
    pub(crate) refractive_index: Option<At<f64>>,
    /// Share of the light that dirt leaves of what glass, a translucent material or a BSDF lets by, 0 to 1; 1 unless given.
    pub(crate) maintenance_factor: Option<At<f64>>,
    /// XML file of a BSDF, as WINDOW writes it; the front of the faces is its front, which looks outdoors.
    pub(crate) file: Option<At<String>>,
    /// What is up in a BSDF, where its azimuth of 90 degrees points; [0, 0, 1] in z-up scenes unless given.
    pub(crate) up: Option<At<[f64; 3]>>,
    /// Light of the surface's own.
    pub(crate) emission: Option<At<EmissionDef>>,
    /// Stands outside: light that it reflects last counts as external.
    #[serde(default)]
    pub(crate) outside: bool,
}

/// A number of equal panes, or each pane.
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum PanesDef {
    /// How many equal uncoated panes, 1 to 8.
    Count(u32),
    /// Each, from the front of the faces to their back.
    List(Vec<At<PaneDef>>),
}

/// One pane of a glazing unit, as measured at normal incidence.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PaneDef {
    /// Transmittance, 0 to 1.
    pub(crate) transmittance: At<ValueDef>,
    /// Reflectance of coated glass towards the front of the faces, 0 to 1.
    pub(crate) reflectance_front: Option<At<ValueDef>>,
    /// Reflectance of coated glass towards their back, 0 to 1.
    pub(crate) reflectance_back: Option<At<ValueDef>>,
}

/// Kind of material.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Kind {
    /// Lambertian.
    Diffuse,
    /// A thin clear pane.
    Glass,
    /// A plane mirror.
    Mirror,
    /// Passes light on diffusely.
    Translucent,
    /// A window element with a measured or computed BSDF.
    Bsdf,
}

/// A number, linear Rec. 709 [r, g, b], or a spectrum file (`wavelength_nm,value`).
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum ValueDef {
    /// The same at all wavelengths.
    Number(f64),
    /// Linear Rec. 709.
    Rgb([f64; 3]),
    /// A CSV file with the header `wavelength_nm,value`.
    File(String),
}

/// Lambertian emission; exactly one of the four quantities.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct EmissionDef {
    /// Luminance, cd/m².
    pub(crate) luminance_cd_m2: Option<At<f64>>,
    /// Luminous exitance of each emitting side, lm/m².
    pub(crate) exitance_lm_m2: Option<At<f64>>,
    /// Luminous flux of all faces of this material together, lm.
    pub(crate) flux_lm: Option<At<f64>>,
    /// CSV file of absolute spectral radiance, W/(m² sr nm); zero beyond its ends.
    pub(crate) radiance: Option<At<String>>,
    /// Spectrum of the light: illuminant name, colour temperature in K, or a CSV file of relative values.
    /// Equal energy ("E") unless given.
    pub(crate) spectrum: Option<At<SpectrumDef>>,
    /// Emit from the back as well.
    #[serde(default)]
    pub(crate) two_sided: bool,
    /// Group of lamps that the states dim together.
    pub(crate) group: Option<String>,
}

/// An illuminant name, a colour temperature in K, or a CSV file of relative values.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum SpectrumDef {
    /// Colour temperature, K.
    Kelvin(f64),
    /// Illuminant name, or a file name ending in `.csv`.
    Name(String),
}

/// Points at which illuminance is asked: exactly one of `plane`, `on`, `points`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GridDef {
    /// Name, unique among grids and views; used for files too.
    pub(crate) name: At<String>,
    /// Cells of a parallelogram; points at the cell centres.
    pub(crate) plane: Option<At<PlaneDef>>,
    /// Name of a material or of an OBJ object or group: points over its faces.
    pub(crate) on: Option<At<String>>,
    /// With `on`: distance of the points from the faces along the normal, m.
    pub(crate) height_m: Option<At<f64>>,
    /// With `on`: distance between points, m.
    pub(crate) spacing_m: Option<At<f64>>,
    /// With `on`: strip left out along the outline, m.
    pub(crate) inset_m: Option<At<f64>>,
    /// File of points in Radiance's form: `x y z dx dy dz` on each line, metres.
    pub(crate) points: Option<At<String>>,
    /// Rate the glare of luminaires (UGR) for eyes at the points that look along the normals.
    #[serde(default)]
    pub(crate) ugr: bool,
    /// Cylindrical illuminance (EN 12464-1) at the points too, as the grid `<name>_cylindrical`; and the modelling ratio.
    #[serde(default)]
    pub(crate) cylindrical: bool,
    /// Level direction for which the semi-cylindrical illuminance (EN 13201-3) at the points is asked too, as the grid
    /// `<name>_semicylindrical`.
    pub(crate) semicylindrical: Option<At<[f64; 3]>>,
    /// Limits to keep, as EN 12464-1 sets them.
    pub(crate) requirement: Option<RequirementDef>,
    /// Limits of emergency lighting to keep (EN 1838), `{}` for the usual ones.
    pub(crate) emergency: Option<EmergencyDef>,
    /// Direction that the points face. u × v for `plane` and the face's normal for `on`, unless given.
    pub(crate) normal: Option<At<[f64; 3]>>,
}

/// Cells of a parallelogram.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlaneDef {
    /// A corner, m.
    pub(crate) origin_m: At<[f64; 3]>,
    /// Whole side along u, m.
    pub(crate) u_m: At<[f64; 3]>,
    /// Whole side along v, m.
    pub(crate) v_m: At<[f64; 3]>,
    /// Cells along u.
    pub(crate) nu: At<u32>,
    /// Cells along v.
    pub(crate) nv: At<u32>,
}

/// A picture: position, direction and projection.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ViewDef {
    /// Name, unique among grids and views; used for files too.
    pub(crate) name: At<String>,
    /// Eye, m.
    pub(crate) position_m: At<[f64; 3]>,
    /// View direction; any length.
    pub(crate) direction: At<[f64; 3]>,
    /// Up in the picture; the scene's up axis unless given.
    pub(crate) up: Option<At<[f64; 3]>>,
    /// "perspective" unless given.
    pub(crate) kind: Option<At<ViewKind>>,
    /// Width and height of the film, mm; wants `focal_mm`.
    pub(crate) film_mm: Option<At<[f64; 2]>>,
    /// Focal length, mm.
    pub(crate) focal_mm: Option<At<f64>>,
    /// Full angle in degrees: horizontal, or [horizontal, vertical].
    pub(crate) fov_deg: Option<At<FovDef>>,
    /// Width and height in pixels, 1 to 16384.
    pub(crate) pixels: At<[u32; 2]>,
}

/// Projection of a view.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ViewKind {
    /// A pinhole camera.
    Perspective,
    /// Equidistant (angular) fisheye.
    Fisheye,
    /// Equirectangular, all around.
    Panorama,
}

/// Horizontal angle, or [horizontal, vertical], degrees.
#[derive(Clone, Copy, Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum FovDef {
    /// Horizontal.
    Horizontal(f64),
    /// Horizontal and vertical.
    Both([f64; 2]),
}

/// Reads the text of a scene file.
///
/// # Errors
/// Malformed TOML, unknown or missing keys and wrong types, with file and line.
pub(crate) fn parse(source: Source<'_>) -> Result<SceneFile> {
    toml::from_str(source.text).map_err(|e| explain(source, &e))
}

/// The JSON Schema of the scene file, for editors.
#[must_use]
pub fn json_schema() -> serde_json::Value {
    schemars::schema_for!(SceneFile).to_value()
}

/// Turns a TOML error into ours.
fn explain(source: Source<'_>, error: &toml::de::Error) -> Error {
    let message = error.message();
    let (text, mend) = reword(message);
    let mut ours = Error::malformed(text).in_file(source.path);
    if let Some(span) = error.span() {
        ours = ours.at_line(source.line(span.start));
    }
    match mend {
        Some(mend) => ours.mend(mend),
        None => ours,
    }
}

/// Our words for what serde says, and the mend.
fn reword(message: &str) -> (String, Option<String>) {
    let names: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let Some((found, known)) = names.split_first() else {
        return (message.to_owned(), None);
    };
    if message.starts_with("unknown field") {
        return (format!("unknown key `{found}`"), Some(suggest::mend(found, known)));
    }
    if message.starts_with("unknown variant") {
        return (format!("unknown word `{found}`"), Some(suggest::mend(found, known)));
    }
    if message.starts_with("missing field") {
        return (format!("missing key `{found}`"), Some(mend_missing(found)));
    }
    (message.to_owned(), None)
}

/// What to write for a missing key.
fn mend_missing(key: &str) -> String {
    match key {
        "geometry" => "add a [geometry] table with files, unit and up".to_owned(),
        "unit" => "add unit = \"m\" (or cm, mm, ft, in): an OBJ file carries no unit".to_owned(),
        "up" => "add up = \"z\" (or y): an OBJ file does not say which axis points up".to_owned(),
        "model" => "add model = \"cie-overcast\"".to_owned(),
        "files" => "add files = [\"room.obj\"]".to_owned(),
        "pixels" => "add pixels = [512, 512]".to_owned(),
        _ => format!("add `{key} = ...`; `clerestory schema` lists all keys"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        parse(Source { path: Path::new("s.toml"), text }).unwrap_err().to_string()
    }

    const HEAD: &str = "[geometry]\nfiles = [\"a.obj\"]\nunit = \"m\"\nup = \"z\"\n";

    #[test]
    fn an_unknown_key_names_line_and_nearest_key() {
        let e = error(&format!("{HEAD}[materials.wall]\nreflectence = 0.5\n"));
        assert!(e.contains("s.toml:6: unknown key `reflectence`"), "{e}");
        assert!(e.contains("did you mean `reflectance`?"), "{e}");
    }

    #[test]
    fn an_unknown_unit_names_line_and_nearest_unit() {
        let e = error("[geometry]\nfiles = []\nunit = \"mmm\"\nup = \"z\"\n");
        assert!(e.contains("s.toml:3: unknown word `mmm`") && e.contains("`mm`"), "{e}");
    }

    #[test]
    fn an_unknown_kind_and_band_mode_are_named() {
        let e = error(&format!("{HEAD}[materials.w]\nkind = \"glas\"\n"));
        assert!(e.contains("s.toml:6:") && e.contains("did you mean `glass`?"), "{e}");
        let e = error(&format!("{HEAD}[bands]\nmode = \"gray\"\n"));
        assert!(e.contains("s.toml:6:") && e.contains("did you mean `grey`?"), "{e}");
        let e = error(&format!("{HEAD}[bands]\nmode = {{ step = 5 }}\n"));
        assert!(e.contains("s.toml:6: unknown key `step`") && e.contains("`step_nm`"), "{e}");
    }

    #[test]
    fn a_missing_unit_says_what_to_add() {
        let e = error("[geometry]\nfiles = []\nup = \"z\"\n");
        assert!(e.contains("s.toml:1: missing key `unit`") && e.contains("add unit = \"m\""), "{e}");
        assert!(error("").contains("add a [geometry] table"));
    }

    #[test]
    fn broken_toml_names_its_line() {
        let e = error("title = \"x\"\n[geometry\n");
        assert!(e.contains("s.toml:2:"), "{e}");
    }

    #[test]
    fn the_schema_knows_the_keys_and_closes_the_tables() {
        let text = json_schema().to_string();
        for key in ["bsdf", "luminance_cd_m2", "spacing_m", "range_nm", "film_mm", "additionalProperties"] {
            assert!(text.contains(key), "{key}");
        }
    }
}
