//! OBJ files: polygons with material, object and line.
//!
//! Every record is checked here first, because an error has to name its line; what passes is handed to
//! [`tobj`] in a canonical form (positions, faces, objects and numbered materials only). Texture
//! coordinates, normals and material libraries are not used. A backslash at a line's end continues it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::{Error, Result};

/// Coordinates beyond this cannot be meant; squares and cubes of them stay finite.
pub(crate) const LARGEST: f64 = 1e12;

/// One `f` record.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Polygon {
    /// In the file's unit and axes.
    pub(crate) ring: Vec<DVec3>,
    /// Index into [`Obj::materials`].
    pub(crate) material: usize,
    /// Index into [`Obj::objects`].
    pub(crate) object: usize,
    /// Line of the record.
    pub(crate) line: usize,
}

/// What an OBJ file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Obj {
    pub(crate) polygons: Vec<Polygon>,
    /// `usemtl` names with the line of their first use by a face.
    pub(crate) materials: Vec<(String, usize)>,
    pub(crate) objects: Vec<String>,
    /// Material libraries named.
    pub(crate) libraries: Vec<String>,
    /// Records that are lawful but not read (curves, surfaces, lines), with the first line.
    pub(crate) skipped: BTreeMap<String, (usize, usize)>,
}

/// Records that carry nothing we need.
const SILENT: &[&str] = &[
    "vt",
    "vn",
    "s",
    "mg",
    "usemap",
    "maplib",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
    "end",
];
/// Records that carry geometry that we do not read.
const SKIPPED: &[&str] = &[
    "l", "p", "vp", "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp",
    "con", "ctech", "stech", "call", "csh",
];

/// The checked records, ready for tobj.
#[derive(Default)]
struct Scan {
    obj: Obj,
    /// Canonical text.
    canonical: String,
    vertices: usize,
    material: Option<usize>,
    object: usize,
    /// Line, material and object of every face.
    faces: Vec<(usize, usize, usize)>,
    material_ids: BTreeMap<String, usize>,
    object_ids: BTreeMap<String, usize>,
}

/// Reads an OBJ file's bytes.
///
/// # Errors
/// Anything that is not a well-formed polygon soup with a material on every face, with its line.
pub(crate) fn parse(bytes: &[u8]) -> Result<Obj> {
    let text = super::text(bytes)?;
    let mut scan = Scan::default();
    scan.use_object("unnamed");
    for (line, record) in logical_lines(text) {
        scan.record(line, &record).map_err(|e| e.at_line(line))?;
    }
    if scan.faces.is_empty() {
        return Err(
            Error::malformed("no faces: the file holds no `f` record").mend("export polygons, not curves or points")
        );
    }
    scan.finish()
}

/// Lines with comments off and continuations joined, with the number of their first line.
fn logical_lines(text: &str) -> impl Iterator<Item = (usize, String)> + '_ {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (number, first) = lines.next()?;
        let mut joined = without_comment(first).to_owned();
        while joined.trim_end().ends_with('\\') {
            joined.truncate(joined.trim_end().len() - 1);
            let Some((_, more)) = lines.next() else { break };
            joined.push(' ');
            joined.push_str(without_comment(more));
        }
        Some((number + 1, joined))
    })
}

fn without_comment(line: &str) -> &str {
    line.split('#').next().unwrap_or_default()
}

impl Scan {
    fn record(&mut self, line: usize, record: &str) -> Result<()> {
        let record = record.trim();
        let (word, rest) = record.split_once(char::is_whitespace).unwrap_or((record, ""));
        let rest = rest.trim();
        match word {
            "" => {}
            "v" => self.vertex(rest)?,
            "f" | "fo" => self.face(line, rest)?,
            "o" | "g" => self.use_object(if rest.is_empty() { "unnamed" } else { rest }),
            "usemtl" => self.use_material(line, rest)?,
            "mtllib" => self.obj.libraries.push(rest.to_owned()),
            _ if SILENT.contains(&word) => {}
            _ if SKIPPED.contains(&word) => self.skip(line, word),
            _ => return Err(unknown_record(word)),
        }
        Ok(())
    }

    fn skip(&mut self, line: usize, word: &str) {
        self.obj.skipped.entry(word.to_owned()).or_insert((line, 0)).1 += 1;
    }

