//! From polygons as drawn to the faces that are solved.
//!
//! Cuts what is not convex and planar, leaves out what has no area or stands there twice, and says so: one
//! warning for each kind of trouble, with the count and the first place.

use std::collections::{BTreeSet, HashMap};

use glam::{DVec2, DVec3};

use super::Face;
use super::outline::{Welder, weld_tolerance};
use super::polygon::{self, Degeneracy, Shape};

/// A polygon as drawn, in metres and the program's axes.
#[derive(Clone, Debug)]
pub(crate) struct Drawn {
    pub(crate) ring: Vec<DVec3>,
    pub(crate) material: usize,
    pub(crate) object: usize,
    /// File and line, and the object, for messages.
    pub(crate) place: Place,
}

/// Where a polygon was drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// Index of the file.
    pub(crate) file: usize,
    /// Line in it.
    pub(crate) line: usize,
}

/// What messages call things.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Names<'a> {
    pub(crate) files: &'a [String],
    pub(crate) objects: &'a [String],
    pub(crate) materials: &'a [String],
}

impl Names<'_> {
    fn place(&self, face: &Placed) -> String {
        format!("{}:{} (object `{}`)", self.files[face.place.file], face.place.line, self.objects[face.face.object])
    }
}

/// A face and where it was drawn.
#[derive(Clone, Debug)]
struct Placed {
    face: Face,
    place: Place,
}

/// How often something was met, and where first.
#[derive(Debug, Default)]
struct Tally {
    count: usize,
    first: String,
}

impl Tally {
    fn add(&mut self, place: impl FnOnce() -> String) {
        if self.count == 0 {
            self.first = place();
        }
        self.count += 1;
    }

    fn warn(&self, warnings: &mut Vec<String>, singular: &str, plural: &str) {
        match self.count {
            0 => {}
            1 => warnings.push(format!("1 {singular}: {}", self.first)),
            n => warnings.push(format!("{n} {plural}; the first: {}", self.first)),
        }
    }
}

/// Makes faces of polygons. `emits` tells for each material whether it gives off light.
pub(crate) fn build(drawn: &[Drawn], names: Names<'_>, emits: &[bool]) -> (Vec<Face>, Vec<String>) {
    let mut warnings = Vec::new();
    let faces = cut(drawn, names, &mut warnings);
    let faces = without_duplicates(faces, names, emits, &mut warnings);
    warn_overlaps(&faces, names, &mut warnings);
    (faces.into_iter().map(|f| f.face).collect(), warnings)
}

fn cut(drawn: &[Drawn], names: Names<'_>, warnings: &mut Vec<String>) -> Vec<Placed> {
    let mut faces = Vec::with_capacity(drawn.len());
    let (mut repeated, mut flat, mut crossing, mut warped) = Default::default();
    let mut worst = (0.0, String::new());
    for d in drawn {
        let place = || format!("{}:{} (object `{}`)", names.files[d.place.file], d.place.line, names.objects[d.object]);
        match polygon::shape(&d.ring) {
            Shape::Convex(ring) => faces.push(placed(d, ring)),
            Shape::Degenerate(Degeneracy::Repeated) => Tally::add(&mut repeated, place),
            Shape::Degenerate(Degeneracy::Flat) => Tally::add(&mut flat, place),
            Shape::Pieces { pieces, deviation, excess } => {
                faces.extend(pieces.into_iter().map(|p| placed(d, p)));
                if excess > 1e-6 {
                    Tally::add(&mut crossing, place);
                }
                if deviation > polygon::TELL {
                    Tally::add(&mut warped, place);
                    if deviation > worst.0 {
                        let mm = 1e3 * deviation * polygon::size(&d.ring);
                        worst =
                            (deviation, format!("{}, by {mm:.3} mm, {:.2} % of its size", place(), 100.0 * deviation));
                    }
                }
            }
        }
    }
    repeated.warn(
        warnings,
        "face left out: it has fewer than three different vertices",
        "faces left out: they have fewer than three different vertices",
    );
    flat.warn(warnings, "face left out: it has no area", "faces left out: they have no area");
    crossing.warn(warnings, "polygon crosses itself", "polygons cross themselves");
    warped.first = worst.1;
    if warped.count > 1 {
        warnings.push(format!(
            "{} polygons are not planar and were split into triangles; the worst: {}",
            warped.count, warped.first
        ));
    } else {
        warped.warn(warnings, "polygon is not planar and was split into triangles", "");
    }
    faces
}

fn placed(drawn: &Drawn, vertices: Vec<DVec3>) -> Placed {
    let area = polygon::area_vector(&vertices);
    let face = Face {
        vertices,
        normal: area.normalize(),
        area_m2: area.length(),
        material: drawn.material,
        object: drawn.object,
    };
    Placed { face, place: drawn.place }
}

