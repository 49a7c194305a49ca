//! Grids: where illuminance is asked.

use glam::{DVec2, DVec3};

use super::file::{At, GridDef, PlaneDef, Source};
use super::load::{Files, check_number, unit_vector, vector};
use super::outline::{OpenEdge, open_edges, weld_tolerance};
use super::{Axes, Face, Grid, GridLayout, Receiver, Sensor, faces, obj, polygon, suggest};
use crate::{Error, Result};

/// Most points of a grid.
const MOST_POINTS: f64 = 1e6;

/// What a grid may refer to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage<'a> {
    pub(crate) faces: &'a [Face],
    pub(crate) objects: &'a [String],
    pub(crate) materials: &'a [String],
    pub(crate) axes: Axes,
}

/// Checks one grid and places its points.
pub(crate) fn resolve(files: &mut Files<'_>, stage: &Stage<'_>, def: &GridDef) -> Result<Grid> {
    let source = files.source;
    if def.on.is_none() {
        for (number, key) in [(&def.height_m, "height_m"), (&def.spacing_m, "spacing_m"), (&def.inset_m, "inset_m")] {
            if let Some(n) = number {
                return Err(source
                    .malformed(n.offset, format!("`{key}` belongs to a grid with `on`"))
                    .mend("remove the key"));
            }
        }
    }
    let (sensors, layout) = match (&def.plane, &def.on, &def.points) {
        (Some(plane), None, None) => on_plane(source, stage.axes, def, &plane.value)?,
        (None, Some(on), None) => on_faces(files, stage, def, on)?,
        (None, None, Some(points)) => from_file(files, stage.axes, def, points)?,
        _ => {
            let message = format!("grid \"{}\" says nowhere or more than once where its points are", def.name.value);
            return Err(source.malformed(def.name.offset, message).mend("give exactly one of `plane`, `on`, `points`"));
        }
    };
    Ok(Grid { name: def.name.value.clone(), sensors, layout, receiver: Receiver::Plane })
}

/// The grids of cylinders and half cylinders that a grid asks for at its points.
pub(crate) fn companions(source: Source<'_>, axes: Axes, def: &GridDef, grid: &Grid) -> Result<Vec<Grid>> {
    let with = |ending: &str, receiver: Receiver, normal: DVec3| Grid {
        name: format!("{}{ending}", grid.name),
        sensors: grid.sensors.iter().map(|s| Sensor { normal, ..*s }).collect(),
        layout: grid.layout.clone(),
        receiver,
    };
    let mut all = Vec::new();
    if def.cylindrical {
        all.push(with(CYLINDRICAL, Receiver::Cylinder, DVec3::Z));
    }
    if let Some(direction) = &def.semicylindrical {
        let ahead = axes.to_internal(unit_vector(source, direction, "semicylindrical")?);
        if ahead.z.abs() > 1e-6 {
            return Err(source
                .malformed(direction.offset, "semicylindrical is no level direction: half cylinders stand upright")
                .mend("semicylindrical = [1, 0, 0]"));
        }
        all.push(with(SEMICYLINDRICAL, Receiver::HalfCylinder, ahead));
    }
    Ok(all)
}

/// Endings of the names of grids of cylinders and half cylinders.
pub(crate) const CYLINDRICAL: &str = "_cylindrical";
/// See [`CYLINDRICAL`].
pub(crate) const SEMICYLINDRICAL: &str = "_semicylindrical";

