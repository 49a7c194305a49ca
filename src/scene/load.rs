//! The reader: scene file in, [`Scene`] out.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;
use sha2::{Digest, Sha256};

use super::faces::{self, Drawn, Names, Place};
use super::file::{self, At, BandsDef, DivisionDef, GridDef, Kind, ModeDef, ModeName, SceneFile, Source, Up};
use super::obj::{self, Obj};
use super::{
    Axes, Face, InputFile, MaterialKind, Receiver, Scene, dimming, fenestration, grid, luminaire, material,
    requirement, shells, sky, suggest, usage, view,
};
use crate::error::ErrorKind;
use crate::spectrum::BandMode;
use crate::{Error, Result};

/// Reads and checks a scene file with all the files that it names.
///
/// # Errors
/// Whatever is malformed, impossible or not built, with file, line and mend.
pub fn load(path: &Path) -> Result<Scene> {
    let bytes = read(path)?;
    let text = super::text(&bytes).map_err(|e| e.in_file(path))?;
    let source = Source { path, text };
    let file = file::parse(source)?;
    refuse_bsdf_keys(source, &file)?;
    let mut files = Files::new(source, &bytes);
    let axes = match file.geometry.value.up {
        Up::Z => Axes::ZUp,
        Up::Y => Axes::YUp,
    };
    check_number(source, file.geometry.value.north_deg.as_ref(), "north_deg")?;
    let drawing = draw(&mut files, &file, axes)?;
    let (faces, told) = face_list(&mut files, &file, &drawing)?;
    files.warnings.extend(told);
    files.warnings.extend(shells::penetrations(&faces, &drawing.objects));
    warn_size(&mut files, &file, &faces);
    let materials = materials(&mut files, &file, axes, &drawing, &faces)?;
    let bands = bands(source, file.bands.as_ref())?;
    check_names(source, &file)?;
    let stage = grid::Stage { faces: &faces, objects: &drawing.objects, materials: &drawing.materials, axes };
    let mut grids = Vec::new();
    for def in &file.grids {
        grids.push(grid::resolve(&mut files, &stage, &def.value)?);
    }
    let mut modelling = Vec::new();
    for (number, def) in file.grids.iter().enumerate() {
        for companion in grid::companions(source, axes, &def.value, &grids[number])? {
            if companion.receiver == Receiver::Cylinder {
                modelling.push((number, grids.len()));
            }
            grids.push(companion);
        }
    }
    let mut views = Vec::new();
    for def in &file.views {
        views.push(view::resolve(&mut files, axes, &def.value)?);
    }
    let mut luminaires = Vec::new();
    for def in &file.luminaires {
        luminaires.push(luminaire::resolve(&mut files, axes, def)?);
    }
    let north_deg = file.geometry.value.north_deg.as_ref().map_or(0.0, |n| n.value);
    let daytime = sky::resolve(&mut files, file.sky.as_ref(), file.site.as_ref(), north_deg)?;
    let states = dimming::resolve(&files, &file)?;
    let requirements = requirement::resolve(&files, &file, &states)?;
    let power = requirement::power(&files, &stage, &file)?;
    let occupancy = usage::occupancy(&mut files, file.annual.as_ref())?;
    let blinds = usage::blinds(&mut files, &file.blinds, &materials, &drawing.objects)?;
    let title = file.title.unwrap_or_else(|| stem(path));
    Ok(Scene {
        title,
        faces,
        objects: drawing.objects,
        materials,
        bands,
        grids,
        views,
        daytime,
        luminaires,
        modelling,
        observers: (0..file.grids.len()).filter(|g| file.grids[*g].value.ugr).collect(),
        requirements,
        power,
        states,
        occupancy,
        blinds,
        axes,
        inputs: files.inputs,
        warnings: files.warnings,
    })
}

/// Reads a file; one that is not there is the user's trouble, not the disk's.
fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|e| unreadable(path, &e))
}

fn unreadable(path: &Path, cause: &std::io::Error) -> Error {
    match cause.kind() {
        std::io::ErrorKind::NotFound => Error::malformed("no such file").mend("check the name").in_file(path),
        std::io::ErrorKind::IsADirectory => Error::malformed("a folder, not a file").in_file(path),
        _ => Error::io(path, cause),
    }
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "scene".to_owned(), |s| s.to_string_lossy().into_owned())
}

/// The files beside the scene file: reads them, remembers their hashes, collects warnings.
#[derive(Debug)]
pub(crate) struct Files<'a> {
    pub(crate) source: Source<'a>,
    pub(crate) inputs: Vec<InputFile>,
    pub(crate) warnings: Vec<String>,
}

