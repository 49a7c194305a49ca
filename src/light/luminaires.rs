//! Luminaires as they hang: a luminous intensity distribution, spread over a luminous shape.
//!
//! In a given direction all that is seen of the shape has one luminance, intensity over projected area
//! (`L = I / Σ A cos θ`): far away that is the intensity of the file, near by it is the light of the shape, and the flux
//! is that of the file at any distance. The body of a luminaire is no geometry: it neither shades nor reflects.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::photometry::{Opening, Photometry, Web};
use crate::mesh::{Frame, Surface, sample_polygon};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use crate::{Error, Result};

/// Corners of a round opening: with equal areas its outline is off by less than 0.2 % of the radius.
const CORNERS: usize = 48;

/// Where light leaves from.
#[derive(Clone, Debug)]
pub enum Shape {
    /// One point.
    Point,
    /// Evenly along a line between two points.
    Line([DVec3; 2]),
    /// Plane faces that look outward.
    Faces(Vec<LuminousFace>),
}

/// A luminous face.
#[derive(Clone, Debug)]
pub struct LuminousFace {
    /// The polygon.
    pub surface: Surface,
    /// A polygon of few corners around it.
    pub hull: Vec<DVec3>,
}

/// A luminaire in its place; lengths in the program's frame once it is placed there.
#[derive(Clone, Debug)]
pub struct Luminaire {
    /// Intensity by direction, cd.
    pub web: Arc<Web>,
    /// Luminous flux, lm.
    pub flux_lm: f64,
    /// Largest intensity, cd.
    pub peak_cd: f64,
    /// Photometric centre.
    pub position: DVec3,
    /// Columns: where C0, C90 and the direction opposite to the aim point.
    pub axes: DMat3,
    /// Where light leaves from.
    pub shape: Shape,
    /// Its corners, or its ends, or its place.
    pub corners: Vec<DVec3>,
    /// Spectrum, as an index into [`Luminaires::spectra`]; once placed, the group of light.
    pub group: usize,
    /// Which table of the scene it is of.
    pub table: usize,
}

/// All luminaires of a scene.
#[derive(Clone, Debug, Default)]
pub struct Luminaires {
    /// In the order of the scene file, metres.
    pub list: Vec<Luminaire>,
    /// Spectra of one lumen, W/(nm lm).
    pub spectra: Vec<Spectrum>,
    /// Group of lamps that those of each spectrum are dimmed with.
    pub dimming: Vec<Option<String>>,
    /// Electric power of each luminaire of each table, W, where it is known.
    pub power_w: Vec<Option<f64>>,
    /// General colour rendering index of each table, where it is known.
    pub ra: Vec<Option<f64>>,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// Names of the tables: file and line.
    pub tables: Vec<String>,
}

impl Luminaires {
    /// Reads the photometric files of a scene and hangs the luminaires.
    ///
    /// # Errors
    /// Files that are no photometry, a flux asked of a luminaire that has none.
    pub fn new(scene: &Scene) -> Result<Self> {
        let mut all = Self::default();
        for (table, row) in scene.luminaires.iter().enumerate() {
            let photometry = Photometry::parse(&row.bytes, &row.file)?;
            let own = photometry.web.flux_lm();
            let name = row.file.file_name().unwrap_or_default().to_string_lossy().into_owned();
            all.tables.push(format!("{name} ([[luminaires]], line {})", row.line));
            for warning in &photometry.warnings {
                let told = format!("{name}: {warning}");
                if !all.warnings.contains(&told) {
                    all.warnings.push(told);
                }
            }
            all.power_w.push(row.power_w.or(Some(photometry.power_w).filter(|w| *w > 0.0)));
            all.ra.push(row.ra.or_else(|| photometry.colour_rendering()));
            if row.flux_lm.is_some() && own <= 0.0 {
                return Err(Error::impossible("flux_lm scales a luminaire that gives no light").in_file(&row.file));
            }
            let tilt_deg = row.axes.z_axis.dot(DVec3::Z).clamp(-1.0, 1.0).acos().to_degrees();
            let tilt = photometry.tilt.as_ref().map_or(1.0, |t| t.factor(tilt_deg));
            let factor = row.factor * tilt * row.flux_lm.map_or(1.0, |flux_lm| flux_lm / own);
            let web = Arc::new(photometry.web.scaled(factor));
            let unit = row.spectrum.scaled(1.0 / row.spectrum.luminous());
            let known = all.spectra.iter().zip(&all.dimming).position(|(s, g)| *s == unit && *g == row.group);
            let group = known.unwrap_or_else(|| {
                all.spectra.push(unit);
                all.dimming.push(row.group.clone());
                all.spectra.len() - 1
            });
            if web.flux_lm() <= 0.0 {
                continue; // dark
            }
            let hang = |p: &DVec3| Luminaire::hung(web.clone(), &photometry.opening, *p, row.axes, (group, table));
            all.list.extend(row.positions.iter().map(hang));
        }
        Ok(all)
    }

