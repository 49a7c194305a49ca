//! Materials: the user's numbers into reflectances, transmittances and spectral radiances.
//!
//! Photometric quantities are scaled through V(λ), so that the stated lumens or candelas are exact. A
//! relative spectrum holds its end values, an absolute radiance is zero beyond its ends; without a stated
//! spectrum the light is equal-energy.

use std::f64::consts::PI;

use super::fenestration::{maintenance_factor, refuse_dirt};
use super::file::{At, EmissionDef, Kind, MaterialDef, Source, SpectrumDef, ValueDef};
use super::load::{Files, check_number};
use super::{Axes, Emission, Material, MaterialKind, fenestration, glazing, suggest};
use crate::spectrum::{self, Beyond, SpectralValue, Spectrum};
use crate::{Error, Result};

/// Above this the user is told how long the light lives.
const BRIGHT: f64 = 0.95;

/// Checks one material. `area_m2` is the area of all its faces; 0 if it is on none.
pub(crate) fn resolve(
    files: &mut Files<'_>,
    axes: Axes,
    name: &str,
    def: &At<MaterialDef>,
    area_m2: f64,
) -> Result<Material> {
    let kind = match def.value.kind.as_ref().map_or(Kind::Diffuse, |k| k.value) {
        Kind::Diffuse => diffuse(files, name, def)?,
        Kind::Bsdf => fenestration::element(files, axes, name, def)?,
        Kind::Glass => glazing::glass(files, name, def)?,
        Kind::Mirror => mirror(files, name, def)?,
        Kind::Translucent => translucent(files, name, def)?,
    };
    let emission = match &def.value.emission {
        Some(emission) => emit(files, name, emission, area_m2)?,
        None => None,
    };
    Ok(Material { name: name.to_owned(), kind, emission, outside: def.value.outside })
}

fn diffuse(files: &mut Files<'_>, name: &str, def: &At<MaterialDef>) -> Result<MaterialKind> {
    let m = &def.value;
    refuse(files.source, name, "diffuse", m.transmittance.as_ref().map(|t| t.offset), "transmittance")?;
    refuse(files.source, name, "diffuse", m.refractive_index.as_ref().map(|n| n.offset), "refractive_index")?;
    refuse_dirt(files, name, "diffuse", def)?;
    refuse(files.source, name, "diffuse", m.panes.as_ref().map(|p| p.offset), "panes")?;
    let front = match &m.reflectance {
        Some(value) => share(files, name, "reflectance", value)?,
        None if m.emission.is_some() => SpectralValue::Grey(0.0),
        None => return Err(missing(files.source, name, def, "reflectance")),
    };
    let back = match &m.reflectance_back {
        Some(value) => share(files, name, "reflectance_back", value)?,
        None => front.clone(),
    };
    warn_bright(files, name, front.max().max(back.max()));
    Ok(MaterialKind::Diffuse { front, back })
}

fn mirror(files: &mut Files<'_>, name: &str, def: &At<MaterialDef>) -> Result<MaterialKind> {
    let m = &def.value;
    let others = [
        (m.transmittance.as_ref().map(|t| t.offset), "transmittance"),
        (m.refractive_index.as_ref().map(|n| n.offset), "refractive_index"),
        (m.panes.as_ref().map(|p| p.offset), "panes"),
        (m.reflectance_back.as_ref().map(|r| r.offset), "reflectance_back"),
        (m.emission.as_ref().map(|e| e.offset), "emission"),
    ];
    for (offset, key) in others {
        refuse(files.source, name, "mirror", offset, key)?;
    }
    refuse_dirt(files, name, "mirror", def)?;
    let value = m.reflectance.as_ref().ok_or_else(|| missing(files.source, name, def, "reflectance"))?;
    let reflectance = share(files, name, "reflectance", value)?;
    warn_bright(files, name, reflectance.max());
    Ok(MaterialKind::Mirror { reflectance })
}

fn translucent(files: &mut Files<'_>, name: &str, def: &At<MaterialDef>) -> Result<MaterialKind> {
    let m = &def.value;
    let others = [
        (m.refractive_index.as_ref().map(|n| n.offset), "refractive_index"),
        (m.panes.as_ref().map(|p| p.offset), "panes"),
        (m.emission.as_ref().map(|e| e.offset), "emission"),
    ];
    for (offset, key) in others {
        refuse(files.source, name, "translucent", offset, key)?;
    }
    let needed =
        |value: &Option<At<ValueDef>>, key: &str| value.clone().ok_or_else(|| missing(files.source, name, def, key));
    let (passes, reflects) = (needed(&m.transmittance, "transmittance")?, needed(&m.reflectance, "reflectance")?);
    let transmittance = share(files, name, "transmittance", &passes)?;
    let front = share(files, name, "reflectance", &reflects)?;
    let back_def = m.reflectance_back.as_ref().unwrap_or(&reflects);
    let back = share(files, name, "reflectance_back", back_def)?;
    for (side, offset) in [(&front, reflects.offset), (&back, back_def.offset)] {
        if let Some((nm, sum)) = beyond_one(&transmittance, side) {
            let message = format!("material \"{name}\": transmittance and reflectance sum to {sum:.4} at {nm} nm");
            return Err(files.source.impossible(offset, message).mend("together they are at most 1"));
        }
    }
    let maintenance_factor = maintenance_factor(files, name, def)?;
    warn_bright(files, name, transmittance.max() + front.max().max(back.max()));
    Ok(MaterialKind::Translucent { front, back, transmittance, maintenance_factor })
}