    fn vertex(&mut self, rest: &str) -> Result<()> {
        let words: Vec<&str> = rest.split_whitespace().collect();
        if words.len() < 3 {
            return Err(Error::malformed(format!("a vertex needs three coordinates, found {}", words.len())));
        }
        for word in &words[..3] {
            let x: f64 = word.parse().map_err(|_| Error::malformed(format!("coordinate `{word}` is not a number")))?;
            if !x.is_finite() || x.abs() > LARGEST {
                return Err(Error::malformed(format!("coordinate {word} is not a finite number below {LARGEST:e}"))
                    .mend("export the model again: such a vertex has no place"));
            }
        }
        self.vertices += 1;
        self.canonical.push_str(&format!("v {} {} {}\n", words[0], words[1], words[2]));
        Ok(())
    }

    fn face(&mut self, line: usize, rest: &str) -> Result<()> {
        let corners: Vec<usize> = rest.split_whitespace().map(|word| self.corner(word)).collect::<Result<_>>()?;
        if corners.len() < 3 {
            return Err(Error::malformed(format!("a face needs at least three vertices, found {}", corners.len())));
        }
        let Some(material) = self.material else {
            return Err(Error::malformed("a face without a material: no `usemtl` comes before it")
                .mend("put `usemtl NAME` before the face and describe it under [materials.NAME]"));
        };
        self.canonical.push('f');
        for corner in corners {
            self.canonical.push_str(&format!(" {corner}"));
        }
        self.canonical.push('\n');
        self.faces.push((line, material, self.object));
        Ok(())
    }

    /// Absolute index, from one, of `3`, `-1`, `3/1`, `3//2`, `3/1/2`.
    fn corner(&self, word: &str) -> Result<usize> {
        let mut parts = word.split('/');
        let index = parts.next().unwrap_or_default();
        if word.split('/').count() > 3 || parts.any(|p| !p.is_empty() && p.parse::<i64>().is_err()) {
            return Err(Error::malformed(format!("`{word}` is not a vertex reference such as 3, 3/1 or 3/1/2")));
        }
        let index: i64 = index
            .parse()
            .map_err(|_| Error::malformed(format!("`{word}` is not a vertex reference such as 3, 3/1 or 3/1/2")))?;
        let count = self.vertices as i64;
        let absolute = if index < 0 { count.checked_add(index).map(|i| i + 1) } else { Some(index) };
        match absolute {
            Some(i) if (1..=count).contains(&i) => Ok(i as usize),
            _ => {
                Err(Error::malformed(format!("vertex {index} is out of range: {count} vertices come before this face"))
                    .mend("indices count from 1, or back from -1"))
            }
        }
    }

    fn use_object(&mut self, name: &str) {
        let next = self.object_ids.len();
        self.object = *self.object_ids.entry(name.to_owned()).or_insert(next);
        if self.object == next {
            self.obj.objects.push(name.to_owned());
        }
        self.canonical.push_str(&format!("o {}\n", self.object));
    }

    fn use_material(&mut self, line: usize, name: &str) -> Result<()> {
        if name.is_empty() {
            return Err(Error::malformed("`usemtl` without a name"));
        }
        let next = self.material_ids.len();
        let id = *self.material_ids.entry(name.to_owned()).or_insert(next);
        if id == next {
            self.obj.materials.push((name.to_owned(), line));
        }
        self.material = Some(id);
        self.canonical.push_str(&format!("usemtl {id}\n"));
        Ok(())
    }

    /// Hands the canonical text to tobj and joins its faces with our lines.
    fn finish(mut self) -> Result<Obj> {
        // tobj keeps a `usemtl` name only if a library defines it: give it one that defines all.
        let names: Vec<tobj::Material> = (0..self.obj.materials.len())
            .map(|i| tobj::Material { name: i.to_string(), ..Default::default() })
            .collect();
        let canonical = format!("mtllib all\n{}", self.canonical);
        let library =
            |_: &Path| Ok((names.clone(), names.iter().enumerate().map(|(i, m)| (m.name.clone(), i)).collect()));
        let options = tobj::LoadOptions::default();
        let (models, _) = tobj::load_obj_buf(&mut canonical.as_bytes(), &options, library)
            .map_err(|e| Error::malformed(format!("the OBJ reader refuses the file: {e}")))?;
        let rings = models.iter().flat_map(|m| rings(&m.mesh));
        for (ring, &(line, material, object)) in rings.zip(&self.faces) {
            self.obj.polygons.push(Polygon { ring, material, object, line });
        }
        if self.obj.polygons.len() != self.faces.len() {
            return Err(Error::new(crate::error::ErrorKind::Internal, "the OBJ reader lost faces"));
        }
        Ok(self.obj)
    }
}

