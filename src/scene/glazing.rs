//! Glass: measured values of panes into a glazing unit that physics allows.

use super::fenestration::maintenance_factor;
use super::file::{At, MaterialDef, PaneDef, PanesDef, Source, ValueDef};
use super::load::Files;
use super::material::{beyond_one, missing, refuse, share};
use super::{GlassPane, MaterialKind, Panes};
use crate::Result;
use crate::spectrum::SpectralValue;

/// Window glass.
const GLASS_INDEX: f64 = 1.52;

/// A glass material.
pub(super) fn glass(files: &mut Files<'_>, name: &str, def: &At<MaterialDef>) -> Result<MaterialKind> {
    let m = &def.value;
    let others = [
        (m.reflectance.as_ref().map(|r| r.offset), "reflectance"),
        (m.reflectance_back.as_ref().map(|r| r.offset), "reflectance_back"),
        (m.emission.as_ref().map(|e| e.offset), "emission"),
    ];
    for (offset, key) in others {
        refuse(files.source, name, "glass", offset, key)?;
    }
    let refractive_index = refractive_index(files.source, name, m.refractive_index.as_ref())?;
    let maintenance_factor = maintenance_factor(files, name, def)?;
    let (count, offset) = match m.panes.as_ref().map(|p| (&p.value, p.offset)) {
        None => (1, def.offset),
        Some((PanesDef::Count(count), offset)) => (*count as usize, offset),
        Some((PanesDef::List(list), offset)) => {
            if let Some(whole) = &m.transmittance {
                let message = format!("material \"{name}\": each pane tells its transmittance, and the whole unit too");
                return Err(files.source.malformed(whole.offset, message).mend("remove one of the two"));
            }
            check_count(files.source, name, list.len(), offset)?;
            let list = list.iter().map(|p| pane(files, name, &p.value, refractive_index)).collect::<Result<_>>()?;
            return Ok(MaterialKind::Glass { panes: Panes::Listed(list), refractive_index, maintenance_factor });
        }
    };
    check_count(files.source, name, count, offset)?;
    let value = m.transmittance.as_ref().ok_or_else(|| missing(files.source, name, def, "transmittance"))?;
    let transmittance = clear_share(files, name, value, count, refractive_index)?;
    Ok(MaterialKind::Glass { panes: Panes::Alike { count, transmittance }, refractive_index, maintenance_factor })
}

/// Most panes of a unit.
const MOST_PANES: usize = 8;

fn check_count(source: Source<'_>, name: &str, count: usize, offset: usize) -> Result<()> {
    if (1..=MOST_PANES).contains(&count) {
        return Ok(());
    }
    let message = format!("material \"{name}\": {count} panes; a glazing unit has 1 to {MOST_PANES}");
    Err(source.malformed(offset, message).mend("panes = 2 is double glazing"))
}

/// The transmittance of uncoated panes: no more than they pass if nothing is absorbed.
fn clear_share(
    files: &mut Files<'_>,
    name: &str,
    value: &At<ValueDef>,
    count: usize,
    refractive_index: f64,
) -> Result<SpectralValue> {
    let transmittance = share(files, name, "transmittance", value)?;
    let most = clear_transmittance(count, refractive_index);
    if transmittance.max() <= most + 1e-9 {
        return Ok(transmittance);
    }
    let what = if count == 1 { "a clear pane".to_owned() } else { format!("{count} clear panes") };
    let message = format!(
        "material \"{name}\": transmittance {} is more than {what} of n = {refractive_index} can pass at normal incidence, {most:.4}",
        transmittance.max()
    );
    let mend = "give the measured transmittance at normal incidence (not the transmissivity), or list coated panes with their reflectances";
    Err(files.source.impossible(value.offset, message).mend(mend))
}

fn pane(files: &mut Files<'_>, name: &str, def: &PaneDef, refractive_index: f64) -> Result<GlassPane> {
    let value = &def.transmittance;
    let (front, back) = match (&def.reflectance_front, &def.reflectance_back) {
        (None, None) => {
            let transmittance = clear_share(files, name, value, 1, refractive_index)?;
            return Ok(GlassPane { transmittance, reflectance: None });
        }
        (Some(front), Some(back)) => (front, back),
        (Some(one), None) | (None, Some(one)) => {
            let message = format!("material \"{name}\": a coated pane needs the reflectances of both of its sides");
            let mend = "state reflectance_front and reflectance_back, or neither for uncoated glass";
            return Err(files.source.malformed(one.offset, message).mend(mend));
        }
    };
    let transmittance = share(files, name, "transmittance", value)?;
    let mut sides = Vec::new();
    for (key, side) in [("reflectance_back", back), ("reflectance_front", front)] {
        let reflectance = share(files, name, key, side)?;
        if let Some((nm, sum)) = beyond_one(&transmittance, &reflectance) {
            let message = format!("material \"{name}\": transmittance and {key} of a pane sum to {sum:.4} at {nm} nm");
            return Err(files.source.impossible(side.offset, message).mend("together they are at most 1"));
        }
        sides.push(reflectance);
    }
    let reflectance = sides.try_into().ok();
    Ok(GlassPane { transmittance, reflectance })
}

/// Normal transmittance of panes that absorb nothing, with all reflections between their faces (Stokes 1862):
/// T = (1 − r)/(1 + (2N − 1) r), r = ((n − 1)/(n + 1))².
fn clear_transmittance(panes: usize, n: f64) -> f64 {
    let r = ((n - 1.0) / (n + 1.0)).powi(2);
    (1.0 - r) / (1.0 + (2 * panes - 1) as f64 * r)
}

fn refractive_index(source: Source<'_>, name: &str, def: Option<&At<f64>>) -> Result<f64> {
    let Some(n) = def else { return Ok(GLASS_INDEX) };
    if (1.0..=4.0).contains(&n.value) {
        return Ok(n.value);
    }
    let message = format!("material \"{name}\": refractive index {} is not within 1 to 4", n.value);
    Err(source.impossible(n.offset, message).mend("window glass has 1.52"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clear_pane_of_window_glass_passes_92_percent() {
        // r = (0.52/2.52)² = 0.042580; (1 − r)/(1 + r)
        assert!((clear_transmittance(1, 1.52) - 0.918_318).abs() < 1e-6);
        assert_eq!(clear_transmittance(3, 1.0), 1.0);
    }
}
