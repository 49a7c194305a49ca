//! The chamber by its data: `polygons.csv`, `lamps.csv`, `reflectance_1nm.csv`, `lamp_plus_chamber_spectrum.csv` and
//! `measured_12.csv` of one folder.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use glam::DVec3;

use super::super::references::{Row, rows_of};
use super::super::scenes::Build;
use crate::error::{Error, Result};
use crate::scene::{Emission, MaterialKind};
use crate::spectrum::{BandMode, Beyond, SpectralValue, Spectrum};

/// Edges of the bands, nm, and the columns that were measured in them.
const EDGES_NM: [f64; 3] = [600.0, 655.0, 665.0];
const MEASURED: [&str; 2] = ["ppfd_600_655_umol_m2_s", "ppfd_655_665_umol_m2_s"];
/// The translucent ceiling.
const PLATE: &str = "Makrolon";
/// Faces nearer than this to one of their own material are its other side, m.
const SAME_M: f64 = 1e-3;
/// The lamps are lines of light: a tube of this radius (m) and so many sides shines as one, 1 % apart over its turn.
const TUBE_M: f64 = 1e-3;
const SIDES: usize = 16;

/// Which surfaces reflect besides the plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reflecting {
    Everywhere,
    BoxAlone,
    RoomAlone,
    Nowhere,
}

impl Reflecting {
    pub(super) const ALL: [Self; 4] = [Self::Everywhere, Self::BoxAlone, Self::RoomAlone, Self::Nowhere];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Everywhere => "all",
            Self::BoxAlone => "lamp box and plate",
            Self::RoomAlone => "plate and room",
            Self::Nowhere => "the plate alone",
        }
    }
}

/// A measured point, looking up.
#[derive(Debug)]
pub(super) struct Point {
    pub(super) position_m: DVec3,
    /// In each band, µmol/(m² s).
    pub(super) photon_flux: [f64; 2],
}

/// Everything that the data say.
#[derive(Debug)]
pub(super) struct Chamber {
    /// Material and vertices, m.
    faces: Vec<(String, Vec<DVec3>)>,
    /// Ends, m.
    lamps: Vec<[DVec3; 2]>,
    /// `r_<material>` and `t_<material>`.
    curves: BTreeMap<String, Spectrum>,
    /// Photons per nm.
    light: Spectrum,
    pub(super) points: Vec<Point>,
}

impl Chamber {
    pub(super) fn read(folder: &Path) -> Result<Self> {
        let table = |name: &str| -> Result<Vec<Row>> {
            let path = folder.join(name);
            let text = std::fs::read_to_string(&path).map_err(|e| Error::io(&path, &e))?;
            rows_of(&text, &path.display().to_string())
        };
        let curve_rows = table("reflectance_1nm.csv")?;
        let names: Vec<String> = curve_rows
            .first()
            .map_or(Vec::new(), |r| r.fields().filter(|f| *f != "wavelength_nm").map(Into::into).collect());
        // A reflectance below zero is noise of the instrument.
        let curves = names
            .into_iter()
            .map(|name| Ok((name.clone(), curve(&curve_rows, &name, Beyond::Hold, |v| v.clamp(0.0, 1.0))?)))
            .collect::<Result<_>>()?;
        let mm = |r: &Row, fields: [&str; 3]| -> Result<DVec3> {
            Ok(1e-3 * DVec3::new(r.number(fields[0])?, r.number(fields[1])?, r.number(fields[2])?))
        };
        let lamps = table("lamps.csv")?
            .iter()
            .map(|r| Ok([mm(r, ["x0_mm", "y0_mm", "z0_mm"])?, mm(r, ["x1_mm", "y1_mm", "z1_mm"])?]))
            .collect::<Result<_>>()?;
        let points = table("measured_12.csv")?
            .iter()
            .map(|r| {
                let photon_flux = [r.number(MEASURED[0])?, r.number(MEASURED[1])?];
                Ok(Point { position_m: mm(r, ["x_mm", "y_mm", "z_mm"])?, photon_flux })
            })
            .collect::<Result<_>>()?;
        let mut faces = Vec::new();
        for row in table("polygons.csv")? {
            let vertices = row.points_between("vertices_mm (x y z | x y z | ...)", '|')?;
            add(&mut faces, row.text("material")?, vertices.into_iter().map(|v| 1e-3 * v).collect());
        }
        let light = curve(&table("lamp_plus_chamber_spectrum.csv")?, "ppfd_umol_m2_s_nm", Beyond::Hold, |v| v)?;
        Ok(Self { faces, lamps, curves, light, points })
    }

    /// The scene; its irradiances are photons in a unit of their own.
    pub(super) fn build(&self, reflecting: Reflecting) -> Build {
        let mut b = Build::new();
        b.0.bands = BandMode::Edges(EDGES_NM.to_vec());
        let black = b.paint(0.0, 0.0);
        let emission = Emission { radiance: self.light.clone(), two_sided: false, group: None };
        let none = SpectralValue::Grey(0.0);
        let lamp = b.made_of(MaterialKind::Diffuse { front: none.clone(), back: none }, Some(emission));
        let curve =
            |kind: &str, name: &str| self.curves.get(&format!("{kind}_{name}")).cloned().map(SpectralValue::Spectrum);
        let plate_height = self.faces.iter().find(|f| f.0 == PLATE).map_or(0.0, |f| f.1[0].z);
        let mut paints = BTreeMap::new();
        for (name, vertices) in &self.faces {
            let middle = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
            let reflects = match reflecting {
                Reflecting::Everywhere => true,
                Reflecting::BoxAlone => middle.z > plate_height,
                Reflecting::RoomAlone => middle.z <= plate_height,
                Reflecting::Nowhere => false,
            };
            // What has no published reflectance (the discs that screen the lamps) is black.
            let kind = match (curve("r", name), curve("t", name)) {
                (Some(rho), Some(transmittance)) => {
                    MaterialKind::Translucent { front: rho.clone(), back: rho, transmittance, maintenance_factor: 1.0 }
                }
                (Some(rho), None) if reflects => MaterialKind::Diffuse { front: rho.clone(), back: rho },
                _ => {
                    b.face(vertices, black);
                    continue;
                }
            };
            let paint = *paints.entry(name).or_insert_with(|| b.made_of(kind, None));
            b.face(vertices, paint);
        }
        for [from, to] in &self.lamps {
            tube(&mut b, *from, *to, lamp);
        }
        b.points("points", &self.points.iter().map(|p| (p.position_m, DVec3::Z)).collect::<Vec<_>>());
        b
    }
}