/// Cell centres of a parallelogram.
fn on_plane(source: Source<'_>, axes: Axes, def: &GridDef, plane: &PlaneDef) -> Result<(Vec<Sensor>, GridLayout)> {
    let origin = axes.to_internal(vector(source, &plane.origin_m, "origin_m")?);
    let u = axes.to_internal(vector(source, &plane.u_m, "u_m")?);
    let v = axes.to_internal(vector(source, &plane.v_m, "v_m")?);
    let area = u.cross(v);
    if area.length() <= 1e-9 * u.length() * v.length() {
        return Err(source
            .malformed(plane.u_m.offset, format!("grid \"{}\": u_m and v_m span no area", def.name.value))
            .mend("give two sides that are neither zero nor parallel"));
    }
    for (n, key) in [(&plane.nu, "nu"), (&plane.nv, "nv")] {
        if n.value == 0 {
            return Err(source.malformed(n.offset, format!("grid \"{}\": {key} is zero", def.name.value)));
        }
    }
    let (nu, nv) = (plane.nu.value as usize, plane.nv.value as usize);
    check_count(source, plane.nu.offset, nu as f64 * nv as f64)?;
    let normal = match &def.normal {
        Some(normal) => axes.to_internal(unit_vector(source, normal, "normal")?),
        None => area.normalize(),
    };
    let area_m2 = Some(area.length() / (nu * nv) as f64);
    let centre = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
    let sensors = (0..nu * nv)
        .map(|k| Sensor { position: origin + u * centre(k % nu, nu) + v * centre(k / nu, nv), normal, area_m2 })
        .collect();
    Ok((sensors, GridLayout::Raster { origin, u, v, nu, nv, index: (0..nu * nv).map(Some).collect() }))
}

fn check_count(source: Source<'_>, offset: usize, count: f64) -> Result<()> {
    if count <= MOST_POINTS {
        return Ok(());
    }
    Err(source
        .malformed(offset, format!("a grid of {count:.3e} points is more than the {MOST_POINTS:.0e} allowed"))
        .mend("choose a wider spacing"))
}

/// A raster over the faces of a material or object.
fn on_faces(
    files: &mut Files<'_>,
    stage: &Stage<'_>,
    def: &GridDef,
    on: &At<String>,
) -> Result<(Vec<Sensor>, GridLayout)> {
    let source = files.source;
    let chosen = faces_named(source, stage, on)?;
    let (flat, left_out) = dominant(&chosen);
    if left_out > 1e-6 {
        let share = 100.0 * left_out;
        files.warnings.push(format!(
            "grid \"{}\": {share:.1} % of the area of `{}` faces another way than most of it and gets no points",
            def.name.value, on.value
        ));
    }
    let spacing = def.spacing_m.as_ref().ok_or_else(|| {
        source
            .malformed(on.offset, format!("grid \"{}\" has no `spacing_m`", def.name.value))
            .mend("add spacing_m = 0.25")
    })?;
    check_number(source, Some(spacing), "spacing_m")?;
    if spacing.value <= 0.0 {
        return Err(source.malformed(spacing.offset, "spacing_m must be positive"));
    }
    for (number, key) in [(&def.height_m, "height_m"), (&def.inset_m, "inset_m")] {
        check_number(source, number.as_ref(), key)?;
    }
    let height = def.height_m.as_ref().map_or(0.0, |h| h.value);
    let inset = def.inset_m.as_ref().map_or(0.0, |i| i.value);
    if inset < 0.0 {
        return Err(source.malformed(on.offset, format!("grid \"{}\": inset_m is negative", def.name.value)));
    }
    let raster = Raster::over(&flat, spacing.value);
    check_count(source, spacing.offset, raster.nu as f64 * raster.nv as f64)?;
    let normal = match &def.normal {
        Some(normal) => Some(stage.axes.to_internal(unit_vector(source, normal, "normal")?)),
        None => None,
    };
    let (sensors, index) = raster.sensors(&flat, inset, height, normal);
    if sensors.is_empty() {
        let message =
            format!("grid \"{}\": no point lies on `{}` at least {inset} m from its outline", def.name.value, on.value);
        return Err(source.impossible(on.offset, message).mend("choose a smaller inset_m or spacing_m"));
    }
    Ok((sensors, raster.layout(height * normal.unwrap_or(raster.normal), index)))
}

/// Faces whose object or material has the name.
pub(crate) fn faces_named<'a>(source: Source<'_>, stage: &Stage<'a>, on: &At<String>) -> Result<Vec<&'a Face>> {
    let name = on.value.as_str();
    let chosen: Vec<&Face> =
        stage.faces.iter().filter(|f| stage.objects[f.object] == name || stage.materials[f.material] == name).collect();
    if chosen.is_empty() {
        let known: Vec<&str> = stage.objects.iter().chain(stage.materials).map(String::as_str).collect();
        let error = source.malformed(on.offset, format!("no object and no material in use is called `{name}`"));
        return Err(error.mend(suggest::mend(name, &known)));
    }
    Ok(chosen)
}

