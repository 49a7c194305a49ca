//! What is told of windows with a BSDF, and what they are refused with.

use super::result::{LeftOut, Setting};
use crate::error::{Error, Result};
use crate::scene::{Face, MaterialKind, Scene};
use crate::transport::caster::{MISS, Ray};
use crate::transport::points::Points;
use crate::transport::{Kind, World, cosine_direction};

/// Rays from each side of a window that look for coloured panes.
const LOOKS: u32 = 64;

/// Windows with a BSDF are the same in all bands, and so must be the panes before them.
///
/// # Errors
/// When one looks at the light through a coloured pane.
pub(super) fn check(world: &World) -> Result<()> {
    let points = Points::new(0);
    let list = &world.surfaces.list;
    for s in list.iter().enumerate().filter(|(k, _)| world.scatterer(*k as u32).is_some()).map(|(_, s)| s) {
        let middle = s.vertices.iter().sum::<glam::DVec3>() / s.vertices.len() as f64;
        for (k, front) in (0..LOOKS).flat_map(|k| [(k, false), (k, true)]) {
            let normal = s.side_normal(front);
            let (a, b) = points.pair(k, 0);
            let hit = world.caster.closest(&Ray::new(world.lift(middle, normal), cosine_direction(normal, a, b)));
            let is_pane = hit.surface != MISS && world.kind(hit.surface) == Kind::Glass;
            if is_pane && world.greys().pane(world, hit.surface).is_none() {
                return Err(Error::unsupported("a coloured pane before a window with a BSDF")
                    .mend("give the panes a transmittance of one number, or export the whole unit as one BSDF"));
            }
        }
    }
    Ok(())
}

/// What scatters light already has no blinds that close.
///
/// # Errors
/// When blinds shall hang before a window with a BSDF.
pub(super) fn check_blinds(scene: &Scene) -> Result<()> {
    let is_bsdf = |face: &Face| matches!(scene.materials[face.material].kind, MaterialKind::Bsdf { .. });
    let windows: Vec<&Face> = scene.faces.iter().filter(|f| is_bsdf(f)).collect();
    let Some(blind) = scene.blinds.iter().find(|b| windows.iter().any(|f| b.names(scene, f))) else { return Ok(()) };
    let names = blind.panes.join("\", \"");
    Err(Error::unsupported(format!("[[blinds]] before a window with a BSDF (\"{names}\")"))
        .mend("name panes of glass alone, and give the closed window a BSDF and a year of its own"))
}

/// Each BSDF by its hemispherical values, and where its front looks; dirt on translucent sheets.
pub(super) fn settings<'a>(scene: &'a Scene, world: &'a World) -> impl Iterator<Item = Setting> + 'a {
    scene.materials.iter().enumerate().filter_map(|(material, m)| {
        let maintenance_factor = match &m.kind {
            MaterialKind::Bsdf { maintenance_factor, .. } => maintenance_factor,
            MaterialKind::Translucent { maintenance_factor, .. } if *maintenance_factor < 1.0 => {
                let value = format!("maintenance factor {maintenance_factor}");
                return Some(Setting { name: format!("translucent {}", m.name), value, why: "as the scene says".into() });
            }
            _ => return None,
        };
        let surface = world.surfaces.list.iter().position(|s| s.material == material)?;
        let scatterer = world.scatterer(surface as u32)?;
        let [back, front] = [false, true]
            .map(|side| (scatterer.hemispherical(side), scatterer.reflectance(side) * scatterer.stays(side)));
        let normal = scene.axes.to_user(world.surfaces.list[surface].normal);
        let value = format!(
            "hemispherical transmittance from the front {:.4}, from the back {:.4}, reflectance front {:.4}, back {:.4}; front of its first face towards [{:.3}, {:.3}, {:.3}]",
            front.0, back.0, front.1, back.1, normal.x, normal.y, normal.z
        );
        let why =
            format!("visible data of its file, maintenance factor {maintenance_factor}; reflection is taken as diffuse");
        Some(Setting { name: format!("bsdf {}", m.name), value, why })
    })
}

/// What Klems's patches cannot hold, and what is not followed; does the sun shine?
pub(super) fn omissions(scene: &Scene, world: &World, is_sunny: bool) -> Vec<LeftOut> {
    if !world.has_bsdf() {
        return Vec::new();
    }
    let mut list = vec![LeftOut {
        what: "directions finer than the patches of a BSDF (10 to 15 degrees in Klems's full basis)".into(),
        bound: "no light is lost, but none has a sharp edge: a beam of the sun that passes a slit or a clear pane is spread over a whole patch".into(),
    }];
    if is_sunny {
        list.push(LeftOut {
            what: "sun that reaches a window with a BSDF by a mirror, a pane's reflection or another such window"
                .into(),
            bound: "at most the sun's illuminance on that window times what the way before it passes or reflects"
                .into(),
        });
    }
    if !scene.luminaires.is_empty() {
        list.push(LeftOut {
            what: "light of luminaires beyond windows with a BSDF".into(),
            bound: "what leaves by them is escaped or unexpanded flux of the energy balance".into(),
        });
    }
    list
}