/// Where two shares of the same light sum to more than one, by more than rounding to three digits explains.
pub(super) fn beyond_one(a: &SpectralValue, b: &SpectralValue) -> Option<(f64, f64)> {
    let (a, b) = (a.to_spectrum(), b.to_spectrum());
    let sums = a.knots_nm().iter().chain(b.knots_nm()).map(|nm| (*nm, a.at(*nm) + b.at(*nm)));
    sums.max_by(|p, q| p.1.total_cmp(&q.1)).filter(|(_, sum)| *sum > 1.0 + 1e-3)
}

/// A key that does not belong to this kind of material.
pub(super) fn refuse(source: Source<'_>, name: &str, kind: &str, offset: Option<usize>, key: &str) -> Result<()> {
    let Some(offset) = offset else { return Ok(()) };
    let mend = match key {
        "transmittance" => "set kind = \"glass\" (clear) or \"translucent\" (diffusing), or remove the key",
        "maintenance_factor" => "dirt lies on glass, translucent sheets and bsdf windows alone: remove the key",
        "refractive_index" | "panes" => "set kind = \"glass\", or remove the key",
        "emission" => "only diffuse faces emit: give the lamp a face of its own",
        _ => "remove the key, or choose another kind",
    };
    Err(source.malformed(offset, format!("material \"{name}\": a {kind} material has no `{key}`")).mend(mend))
}

pub(super) fn missing(source: Source<'_>, name: &str, def: &At<MaterialDef>, key: &str) -> Error {
    source
        .malformed(def.offset, format!("material \"{name}\" has no `{key}`"))
        .mend(format!("add {key} = 0.5 (or [r, g, b], or a spectrum file)"))
}

fn warn_bright(files: &mut Files<'_>, name: &str, most: f64) {
    if most >= 1.0 {
        files.warnings.push(format!(
            "material \"{name}\": reflectance 1 absorbs nothing: a closed room of it has no finite solution"
        ));
    } else if most > BRIGHT {
        let gain = 1.0 / (1.0 - most);
        files.warnings.push(format!(
            "material \"{name}\": reflectance {most} multiplies light up to {gain:.0} times between such walls"
        ));
    }
}

/// A value that must lie within 0 to 1 in every channel and sample.
pub(super) fn share(files: &mut Files<'_>, name: &str, key: &str, def: &At<ValueDef>) -> Result<SpectralValue> {
    let value = match &def.value {
        ValueDef::Number(v) => SpectralValue::Grey(*v),
        ValueDef::Rgb(rgb) => SpectralValue::Rgb(*rgb),
        ValueDef::File(file) => {
            SpectralValue::Spectrum(curve(files, &At { value: file.clone(), offset: def.offset }, Beyond::Hold)?)
        }
    };
    for (v, place) in samples(&value) {
        let wrong = if v > 1.0 {
            "exceeds 1"
        } else if v < 0.0 {
            "is negative"
        } else if v.is_nan() {
            "is no number"
        } else {
            continue;
        };
        let message = format!("material \"{name}\": {key} {v}{place} {wrong}");
        return Err(files
            .source
            .impossible(def.offset, message)
            .mend("give shares from 0 to 1; measured tables above 1 usually are percent or fluorescent"));
    }
    Ok(value)
}

/// All given numbers of a value, each with words for its place.
fn samples(value: &SpectralValue) -> Vec<(f64, String)> {
    match value {
        SpectralValue::Grey(v) => vec![(*v, String::new())],
        SpectralValue::Rgb(rgb) => {
            rgb.iter().zip(["red", "green", "blue"]).map(|(v, c)| (*v, format!(" ({c} channel)"))).collect()
        }
        SpectralValue::Spectrum(s) => s.knots_nm().iter().map(|nm| (s.at(*nm), format!(" at {nm} nm"))).collect(),
    }
}

/// A spectrum from a CSV file beside the scene file.
fn curve(files: &mut Files<'_>, name: &At<String>, beyond: Beyond) -> Result<Spectrum> {
    let bytes = files.read(name)?;
    Spectrum::from_csv_bytes(&bytes, beyond).map_err(|e| e.in_file(files.path(&name.value)))
}

