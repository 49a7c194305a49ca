//! Windows with a BSDF file, and dirt on whatever lets light in.

use std::sync::Arc;

use glam::DVec3;

use super::bsdf::Bsdf;
use super::file::{At, MaterialDef};
use super::load::{Files, check_number, unit_vector};
use super::material::refuse;
use super::{Axes, Face, MaterialKind};
use crate::{Error, Result};

/// Sine of the angle between a face's normal and what is up below which nothing is.
const UPRIGHT: f64 = 1e-3;

/// A material with a BSDF file.
pub(super) fn element(files: &mut Files<'_>, axes: Axes, name: &str, def: &At<MaterialDef>) -> Result<MaterialKind> {
    let m = &def.value;
    let others = [
        (m.reflectance.as_ref().map(|v| v.offset), "reflectance"),
        (m.reflectance_back.as_ref().map(|v| v.offset), "reflectance_back"),
        (m.transmittance.as_ref().map(|v| v.offset), "transmittance"),
        (m.refractive_index.as_ref().map(|v| v.offset), "refractive_index"),
        (m.panes.as_ref().map(|v| v.offset), "panes"),
        (m.emission.as_ref().map(|v| v.offset), "emission"),
    ];
    for (offset, key) in others {
        let Some(offset) = offset else { continue };
        let message = format!("material \"{name}\": a bsdf material has no `{key}`: its file tells it");
        return Err(files.source.malformed(offset, message).mend("remove the key"));
    }
    let file = m.file.as_ref().ok_or_else(|| {
        let message = format!("material \"{name}\" has no `file`");
        files.source.malformed(def.offset, message).mend("add file = \"blind.xml\", a BSDF in the XML of WINDOW")
    })?;
    let up = match &m.up {
        Some(up) => axes.to_internal(unit_vector(files.source, up, "up")?),
        None => DVec3::Z,
    };
    let bytes = files.read(file)?;
    let path = files.path(&file.value);
    let text = super::text(&bytes).map_err(|e| e.in_file(&path))?;
    let bsdf = Bsdf::from_xml(text).map_err(|e| e.in_file(&path))?;
    let maintenance_factor = maintenance_factor(files, name, def)?;
    Ok(MaterialKind::Bsdf { bsdf: Arc::new(bsdf), up, maintenance_factor })
}

/// A face of a BSDF material must have an upward direction of its own.
pub(super) fn check_up(files: &Files<'_>, name: &str, def: &At<MaterialDef>, up: DVec3, faces: &[&Face]) -> Result<()> {
    let level = faces.iter().find(|f| f.normal.cross(up).length() < UPRIGHT);
    level.map_or(Ok(()), |_| {
        let offset = def.value.up.as_ref().map_or(def.offset, |u| u.offset);
        let message = format!("material \"{name}\": `up` points along the normal of one of its faces");
        Err(files
            .source
            .place(offset, Error::malformed(message))
            .mend("state up = [x, y, z] within the plane of the element; [0, 0, 1] unless given"))
    })
}

/// Share of the light that dirt leaves, 0 to 1.
pub(super) fn maintenance_factor(files: &Files<'_>, name: &str, def: &At<MaterialDef>) -> Result<f64> {
    let Some(factor) = &def.value.maintenance_factor else { return Ok(1.0) };
    check_number(files.source, Some(factor), "maintenance_factor")?;
    if (0.0..=1.0).contains(&factor.value) {
        return Ok(factor.value);
    }
    let message = format!("material \"{name}\": maintenance_factor = {} is not within 0 to 1", factor.value);
    Err(files
        .source
        .impossible(factor.offset, message)
        .mend("0.9 is glass that lets by 90 % of what it does when clean"))
}

/// Dirt lies on what lets light in alone.
pub(super) fn refuse_dirt(files: &Files<'_>, name: &str, kind: &str, def: &At<MaterialDef>) -> Result<()> {
    let offset = def.value.maintenance_factor.as_ref().map(|f| f.offset);
    refuse(files.source, name, kind, offset, "maintenance_factor")
}
