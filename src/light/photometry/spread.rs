//! How wide a luminaire throws its light: beam and field angles.

use super::{PhotometricType, Web};

/// Full angles, degrees, within which the intensity is at least a share of the greatest of its plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// 50 % (beam angle), in the planes C0-C180 and C90-C270; for types A and B vertically and horizontally.
    pub beam_deg: [f64; 2],
    /// 10 % (field angle), in the same planes.
    pub field_deg: [f64; 2],
}

/// Beam and field angles of a web, exact for its interpolation.
///
/// The angle is that of the lobe which holds the greatest intensity of the plane (ANSI/IES LS-1).
#[must_use]
pub fn spread(web: &Web) -> Spread {
    let curves = if web.kind() == PhotometricType::C {
        [0.0, 90.0].map(|c| plane_pair(web, c))
    } else {
        [vertical(web), horizontal(web)]
    };
    let within = |share: f64| [lobe_deg(&curves[0], share), lobe_deg(&curves[1], share)];
    Spread { beam_deg: within(0.5), field_deg: within(0.1) }
}

/// Intensity over the angle through both halves of a plane, with the pole nearer to its peak in the middle.
pub(crate) fn plane_pair(web: &Web, c_deg: f64) -> Vec<(f64, f64)> {
    let angles = web.vertical_deg();
    let half = |sign: f64, c: f64| angles.iter().map(move |g| (sign * g, web.at(*g, c)));
    let mut curve: Vec<(f64, f64)> = half(-1.0, c_deg + 180.0).chain(half(1.0, c_deg)).collect();
    if curve[greatest(&curve)].0.abs() > 90.0 {
        for (angle, _) in &mut curve {
            *angle -= 180f64.copysign(*angle);
        }
    }
    curve.sort_by(|a, b| a.0.total_cmp(&b.0));
    curve.dedup();
    curve
}

fn vertical(web: &Web) -> Vec<(f64, f64)> {
    web.vertical_deg().iter().map(|v| (*v, web.at(*v, 0.0))).collect()
}

fn horizontal(web: &Web) -> Vec<(f64, f64)> {
    let mut angles: Vec<f64> = web.horizontal_deg().iter().flat_map(|h| [-h, *h]).collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    angles.into_iter().map(|h| (h, web.at(0.0, h))).collect()
}

fn greatest(curve: &[(f64, f64)]) -> usize {
    (0..curve.len()).fold(0, |best, k| if curve[k].1 > curve[best].1 { k } else { best })
}

/// Width of the part about the peak where the curve is at least a share of it.
fn lobe_deg(curve: &[(f64, f64)], share: f64) -> f64 {
    let peak = greatest(curve);
    let level = share * curve[peak].1;
    let edge = |inside: &(f64, f64), outside: &(f64, f64)| {
        inside.0 + (outside.0 - inside.0) * (inside.1 - level) / (inside.1 - outside.1)
    };
    let right = (peak + 1..curve.len()).find(|k| curve[*k].1 < level);
    let left = (0..peak).rev().find(|k| curve[*k].1 < level);
    let end = right.map_or(curve[curve.len() - 1].0, |k| edge(&curve[k - 1], &curve[k]));
    let start = left.map_or(curve[0].0, |k| edge(&curve[k + 1], &curve[k]));
    end - start
}