    /// Spectrum of each group that shines with its flux over π, for the choice of bands.
    pub fn lights(&self) -> impl Iterator<Item = (&Spectrum, f64)> {
        self.spectra.iter().enumerate().map(|(group, spectrum)| {
            (spectrum, self.list.iter().filter(|l| l.group == group).map(|l| l.flux_lm).sum::<f64>() / PI)
        })
    }
}

impl Luminaire {
    /// A luminaire in its place, metres; its spectrum and its table.
    #[must_use]
    pub fn hung(
        web: Arc<Web>,
        opening: &Opening,
        position: DVec3,
        axes: DMat3,
        (group, table): (usize, usize),
    ) -> Self {
        let shape = shape(opening, position, axes, &web);
        let corners = corners(&shape, position);
        let (flux_lm, peak_cd) = (web.flux_lm(), web.peak().0);
        Self { web, flux_lm, peak_cd, position, axes, shape, corners, group, table }
    }

    /// The same in the program's frame, its group counted from `first`.
    #[must_use]
    pub fn placed(mut self, frame: &Frame, first: usize) -> Self {
        let place = |p: &mut DVec3| *p = frame.to_local(*p);
        place(&mut self.position);
        self.corners.iter_mut().for_each(place);
        match &mut self.shape {
            Shape::Point => {}
            Shape::Line(ends) => ends.iter_mut().for_each(place),
            Shape::Faces(faces) => {
                for face in faces {
                    let vertices = face.surface.vertices.iter().map(|p| frame.to_local(*p)).collect();
                    face.surface = Surface::new(vertices, face.surface.normal, 0);
                    face.hull.iter_mut().for_each(place);
                }
            }
        }
        self.group += first;
        self
    }

    /// Intensity in a direction of any length, cd.
    #[must_use]
    pub fn intensity(&self, direction: DVec3) -> f64 {
        self.web.towards(self.axes.transpose() * direction)
    }

    /// Luminous area as seen from a direction of any length, times that length.
    #[must_use]
    pub fn projected_area(&self, direction: DVec3) -> f64 {
        let Shape::Faces(faces) = &self.shape else { return 0.0 };
        faces.iter().map(|f| f.surface.area * f.surface.normal.dot(direction).max(0.0)).sum()
    }

    /// Most illuminance that the luminaire gives near a point, roughly, times the square of a unit of length: by its
    /// centre, but no less than a hundredth of what its peak could.
    #[must_use]
    pub fn rough(&self, x: DVec3, normal: DVec3) -> f64 {
        if !self.corners.iter().any(|c| normal.dot(*c - x) > 0.0) {
            return 0.0;
        }
        let d = self.position - x;
        let r2 = d.length_squared().max(1e-12);
        let cosine = normal.dot(d) / r2.sqrt();
        (self.intensity(-d) * cosine.max(0.0)).max(0.01 * self.peak_cd * cosine.max(0.05)) / r2
    }

    /// A place that light in a direction leaves from, and the normal there; `a` and `b` choose it.
    #[must_use]
    pub fn start(&self, direction: DVec3, a: f64, b: f64) -> (DVec3, DVec3) {
        match &self.shape {
            Shape::Point => (self.position, direction),
            Shape::Line([from, to]) => (from.lerp(*to, a), direction),
            Shape::Faces(faces) => {
                let share = |f: &LuminousFace| f.surface.area * f.surface.normal.dot(direction).max(0.0);
                let all: f64 = faces.iter().map(share).sum();
                let mut want = a * all;
                let facing = faces.iter().filter(|f| share(f) > 0.0);
                let mut chosen = None;
                for face in facing {
                    chosen = Some(face);
                    let own = share(face);
                    if want < own {
                        return (
                            face.surface.point(sample_polygon(&face.surface.outline, want / own, b)),
                            face.surface.normal,
                        );
                    }
                    want -= own;
                }
                chosen.map_or((self.position, direction), |f| {
                    (f.surface.point(sample_polygon(&f.surface.outline, 1.0, b)), f.surface.normal)
                })
            }
        }
    }

