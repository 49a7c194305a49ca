//! Closed parts of a scene: what is inside of what, and what runs into what.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::outline::{Welder, open_edges, weld_tolerance};
use super::{Face, faces, polygon};

/// Pairs of edge and face that the search for penetrations may look at.
const MOST_PAIRS: usize = 4_000_000;

/// A closed part of the scene.
#[derive(Clone, Debug)]
pub(super) struct Shell {
    pub(super) faces: Vec<usize>,
    lo: DVec3,
    hi: DVec3,
    /// Positive if the fronts look outward, m³.
    pub(super) volume: f64,
}

/// The closed parts of the scene.
pub(super) fn shells(all: &[Face], tolerance: f64) -> Vec<Shell> {
    parts(all, tolerance).into_iter().filter_map(|part| Shell::of(all, part, tolerance)).collect()
}

/// Warns of solids that run into each other: what lies inside the other gets no light.
pub(crate) fn penetrations(all: &[Face], objects: &[String]) -> Vec<String> {
    let Some((lo, hi)) = faces::bounds(all) else { return Vec::new() };
    let tolerance = weld_tolerance(lo, hi);
    let solids: Vec<Shell> = shells(all, tolerance).into_iter().filter(|s| s.volume > 0.0).collect();
    let (mut work, mut told) = (0, BTreeSet::new());
    for (k, a) in solids.iter().enumerate() {
        for b in &solids[k + 1..] {
            let apart = (a.lo + tolerance).cmpge(b.hi).any() || (b.lo + tolerance).cmpge(a.hi).any();
            if apart {
                continue;
            }
            work += a.faces.len() * b.faces.len();
            if work > MOST_PAIRS {
                return vec!["too many solids overlap: the search for penetrations stopped early".to_owned()];
            }
            if a.pierces(b, all, tolerance) || b.pierces(a, all, tolerance) {
                told.insert([a, b].map(|s| all[s.faces[0]].object));
            }
        }
    }
    let Some(first) = told.first().map(|pair| pair.map(|o| format!("`{}`", objects[o]))) else { return Vec::new() };
    vec![format!(
        "{} pair(s) of solids run into each other, the first in the objects {}: what lies inside the other is dark",
        told.len(),
        first.join(" and ")
    )]
}

/// Faces joined by welded edges.
fn parts(faces: &[Face], tolerance: f64) -> Vec<Vec<usize>> {
    let mut welder = Welder::new(tolerance);
    let mut leader: Vec<usize> = (0..faces.len()).collect();
    let mut first: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for (i, face) in faces.iter().enumerate() {
        let ids: Vec<usize> = face.vertices.iter().map(|p| welder.id(*p)).collect();
        for k in 0..ids.len() {
            let (a, b) = (ids[k], ids[(k + 1) % ids.len()]);
            let other = *first.entry((a.min(b), a.max(b))).or_insert(i);
            let (x, y) = (root(&mut leader, i), root(&mut leader, other));
            leader[x.max(y)] = x.min(y);
        }
    }
    let mut parts: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for i in 0..faces.len() {
        parts.entry(root(&mut leader, i)).or_default().push(i);
    }
    parts.into_values().collect()
}

fn root(leader: &mut [usize], mut i: usize) -> usize {
    while leader[i] != i {
        leader[i] = leader[leader[i]];
        i = leader[i];
    }
    i
}

impl Shell {
    /// The part as a shell, if it is closed.
    fn of(all: &[Face], part: Vec<usize>, tolerance: f64) -> Option<Self> {
        if part.len() < 4 || !open_edges(part.iter().map(|i| all[*i].vertices.as_slice()), tolerance).is_empty() {
            return None;
        }
        let (lo, hi) = faces::bounds(part.iter().map(|i| &all[*i]))?;
        let volume = part.iter().map(|i| (all[*i].vertices[0] - lo).dot(all[*i].normal) * all[*i].area_m2 / 3.0).sum();
        Some(Self { faces: part, lo, hi, volume })
    }

    /// Does any edge go through the inside of a face of `other`?
    fn pierces(&self, other: &Self, all: &[Face], tolerance: f64) -> bool {
        let edges = self.faces.iter().flat_map(|f| {
            let v = &all[*f].vertices;
            (0..v.len()).map(|k| (v[k], v[(k + 1) % v.len()]))
        });
        edges.into_iter().any(|(a, b)| {
            other.faces.iter().map(|f| &all[*f]).any(|f| {
                let (da, db) = ((a - f.vertices[0]).dot(f.normal), (b - f.vertices[0]).dot(f.normal));
                let across = da.min(db) < -tolerance && da.max(db) > tolerance;
                across && polygon::contains(&f.vertices, f.normal, a + (b - a) * (da / (da - db)), -tolerance)
            })
        })
    }

    /// Is a point inside? The odd number of crossings of two rays out of three.
    pub(super) fn holds(&self, all: &[Face], p: DVec3) -> bool {
        if p.cmplt(self.lo).any() || p.cmpgt(self.hi).any() {
            return false;
        }
        // Directions without a simple ratio miss edges and vertices of ordinary models.
        let directions =
            [DVec3::new(0.571, 0.357, 0.739), DVec3::new(-0.683, 0.601, 0.415), DVec3::new(0.293, -0.779, -0.554)];
        let odd = |d: &DVec3| self.faces.iter().filter(|i| crosses(&all[**i], p, *d)).count() % 2 == 1;
        directions.iter().filter(|d| odd(d)).count() >= 2
    }
}

fn crosses(face: &Face, p: DVec3, direction: DVec3) -> bool {
    let slope = direction.dot(face.normal);
    let t = (face.vertices[0] - p).dot(face.normal) / slope;
    t > 0.0 && t.is_finite() && polygon::contains(&face.vertices, face.normal, p + direction * t, 0.0)
}
