//! A checked scene in SI units, z up: what all later stages work on.
//!
//! In: a scene file (TOML) with the OBJ and CSV files it names. Out: [`Scene`]. Every error names file,
//! line or object, and what mends it. Inside the program everything is in metres, z up; a y-up file is
//! turned by (x, y, z) → (x, −z, y), and turned back where a user reads coordinates
//! ([`Axes::to_user`]).

pub mod bsdf;
mod build;
pub mod check;
#[cfg(test)]
mod check_tests;
mod dimming;
mod faces;
mod fenestration;
mod file;
mod glazing;
mod grid;
mod load;
mod loose;
mod luminaire;
mod material;
mod obj;
mod outline;
mod polygon;
mod requirement;
mod shells;
mod sky;
mod suggest;
#[cfg(test)]
mod tests;
mod usage;
mod view;

use std::path::PathBuf;

use glam::DVec3;

pub use build::Build;
pub use check::{Diagnostic, Severity, check};
pub use dimming::{DAYLIGHT, ELECTRIC, LightState};
pub use file::json_schema;
pub use load::load;
pub use luminaire::LuminaireRow;
pub use requirement::{PowerBasis, Quantity, Requirement};
pub use sky::{Amount, ClockTime, Daytime, Placed, Site, SkyName};
pub use usage::{Blind, BlindControl, Occupancy};

use crate::spectrum::{BandMode, SpectralValue, Spectrum};

/// UTF-8 text without a byte order mark, or the line of the first byte that is none.
fn text(bytes: &[u8]) -> crate::Result<&str> {
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let line = 1 + bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count();
        crate::Error::malformed("a byte that is not UTF-8 text").mend("save the file as UTF-8").at_line(line)
    })?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

/// Everything a run needs to know.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Title, for reports.
    pub title: String,
    /// Convex planar polygons, metres, z up.
    pub faces: Vec<Face>,
    /// Names of OBJ groups and objects; [`Face::object`] points here.
    pub objects: Vec<String>,
    /// Materials; [`Face::material`] points here.
    pub materials: Vec<Material>,
    /// How the spectrum is to be divided.
    pub bands: BandMode,
    /// Where illuminance is asked.
    pub grids: Vec<Grid>,
    /// Grids whose points carry cylinders as well: the number of each, then that of the grid of its cylinders.
    pub modelling: Vec<(usize, usize)>,
    /// Grids whose points are eyes for which glare is rated.
    pub observers: Vec<usize>,
    /// Pictures asked for.
    pub views: Vec<View>,
    /// Sky, sun and ground, as asked for.
    pub daytime: Option<Daytime>,
    /// Luminaires, table by table.
    pub luminaires: Vec<LuminaireRow>,
    /// Limits that grids are to keep.
    pub requirements: Vec<Requirement>,
    /// What the watts of the luminaires refer to.
    pub power: Option<PowerBasis>,
    /// States of the lights that are reported beside the scene as it stands.
    pub states: Vec<LightState>,
    /// Hours of presence, for a year of daylight.
    pub occupancy: Occupancy,
    /// Blinds before windows, for a year of daylight.
    pub blinds: Vec<Blind>,
    /// The user's axes.
    pub axes: Axes,
    /// Files read, with SHA-256 of their bytes in hexadecimal, in reading order.
    pub inputs: Vec<InputFile>,
    /// What a careful reader would tell the user, although the run goes on.
    pub warnings: Vec<String>,
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputFile {
    /// As named by the user, relative to the scene file where possible.
    pub path: PathBuf,
    /// SHA-256 of the bytes.
    pub sha256: String,
}

/// The user's axes against the program's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axes {
    /// z points up in the user's files.
    #[default]
    ZUp,
    /// y points up in the user's files.
    YUp,
}

impl Axes {
    /// User coordinates to the program's (z up).
    #[must_use]
    pub fn to_internal(self, p: DVec3) -> DVec3 {
        match self {
            Self::ZUp => p,
            Self::YUp => DVec3::new(p.x, -p.z, p.y),
        }
    }

    /// Program coordinates to the user's.
    #[must_use]
    pub fn to_user(self, p: DVec3) -> DVec3 {
        match self {
            Self::ZUp => p,
            Self::YUp => DVec3::new(p.x, p.z, -p.y),
        }
    }
}

/// A convex planar polygon, counter-clockwise seen from its front.
#[derive(Clone, Debug)]
pub struct Face {
    /// At least three vertices, metres.
    pub vertices: Vec<DVec3>,
    /// Unit normal of the front.
    pub normal: DVec3,
    /// Area, m².
    pub area_m2: f64,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Index into [`Scene::objects`].
    pub object: usize,
}

/// What a surface does with light.
#[derive(Clone, Debug)]
pub struct Material {
    /// The OBJ's `usemtl` name.
    pub name: String,
    /// Reflection and transmission.
    pub kind: MaterialKind,
    /// Light of its own.
    pub emission: Option<Emission>,
    /// Stands outside: light that it reflects last is external.
    pub outside: bool,
}

