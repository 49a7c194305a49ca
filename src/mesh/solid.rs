//! Which surfaces enclose the inside of a solid.
//!
//! A connected set of faces is a solid when its edges close (or end on another surface: a block that stands on
//! the floor without a bottom of its own) and its faces look outward. What lies behind them is dark for good:
//! a sample that sees such a back face first lies inside the solid and must not count.

use std::collections::HashMap;

use glam::DVec3;

use super::surfaces::{Surface, TOUCH};

type Cell = [i64; 3];

/// Marks the faces of solids; what has a face of a material that lets light in is none.
pub(super) fn mark_solids(list: &mut [Surface], neighbours: &[Vec<u32>], lets_light_in: impl Fn(usize) -> bool) {
    let edges = Edges::new(list);
    let components = edges.components(list.len());
    let bounds = bounds_of(list, &(0..list.len()).collect::<Vec<_>>());
    for members in components {
        let is_dark = !members.iter().any(|m| lets_light_in(list[*m].material));
        if is_dark && is_solid(list, neighbours, &edges, &members, bounds) {
            for m in members {
                list[m].solid = true;
            }
        }
    }
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
            match edges.use_of(a, b) {
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

/// Directed edges by welded end points, with the faces that use them.
struct Edges(HashMap<(Cell, Cell), Vec<usize>>);

impl Edges {
    fn new(list: &[Surface]) -> Self {
        let mut map: HashMap<(Cell, Cell), Vec<usize>> = HashMap::new();
        for (i, s) in list.iter().enumerate() {
            for k in 0..s.vertices.len() {
                let (a, b) = (s.vertices[k], s.vertices[(k + 1) % s.vertices.len()]);
                map.entry((weld(a), weld(b))).or_default().push(i);
            }
        }
        Self(map)
    }

    /// How often the edge is used in this direction and in the other.
    fn use_of(&self, a: DVec3, b: DVec3) -> (usize, usize) {
        let count = |k: &(Cell, Cell)| self.0.get(k).map_or(0, Vec::len);
        (count(&(weld(a), weld(b))), count(&(weld(b), weld(a))))
    }

    /// Sets of faces joined by shared edges, each in ascending order.
    fn components(&self, faces: usize) -> Vec<Vec<usize>> {
        let mut parent: Vec<usize> = (0..faces).collect();
        fn root(parent: &mut [usize], mut i: usize) -> usize {
            while parent[i] != i {
                parent[i] = parent[parent[i]];
                i = parent[i];
            }
            i
        }
        #[expect(clippy::iter_over_hash_type, reason = "union of sets: the order cannot reach the result")]
        for (key, users) in &self.0 {
            let back = self.0.get(&(key.1, key.0)).map_or(&[][..], Vec::as_slice);
            for pair in users.iter().chain(back).collect::<Vec<_>>().windows(2) {
                let (a, b) = (root(&mut parent, *pair[0]), root(&mut parent, *pair[1]));
                let (low, high) = (a.min(b), a.max(b));
                parent[high] = low;
            }
        }
        let mut sets: Vec<Vec<usize>> = vec![Vec::new(); faces];
        for i in 0..faces {
            let r = root(&mut parent, i);
            sets[r].push(i);
        }
        sets.retain(|s| !s.is_empty());
        sets
    }
}

fn weld(p: DVec3) -> Cell {
    // Cells several times the touching distance; equal corners of one file are equal to rounding.
    (p / (4.0 * TOUCH)).round().to_array().map(|x| x as i64)
}
