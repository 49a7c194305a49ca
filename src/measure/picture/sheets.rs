//! Planes on which reflected light changes smoothly: neighbouring faces of one wall are one sheet.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::sight::Sight;
use crate::transport::World;
use crate::transport::caster::MISS;

/// Faces are in one plane where normals (1 over this) and heights (in the program's frame) agree.
const NORMALS: f64 = 1e5;
const HEIGHTS: f64 = 1e6;
const NONE: u32 = u32::MAX;

/// The sides of faces that a picture shows, sorted into planes.
#[derive(Debug)]
pub(super) struct Sheets {
    /// By surface and side.
    of: Vec<[u32; 2]>,
    /// Axes in each plane.
    axes: Vec<[DVec3; 2]>,
}

impl Sheets {
    pub(super) fn new<'a>(world: &World, sights: impl Iterator<Item = &'a Sight>) -> Self {
        let sides: std::collections::BTreeSet<(u32, bool)> =
            sights.filter(|s| s.surface != MISS).map(|s| (s.surface, s.front)).collect();
        let mut planes: BTreeMap<[i64; 4], u32> = BTreeMap::new();
        let (mut of, mut axes) = (vec![[NONE; 2]; world.surfaces.list.len()], Vec::new());
        for (surface, front) in sides {
            let s = &world.surfaces.list[surface as usize];
            let n = s.side_normal(front);
            let round = |x: f64, steps: f64| (x * steps).round() as i64;
            let plane =
                [round(n.x, NORMALS), round(n.y, NORMALS), round(n.z, NORMALS), round(n.dot(s.origin), HEIGHTS)];
            let sheet = *planes.entry(plane).or_insert_with(|| {
                axes.push(s.axes);
                axes.len() as u32 - 1
            });
            of[surface as usize][usize::from(front)] = sheet;
        }
        Self { of, axes }
    }

    pub(super) fn len(&self) -> usize {
        self.axes.len()
    }

    /// The sheet of a sight and where on it; `None` for what no pixel's middle shows.
    pub(super) fn place(&self, sight: &Sight) -> Option<(u32, DVec2)> {
        let sheet = self.of.get(sight.surface as usize)?[usize::from(sight.front)];
        if sheet == NONE {
            return None;
        }
        let [u, v] = self.axes[sheet as usize];
        Some((sheet, DVec2::new(u.dot(sight.point), v.dot(sight.point))))
    }
}