/// The faces within a degree of the direction in which most area faces, and the share of area left out.
fn dominant<'a>(chosen: &[&'a Face]) -> (Vec<&'a Face>, f64) {
    let near = |a: DVec3, b: DVec3| a.dot(b) > 1.0_f64.to_radians().cos();
    let mut directions: Vec<(DVec3, f64)> = Vec::new();
    for face in chosen {
        match directions.iter_mut().find(|(d, _)| near(*d, face.normal)) {
            Some((_, area)) => *area += face.area_m2,
            None => directions.push((face.normal, face.area_m2)),
        }
    }
    let total: f64 = directions.iter().map(|(_, a)| a).sum();
    let mut best = directions[0];
    for direction in &directions[1..] {
        if direction.1 > best.1 {
            best = *direction;
        }
    }
    (chosen.iter().copied().filter(|f| near(best.0, f.normal)).collect(), 1.0 - best.1 / total)
}

/// Square cells over coplanar faces.
struct Raster {
    /// Middle of the first cell's corner, in the faces' plane.
    origin: DVec3,
    u: DVec3,
    v: DVec3,
    normal: DVec3,
    spacing: f64,
    nu: usize,
    nv: usize,
    tolerance: f64,
    outline: Vec<OpenEdge>,
}

impl Raster {
    /// Cells of `spacing` metres, centred on the faces' bounding rectangle.
    fn over(faces: &[&Face], spacing: f64) -> Self {
        let normal = faces.iter().map(|f| f.normal * f.area_m2).sum::<DVec3>().normalize();
        let (lo, hi) = faces::bounds(faces.iter().copied()).unwrap_or_default();
        let tolerance = weld_tolerance(lo, hi);
        let outline = open_edges(faces.iter().map(|f| f.vertices.as_slice()), tolerance);
        let (u, v) = plane_axes(normal, &outline);
        let points = || faces.iter().flat_map(|f| &f.vertices);
        let range = |axis: DVec3| {
            points().map(|p| p.dot(axis)).fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)))
        };
        let cells = |(lo, hi): (f64, f64)| ((hi - lo) / spacing + 1e-6).floor().max(1.0);
        let (ru, rv) = (range(u), range(v));
        let (nu, nv) = (cells(ru), cells(rv));
        let start = |(lo, hi): (f64, f64), n: f64| 0.5 * (lo + hi - n * spacing);
        let area: f64 = faces.iter().map(|f| f.area_m2).sum();
        let level = faces.iter().map(|f| f.area_m2 * f.vertices[0].dot(normal)).sum::<f64>() / area;
        let origin = u * start(ru, nu) + v * start(rv, nv) + normal * level;
        Self { origin, u, v, normal, spacing, nu: nu as usize, nv: nv as usize, tolerance, outline }
    }

    /// A sensor for every cell whose centre lies on a face, `inset` metres or more from the outline.
    fn sensors(
        &self,
        faces: &[&Face],
        inset: f64,
        height: f64,
        normal: Option<DVec3>,
    ) -> (Vec<Sensor>, Vec<Option<usize>>) {
        let mut cells: Vec<Option<Sensor>> = vec![None; self.nu * self.nv];
        for face in faces {
            for k in self.cells_near(face) {
                if cells[k].is_none() {
                    cells[k] = self.sensor(face, k, inset, height, normal);
                }
            }
        }
        let mut sensors = Vec::new();
        let index = cells
            .into_iter()
            .map(|cell| {
                cell.map(|sensor| {
                    sensors.push(sensor);
                    sensors.len() - 1
                })
            })
            .collect();
        (sensors, index)
    }

    /// Cells whose centre may lie on the face.
    fn cells_near(&self, face: &Face) -> Vec<usize> {
        let range = |axis: DVec3, n: usize| {
            let along = face.vertices.iter().map(|p| (*p - self.origin).dot(axis) / self.spacing - 0.5);
            let (lo, hi) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
            (lo - 1e-6).ceil().max(0.0) as usize..((hi + 1e-6).floor() + 1.0).clamp(0.0, n as f64) as usize
        };
        let columns = range(self.u, self.nu);
        range(self.v, self.nv).flat_map(|j| columns.clone().map(move |i| j * self.nu + i)).collect()
    }

    fn sensor(&self, face: &Face, cell: usize, inset: f64, height: f64, normal: Option<DVec3>) -> Option<Sensor> {
        let (i, j) = ((cell % self.nu) as f64 + 0.5, (cell / self.nu) as f64 + 0.5);
        let centre = self.origin + self.u * (i * self.spacing) + self.v * (j * self.spacing);
        let drop = (face.vertices[0] - centre).dot(face.normal) / self.normal.dot(face.normal);
        let foot = centre + self.normal * drop;
        if !polygon::contains(&face.vertices, face.normal, foot, self.tolerance) || self.near_outline(foot, inset) {
            return None;
        }
        let normal = normal.unwrap_or(face.normal);
        Some(Sensor { position: foot + normal * height, normal, area_m2: Some(self.spacing * self.spacing) })
    }

    fn near_outline(&self, p: DVec3, inset: f64) -> bool {
        let flat = |q: DVec3| DVec2::new((q - self.origin).dot(self.u), (q - self.origin).dot(self.v));
        inset > 0.0 && self.outline.iter().any(|e| distance(flat(p), flat(e.from), flat(e.to)) < inset - self.tolerance)
    }

    fn layout(&self, offset: DVec3, index: Vec<Option<usize>>) -> GridLayout {
        GridLayout::Raster {
            origin: self.origin + offset,
            u: self.u * (self.nu as f64 * self.spacing),
            v: self.v * (self.nv as f64 * self.spacing),
            nu: self.nu,
            nv: self.nv,
            index,
        }
    }
}

