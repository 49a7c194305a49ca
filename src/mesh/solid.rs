//! Which surfaces enclose the inside of a solid.
//!
//! A connected set of faces is a solid when its edges close (or end on another surface: a block that stands on
//! the floor without a bottom of its own) and its faces look outward. What lies behind them is dark for good:
//! a sample that sees such a back face first lies inside the solid and must not count.

use glam::DVec3;
use rayon::prelude::*;

use super::surfaces::{Surface, TOUCH};

/// Marks the faces of solids; what has a face of a material that lets light in is none.
pub(super) fn mark_solids(list: &mut [Surface], neighbours: &[Vec<u32>], lets_light_in: impl Fn(usize) -> bool) {
    let mut edges = Edges::new(list);
    let mut components = edges.sets.list();
    components.retain(|members| !members.iter().any(|m| lets_light_in(list[*m].material)));
    let bounds = bounds_of(list, &(0..list.len()).collect::<Vec<_>>());
    let faces: &[Surface] = list;
    let solid = |members: &Vec<usize>| is_solid(faces, neighbours, &edges, members, bounds);
    let solids: Vec<Vec<usize>> = components.into_par_iter().filter(solid).collect();
    solids.into_iter().flatten().for_each(|m| list[m].solid = true);
}

fn is_solid(
    list: &[Surface],
    neighbours: &[Vec<u32>],
    edges: &Edges,
    members: &[usize],
    scene: (DVec3, DVec3),
) -> bool {
    if members.len() < 3 {
        return false;
    }
    let own = bounds_of(list, members);
    // The shell that holds everything else is a room, whichever way it is wound.
    if (own.0 - scene.0).abs().max_element() <= TOUCH && (own.1 - scene.1).abs().max_element() <= TOUCH {
        return false;
    }
    let mut open_end = None;
    for &m in members {
        let s = &list[m];
        for k in 0..s.vertices.len() {
            let (a, b) = (s.vertices[k], s.vertices[(k + 1) % s.vertices.len()]);
            match edges.uses[edges.first[m] + k] {
                (1, 1) => {}
                (1, 0) if rests_on_another(list, &neighbours[m], members, a, b) => open_end = Some(a),
                _ => return false,
            }
        }
    }
    let reference = open_end.unwrap_or(list[members[0]].vertices[0]);
    volume(list, members, reference) > 0.0
}

/// Signed volume times three, seen from `reference`: positive when the faces look outward (Gauss).
fn volume(list: &[Surface], members: &[usize], reference: DVec3) -> f64 {
    members.iter().map(|&m| list[m].area * (list[m].vertices[0] - reference).dot(list[m].normal)).sum()
}

fn rests_on_another(list: &[Surface], near: &[u32], members: &[usize], a: DVec3, b: DVec3) -> bool {
    near.iter().map(|j| *j as usize).filter(|j| members.binary_search(j).is_err()).any(|j| {
        let s = &list[j];
        [a, b].iter().all(|p| s.height(*p).abs() <= TOUCH && within(s, *p))
    })
}

fn within(s: &Surface, p: DVec3) -> bool {
    let uv = s.uv(p);
    let n = s.outline.len();
    (0..n).all(|k| {
        let (a, b) = (s.outline[k], s.outline[(k + 1) % n]);
        let edge = b - a;
        edge.perp_dot(uv - a) >= -TOUCH * edge.length()
    })
}

fn bounds_of(list: &[Surface], members: &[usize]) -> (DVec3, DVec3) {
    let points = || members.iter().flat_map(|m| list[*m].vertices.iter().copied());
    (points().fold(DVec3::INFINITY, DVec3::min), points().fold(DVec3::NEG_INFINITY, DVec3::max))
}

/// Edges between welded corners, and how often they are used.
struct Edges {
    /// Of each face, its first among the corners of all faces.
    first: Vec<usize>,
    /// By corner: how many faces use the edge that begins there in this direction, and in the other.
    uses: Vec<(u32, u32)>,
    /// Faces of the same component are joined.
    sets: DisjointSets,
}

impl Edges {
    fn new(list: &[Surface]) -> Self {
        let mut first = Vec::with_capacity(list.len());
        let mut edges = Vec::new();
        let points = weld(list);
        for (face, s) in list.iter().enumerate() {
            let start = edges.len();
            first.push(start);
            let n = s.vertices.len();
            edges.extend((0..n).map(|k| {
                let (a, b) = (points[start + k], points[start + (k + 1) % n]);
                Edge { ends: (a.min(b), a.max(b)), forward: a <= b, corner: (start + k) as u32, face: face as u32 }
            }));
        }
        let mut uses = vec![(0, 0); edges.len()];
        let mut sets = DisjointSets::new(list.len());
        edges.par_sort_unstable();
        for same in edges.chunk_by(|a, b| a.ends == b.ends) {
            let forward = same.iter().filter(|e| e.forward).count() as u32;
            let back = if same[0].ends.0 == same[0].ends.1 { forward } else { same.len() as u32 - forward };
            for e in same {
                uses[e.corner as usize] = if e.forward { (forward, back) } else { (back, forward) };
                sets.join(same[0].face as usize, e.face as usize);
            }
        }
        Self { first, uses, sets }
    }
}

#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    ends: (u32, u32),
    forward: bool,
    /// Where it begins.
    corner: u32,
    face: u32,
}

/// The number of the welded point of each corner of all faces.
fn weld(list: &[Surface]) -> Vec<u32> {
    // Cells several times the touching distance; equal corners of one file are equal to rounding.
    let cell = |p: &DVec3| (p / (4.0 * TOUCH)).round().to_array().map(|x| x as i64);
    let mut corners: Vec<([i64; 3], u32)> = list.iter().flat_map(|s| &s.vertices).map(cell).zip(0..).collect();
    corners.par_sort_unstable();
    let mut points = vec![0; corners.len()];
    for (point, same) in corners.chunk_by(|a, b| a.0 == b.0).enumerate() {
        same.iter().for_each(|(_, corner)| points[*corner as usize] = point as u32);
    }
    points
}

/// Each set is a tree whose root is its lowest member.
struct DisjointSets(Vec<usize>);

impl DisjointSets {
    fn new(len: usize) -> Self {
        Self((0..len).collect())
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }

    /// The sets, each in ascending order.
    fn list(&mut self) -> Vec<Vec<usize>> {
        let mut sets = vec![Vec::new(); self.0.len()];
        for i in 0..sets.len() {
            sets[self.root(i)].push(i);
        }
        sets.retain(|s| !s.is_empty());
        sets
    }
}
