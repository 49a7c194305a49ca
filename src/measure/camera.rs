//! Pixels and directions.

use glam::DVec3;

use crate::mesh::Frame;
use crate::scene::{Projection, View};

/// A view in the program's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    projection: Projection,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Camera {
    pub(super) fn new(view: &View, frame: &Frame) -> Self {
        Self {
            eye: frame.to_local(view.position),
            forward: view.direction,
            right: view.direction.cross(view.up),
            up: view.up,
            projection: view.projection,
            width: view.width,
            height: view.height,
        }
    }

    pub(super) fn eye(&self) -> DVec3 {
        self.eye
    }

    /// Direction through a point of the picture, in pixels from the top left; `None` outside a fisheye's circle.
    pub(super) fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let u = 2.0 * x / self.width as f64 - 1.0;
        let v = 1.0 - 2.0 * y / self.height as f64;
        match self.projection {
            Projection::Perspective { horizontal, vertical } => {
                let (h, w) = ((horizontal / 2.0).tan() * u, (vertical / 2.0).tan() * v);
                Some((self.forward + self.right * h + self.up * w).normalize())
            }
            Projection::Fisheye { angle } => {
                let r = u.hypot(v);
                if r > 1.0 {
                    return None;
                }
                let theta = r * angle / 2.0;
                let across = if r > 0.0 { (self.right * u + self.up * v) / r } else { DVec3::ZERO };
                Some(self.forward * theta.cos() + across * theta.sin())
            }
            Projection::Panorama => {
                let (phi, theta) = (u * std::f64::consts::PI, v * std::f64::consts::FRAC_PI_2);
                let level = self.forward * phi.cos() + self.right * phi.sin();
                Some(level * theta.cos() + self.up * theta.sin())
            }
        }
    }
    /// Angle between neighbouring pixels at a place of the picture, radians.
    pub(super) fn pixel_angle(&self, x: f64, y: f64) -> f64 {
        let at = |x: f64, y: f64| self.direction(x.clamp(0.0, self.width as f64), y);
        let middle = (self.width as f64 * 0.5, self.height as f64 * 0.5);
        let here = at(x, y).zip(at(x + if x < middle.0 { 1.0 } else { -1.0 }, y));
        // Outside a fisheye's circle, where nothing is seen, any will do.
        let (a, b) = here.unwrap_or((self.forward, self.forward));
        a.cross(b).length()
    }
}