impl<'a> Files<'a> {
    fn new(source: Source<'a>, bytes: &[u8]) -> Self {
        let name = source.path.file_name().map_or_else(|| source.path.to_path_buf(), PathBuf::from);
        Self { source, inputs: vec![InputFile { path: name, sha256: hash(bytes) }], warnings: Vec::new() }
    }

    /// Path of a file named in the scene.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.source.path.parent().unwrap_or_else(|| Path::new("")).join(name)
    }

    /// Bytes of a file named in the scene.
    pub(crate) fn read(&mut self, name: &At<String>) -> Result<Vec<u8>> {
        let path = self.path(&name.value);
        let bytes = std::fs::read(&path).map_err(|e| match e.kind() {
            std::io::ErrorKind::NotFound => self
                .source
                .malformed(name.offset, format!("no such file: `{}`", name.value))
                .mend("names are relative to the scene file"),
            _ => unreadable(&path, &e),
        })?;
        let input = InputFile { path: PathBuf::from(&name.value), sha256: hash(&bytes) };
        if !self.inputs.contains(&input) {
            self.inputs.push(input);
        }
        Ok(bytes)
    }
}

fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// A number that has to be finite, if it is there.
pub(crate) fn check_number(source: Source<'_>, number: Option<&At<f64>>, key: &str) -> Result<()> {
    match number {
        Some(n) if !n.value.is_finite() || n.value.abs() > obj::LARGEST => {
            Err(source
                .malformed(n.offset, format!("{key} = {} is not a finite number below {:e}", n.value, obj::LARGEST)))
        }
        _ => Ok(()),
    }
}

/// A vector of finite numbers.
pub(crate) fn vector(source: Source<'_>, v: &At<[f64; 3]>, key: &str) -> Result<DVec3> {
    if v.value.iter().any(|x| !x.is_finite() || x.abs() > obj::LARGEST) {
        return Err(
            source.malformed(v.offset, format!("{key} holds a number that is not finite or beyond {:e}", obj::LARGEST))
        );
    }
    Ok(DVec3::from(v.value))
}

/// A unit vector along `v`, whatever its magnitude.
pub(crate) fn unit_vector(source: Source<'_>, v: &At<[f64; 3]>, key: &str) -> Result<DVec3> {
    let d = vector(source, v, key)?;
    let d = d / d.abs().max_element();
    d.try_normalize().ok_or_else(|| source.malformed(v.offset, format!("{key} is zero: it gives no direction")))
}

/// Keys of a BSDF's file belong to no other kind.
fn refuse_bsdf_keys(source: Source<'_>, file: &SceneFile) -> Result<()> {
    for (name, def) in &file.materials {
        let m = &def.value;
        if m.kind.as_ref().is_some_and(|k| k.value == Kind::Bsdf) {
            continue;
        }
        for (offset, key) in [(m.file.as_ref().map(|f| f.offset), "file"), (m.up.as_ref().map(|u| u.offset), "up")] {
            if let Some(offset) = offset {
                let message = format!("material \"{name}\": `{key}` belongs to kind = \"bsdf\"");
                return Err(source.malformed(offset, message).mend("set that kind, or remove the key"));
            }
        }
    }
    Ok(())
}

/// All polygons of all files, with the names they use.
#[derive(Debug, Default)]
struct Drawing {
    polygons: Vec<Drawn>,
    files: Vec<String>,
    objects: Vec<String>,
    materials: Vec<String>,
}

fn draw(files: &mut Files<'_>, file: &SceneFile, axes: Axes) -> Result<Drawing> {
    let mut drawing = Drawing::default();
    let geometry = &file.geometry.value;
    if geometry.files.is_empty() {
        return Err(files
            .source
            .malformed(file.geometry.offset, "no geometry: `files` is empty")
            .mend("name at least one OBJ file"));
    }
    for name in &geometry.files {
        let bytes = files.read(name)?;
        let path = files.path(&name.value);
        let obj = obj::parse(&bytes).map_err(|e| e.in_file(&path))?;
        check_materials(files.source, file, &obj, &path)?;
        warn_obj(files, &obj, name, &path);
        drawing.add(obj, &name.value, |p| axes.to_internal(geometry.unit.to_metres(p)));
    }
    Ok(drawing)
}

/// Every `usemtl` name must be described.
fn check_materials(source: Source<'_>, file: &SceneFile, obj: &Obj, path: &Path) -> Result<()> {
    let known: Vec<&str> = file.materials.keys().map(String::as_str).collect();
    for (i, (name, line)) in obj.materials.iter().enumerate() {
        let used = obj.polygons.iter().any(|p| p.material == i);
        if used && !file.materials.contains_key(name) {
            let mend = match suggest::nearest(name, known.iter().copied()) {
                Some(near) => {
                    format!("did you mean `{near}`? Otherwise add [materials.{name}] to {}", source.path.display())
                }
                None => format!("add [materials.{name}] to {}", source.path.display()),
            };
            return Err(Error::malformed(format!("material `{name}` is not described in the scene file"))
                .mend(mend)
                .in_file(path)
                .at_line(*line));
        }
    }
    Ok(())
}