    /// A place of the shape by area: the place, its face's normal (none for points and lines), and the whole area.
    #[must_use]
    pub fn place(&self, a: f64, b: f64) -> (DVec3, Option<DVec3>, f64) {
        match &self.shape {
            Shape::Point => (self.position, None, 0.0),
            Shape::Line([from, to]) => (from.lerp(*to, a), None, 0.0),
            Shape::Faces(faces) => {
                let all: f64 = faces.iter().map(|f| f.surface.area).sum();
                let mut want = a * all;
                let mut k = 0;
                while k + 1 < faces.len() && want >= faces[k].surface.area {
                    want -= faces[k].surface.area;
                    k += 1;
                }
                let s = &faces[k].surface;
                (s.point(sample_polygon(&s.outline, (want / s.area).min(1.0), b)), Some(s.normal), all)
            }
        }
    }
}

/// The luminous shape of an opening: its faces where it has two extents or more and light leaves them.
fn shape(o: &Opening, position: DVec3, axes: DMat3, web: &Web) -> Shape {
    let half = DVec3::new(o.along_c0_m, o.along_c90_m, o.height_m) * 0.5;
    let at = |x: f64, y: f64, z: f64| position + axes * DVec3::new(x, y, z);
    match o.shape() {
        "point" => Shape::Point,
        "line" => Shape::Line([at(-half.x, -half.y, -half.z), at(half.x, half.y, half.z)]),
        _ => {
            let outline: Vec<(f64, f64)> = if o.round {
                // An ellipse of equal area.
                let grow = (PI / (0.5 * CORNERS as f64 * (TAU / CORNERS as f64).sin())).sqrt();
                let corner = |k: usize| (TAU * (k as f64 + 0.5) / CORNERS as f64).sin_cos();
                (0..CORNERS).map(corner).map(|(s, c)| (half.x * grow * c, half.y * grow * s)).collect()
            } else {
                vec![(-half.x, -half.y), (half.x, -half.y), (half.x, half.y), (-half.x, half.y)]
            };
            let ring = |z: f64| outline.iter().map(|(x, y)| at(*x, *y, z)).collect::<Vec<_>>();
            let mut faces = Vec::new();
            if half.x > 0.0 && half.y > 0.0 {
                let mut below = ring(-half.z);
                below.reverse();
                let gives = |sign: f64| {
                    let (from, to) = if sign < 0.0 { (0.0, 90.0 - 1e-6) } else { (90.0 + 1e-6, 180.0) };
                    half.z > 0.0 || gives_light(web, from, to)
                };
                let hull = |z: f64| {
                    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                        .map(|(x, y)| at(1.01 * x * half.x, 1.01 * y * half.y, z))
                        .to_vec()
                };
                if gives(-1.0) {
                    faces.push(face(below, -axes.z_axis, o.round.then(|| hull(-half.z))));
                }
                if gives(1.0) {
                    faces.push(face(ring(half.z), axes.z_axis, o.round.then(|| hull(half.z))));
                }
            }
            if half.z > 0.0 {
                let n = outline.len();
                for k in 0..n {
                    let (a, b) = (outline[k], outline[(k + 1) % n]);
                    let side =
                        vec![at(a.0, a.1, -half.z), at(b.0, b.1, -half.z), at(b.0, b.1, half.z), at(a.0, a.1, half.z)];
                    let normal = (side[1] - side[0]).cross(side[3] - side[0]);
                    if normal.length() > 0.0 {
                        faces.push(face(side, normal.normalize(), None));
                    }
                }
            }
            Shape::Faces(faces)
        }
    }
}

/// Does a flat opening give any light between two vertical angles? For types A and B both sides are taken to.
fn gives_light(web: &Web, from_deg: f64, to_deg: f64) -> bool {
    web.kind() != super::photometry::PhotometricType::C || web.zone_flux_lm(from_deg, to_deg) > 0.0
}

fn face(vertices: Vec<DVec3>, normal: DVec3, hull: Option<Vec<DVec3>>) -> LuminousFace {
    let hull = hull.unwrap_or_else(|| vertices.clone());
    LuminousFace { surface: Surface::new(vertices, normal, 0), hull }
}

fn corners(shape: &Shape, position: DVec3) -> Vec<DVec3> {
    match shape {
        Shape::Point => vec![position],
        Shape::Line(ends) => ends.to_vec(),
        Shape::Faces(faces) => faces.iter().flat_map(|f| f.hull.iter().copied()).collect(),
    }
}