/// Reflection and transmission.
#[derive(Clone, Debug)]
pub enum MaterialKind {
    /// Lambertian on both sides.
    Diffuse {
        /// Reflectance of the front.
        front: SpectralValue,
        /// Reflectance of the back; equals `front` unless the user says otherwise.
        back: SpectralValue,
    },
    /// Lambertian on both sides, and light that arrives on one side leaves the other diffusely too.
    Translucent {
        /// Reflectance of the front.
        front: SpectralValue,
        /// Reflectance of the back.
        back: SpectralValue,
        /// Diffuse transmittance, the same both ways, when clean.
        transmittance: SpectralValue,
        /// Share of what it passes that dirt leaves.
        maintenance_factor: f64,
    },
    /// A plane mirror on both sides.
    Mirror {
        /// Specular reflectance.
        reflectance: SpectralValue,
    },
    /// A thin clear glazing unit: passes light straight on, reflects it at every face.
    Glass {
        /// Its panes.
        panes: Panes,
        /// Index of refraction of uncoated panes.
        refractive_index: f64,
        /// Share of what it passes that dirt leaves.
        maintenance_factor: f64,
    },
    /// A window element with a BSDF.
    Bsdf {
        /// What it does when clean; the front is that of the face.
        bsdf: std::sync::Arc<bsdf::Bsdf>,
        /// Where its azimuth of 90° points, projected on the face.
        up: DVec3,
        /// Share of what it passes that dirt leaves.
        maintenance_factor: f64,
    },
}

impl MaterialKind {
    /// Does light that arrives on one side leave the other diffusely?
    #[must_use]
    pub fn is_translucent(&self) -> bool {
        matches!(self, Self::Translucent { .. })
    }

    /// Does light pass to the other side, in whatever way?
    #[must_use]
    pub fn lets_light_in(&self) -> bool {
        matches!(self, Self::Glass { .. } | Self::Translucent { .. } | Self::Bsdf { .. })
    }
}

/// The panes of a glazing unit.
#[derive(Clone, Debug)]
pub enum Panes {
    /// Equal uncoated panes.
    Alike {
        /// How many.
        count: usize,
        /// Measured transmittance of the whole unit at normal incidence (not transmissivity).
        transmittance: SpectralValue,
    },
    /// Each by its own measured values, from the front of the face to its back.
    Listed(Vec<GlassPane>),
}

impl Panes {
    /// All spectral values that describe them.
    #[must_use]
    pub fn values(&self) -> Vec<&SpectralValue> {
        match self {
            Self::Alike { transmittance, .. } => vec![transmittance],
            Self::Listed(list) => list
                .iter()
                .flat_map(|p| std::iter::once(&p.transmittance).chain(p.reflectance.iter().flatten()))
                .collect(),
        }
    }
}

/// One pane of a glazing unit.
#[derive(Clone, Debug)]
pub struct GlassPane {
    /// Measured transmittance at normal incidence.
    pub transmittance: SpectralValue,
    /// Measured reflectances of back and front at normal incidence; none for uncoated glass, whose index tells them.
    pub reflectance: Option<[SpectralValue; 2]>,
}

/// Light of a surface's own, Lambertian.
#[derive(Clone, Debug)]
pub struct Emission {
    /// Spectral radiance, W/(m² sr nm).
    pub radiance: Spectrum,
    /// Emits from the back as well as from the front.
    pub two_sided: bool,
    /// Group of lamps that it is dimmed with.
    pub group: Option<String>,
}

/// Points at which illuminance is asked.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Name, used for files too.
    pub name: String,
    /// The points, in the user's order.
    pub sensors: Vec<Sensor>,
    /// How they lie, for maps.
    pub layout: GridLayout,
    /// What receives the light.
    pub receiver: Receiver,
}

/// What receives light at the points of a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Receiver {
    /// A plane: illuminance.
    #[default]
    Plane,
    /// An upright cylinder: mean vertical illuminance (EN 12464-1).
    Cylinder,
    /// Half of one, about the level direction of the point's normal (EN 13201-3).
    HalfCylinder,
}

/// One point and the direction it faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Metres, z up.
    pub position: DVec3,
    /// Unit vector.
    pub normal: DVec3,
    /// The area it stands for, m²; `None` where the grid has no areas (points from a file).
    pub area_m2: Option<f64>,
}

/// How the sensors of a grid lie.
#[derive(Clone, Debug)]
pub enum GridLayout {
    /// Cells of a rectangle; `index[v * nu + u]` is the sensor in the cell, if any.
    Raster {
        /// Corner of cell (0, 0), metres, z up.
        origin: DVec3,
        /// Whole side along u, metres.
        u: DVec3,
        /// Whole side along v, metres.
        v: DVec3,
        /// Cells along u.
        nu: usize,
        /// Cells along v.
        nv: usize,
        /// Sensor of each cell.
        index: Vec<Option<usize>>,
    },
    /// No order.
    Points,
}

/// A picture asked for.
#[derive(Clone, Debug)]
pub struct View {
    /// Name, used for files too.
    pub name: String,
    /// Eye, metres, z up.
    pub position: DVec3,
    /// Unit view direction.
    pub direction: DVec3,
    /// Unit vector, perpendicular to `direction`, up in the picture.
    pub up: DVec3,
    /// Projection.
    pub projection: Projection,
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
}

/// How directions become pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A pinhole camera; full angles across the picture, radians.
    Perspective {
        /// Horizontal angle.
        horizontal: f64,
        /// Vertical angle.
        vertical: f64,
    },
    /// Equidistant (angular) fisheye; full angle across the picture, radians.
    Fisheye {
        /// Full angle.
        angle: f64,
    },
    /// Equirectangular, 2π by π.
    Panorama,
}
