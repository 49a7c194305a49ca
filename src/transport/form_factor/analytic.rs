//! Analytic form factors: contour integrals where nothing stands between, exact clipping inside a quadrature elsewhere.

use glam::{DVec2, DVec3};

use super::contour::exchange_area;
use super::quadrature::gauss_legendre;
use super::shaft::{Bounds, Shaft};
use super::{Method, Work};
use crate::light::Emitter;
use crate::mesh::{Patch, PatchMesh, polygon_area};
use crate::transport::World;
use crate::transport::visible_factor;

/// Points along each side of the outer quadrature of a partly blocked pair.
const RULES: [usize; 4] = [2, 4, 8, 16];
/// Change of a form factor between two rules that ends the refinement: relative, and of the whole hemisphere.
const RELATIVE: f64 = 1e-3;
const ABSOLUTE: f64 = 2e-6;
/// Distance, in units of the scene's size, below which two things touch.
const TOUCH: f64 = 2e-6;

/// Analytic form factors of a mesh.
#[derive(Debug)]
pub struct Analytic<'a> {
    world: &'a World,
    patches: &'a [Patch],
    senders: Vec<Emitter>,
    bounds: Vec<Bounds>,
    blockers: Vec<Bounds>,
}

impl<'a> Analytic<'a> {
    /// Prepares the patches of a mesh.
    #[must_use]
    pub fn new(world: &'a World, mesh: &'a PatchMesh) -> Self {
        Self {
            world,
            patches: &mesh.list,
            senders: mesh.list.iter().map(sender).collect(),
            bounds: mesh.list.iter().map(|p| Bounds::new(&p.polygon)).collect(),
            blockers: world.surfaces.list.iter().map(|s| Bounds::new(&s.vertices)).collect(),
        }
    }

    /// Factor of patch `j` at a point: irradiance per unit radiosity.
    #[must_use]
    pub fn at_point(&self, x: DVec3, normal: DVec3, j: usize, work: &mut Work) -> f64 {
        let stream = j as u64;
        visible_factor(self.world, &self.senders[j], x, normal, stream, &mut work.scratch)
    }

    /// Exchange area of a patch `a` (of this mesh or a finer one) with patch `j`.
    #[must_use]
    pub fn between(&self, a: &Patch, j: usize, work: &mut Work) -> f64 {
        let b = &self.patches[j];
        if !face_each_other(a, b) {
            return 0.0;
        }
        let bounds_a = Bounds::new(&a.polygon);
        if !self.may_be_blocked(a, &bounds_a, b, &self.bounds[j]) {
            work.factors += 1;
            return exchange_area(&a.polygon, a.normal, &b.polygon, b.normal);
        }
        // The exact integral goes over the larger patch, the quadrature over the smaller.
        if a.area <= b.area { self.partly(a, &self.senders[j], work) } else { self.partly(b, &sender(a), work) }
    }

    fn may_be_blocked(&self, a: &Patch, bounds_a: &Bounds, b: &Patch, bounds_b: &Bounds) -> bool {
        let mut shaft = None;
        self.world.surfaces.list.iter().zip(&self.blockers).enumerate().any(|(k, (s, bounds))| {
            let k = k as u32;
            k != a.surface
                && k != b.surface
                && [a, b].iter().all(|p| s.vertices.iter().any(|v| (*v - p.polygon[0]).dot(p.normal) > TOUCH))
                && shaft.get_or_insert_with(|| Shaft::new(bounds_a, bounds_b)).touches(s, bounds)
        })
    }

    /// Exchange area by quadrature over `receiver` of the exact factor of what is seen of `sender`.
    fn partly(&self, receiver: &Patch, sender: &Emitter, work: &mut Work) -> f64 {
        let surface = &self.world.surfaces.list[receiver.surface as usize];
        let mut last = f64::INFINITY;
        for (level, points) in RULES.into_iter().enumerate() {
            let mut mean = 0.0;
            for (k, (uv, weight)) in polygon_rule(&receiver.outline, points).enumerate() {
                let x = surface.point(uv);
                let stream = ((level as u64) << 16) | k as u64;
                mean += weight * visible_factor(self.world, sender, x, receiver.normal, stream, &mut work.scratch);
            }
            if (mean - last).abs() <= (RELATIVE * mean).max(ABSOLUTE) {
                return mean * receiver.area;
            }
            last = mean;
        }
        last * receiver.area
    }
}

impl Method for Analytic<'_> {
    fn describe(&self) -> String {
        "analytic: contour integrals, exact clipping where something stands between".into()
    }

    fn row(&self, i: usize, row: &mut [f64], work: &mut Work) {
        let a = &self.patches[i];
        for (j, f) in row.iter_mut().enumerate() {
            *f = self.between(a, j, work) / a.area;
        }
    }

    fn exchange(&self, i: usize, j: usize, work: &mut Work) -> Option<f64> {
        Some(self.between(&self.patches[i], j, work))
    }
}

fn sender(p: &Patch) -> Emitter {
    Emitter {
        surface: p.surface as usize,
        front: p.front,
        vertices: p.polygon.clone(),
        normal: p.normal,
        group: 0,
        area: p.area,
    }
}

/// Is any of each before the other?
fn face_each_other(a: &Patch, b: &Patch) -> bool {
    let before = |p: &Patch, q: &Patch| q.polygon.iter().any(|v| (*v - p.polygon[0]).dot(p.normal) > 1e-12);
    before(a, b) && before(b, a)
}

/// Points of a convex polygon with weights that sum to one: a product of Gauss rules on a parallelogram, on the triangles
/// of a fan otherwise.
fn polygon_rule(outline: &[DVec2], points: usize) -> impl Iterator<Item = (DVec2, f64)> {
    let first = outline[0];
    let mut quads: Vec<[DVec2; 4]> = Vec::new();
    match *outline {
        [a, b, c, d] if (a + c - b - d).abs().max_element() < 1e-12 => quads.push([a, b, c, d]),
        _ => quads.extend(outline[1..].windows(2).map(|e| [first, e[0], e[1], first])),
    }
    let total = polygon_area(outline);
    let rule = gauss_legendre(points);
    quads.into_iter().flat_map(move |[a, b, c, d]| {
        rule.iter().flat_map(move |(s, ws)| {
            rule.iter().map(move |(t, wt)| {
                let point = (a * (1.0 - s) + b * *s) * (1.0 - t) + (d * (1.0 - s) + c * *s) * *t;
                let du = (b - a) * (1.0 - t) + (c - d) * *t;
                let dv = (d - a) * (1.0 - s) + (c - b) * *s;
                (point, ws * wt * du.perp_dot(dv).abs() / total)
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_integrate_squares_over_polygons() {
        // ∫ x² over the unit square is 1/3, over the triangle below its diagonal 1/4 of the unit, mean 1/2.
        let square = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let triangle = [DVec2::ZERO, DVec2::X, DVec2::ONE];
        for (outline, mean) in [(&square[..], 1.0 / 3.0), (&triangle[..], 0.5)] {
            let value: f64 = polygon_rule(outline, 3).map(|(p, w)| w * p.x * p.x).sum();
            let weight: f64 = polygon_rule(outline, 3).map(|(_, w)| w).sum();
            assert!((value - mean).abs() < 1e-14 && (weight - 1.0).abs() < 1e-14, "{value} {weight}");
        }
    }
}
