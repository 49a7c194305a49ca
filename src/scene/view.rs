//! Views: where the eye is and how directions become pixels.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::file::{At, FovDef, Source, ViewDef, ViewKind};
use super::load::{Files, check_number, unit_vector, vector};
use super::{Axes, Projection, View};
use crate::Result;

/// Most pixels along a side.
const MOST_PIXELS: u32 = 16_384;

/// Checks one view.
pub(crate) fn resolve(files: &mut Files<'_>, axes: Axes, def: &ViewDef) -> Result<View> {
    let source = files.source;
    let name = def.name.value.clone();
    let position = axes.to_internal(vector(source, &def.position_m, "position_m")?);
    let direction = axes.to_internal(unit_vector(source, &def.direction, "direction")?);
    let up = up(source, axes, def, direction)?;
    let [width, height] = def.pixels.value;
    if width == 0 || height == 0 || width > MOST_PIXELS || height > MOST_PIXELS {
        return Err(source
            .malformed(def.pixels.offset, format!("pixels = [{width}, {height}] is not within 1 to {MOST_PIXELS}")));
    }
    let projection = projection(source, def)?;
    warn_pixels(files, &name, projection, f64::from(width) / f64::from(height));
    Ok(View { name, position, direction, up, projection, width: width as usize, height: height as usize })
}

/// The picture's up, made perpendicular to the direction.
fn up(source: Source<'_>, axes: Axes, def: &ViewDef, direction: DVec3) -> Result<DVec3> {
    let up = match &def.up {
        Some(up) => axes.to_internal(unit_vector(source, up, "up")?),
        None => DVec3::Z,
    };
    let across = up - direction * up.dot(direction);
    if across.length() < 1e-6 {
        let offset = def.up.as_ref().map_or(def.direction.offset, |u| u.offset);
        return Err(source
            .malformed(offset, format!("view \"{}\": `up` is parallel to `direction`", def.name.value))
            .mend("give an `up` across the view direction"));
    }
    Ok(across.normalize())
}

fn projection(source: Source<'_>, def: &ViewDef) -> Result<Projection> {
    let kind = def.kind.as_ref().map_or(ViewKind::Perspective, |k| k.value);
    if kind != ViewKind::Perspective {
        for (offset, key) in
            [(def.film_mm.as_ref().map(|f| f.offset), "film_mm"), (def.focal_mm.as_ref().map(|f| f.offset), "focal_mm")]
        {
            if let Some(offset) = offset {
                return Err(source
                    .malformed(offset, format!("`{key}` belongs to a perspective view"))
                    .mend("use fov_deg"));
            }
        }
    }
    match kind {
        ViewKind::Perspective => perspective(source, def),
        ViewKind::Fisheye => fisheye(source, def),
        ViewKind::Panorama => match &def.fov_deg {
            Some(fov) => Err(source
                .malformed(fov.offset, "a panorama sees all around: it has no `fov_deg`")
                .mend("remove the key")),
            None => Ok(Projection::Panorama),
        },
    }
}

fn perspective(source: Source<'_>, def: &ViewDef) -> Result<Projection> {
    let [width, height] = def.pixels.value.map(f64::from);
    match (&def.film_mm, &def.focal_mm, &def.fov_deg) {
        (Some(film), Some(focal), None) => {
            check_number(source, Some(focal), "focal_mm")?;
            let [w, h] = film.value;
            if !(w > 0.0 && h > 0.0 && focal.value > 0.0 && w.is_finite() && h.is_finite()) {
                return Err(source.malformed(film.offset, "film_mm and focal_mm must be positive"));
            }
            let angle = |side: f64| 2.0 * (0.5 * side / focal.value).atan();
            Ok(Projection::Perspective { horizontal: angle(w), vertical: angle(h) })
        }
        (None, None, Some(fov)) => {
            let horizontal = angle(source, fov, first(fov), 180.0)?;
            let vertical = match fov.value {
                FovDef::Horizontal(_) => 2.0 * ((0.5 * horizontal).tan() * height / width).atan(),
                FovDef::Both([_, v]) => angle(source, fov, v, 180.0)?,
            };
            Ok(Projection::Perspective { horizontal, vertical })
        }
        _ => Err(source
            .malformed(def.name.offset, format!("view \"{}\" states no angle, or two", def.name.value))
            .mend("give film_mm and focal_mm, or fov_deg")),
    }
}

fn fisheye(source: Source<'_>, def: &ViewDef) -> Result<Projection> {
    let Some(fov) = &def.fov_deg else {
        return Ok(Projection::Fisheye { angle: PI });
    };
    if let FovDef::Both([h, v]) = fov.value
        && h != v
    {
        return Err(source.malformed(fov.offset, "a fisheye is round: it has one angle").mend("give fov_deg = 180"));
    }
    Ok(Projection::Fisheye { angle: angle(source, fov, first(fov), 360.0 + 1e-9)?.min(TAU) })
}

fn first(fov: &At<FovDef>) -> f64 {
    match fov.value {
        FovDef::Horizontal(h) | FovDef::Both([h, _]) => h,
    }
}

/// An angle in degrees, above 0 and below `limit`, in radians.
fn angle(source: Source<'_>, at: &At<FovDef>, degrees: f64, limit: f64) -> Result<f64> {
    if degrees > 0.0 && degrees < limit {
        return Ok(degrees.to_radians());
    }
    Err(source
        .malformed(at.offset, format!("fov_deg = {degrees} is not between 0 and {limit:.0}"))
        .mend("a wider view wants kind = \"fisheye\" or \"panorama\""))
}

fn warn_pixels(files: &mut Files<'_>, name: &str, projection: Projection, aspect: f64) {
    let shape = match projection {
        Projection::Perspective { horizontal, vertical } => (0.5 * horizontal).tan() / (0.5 * vertical).tan(),
        Projection::Fisheye { .. } => 1.0,
        Projection::Panorama => 2.0,
    };
    if (aspect / shape - 1.0).abs() > 0.01 {
        files.warnings.push(format!(
            "view \"{name}\": its pixels are not square: {aspect:.3} wide by high, where the view is {shape:.3}"
        ));
    }
}