/// The emission of a material on `area_m2` of faces; none where it is on no face.
fn emit(files: &mut Files<'_>, name: &str, def: &At<EmissionDef>, area_m2: f64) -> Result<Option<Emission>> {
    let e = &def.value;
    let two_sided = e.two_sided;
    let owner = format!("material \"{name}\"");
    let relative = match &e.spectrum {
        Some(spectrum) => relative(files, &owner, spectrum)?,
        None => Spectrum::constant(1.0),
    };
    if let Some(file) = &e.radiance {
        only(files.source, name, def, 1)?;
        if let Some(spectrum) = &e.spectrum {
            return Err(files
                .source
                .malformed(spectrum.offset, format!("material \"{name}\": `radiance` is a spectrum already"))
                .mend("remove `spectrum`"));
        }
        let radiance = curve(files, file, Beyond::Zero)?;
        check_curve(files.source, &owner, file.offset, &radiance)?;
        warn_dark(files, name, radiance.max());
        return Ok(Some(Emission { radiance, two_sided, group: e.group.clone() }));
    }
    let (luminance, offset) = luminance(files.source, name, def, area_m2)?;
    if !luminance.is_finite() {
        return Ok(None); // on no face
    }
    let per_unit = relative.luminous();
    if !(per_unit > 0.0 && per_unit.is_finite()) {
        return Err(files
            .source
            .impossible(offset, format!("material \"{name}\": its spectrum holds no visible light to scale"))
            .mend("state `radiance` in W/(m² sr nm) for light outside the visible range"));
    }
    warn_dark(files, name, luminance);
    Ok(Some(Emission { radiance: relative.scaled(luminance / per_unit), two_sided, group: e.group.clone() }))
}

fn warn_dark(files: &mut Files<'_>, name: &str, most: f64) {
    if most == 0.0 {
        files.warnings.push(format!("material \"{name}\": its emission is zero"));
    }
}

/// Exactly one of the four quantities.
fn only(source: Source<'_>, name: &str, def: &At<EmissionDef>, wanted: usize) -> Result<()> {
    let e = &def.value;
    let given = [e.luminance_cd_m2.is_some(), e.exitance_lm_m2.is_some(), e.flux_lm.is_some(), e.radiance.is_some()];
    if given.iter().filter(|g| **g).count() == wanted {
        return Ok(());
    }
    Err(source
        .malformed(
            def.offset,
            format!("material \"{name}\": its emission states {} quantities", given.iter().filter(|g| **g).count()),
        )
        .mend("state exactly one of luminance_cd_m2, exitance_lm_m2, flux_lm, radiance"))
}

/// Luminance, cd/m², and where it stands; not finite where a flux has no face to leave from.
fn luminance(source: Source<'_>, name: &str, def: &At<EmissionDef>, area_m2: f64) -> Result<(f64, usize)> {
    only(source, name, def, 1)?;
    let e = &def.value;
    let sides = if e.two_sided { 2.0 } else { 1.0 };
    let quantities = [
        (&e.luminance_cd_m2, "luminance_cd_m2", 1.0),
        (&e.exitance_lm_m2, "exitance_lm_m2", PI),
        (&e.flux_lm, "flux_lm", PI * area_m2 * sides),
    ];
    for (quantity, key, per_luminance) in quantities {
        let Some(q) = quantity else { continue };
        check_number(source, Some(q), key)?;
        if q.value < 0.0 {
            return Err(source
                .impossible(q.offset, format!("material \"{name}\": {key} = {} is negative", q.value))
                .mend("light cannot be taken away"));
        }
        let luminance = if per_luminance == 0.0 { f64::INFINITY } else { q.value / per_luminance };
        return Ok((luminance, q.offset));
    }
    Err(Error::new(crate::error::ErrorKind::Internal, "an emission without a quantity"))
}

/// The relative spectrum asked for; `owner` says by whom.
pub(super) fn relative(files: &mut Files<'_>, owner: &str, def: &At<SpectrumDef>) -> Result<Spectrum> {
    match &def.value {
        SpectrumDef::Kelvin(kelvin) => spectrum::from_cct(*kelvin).map_err(|e| files.source.place(def.offset, e)),
        SpectrumDef::Name(text) if text.to_lowercase().ends_with(".csv") => {
            let curve = curve(files, &At { value: text.clone(), offset: def.offset }, Beyond::Hold)?;
            check_curve(files.source, owner, def.offset, &curve)?;
            Ok(curve)
        }
        SpectrumDef::Name(text) => spectrum::illuminant(text).ok_or_else(|| {
            files
                .source
                .malformed(def.offset, format!("{owner}: unknown illuminant `{text}`"))
                .mend(suggest::mend(text, spectrum::illuminant_names()))
        }),
    }
}

fn check_curve(source: Source<'_>, owner: &str, offset: usize, curve: &Spectrum) -> Result<()> {
    if curve.min() >= 0.0 {
        return Ok(());
    }
    Err(source
        .impossible(offset, format!("{owner}: its spectrum is negative somewhere ({})", curve.min()))
        .mend("set noise below zero to zero"))
}
