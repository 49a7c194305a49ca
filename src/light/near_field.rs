//! From which distance on a luminaire may be taken as a point.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::luminaires::{Luminaire, LuminousFace, Shape};
use super::photometry::Photometry;
use crate::mesh::sample_polygon;

/// Error of the point model that is told of, relative.
const ALLOWED: f64 = 0.01;
/// Places of a face or a line: a lattice by the golden ratio.
const PLACES: u32 = 1024;
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Angles between the directions that are looked at, degrees.
const STEP_DEG: f64 = 10.0;
/// Directions with less than this share of the peak do not count.
const WEAK: f64 = 0.1;
/// Largest distance, in units of the opening's extent.
const FARTHEST: f64 = 1000.0;

/// Distance, m, beyond which the inverse-square law holds within 1 % for a surface that faces the luminaire, in any
/// direction of the planes C0, C90, C180 and C270 that gets at least a tenth of the peak. The truth that it is compared
/// with is the luminous opening with one luminance in each direction.
#[must_use]
pub fn point_distance_m(photometry: &Photometry) -> f64 {
    let web = Arc::new(photometry.web.clone());
    let l = Luminaire::hung(web, &photometry.opening, DVec3::ZERO, DMat3::IDENTITY, (0, 0));
    let steps = (180.0 / STEP_DEG) as u32;
    let directions =
        (0..4u32).flat_map(|plane| (0..=steps).map(move |k| (f64::from(k) * STEP_DEG, 90.0 * f64::from(plane))));
    directions
        .map(|(vertical, horizontal)| l.axes * l.web.direction(vertical, horizontal))
        .filter(|d| l.intensity(*d) >= WEAK * l.peak_cd && l.peak_cd > 0.0)
        .map(|d| distance_along(&l, d))
        .fold(0.0, f64::max)
}

/// The same in one direction.
fn distance_along(l: &Luminaire, direction: DVec3) -> f64 {
    let extent = l.corners.iter().map(|c| 2.0 * c.distance(l.position)).fold(0.0, f64::max);
    if extent == 0.0 {
        return 0.0;
    }
    let is_off = |distance: f64| {
        let point = l.intensity(direction) / (distance * distance);
        (point / facing_lx(l, direction, distance) - 1.0).abs() > ALLOWED
    };
    // From far away inwards: the first distance at which it is off.
    let (mut good, mut factor) = (FARTHEST * extent, 0.7);
    while factor < 0.999 {
        let next = good * factor;
        if next > 0.5 * extent && !is_off(next) {
            good = next;
        } else {
            factor = factor.sqrt();
        }
    }
    good
}

/// Illuminance of a surface that faces the luminaire's centre from a distance, lx.
fn facing_lx(l: &Luminaire, direction: DVec3, distance: f64) -> f64 {
    let x = l.position + direction * distance;
    let place = |k: u32| ((f64::from(k) + 0.5) / f64::from(PLACES), (0.5 + f64::from(k) * GOLDEN).fract());
    let faced = |p: DVec3| {
        let d = p - x;
        (d, -direction.dot(d) / d.length().powi(3))
    };
    match &l.shape {
        Shape::Point => l.intensity(direction) / (distance * distance),
        Shape::Line([from, to]) => {
            let of = |k: u32| {
                let (d, kernel) = faced(from.lerp(*to, place(k).0));
                l.intensity(-d) * kernel.max(0.0)
            };
            (0..PLACES).map(of).sum::<f64>() / f64::from(PLACES)
        }
        Shape::Faces(faces) => {
            let of = |f: &LuminousFace, k: u32| {
                let uv = sample_polygon(&f.surface.outline, place(k).0, place(k).1);
                let (d, kernel) = faced(f.surface.point(uv));
                let seen = -f.surface.normal.dot(d);
                let all = l.projected_area(-d);
                if seen <= 0.0 || all <= 0.0 {
                    return 0.0;
                }
                let share = f.surface.area / f64::from(PLACES) * seen / all;
                l.intensity(-d) * kernel.max(0.0) * share
            };
            faces.iter().map(|f| (0..PLACES).map(|k| of(f, k)).sum::<f64>()).sum()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::photometry::{Opening, PhotometricType, Web};

    fn lambertian(opening: Opening) -> Photometry {
        let blank = Photometry::parse(b"TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 0\n0 180\n0\n1 1\n", "x.ies".as_ref());
        let angles: Vec<f64> = (0..=180).map(|k| 0.5 * f64::from(k)).collect();
        let candela = angles.iter().map(|a| 1000.0 * a.to_radians().cos().max(0.0)).collect();
        let web = Web::new(PhotometricType::C, angles, vec![0.0], candela).unwrap();
        Photometry { web, opening, ..blank.unwrap() }
    }

    #[test]
    fn a_disc_is_a_point_from_five_diameters_on() {
        // E = π L r²/(r² + d²) against π L r²/d²: 1 % off where d² = 100 r²; to the sides it is less.
        let p = lambertian(Opening { along_c0_m: 0.4, along_c90_m: 0.4, height_m: 0.0, round: true });
        let distance_m = point_distance_m(&p);
        // A lattice of 1024 places tells the second moment to less than a percent, its root to half of that.
        assert!((distance_m / 2.0 - 1.0).abs() < 0.005, "{distance_m}");
    }

    #[test]
    fn a_long_panel_is_a_point_from_further_away_than_a_short_one() {
        let of = |x, y| point_distance_m(&lambertian(Opening { along_c0_m: x, along_c90_m: y, ..Opening::default() }));
        let (long, short) = (of(1.2, 0.3), of(0.3, 0.3));
        assert!(long > 3.0 * short, "{long} {short}");
        assert_eq!(of(0.0, 0.0), 0.0);
        // Twice the size, twice the distance; the search ends within 0.1 %.
        assert!((of(2.4, 0.6) / (2.0 * long) - 1.0).abs() < 2e-3);
    }
}
