//! Where a set of faces ends: edges that no neighbour answers.
//!
//! Edges that meet end to end are cancelled by their welded ends; what is left is compared as intervals on
//! its carrying line, so that a long edge against several short ones (T-vertices) closes too.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;

/// Part of an edge used more often in one direction than in the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OpenEdge {
    pub(crate) from: DVec3,
    pub(crate) to: DVec3,
    /// How many faces too many run along it from `from` to `to`: 1 an open edge, 2 two faces wound
    /// against each other.
    pub(crate) net: u32,
}

/// Gives points closer than a tolerance the same number.
#[derive(Debug)]
pub(crate) struct Welder {
    tolerance: f64,
    cells: HashMap<[i64; 3], Vec<usize>>,
    points: Vec<DVec3>,
}

impl Welder {
    /// Points within `tolerance` (metres) are one.
    pub(crate) fn new(tolerance: f64) -> Self {
        Self { tolerance: tolerance.max(f64::MIN_POSITIVE), cells: HashMap::new(), points: Vec::new() }
    }

    /// Number of the point.
    pub(crate) fn id(&mut self, p: DVec3) -> usize {
        let cell = (p / (2.0 * self.tolerance)).floor();
        let cell = [cell.x as i64, cell.y as i64, cell.z as i64];
        if let Some(id) = self.near(p, cell) {
            return id;
        }
        self.points.push(p);
        self.cells.entry(cell).or_default().push(self.points.len() - 1);
        self.points.len() - 1
    }

    fn near(&self, p: DVec3, cell: [i64; 3]) -> Option<usize> {
        for i in 0..27 {
            let at = |axis: usize, d: i64| cell[axis].saturating_add(d - 1);
            let Some(ids) = self.cells.get(&[at(0, i % 3), at(1, i / 3 % 3), at(2, i / 9)]) else {
                continue;
            };
            if let Some(id) = ids.iter().find(|id| self.points[**id].distance(p) <= self.tolerance) {
                return Some(*id);
            }
        }
        None
    }

    /// The point of a number.
    pub(crate) fn point(&self, id: usize) -> DVec3 {
        self.points[id]
    }
}

/// Distance below which two vertices of a scene are one: 1e-9 of its size, and never below rounding.
pub(crate) fn weld_tolerance(lo: DVec3, hi: DVec3) -> f64 {
    1e-9 * (hi - lo).length() + 8.0 * f64::EPSILON * lo.abs().max(hi.abs()).max_element()
}

/// The open edges of a set of faces.
pub(crate) fn open_edges<'a>(rings: impl IntoIterator<Item = &'a [DVec3]>, tolerance: f64) -> Vec<OpenEdge> {
    let mut welder = Welder::new(tolerance);
    let mut net: BTreeMap<(usize, usize), i64> = BTreeMap::new();
    for ring in rings {
        let ids: Vec<usize> = ring.iter().map(|p| welder.id(*p)).collect();
        for i in 0..ids.len() {
            let (a, b) = (ids[i], ids[(i + 1) % ids.len()]);
            *net.entry((a.min(b), a.max(b))).or_default() += (b as i64 - a as i64).signum();
        }
    }
    let mut lines: BTreeMap<[i64; 6], Line> = BTreeMap::new();
    for ((a, b), count) in net {
        if count != 0 && a != b {
            add_to_line(&mut lines, welder.point(a), welder.point(b), count, tolerance);
        }
    }
    lines.values().flat_map(|line| line.open(tolerance)).collect()
}

/// A carrying line with the intervals on it.
struct Line {
    foot: DVec3,
    direction: DVec3,
    /// Parameter along the line, change of the count there.
    events: Vec<(f64, i64)>,
}

fn add_to_line(lines: &mut BTreeMap<[i64; 6], Line>, a: DVec3, b: DVec3, count: i64, tolerance: f64) {
    let direction = upright((b - a).normalize());
    let foot = a - direction * a.dot(direction);
    let cell = 1e3 * tolerance;
    let key = |v: DVec3, cell: f64| [v.x, v.y, v.z].map(|x| (x / cell).round() as i64);
    let (d, f) = (key(direction, 1e-5), key(foot, cell));
    let line = lines.entry([d[0], d[1], d[2], f[0], f[1], f[2]]).or_insert_with(|| Line {
        foot,
        direction,
        events: Vec::new(),
    });
    let (from, to) = (a.dot(line.direction), b.dot(line.direction));
    let (lo, hi, count) = if from < to { (from, to, count) } else { (to, from, -count) };
    line.events.push((lo, count));
    line.events.push((hi, -count));
}

/// The direction or its opposite, so that both name the same line.
fn upright(d: DVec3) -> DVec3 {
    let lead = [d.x, d.y, d.z].into_iter().find(|c| c.abs() > 1e-6).unwrap_or(1.0);
    if lead < 0.0 { -d } else { d }
}

impl Line {
    /// Stretches with a count other than zero.
    fn open(&self, tolerance: f64) -> Vec<OpenEdge> {
        let mut events = self.events.clone();
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut found = Vec::new();
        let mut count = 0;
        for pair in events.windows(2) {
            count += pair[0].1;
            if count != 0 && pair[1].0 - pair[0].0 > 4.0 * tolerance {
                let (lo, hi) = (self.foot + self.direction * pair[0].0, self.foot + self.direction * pair[1].0);
                let (from, to) = if count > 0 { (lo, hi) } else { (hi, lo) };
                found.push(OpenEdge { from, to, net: count.unsigned_abs() as u32 });
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[(f64, f64)]) -> Vec<DVec3> {
        points.iter().map(|(x, y)| DVec3::new(*x, *y, 1.0)).collect()
    }

    fn length(edges: &[OpenEdge]) -> f64 {
        edges.iter().map(|e| e.from.distance(e.to)).sum()
    }

    #[test]
    fn t_vertices_close() {
        let left = ring(&[(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (0.0, 2.0)]);
        let low = ring(&[(1.0, 0.0), (2.0, 0.0), (2.0, 0.7), (1.0, 0.7)]);
        let high = ring(&[(1.0, 0.7), (2.0, 0.7), (2.0, 2.0), (1.0, 2.0)]);
        let open = open_edges([&left[..], &low, &high], 1e-9);
        assert!((length(&open) - 8.0).abs() < 1e-9 && open.iter().all(|e| e.net == 1), "{open:?}");
    }

    #[test]
    fn neighbours_wound_against_each_other_count_twice() {
        let a = ring(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        let mut b = ring(&[(1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0)]);
        b.reverse();
        let open = open_edges([&a[..], &b], 1e-9);
        assert_eq!(open.iter().filter(|e| e.net == 2).count(), 1);
    }
}
