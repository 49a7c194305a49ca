//! What a point sees of the sky, kept: the sun's disc is cut by it hour after hour.

use glam::DVec3;

use super::DirectScratch;
use super::daylight::{Eye, SUN, with_eye};
use super::visible::{Piece, cone_planes};
use super::world::World;
use crate::light::{above_plane, configuration_factor, sun};

/// More of them at one point are not kept.
const MAX_OPENINGS: usize = 512;

/// The convex cones of directions in which a point sees the sky, none of which overlap, with the panes before each.
#[derive(Debug, Default)]
pub struct Openings {
    list: Vec<Opening>,
    /// Inward unit normals of the planes of all, one after the other.
    planes: Vec<DVec3>,
    panes: Vec<u32>,
    is_incomplete: bool,
}

/// Ends of its planes and panes in the lists of all.
#[derive(Clone, Copy, Debug)]
struct Opening {
    planes: u32,
    panes: u32,
}

impl Openings {
    /// They are not all of what the point sees: rays had to be sent for the rest.
    pub(super) fn give_up(&mut self) {
        self.is_incomplete = true;
    }

    pub(super) fn keep(&mut self, piece: &Piece, planes: &mut Vec<DVec3>) {
        if self.list.len() == MAX_OPENINGS {
            self.give_up();
        }
        if self.is_incomplete {
            return;
        }
        cone_planes(&piece.polygon, planes);
        self.planes.extend_from_slice(planes);
        self.panes.extend_from_slice(piece.panes());
        self.list.push(Opening { planes: self.planes.len() as u32, panes: self.panes.len() as u32 });
    }

    /// The openings, where they are all of what the point sees.
    #[must_use]
    pub fn whole(mut self) -> Option<Self> {
        self.list.shrink_to_fit();
        self.planes.shrink_to_fit();
        self.panes.shrink_to_fit();
        (!self.is_incomplete).then_some(self)
    }
}

/// Adds the factors of the sun's disc about `direction` at a point whose openings are known: the same as
/// [`super::sun_factor`], without another look at the scene.
pub fn sun_through(
    world: &World,
    at: (DVec3, DVec3),
    openings: &Openings,
    direction: DVec3,
    scratch: &mut DirectScratch,
    out: &mut [f64],
) {
    with_eye(world, at, 0, &mut scratch.sky, |eye, s| {
        s.through.clear();
        let (mut plane, mut pane) = (0, 0);
        for o in &openings.list {
            let planes = &openings.planes[plane..o.planes as usize];
            let panes = &openings.panes[pane..o.panes as usize];
            (plane, pane) = (o.planes as usize, o.panes as usize);
            let share = share_within(eye, planes, direction);
            if share > 0.0 {
                eye.enter(panes, direction, (SUN, share), &mut s.tint, out);
                s.through.extend_from_slice(panes);
            }
        }
    });
}

/// Irradiance by the part of the sun's disc within a cone, per unit of that of the whole disc face on.
fn share_within(eye: &Eye<'_>, planes: &[DVec3], direction: DVec3) -> f64 {
    let inside = planes.iter().map(|n| n.dot(direction)).fold(f64::INFINITY, f64::min);
    if inside <= -sun::DISC_REACH {
        return 0.0;
    }
    if inside >= sun::DISC_REACH {
        // The irradiance by a regular polygon points to its middle.
        return eye.normal.dot(direction).max(0.0);
    }
    let disc = sun::disc(direction);
    let (mut part, mut rest) = (disc.to_vec(), Vec::with_capacity(16));
    for n in planes {
        above_plane(&part, *n, 0.0, &mut rest);
        std::mem::swap(&mut part, &mut rest);
    }
    if part.len() < 3 { 0.0 } else { configuration_factor(&part, eye.normal) / configuration_factor(&disc, direction) }
}