/// Least and greatest corner of all faces.
pub(crate) fn bounds<'a>(faces: impl IntoIterator<Item = &'a Face>) -> Option<(DVec3, DVec3)> {
    faces
        .into_iter()
        .flat_map(|f| &f.vertices)
        .fold(None, |b: Option<(DVec3, DVec3)>, p| Some(b.map_or((*p, *p), |(lo, hi)| (lo.min(*p), hi.max(*p)))))
}

fn bounds_of(faces: &[Placed]) -> (DVec3, DVec3) {
    bounds(faces.iter().map(|f| &f.face)).unwrap_or_default()
}

/// Keeps one of faces with the same vertices: the emitting one if there is one, else the first.
fn without_duplicates(faces: Vec<Placed>, names: Names<'_>, emits: &[bool], warnings: &mut Vec<String>) -> Vec<Placed> {
    let (lo, hi) = bounds_of(&faces);
    let mut welder = Welder::new(weld_tolerance(lo, hi));
    let mut seen: HashMap<Vec<usize>, usize> = HashMap::new();
    let mut kept: Vec<Placed> = Vec::with_capacity(faces.len());
    let (mut passive, mut emitting) = (Tally::default(), Tally::default());
    for face in faces {
        let mut key: Vec<usize> = face.face.vertices.iter().map(|p| welder.id(*p)).collect();
        key.sort_unstable();
        let Some(&at) = seen.get(&key) else {
            seen.insert(key, kept.len());
            kept.push(face);
            continue;
        };
        let (old, new) = (emits[kept[at].face.material], emits[face.face.material]);
        let tally = if old || new { &mut emitting } else { &mut passive };
        if new && !old {
            tally.add(|| twice(&face, &kept[at], names));
            kept[at] = face;
        } else {
            tally.add(|| twice(&kept[at], &face, names));
        }
    }
    passive.warn(warnings, "duplicate face left out", "duplicate faces left out");
    emitting.warn(
        warnings,
        "emitting face stands there twice: its light is emitted once",
        "emitting faces stand there twice: their light is emitted once",
    );
    kept
}

/// Names a kept face and its double, and what the double would have had different.
fn twice(kept: &Placed, dropped: &Placed, names: Names<'_>) -> String {
    let mut text = format!("{} stands where {} does", names.place(dropped), names.place(kept));
    let (a, b) = (kept.face.material, dropped.face.material);
    if a != b {
        text += &format!("; kept material `{}`, not `{}`", names.materials[a], names.materials[b]);
        if kept.face.normal.dot(dropped.face.normal) < 0.0 {
            text += " (a wall with two different sides wants `reflectance_back`)";
        }
    }
    text
}

/// Work allowed for the search for overlaps: pairs of faces looked at.
const MOST_PAIRS: usize = 4_000_000;

/// Warns of coplanar faces that face the same way and overlap.
fn warn_overlaps(faces: &[Placed], names: Names<'_>, warnings: &mut Vec<String>) {
    let (lo, hi) = bounds_of(faces);
    let size = (hi - lo).length();
    let mut tally = Tally::default();
    let mut told = BTreeSet::new();
    let mut work = 0;
    for mut group in coplanar_groups(faces, size) {
        let (u, v) = polygon::basis(faces[group[0]].face.normal);
        let flat = |i: usize| -> Vec<DVec2> {
            faces[i].face.vertices.iter().map(|p| DVec2::new((*p - lo).dot(u), (*p - lo).dot(v))).collect()
        };
        let boxes: HashMap<usize, (DVec2, DVec2)> = group.iter().map(|&i| (i, box_of(&flat(i)))).collect();
        group.sort_by(|a, b| boxes[a].0.x.total_cmp(&boxes[b].0.x));
        for (k, &i) in group.iter().enumerate() {
            for &j in group[k + 1..].iter().take_while(|j| boxes[*j].0.x < boxes[&i].1.x) {
                work += 1;
                if work > MOST_PAIRS {
                    warnings.push("too many faces share a plane: the search for overlaps stopped early".to_owned());
                    return tally.warn(
                        warnings,
                        "pair of faces overlaps in one plane",
                        "pairs of faces overlap in one plane",
                    );
                }
                if boxes[&j].0.y < boxes[&i].1.y && boxes[&i].0.y < boxes[&j].1.y {
                    let (a, b) = (&faces[i.min(j)], &faces[i.max(j)]);
                    if overlap(a, b, &flat(i), &flat(j), size) && told.insert((i.min(j), i.max(j))) {
                        tally.add(|| format!("{} and {}", names.place(a), names.place(b)));
                    }
                }
            }
        }
    }
    tally.warn(warnings, "pair of faces overlaps in one plane", "pairs of faces overlap in one plane");
}