/// Distance from a point to a segment.
fn distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let ab = b - a;
    let t = ((p - a).dot(ab) / ab.length_squared()).clamp(0.0, 1.0);
    p.distance(a + ab * t)
}

/// Axes of a raster: on slopes and walls u is level; on floors and ceilings u follows the longest edge of
/// the outline, turned to within 45° of x.
fn plane_axes(normal: DVec3, outline: &[OpenEdge]) -> (DVec3, DVec3) {
    let level = DVec3::Z.cross(normal);
    let u = if level.length() > 1e-3 {
        level.normalize()
    } else {
        let longest = outline.iter().map(|e| e.to - e.from).fold(DVec3::X, |best, e| {
            if e.length() > best.length() * (1.0 + 1e-9) || best == DVec3::X { e } else { best }
        });
        nearest_to_x(longest.normalize(), normal)
    };
    let u = (u - normal * u.dot(normal)).normalize();
    (u, normal.cross(u))
}

/// The direction, or one of its quarter turns about the normal, nearest to x.
fn nearest_to_x(d: DVec3, normal: DVec3) -> DVec3 {
    let across = normal.cross(d);
    [d, across, -d, -across].into_iter().fold(d, |best, c| if c.x > best.x + 1e-9 { c } else { best })
}

/// Points from a file in Radiance's form.
fn from_file(files: &mut Files<'_>, axes: Axes, def: &GridDef, name: &At<String>) -> Result<(Vec<Sensor>, GridLayout)> {
    if let Some(normal) = &def.normal {
        return Err(files
            .source
            .malformed(normal.offset, "`normal` does not go with `points`: the file gives each point its direction")
            .mend("remove the key"));
    }
    let bytes = files.read(name)?;
    let path = files.path(&name.value);
    let points = parse_points(&bytes).map_err(|e| e.in_file(&path))?;
    let sensors = points
        .into_iter()
        .map(|(p, d)| Sensor { position: axes.to_internal(p), normal: axes.to_internal(d), area_m2: None })
        .collect();
    Ok((sensors, GridLayout::Points))
}

/// Positions and unit directions of a `.pts` file.
fn parse_points(bytes: &[u8]) -> Result<Vec<(DVec3, DVec3)>> {
    let text = super::text(bytes)?;
    let mut points = Vec::new();
    for (i, line) in text.lines().enumerate() {
        if !line.trim().is_empty() {
            points.push(parse_point(line).map_err(|e| e.at_line(i + 1))?);
        }
    }
    if points.is_empty() {
        return Err(Error::malformed("no points").mend("expected `x y z dx dy dz` on each line"));
    }
    Ok(points)
}