fn warn_obj(files: &mut Files<'_>, obj: &Obj, name: &At<String>, path: &Path) {
    for (word, (line, count)) in &obj.skipped {
        files.warnings.push(format!("{}:{line}: {count} `{word}` record(s) not read: only polygons are", name.value));
    }
    if let Some(library) = obj::library_found(obj, path.parent().unwrap_or_else(|| Path::new(""))) {
        let library = library.file_name().unwrap_or_default().to_string_lossy().into_owned();
        files.warnings.push(format!("{}: {library} is not read: materials come from the scene file", name.value));
    }
}

impl Drawing {
    fn add(&mut self, obj: Obj, file: &str, place: impl Fn(DVec3) -> DVec3) {
        let file_index = self.files.len();
        self.files.push(file.to_owned());
        let mut objects = Interned::new(&mut self.objects, obj.objects.iter());
        let mut materials = Interned::new(&mut self.materials, obj.materials.iter().map(|(name, _)| name));
        self.polygons.extend(obj.polygons.into_iter().map(|p| Drawn {
            ring: p.ring.into_iter().map(&place).collect(),
            material: materials.index(p.material),
            object: objects.index(p.object),
            place: Place { file: file_index, line: p.line },
        }));
    }
}

/// A file's names in the scene's list; a name enters it when it is first used.
struct Interned<'a> {
    all: &'a mut Vec<String>,
    local: Vec<(&'a String, Option<usize>)>,
}

impl<'a> Interned<'a> {
    fn new(all: &'a mut Vec<String>, local: impl Iterator<Item = &'a String>) -> Self {
        Self { all, local: local.map(|name| (name, None)).collect() }
    }

    fn index(&mut self, local: usize) -> usize {
        let (name, known) = &mut self.local[local];
        *known.get_or_insert_with(|| {
            self.all.iter().position(|n| n == *name).unwrap_or_else(|| {
                self.all.push(name.clone());
                self.all.len() - 1
            })
        })
    }
}

fn face_list(files: &mut Files<'_>, file: &SceneFile, drawing: &Drawing) -> Result<(Vec<Face>, Vec<String>)> {
    let emits: Vec<bool> = drawing
        .materials
        .iter()
        .map(|name| file.materials.get(name).is_some_and(|m| m.value.emission.is_some()))
        .collect();
    let names = Names { files: &drawing.files, objects: &drawing.objects, materials: &drawing.materials };
    let (faces, told) = faces::build(&drawing.polygons, names, &emits);
    if faces.is_empty() {
        let message = format!("no geometry: none of the {} faces has an area", drawing.polygons.len());
        return Err(files
            .source
            .place(file.geometry.offset, Error::impossible(message))
            .mend("check `unit` and the export"));
    }
    Ok((faces, told))
}

fn warn_size(files: &mut Files<'_>, file: &SceneFile, faces: &[Face]) {
    let Some((lo, hi)) = faces::bounds(faces) else {
        return;
    };
    let size = (hi - lo).max_element();
    if !(0.01..=1000.0).contains(&size) {
        let unit = format!("{:?}", file.geometry.value.unit).to_lowercase();
        files.warnings.push(format!("the scene is {size:.3e} m across: is unit = \"{unit}\" right?"));
    }
}

/// Materials in the order of [`Drawing::materials`].
fn materials(
    files: &mut Files<'_>,
    file: &SceneFile,
    axes: Axes,
    drawing: &Drawing,
    faces: &[Face],
) -> Result<Vec<super::Material>> {
    let mut areas = vec![0.0; drawing.materials.len()];
    for face in faces {
        areas[face.material] += face.area_m2;
    }
    // All are checked, in the order of the file; those in use are kept.
    let mut in_order: Vec<_> = file.materials.iter().collect();
    in_order.sort_by_key(|(_, def)| def.offset);
    let mut resolved = BTreeMap::new();
    for (name, def) in in_order {
        let index = drawing.materials.iter().position(|n| n == name);
        let area = index.map_or(0.0, |i| areas[i]);
        if area == 0.0 {
            files.warnings.push(format!("material \"{name}\" is on no face"));
        }
        let material = material::resolve(files, axes, name, def, area)?;
        if let MaterialKind::Bsdf { up, .. } = &material.kind {
            let own: Vec<&Face> = faces.iter().filter(|f| Some(f.material) == index).collect();
            fenestration::check_up(files, name, def, *up, &own)?;
        }
        resolved.insert(name.as_str(), material);
    }
    let internal = || Error::new(ErrorKind::Internal, "a material was lost");
    drawing.materials.iter().map(|name| resolved.get(name.as_str()).cloned().ok_or_else(internal)).collect()
}

