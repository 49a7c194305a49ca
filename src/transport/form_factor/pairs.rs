//! Exchange between two patches: contour integrals where nothing stands between, exact clipping inside a quadrature elsewhere.

use glam::{DVec2, DVec3};

use super::Work;
use super::contour::exchange_area;
use super::quadrature::gauss_legendre;
use super::shaft::{Bounds, Shaft};
use crate::light::{Emitter, above_plane, configuration_factor};
use crate::mesh::{Patch, polygon_area};
use crate::transport::World;
use crate::transport::visible_factor;

/// Points along each side of the outer quadrature of a partly blocked pair.
const RULES: [usize; 4] = [2, 4, 8, 16];
/// Points along each side that tell how a factor varies: the outer ones lie near the border.
const LOOKS: usize = 3;
/// Change of a form factor between two rules that ends the refinement: relative, and of the whole hemisphere.
const RELATIVE: f64 = 1e-3;
const ABSOLUTE: f64 = 2e-6;
/// Distance, in units of the scene's size, below which two things touch.
const TOUCH: f64 = 2e-6;

/// Any two patches of a scene.
#[derive(Debug)]
pub struct Pairs<'a> {
    world: &'a World,
    bounds: Vec<Bounds>,
}

/// The factor of a sender over a receiver: irradiance per unit radiosity.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    /// Largest less least, over points that show how it varies.
    pub seen: f64,
    /// Largest if nothing stood between.
    pub open: f64,
}

impl<'a> Pairs<'a> {
    /// Looks at the surfaces of a scene.
    #[must_use]
    pub fn new(world: &'a World) -> Self {
        Self { world, bounds: world.surfaces.list.iter().map(|s| Bounds::new(&s.vertices)).collect() }
    }

    /// All surfaces.
    pub fn all(&self) -> impl Iterator<Item = u32> + use<> {
        0..self.bounds.len() as u32
    }

    /// Which of some surfaces may stand between two patches.
    pub fn blockers<'b>(
        &'b self,
        a: &'b Patch,
        b: &'b Patch,
        among: impl Iterator<Item = u32> + 'b,
    ) -> impl Iterator<Item = u32> + 'b {
        let mut shaft = None;
        among.filter(move |&k| {
            let s = &self.world.surfaces.list[k as usize];
            k != a.surface
                && k != b.surface
                && [a, b].iter().all(|p| s.vertices.iter().any(|v| (*v - p.polygon[0]).dot(p.normal) > TOUCH))
                && shaft
                    .get_or_insert_with(|| Shaft::new(&Bounds::new(&a.polygon), &Bounds::new(&b.polygon)))
                    .touches(s, &self.bounds[k as usize])
        })
    }

    /// Exchange area of two patches that face each other; `blocked` where anything may stand between.
    #[must_use]
    pub fn exchange(&self, a: &Patch, b: &Patch, blocked: bool, work: &mut Work) -> f64 {
        if !blocked {
            work.factors += 1;
            return exchange_area(&a.polygon, a.normal, &b.polygon, b.normal);
        }
        // The exact integral goes over the larger patch, the quadrature over the smaller.
        if a.area <= b.area { self.partly(a, b, work) } else { self.partly(b, a, work) }
    }

    /// Exchange area by quadrature over `receiver` of the exact factor of what is seen of `sent`.
    fn partly(&self, receiver: &Patch, sent: &Patch, work: &mut Work) -> f64 {
        let (surface, sender) = (&self.world.surfaces.list[receiver.surface as usize], sender(sent));
        let mut last = f64::INFINITY;
        for (level, points) in RULES.into_iter().enumerate() {
            let mut mean = 0.0;
            for (k, (uv, weight)) in polygon_rule(&receiver.outline, points).enumerate() {
                let x = surface.point(uv);
                let stream = ((level as u64) << 16) | k as u64;
                mean += weight * visible_factor(self.world, &sender, x, receiver.normal, stream, &mut work.scratch);
            }
            if (mean - last).abs() <= (RELATIVE * mean).max(ABSOLUTE) {
                return mean * receiver.area;
            }
            last = mean;
        }
        last * receiver.area
    }

    /// How the factor of one patch varies over another: at the points of a small rule, and opposite the sender's middle,
    /// where a large receiver may hide a peak from the rule.
    #[must_use]
    pub fn spread(&self, receiver: &Patch, sent: &Patch, blocked: bool, work: &mut Work) -> Spread {
        let (surface, sender) = (&self.world.surfaces.list[receiver.surface as usize], sender(sent));
        let opposite = Some(surface.uv(sent.centre)).filter(|uv| receiver.holds(*uv));
        let points = polygon_rule(&receiver.outline, LOOKS).map(|p| p.0).chain(opposite);
        let (mut least, mut most, mut open) = (f64::INFINITY, 0.0f64, 0.0f64);
        for (k, uv) in points.enumerate() {
            let x = surface.point(uv);
            let whole = open_factor(&sender, x, receiver.normal);
            let seen = if blocked && whole > 0.0 {
                visible_factor(self.world, &sender, x, receiver.normal, k as u64, &mut work.scratch)
            } else {
                work.factors += 1;
                whole
            };
            (least, most, open) = (least.min(seen), most.max(seen), open.max(whole));
        }
        Spread { seen: most - least, open }
    }
}

/// Irradiance per unit exitance of a whole polygon, whatever stands between.
fn open_factor(sender: &Emitter, x: DVec3, normal: DVec3) -> f64 {
    if sender.normal.dot(x - sender.vertices[0]) <= 1e-9 {
        return 0.0; // behind it or in its plane
    }
    let whole: Vec<DVec3> = sender.vertices.iter().map(|v| *v - x).collect();
    let mut above = Vec::with_capacity(whole.len() + 1);
    above_plane(&whole, normal, 0.0, &mut above);
    configuration_factor(&above, normal)
}

pub(super) fn sender(p: &Patch) -> Emitter {
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
#[must_use]
pub fn face_each_other(a: &Patch, b: &Patch) -> bool {
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
