//! What a careful reader finds in a scene before it costs an hour: leaks, flipped faces, buried lamps and
//! sensors.
//!
//! Plain geometry in f64, by brute force within a bounded amount of work; where a scene is too large for
//! that, sensors and faces are sampled.

use std::collections::BTreeMap;

use glam::DVec3;

use super::outline::{OpenEdge, open_edges, weld_tolerance};
use super::shells::{Shell, shells};
use super::{Axes, Face, Scene, faces, polygon};

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Results would be wrong or empty.
    Error,
    /// Results may not mean what is expected.
    Warning,
    /// Worth knowing.
    Info,
}

impl Severity {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Info => "info",
        }
    }
}

/// A finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// What was found, and where.
    pub what: String,
    /// What to do about it; empty where the finding says so itself.
    pub mend: String,
}

/// Pairs of point and face that one question may look at.
const MOST_WORK: usize = 50_000_000;
/// "On the surface", as a share of the scene's size.
const ON: f64 = 1e-5;
/// "At no distance", as a share of the scene's size.
const NEAR: f64 = 1e-3;
/// Edges this near each other look as if they were meant to meet, as a share of the scene's size.
const CRACK: f64 = 1e-4;

/// Looks for everything that can be wrong with a scene that could be read; the worst first.
#[must_use]
pub fn check(scene: &Scene) -> Vec<Diagnostic> {
    let mut checker = Checker::new(scene);
    for warning in &scene.warnings {
        checker.found.push(Diagnostic { severity: Severity::Warning, what: warning.clone(), mend: String::new() });
    }
    checker.asks_and_lights();
    checker.edges();
    checker.shells();
    checker.sensors();
    checker.emitters();
    checker.found.sort_by_key(|d| d.severity);
    checker.found
}

struct Checker<'a> {
    scene: &'a Scene,
    size: f64,
    tolerance: f64,
    /// Closed shells: parts of the scene without an open edge.
    shells: Vec<Shell>,
    found: Vec<Diagnostic>,
}

impl<'a> Checker<'a> {
    fn new(scene: &'a Scene) -> Self {
        let (lo, hi) = faces::bounds(&scene.faces).unwrap_or_default();
        let tolerance = weld_tolerance(lo, hi);
        let shells = shells(&scene.faces, tolerance);
        Self { scene, size: (hi - lo).length(), tolerance, shells, found: Vec::new() }
    }

    fn tell(&mut self, severity: Severity, what: String, mend: &str) {
        self.found.push(Diagnostic { severity, what, mend: mend.to_owned() });
    }