fn parse_point(line: &str) -> Result<(DVec3, DVec3)> {
    let mut numbers = [0.0; 6];
    let words: Vec<&str> = line.split_whitespace().collect();
    if words.len() != 6 {
        return Err(Error::malformed(format!("expected six numbers `x y z dx dy dz`, found {}", words.len())));
    }
    for (number, word) in numbers.iter_mut().zip(&words) {
        *number = word
            .parse()
            .ok()
            .filter(|x: &f64| x.is_finite() && x.abs() <= obj::LARGEST)
            .ok_or_else(|| Error::malformed(format!("`{}` is not a finite number", word.escape_debug())))?;
    }
    let [x, y, z, dx, dy, dz] = numbers;
    let direction = DVec3::new(dx, dy, dz);
    let direction = (direction / direction.abs().max_element()).try_normalize().ok_or_else(|| {
        Error::malformed("the direction is zero").mend("a sensor must face somewhere: 0 0 1 faces up where z is up")
    })?;
    Ok((DVec3::new(x, y, z), direction))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn error(text: &str) -> String {
        parse_points(text.as_bytes()).unwrap_err().in_file("s.pts").to_string()
    }

    #[test]
    fn points_keep_their_order_and_get_unit_directions() {
        let points = parse_points(b"1 2 3 0 0 5\n\n4\t5 6 0 -2 0\r\n").unwrap();
        assert_eq!(points, [(DVec3::new(1.0, 2.0, 3.0), DVec3::Z), (DVec3::new(4.0, 5.0, 6.0), DVec3::NEG_Y)]);
    }

    #[test]
    fn a_bad_line_is_named() {
        assert!(error("0 0 0 0 0 1\n0 0 0 0 0\n").contains("s.pts:2: expected six numbers"));
        assert!(error("0 0 0 0 0 x\n").contains("s.pts:1: `x` is not a finite number"));
        assert!(error("0 0 0 0 0 0\n").contains("s.pts:1: the direction is zero"));
        assert!(error("\n").contains("no points"));
    }

    fn face(points: &[(f64, f64)]) -> Face {
        let vertices: Vec<DVec3> = points.iter().map(|(x, y)| DVec3::new(*x, *y, 2.0)).collect();
        let area = polygon::area_vector(&vertices);
        Face { vertices, normal: area.normalize(), area_m2: area.length(), material: 0, object: 0 }
    }

    #[test]
    fn a_raster_covers_an_l_and_keeps_its_distance() {
        let a = face(&[(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (0.0, 1.0)]);
        let b = face(&[(0.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]);
        let raster = Raster::over(&[&a, &b], 0.5);
        let (sensors, index) = raster.sensors(&[&a, &b], 0.0, 0.8, None);
        assert_eq!((raster.nu, raster.nv, sensors.len()), (8, 6, 24));
        assert_eq!(index.iter().flatten().count(), 24);
        assert!(sensors.iter().all(|s| s.normal == DVec3::Z && (s.position.z - 2.8).abs() < 1e-12));
        assert!(sensors[0].position.distance(DVec3::new(0.25, 0.25, 2.8)) < 1e-9, "{:?}", sensors[0]);
        let (inner, _) = raster.sensors(&[&a, &b], 0.3, 0.8, None);
        assert_eq!(inner.len(), 1, "only (0.75, 0.75) is far enough, also from the inner corner");
        let fine = Raster::over(&[&a, &b], 0.25);
        let (inner, _) = fine.sensors(&[&a, &b], 0.3, 0.0, None);
        assert!(inner.iter().any(|s| (s.position.y - 1.125).abs() < 1e-9 && s.position.x < 0.7), "no gap at the seam");
        assert!(inner.iter().all(|s| s.position.x >= 0.3 && s.position.y <= 2.7));
    }

    #[test]
    fn a_raster_on_a_turned_floor_follows_its_edge() {
        let (s, c) = 0.3_f64.sin_cos();
        let turned = face(&[(0.0, 0.0), (3.0 * c, 3.0 * s), (3.0 * c - s, 3.0 * s + c), (-s, c)]);
        let raster = Raster::over(&[&turned], 0.5);
        assert_eq!((raster.nu, raster.nv), (6, 2));
        assert!(raster.u.distance(DVec3::new(c, s, 0.0)) < 1e-9);
    }

    proptest! {
        #[test]
        fn any_bytes_give_points_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = parse_points(&bytes);
        }
    }
}