fn curve(rows: &[Row], field: &str, beyond: Beyond, mend: impl Fn(f64) -> f64) -> Result<Spectrum> {
    let nm = rows.iter().map(|r| r.number("wavelength_nm")).collect::<Result<_>>()?;
    let values = rows.iter().map(|r| r.number(field).map(&mend)).collect::<Result<_>>()?;
    Spectrum::new(nm, values, beyond)
}

/// Adds a face that is not another's other side, less what others cover of it in its own plane.
fn add(faces: &mut Vec<(String, Vec<DVec3>)>, material: &str, vertices: Vec<DVec3>) {
    let near = |a: &[DVec3], b: &[DVec3]| a.iter().all(|p| b.iter().any(|q| p.distance(*q) <= SAME_M));
    if faces.iter().any(|(m, v)| m == material && v.len() == vertices.len() && near(&vertices, v)) {
        return;
    }
    let mut pieces = vec![vertices];
    for (_, other) in faces.iter() {
        pieces = pieces.into_iter().flat_map(|p| without(p, other)).collect();
    }
    faces.extend(pieces.into_iter().map(|p| (material.to_owned(), p)));
}

/// Corners of an upright rectangle that lies level.
fn level(vertices: &[DVec3]) -> Option<(DVec3, DVec3)> {
    let (low, high) = vertices.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let on_corner = |v: &DVec3| (v.x == low.x || v.x == high.x) && (v.y == low.y || v.y == high.y);
    (vertices.len() == 4 && low.z == high.z && vertices.iter().all(on_corner)).then_some((low, high))
}

/// A level rectangle less another at its height, in pieces; other faces stay as they are.
fn without(face: Vec<DVec3>, other: &[DVec3]) -> Vec<Vec<DVec3>> {
    let (Some((low, high)), Some((a, b))) = (level(&face), level(other)) else { return vec![face] };
    let (c, d) = (low.max(a), high.min(b));
    if low.z != a.z || c.x >= d.x || c.y >= d.y {
        return vec![face];
    }
    let sides = [
        ((low.x, low.y), (high.x, c.y)),
        ((low.x, d.y), (high.x, high.y)),
        ((low.x, c.y), (c.x, d.y)),
        ((d.x, c.y), (high.x, d.y)),
    ];
    sides
        .into_iter()
        .filter(|(p, q)| p.0 < q.0 && p.1 < q.1)
        .map(|(p, q)| [(p.0, p.1), (q.0, p.1), (q.0, q.1), (p.0, q.1)].map(|(x, y)| DVec3::new(x, y, low.z)).to_vec())
        .collect()
}

/// An open tube whose front looks out.
fn tube(b: &mut Build, from: DVec3, to: DVec3, material: usize) {
    let axis = to - from;
    let (u, v) = axis.normalize().any_orthonormal_pair();
    let corner = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / SIDES as f64).sin_cos();
        TUBE_M * (cos * u + sin * v)
    };
    // any_orthonormal_pair is right-handed with the axis: u × v points along it.
    for k in 0..SIDES {
        b.rectangle(from + corner(k), corner(k + 1) - corner(k), axis, material);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, side: f64) -> Vec<DVec3> {
        [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)].map(|(a, b)| DVec3::new(x + a, y + b, 1.0)).to_vec()
    }

    #[test]
    fn doubled_faces_count_once_and_covered_ones_are_cut() {
        let mut faces = Vec::new();
        add(&mut faces, "frame", square(0.0, 0.0, 1.0));
        let mut back = square(0.0, 0.0, 1.0);
        back.reverse();
        add(&mut faces, "frame", back.iter().map(|v| *v + 5e-4 * DVec3::Z).collect());
        assert_eq!(faces.len(), 1, "the other side, half a millimetre away");
        add(&mut faces, "plate", square(-1.0, -1.0, 3.0));
        let area = |v: &[DVec3]| (v[1] - v[0]).cross(v[2] - v[0]).length();
        assert_eq!(faces[1..].iter().map(|f| area(&f.1)).sum::<f64>(), 8.0, "the plate less what covers it");
        add(&mut faces, "plate", square(5.0, 5.0, 1.0));
        assert_eq!(faces.len(), 6, "what lies apart stays whole");
    }

    #[test]
    fn a_tube_looks_outwards() {
        let mut b = Build::new();
        let paint = b.paint(0.5, 0.0);
        tube(&mut b, DVec3::ZERO, DVec3::X, paint);
        for f in &b.0.faces {
            let middle = f.vertices.iter().sum::<DVec3>() / 4.0;
            assert!(f.normal.dot(middle - DVec3::new(middle.x, 0.0, 0.0)) > 0.0, "{f:?}");
        }
    }
}