fn bands(source: Source<'_>, def: Option<&BandsDef>) -> Result<BandMode> {
    let Some(mode) = def.and_then(|b| b.mode.as_ref()) else {
        return Ok(BandMode::Auto);
    };
    match &mode.value {
        ModeDef::Name(ModeName::Auto) => Ok(BandMode::Auto),
        ModeDef::Name(ModeName::Grey) => Ok(BandMode::Grey),
        ModeDef::Name(ModeName::Rgb) => Ok(BandMode::Rgb),
        ModeDef::Division(division) => self::division(division).map_err(|e| source.place(mode.offset, e)),
    }
}

/// Shortest and longest wavelength that bands may reach, nm.
const RANGE_NM: (f64, f64) = (100.0, 10_000.0);
/// Most bands.
const MOST_BANDS: f64 = 1000.0;

fn division(def: &DivisionDef) -> Result<BandMode> {
    let reach = |lo: f64, hi: f64| RANGE_NM.0 <= lo && lo < hi && hi <= RANGE_NM.1;
    match def {
        DivisionDef { step_nm: Some(step_nm), range_nm: Some([lo_nm, hi_nm]), edges_nm: None } => {
            let (step_nm, lo_nm, hi_nm) = (*step_nm, *lo_nm, *hi_nm);
            if !reach(lo_nm, hi_nm) {
                return Err(Error::malformed(format!(
                    "range_nm = [{lo_nm}, {hi_nm}] is no rising range within 100 to 10000 nm"
                )));
            }
            let count = (hi_nm - lo_nm) / step_nm;
            if !(1.0 - 1e-9..=MOST_BANDS).contains(&count) {
                return Err(Error::malformed(format!(
                    "step_nm = {step_nm} does not divide the range into 1 to {MOST_BANDS} bands"
                )));
            }
            Ok(BandMode::Step { step_nm, lo_nm, hi_nm })
        }
        DivisionDef { step_nm: None, range_nm: None, edges_nm: Some(edges) } => {
            let rising = edges.windows(2).all(|w| reach(w[0], w[1]));
            if edges.len() < 2 || edges.len() as f64 > MOST_BANDS || !rising {
                return Err(Error::malformed("edges_nm needs 2 to 1000 rising wavelengths within 100 to 10000 nm"));
            }
            Ok(BandMode::Edges(edges.clone()))
        }
        _ => Err(Error::malformed("a division wants `step_nm` with `range_nm`, or `edges_nm` alone")),
    }
}

/// Names become file names: they must be usable and different.
fn check_names(source: Source<'_>, file: &SceneFile) -> Result<()> {
    let companions = |def: &GridDef| -> Vec<At<String>> {
        let list = [(def.cylindrical, grid::CYLINDRICAL), (def.semicylindrical.is_some(), grid::SEMICYLINDRICAL)];
        let named = |(_, ending)| At { value: format!("{}{ending}", def.name.value), offset: def.name.offset };
        list.into_iter().filter(|c| c.0).map(named).collect()
    };
    let others: Vec<At<String>> = file.grids.iter().flat_map(|g| companions(&g.value)).collect();
    let others = others.iter().map(|name| (name, "grid"));
    let grids = file.grids.iter().map(|g| (&g.value.name, "grid")).chain(others);
    let views = file.views.iter().map(|v| (&v.value.name, "view"));
    let mut taken: BTreeMap<String, &str> = BTreeMap::new();
    for (name, kind) in grids.chain(views) {
        let text = name.value.as_str();
        if text.trim().is_empty() {
            return Err(source.malformed(name.offset, format!("the name of a {kind} is empty")));
        }
        let odd = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
        if text.contains(odd) || text.starts_with('.') || text.len() > 100 {
            return Err(source
                .malformed(name.offset, format!("the name {text:?} of a {kind} cannot be a file name"))
                .mend("use letters, digits, blanks, - and _; 100 at most"));
        }
        let mut files = vec![text.to_lowercase()];
        if kind == "view" {
            files.push(format!("{}_luminance", text.to_lowercase()));
        }
        for stem in files {
            if let Some(other) = taken.insert(stem, kind) {
                return Err(source
                    .malformed(name.offset, format!("the name \"{text}\" is taken by a {other} already"))
                    .mend("grids and views share the folder of results: give each its own name"));
            }
        }
    }
    Ok(())
}