fn box_of(points: &[DVec2]) -> (DVec2, DVec2) {
    points.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), p| (lo.min(*p), hi.max(*p)))
}

/// Groups of at least two faces that may share a plane and face the same way. Offsets are sorted into
/// cells twice, shifted by half, so that no pair falls between; a pair may come up twice.
fn coplanar_groups(faces: &[Placed], size: f64) -> Vec<Vec<usize>> {
    let cell = 1e-5 * size;
    let mut order: Vec<[i64; 4]> = Vec::new();
    let mut groups: HashMap<[i64; 4], Vec<usize>> = HashMap::new();
    for (i, f) in faces.iter().enumerate() {
        let n = (f.face.normal / 1e-4).round();
        let offset = f.face.vertices[0].dot(f.face.normal) / cell;
        // Even keys for one sorting, odd ones for the shifted.
        for part in [2 * offset.floor() as i64, 2 * (offset + 0.5).floor() as i64 + 1] {
            let key = [n.x as i64, n.y as i64, n.z as i64, part];
            groups
                .entry(key)
                .or_insert_with(|| {
                    order.push(key);
                    Vec::new()
                })
                .push(i);
        }
    }
    order.iter().filter_map(|key| groups.remove(key)).filter(|g| g.len() > 1).collect()
}

fn overlap(a: &Placed, b: &Placed, flat_a: &[DVec2], flat_b: &[DVec2], size: f64) -> bool {
    let off = |p: &DVec3| (*p - a.face.vertices[0]).dot(a.face.normal).abs();
    b.face.vertices.iter().all(|p| off(p) <= 1e-6 * size)
        && polygon::overlap_area(flat_a, flat_b) > 1e-6 * a.face.area_m2.min(b.face.area_m2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, z: f64, material: usize, line: usize) -> Drawn {
        let ring = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(a, b)| DVec3::new(x + a, b, z)).to_vec();
        Drawn { ring, material, object: 0, place: Place { file: 0, line } }
    }

    fn built(drawn: &[Drawn]) -> (Vec<Face>, Vec<String>) {
        let (files, objects) = (["a.obj".to_owned()], ["slab".to_owned()]);
        let materials = ["wall".to_owned(), "lamp".to_owned()];
        build(drawn, Names { files: &files, objects: &objects, materials: &materials }, &[false, true])
    }

    #[test]
    fn a_duplicate_in_any_rotation_and_direction_is_dropped_once() {
        let mut turned = square(0.0, 0.0, 0, 2);
        turned.ring.rotate_left(1);
        let mut reversed = square(0.0, 0.0, 0, 3);
        reversed.ring.reverse();
        let (faces, warnings) = built(&[square(0.0, 0.0, 0, 1), turned, reversed, square(5.0, 0.0, 0, 4)]);
        assert_eq!(faces.len(), 2);
        assert_eq!(
            warnings,
            [
                "2 duplicate faces left out; the first: a.obj:2 (object `slab`) stands where a.obj:1 (object `slab`) does"
            ]
        );
    }

    #[test]
    fn an_emitting_duplicate_is_kept_once_even_over_a_passive_one() {
        let (faces, warnings) = built(&[square(0.0, 0.0, 0, 1), square(0.0, 0.0, 1, 2), square(0.0, 0.0, 1, 3)]);
        assert_eq!(faces.len(), 1);
        assert_eq!(faces[0].material, 1);
        assert!(
            warnings[0].contains("their light is emitted once") && warnings[0].contains("kept material `lamp`"),
            "{warnings:?}"
        );
    }

    #[test]
    fn overlaps_are_told_and_neighbours_are_not() {
        let (faces, warnings) = built(&[square(0.0, 0.0, 0, 1), square(0.5, 0.0, 0, 2)]);
        assert_eq!(faces.len(), 2);
        assert!(warnings[0].starts_with("1 pair of faces overlaps in one plane: a.obj:1"), "{warnings:?}");
        assert!(built(&[square(0.0, 0.0, 0, 1), square(1.0, 0.0, 0, 2), square(0.5, 0.1, 0, 3)]).1.is_empty());
    }

    #[test]
    fn contact_of_opposite_faces_is_no_overlap() {
        let mut bottom = square(0.25, 0.0, 0, 2);
        bottom.ring.reverse();
        assert!(built(&[square(0.0, 0.0, 0, 1), bottom]).1.is_empty());
    }

    #[test]
    fn degenerate_faces_are_counted_and_the_first_named() {
        let flat = |line| Drawn { ring: vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0], ..square(0.0, 0.0, 0, line) };
        let (faces, warnings) = built(&[flat(7), square(0.0, 0.0, 0, 8), flat(9)]);
        assert_eq!(faces.len(), 1);
        assert_eq!(warnings, ["2 faces left out: they have no area; the first: a.obj:7 (object `slab`)"]);
    }
}