/// The polygons of a tobj mesh, in order.
fn rings(mesh: &tobj::Mesh) -> Vec<Vec<DVec3>> {
    let vertex = |i: &u32| {
        let at = 3 * *i as usize;
        DVec3::new(mesh.positions[at], mesh.positions[at + 1], mesh.positions[at + 2])
    };
    if mesh.face_arities.is_empty() {
        return mesh.indices.chunks_exact(3).map(|t| t.iter().map(vertex).collect()).collect();
    }
    let mut rest = mesh.indices.as_slice();
    let mut rings = Vec::with_capacity(mesh.face_arities.len());
    for arity in &mesh.face_arities {
        let (ring, after) = rest.split_at(*arity as usize);
        rings.push(ring.iter().map(vertex).collect());
        rest = after;
    }
    rings
}

fn unknown_record(word: &str) -> Error {
    let shown: String = word.chars().take(20).collect();
    Error::malformed(format!("`{}` is not an OBJ record", shown.escape_debug()))
        .mend("expected v, f, o, g, usemtl ...; is this an OBJ file?")
}

/// The first material library that exists beside the OBJ file.
pub(crate) fn library_found(obj: &Obj, folder: &Path) -> Option<PathBuf> {
    obj.libraries.iter().map(|name| folder.join(name)).find(|path| path.is_file())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn error(text: &str) -> String {
        parse(text.as_bytes()).map_err(|e| e.in_file("a.obj")).unwrap_err().to_string()
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl wall\n";

    #[test]
    fn names_lines_and_relative_indices_are_kept() {
        let obj =
            parse(format!("{SQUARE}o box lid\nf -4 -3 -2 -1\nusemtl other one\nf 1/1/1 2//1 \\\n 3\n").as_bytes())
                .unwrap();
        assert_eq!(obj.materials, [("wall".to_owned(), 5), ("other one".to_owned(), 8)]);
        assert_eq!(obj.objects, ["unnamed", "box lid"]);
        let lines: Vec<_> = obj.polygons.iter().map(|p| (p.line, p.ring.len(), p.material, p.object)).collect();
        assert_eq!(lines, [(7, 4, 0, 1), (9, 3, 1, 1)]);
        assert_eq!(obj.polygons[0].ring[2], DVec3::new(1.0, 1.0, 0.0));
    }

    #[test]
    fn a_return_to_an_earlier_material_keeps_the_order() {
        let obj =
            parse(format!("{SQUARE}f 1 2 3\nusemtl b\nf 1 2 4\nusemtl wall\nf 2 3 4\nf 1 2 3 4\n").as_bytes()).unwrap();
        let got: Vec<_> = obj.polygons.iter().map(|p| (p.line, p.material, p.ring.len())).collect();
        assert_eq!(got, [(6, 0, 3), (8, 1, 3), (10, 0, 3), (11, 0, 4)]);
    }

    #[test]
    fn trouble_names_its_line_and_mend() {
        for (text, want) in [
            ("v 0 nan 0\n".to_owned(), "a.obj:1: coordinate nan is not a finite number"),
            ("\nv 0 inf 0\n".to_owned(), "a.obj:2:"),
            ("v 1 2\n".to_owned(), "a.obj:1: a vertex needs three coordinates, found 2"),
            ("v 1 2 x\n".to_owned(), "coordinate `x` is not a number"),
            (format!("{SQUARE}f 1 2 5\n"), "a.obj:6: vertex 5 is out of range: 4 vertices"),
            (format!("{SQUARE}f 0 1 2\n"), "vertex 0 is out of range"),
            (format!("{SQUARE}f -5 1 2\n"), "vertex -5 is out of range"),
            (format!("{SQUARE}f 1 2\n"), "at least three vertices, found 2"),
            (format!("{SQUARE}f 1 2 a/b\n"), "a.obj:6: `a/b` is not a vertex reference"),
            ("v 0 0 0\nf 1 1 1\n".to_owned(), "a.obj:2: a face without a material"),
            (SQUARE.to_owned(), "no faces"),
            (String::new(), "no faces"),
            ("hello\n".to_owned(), "a.obj:1: `hello` is not an OBJ record"),
        ] {
            let e = error(&text);
            assert!(e.contains(want), "{text:?} gave {e}");
        }
        let e = parse(b"# ok\n# \xff\n").unwrap_err().in_file("a.obj").to_string();
        assert!(e.contains("a.obj:2:") && e.contains("UTF-8"), "{e}");
    }

    proptest! {
        #[test]
        fn any_bytes_give_a_file_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = parse(&bytes);
        }

        #[test]
        fn any_records_give_a_file_or_an_error(text in "((v|f|o|g|usemtl|mtllib|vt|l|#)?( (-?[0-9]{1,3}|1/2|//|nan|1e999|\\\\))*\n){0,12}") {
            let _ = parse(text.as_bytes());
        }
    }
}