    fn object(&self, face: usize) -> &'a str {
        &self.scene.objects[self.scene.faces[face].object]
    }

    fn emits(&self, face: usize) -> bool {
        let emission = &self.scene.materials[self.scene.faces[face].material].emission;
        emission.as_ref().is_some_and(|e| e.radiance.max() > 0.0)
    }

    fn asks_and_lights(&mut self) {
        if self.scene.daytime.is_none() && !(0..self.scene.faces.len()).any(|f| self.emits(f)) {
            self.tell(
                Severity::Warning,
                "no light: no face emits, every result will be zero".to_owned(),
                "give a material an `emission`, or add a [sky]",
            );
        }
        if self.scene.grids.is_empty() && self.scene.views.is_empty() {
            self.tell(
                Severity::Warning,
                "nothing is asked: no grids and no views".to_owned(),
                "add [[grids]] or [[views]]",
            );
        }
    }

    /// Cracks, faces wound against each other, openings.
    fn edges(&mut self) {
        let rings = || self.scene.faces.iter().map(|f| f.vertices.as_slice());
        let open = open_edges(rings(), self.tolerance);
        let (twisted, open): (Vec<_>, Vec<_>) = open.into_iter().partition(|e| e.net.is_multiple_of(2));
        if let Some(edge) = longest(&twisted) {
            let what = format!(
                "{} edges join faces that are wound against each other; the longest: {}",
                twisted.len(),
                self.place(edge)
            );
            self.tell(
                Severity::Warning,
                what,
                "flip one side: light is emitted from fronts only, and fronts tell inside from outside",
            );
        }
        let meeting = length(&open) - length(&open_edges(rings(), CRACK * self.size));
        if meeting > 1e-3 * self.size {
            let what =
                format!("{meeting:.3} m of edges nearly meet: cracks narrower than {:.2} mm", 1e3 * CRACK * self.size);
            self.tell(Severity::Warning, what, "weld the vertices before exporting: light leaks through");
        }
        let affordable = open.len() * self.scene.faces.len() <= MOST_WORK;
        let free: Vec<OpenEdge> = open.into_iter().filter(|e| !affordable || !self.rests_on_a_face(e)).collect();
        if let Some(edge) = longest(&free) {
            let what =
                format!("{} open edges, {:.3} m in all; the longest: {}", free.len(), length(&free), self.place(edge));
            self.tell(
                Severity::Info,
                what,
                "fine for openings and free-standing sheets; light that leaves there is counted as escaped",
            );
        }
    }

    /// Does an open edge lie in the middle of another face (a block without a bottom on a floor)?
    fn rests_on_a_face(&self, edge: &OpenEdge) -> bool {
        let middle = 0.5 * (edge.from + edge.to);
        let along = (edge.to - edge.from).normalize();
        let carries = |f: &Face| {
            (0..f.vertices.len()).any(|i| {
                let (a, b) = (f.vertices[i], f.vertices[(i + 1) % f.vertices.len()]);
                let d = (b - a).normalize();
                d.dot(along).abs() > 1.0 - 1e-9 && (middle - a).cross(d).length() < ON * self.size
            })
        };
        self.scene.faces.iter().any(|f| {
            (middle - f.vertices[0]).dot(f.normal).abs() < ON * self.size
                && polygon::contains(&f.vertices, f.normal, middle, self.tolerance)
                && !carries(f)
        })
    }

    fn place(&self, edge: &OpenEdge) -> String {
        let object = self
            .scene
            .faces
            .iter()
            .position(|f| f.vertices.iter().any(|v| v.distance(edge.from) <= 2.0 * self.tolerance));
        let object = object.map_or(String::new(), |f| format!(" (object `{}`)", self.object(f)));
        format!("{} to {}{object}", self.point(edge.from), self.point(edge.to))
    }

    fn point(&self, p: DVec3) -> String {
        point(self.scene.axes, p)
    }

    /// Lamps wound inside out.
    fn shells(&mut self) {
        let asked: Vec<DVec3> = self.asked().collect();
        for index in 0..self.shells.len() {
            let shell = &self.shells[index];
            let Some(&lamp) = shell.faces.iter().find(|f| self.emits(**f)) else {
                continue;
            };
            if shell.volume < 0.0
                && asked.len() * shell.faces.len() < MOST_WORK
                && !asked.iter().any(|p| shell.holds(&self.scene.faces, *p))
            {
                let what = format!(
                    "the lamp on object `{}` is a closed shell whose fronts look inward: its light stays inside",
                    self.object(lamp)
                );
                self.tell(Severity::Warning, what, "flip its faces");
            }
        }
    }

    /// Points at which something is asked, a little off the surfaces.
    fn asked(&self) -> impl Iterator<Item = DVec3> + '_ {
        let sensors =
            self.scene.grids.iter().flat_map(|g| &g.sensors).map(|s| s.position + s.normal * (2.0 * ON * self.size));
        sensors.chain(self.scene.views.iter().map(|v| v.position))
    }

    /// Sensors inside solids, and sensors that face a wall at no distance.
    fn sensors(&mut self) {
        let total: usize = self.scene.grids.iter().map(|g| g.sensors.len()).sum();
        let stride = (total * self.scene.faces.len()).div_ceil(MOST_WORK).max(1);
        for grid in &self.scene.grids {
            let looked: Vec<_> = grid.sensors.iter().step_by(stride).collect();
            let inside: Vec<_> = looked
                .iter()
                .filter_map(|s| Some((s, self.solid_around(s.position + s.normal * (2.0 * ON * self.size))?)))
                .collect();
            if let Some((first, face)) = inside.first() {
                let (n, of) = (inside.len(), looked.len());
                let what = format!(
                    "grid \"{}\": {n} of {of} points lie inside a solid, the first at {}, in object `{}`",
                    grid.name,
                    self.point(first.position),
                    self.object(*face)
                );
                let severity = if n == of { Severity::Error } else { Severity::Warning };
                self.tell(severity, what, "move the points; or, if the solid is meant as a room, flip its faces so that their fronts look into it");
            }
            let facing: Vec<_> =
                looked.iter().filter_map(|s| Some((s, self.wall_before(s.position, s.normal, None)?))).collect();
            if let Some((first, (face, distance))) = facing.first() {
                let what = format!(
                    "grid \"{}\": {} of {} points face a wall at no distance, the first at {}: {:.3} mm before object `{}`",
                    grid.name,
                    facing.len(),
                    looked.len(),
                    self.point(first.position),
                    1e3 * distance,
                    self.object(*face)
                );
                self.tell(Severity::Warning, what, "turn `normal` round, or move the points");
            }
        }
    }

    /// A face of the solid (closed, fronts outward) that a point is in.
    fn solid_around(&self, p: DVec3) -> Option<usize> {
        self.shells.iter().find(|s| s.volume > 0.0 && s.holds(&self.scene.faces, p)).map(|s| s.faces[0])
    }

    /// The face at no distance before a point, and how far it is. Faces that the point lies on do not count.
    fn wall_before(&self, p: DVec3, direction: DVec3, but: Option<usize>) -> Option<(usize, f64)> {
        self.scene.faces.iter().enumerate().find_map(|(i, f)| {
            let height = (f.vertices[0] - p).dot(f.normal);
            let slope = direction.dot(f.normal);
            let near =
                height.abs() > ON * self.size && height.abs() < NEAR * self.size && height * slope > 0.5 * height.abs();
            (near && but != Some(i) && polygon::contains(&f.vertices, f.normal, p, self.tolerance))
                .then_some((i, height.abs()))
        })
    }

    /// Lamps that lie in another face or shine into a wall.
    fn emitters(&mut self) {
        let emitting: Vec<usize> = (0..self.scene.faces.len()).filter(|f| self.emits(*f)).collect();
        let stride = (emitting.len() * self.scene.faces.len()).div_ceil(MOST_WORK).max(1);
        let mut in_plane: BTreeMap<(usize, usize, bool), usize> = BTreeMap::new();
        let mut before_wall: BTreeMap<(usize, usize), (usize, f64)> = BTreeMap::new();
        for &lamp in emitting.iter().step_by(stride) {
            let face = &self.scene.faces[lamp];
            let centre = face.vertices.iter().sum::<DVec3>() / face.vertices.len() as f64;
            if let Some(other) = self.face_at(centre, face.normal, lamp) {
                let other = &self.scene.faces[other];
                let contact = self.is_of_a_solid(lamp) && face.normal.dot(other.normal) < 0.0;
                *in_plane.entry((face.object, other.object, contact)).or_default() += 1;
            } else if let Some((wall, distance)) = self.wall_before(centre, face.normal, Some(lamp)) {
                before_wall.entry((face.object, self.scene.faces[wall].object)).or_insert((0, distance)).0 += 1;
            }
        }
        for ((lamp, other, contact), count) in in_plane {
            let [lamp, other] = [lamp, other].map(|o| self.scene.objects[o].as_str());
            let (severity, doing, mend) = if contact {
                (Severity::Info, "touch", "a flux_lm counts their area although their light stays in the contact")
            } else {
                (
                    Severity::Warning,
                    "lie in the plane of",
                    "cut a hole around the lamp, or move it out by a few millimetres",
                )
            };
            let what = format!("{count} emitting face(s) of object `{lamp}` {doing} faces of object `{other}`");
            self.tell(severity, what, mend);
        }
        for ((lamp, wall), (count, distance)) in before_wall {
            let [lamp, wall] = [lamp, wall].map(|o| self.scene.objects[o].as_str());
            let what = format!(
                "{count} emitting face(s) of object `{lamp}` shine into object `{wall}`, {:.3} mm before them",
                1e3 * distance
            );
            self.tell(Severity::Warning, what, "flip the lamp's faces: light leaves their fronts (right-hand rule)");
        }
    }

    /// Does the face belong to a closed shell whose fronts look outward?
    fn is_of_a_solid(&self, face: usize) -> bool {
        self.shells.iter().any(|s| s.volume > 0.0 && s.faces.binary_search(&face).is_ok())
    }

    /// Another face in whose plane a point lies, parallel to `normal`.
    fn face_at(&self, p: DVec3, normal: DVec3, but: usize) -> Option<usize> {
        self.scene.faces.iter().enumerate().position(|(i, f)| {
            i != but
                && (p - f.vertices[0]).dot(f.normal).abs() < ON * self.size
                && f.normal.dot(normal).abs() > 1.0 - 1e-6
                && polygon::contains(&f.vertices, f.normal, p, -self.tolerance)
        })
    }
}

fn point(axes: Axes, p: DVec3) -> String {
    let p = axes.to_user(p);
    let [x, y, z] = [p.x, p.y, p.z].map(|c| (1e4 * c).round() / 1e4 + 0.0); // no -0
    format!("({x:.4}, {y:.4}, {z:.4}) m")
}

fn length(edges: &[OpenEdge]) -> f64 {
    edges.iter().map(|e| e.from.distance(e.to)).sum()
}

fn longest(edges: &[OpenEdge]) -> Option<&OpenEdge> {
    edges.iter().max_by(|a, b| a.from.distance(a.to).total_cmp(&b.from.distance(b.to)))
}
