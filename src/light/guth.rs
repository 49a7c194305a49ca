//! Where a bright thing disturbs least: Guth's position index.

use glam::DVec3;

/// Guth's position index of a direction for a line of sight, both of any length; `None` behind the eye, and where the sight
/// is vertical.
///
/// The fit of Guth's data that evaluation programs use, `τ` from the vertical, `σ` from the line of sight, in degrees; below
/// the line of sight that of its height.
#[must_use]
pub fn position_index(sight: DVec3, towards: DVec3) -> Option<f64> {
    let (sight, d) = (sight.normalize(), towards.normalize_or_zero());
    let right = sight.cross(DVec3::Z).try_normalize()?;
    let sigma = sight.dot(d).clamp(-1.0, 1.0).acos().to_degrees();
    if sigma >= 90.0 {
        return None;
    }
    let up = right.cross(sight);
    let tau = d.dot(right).abs().atan2(d.dot(up).max(0.0)).to_degrees();
    let linear = 35.2 - 0.31889 * tau - 1.22 * (-2.0 * tau / 9.0).exp();
    let square = 21.0 + 0.26667 * tau - 0.002963 * tau * tau;
    Some((linear * 1e-3 * sigma + square * 1e-5 * sigma * sigma).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_position_index_is_one_ahead_and_grows_aside() {
        let sight = DVec3::Y;
        assert!((position_index(sight, DVec3::Y).unwrap() - 1.0).abs() < 1e-12);
        // 20 degrees above: exp(33.98e-3 · 20 + 21e-5 · 400).
        let above = DVec3::new(0.0, 20f64.to_radians().cos(), 20f64.to_radians().sin());
        assert!((position_index(sight, above).unwrap() - (0.6796f64 + 0.084).exp()).abs() < 1e-9);
        // 20 degrees aside, τ = 90: linear 6.4999, square 20.9999.
        let aside = DVec3::new(20f64.to_radians().sin(), 20f64.to_radians().cos(), 0.0);
        assert!((position_index(sight, aside).unwrap() - (0.129_998f64 + 0.084_000).exp()).abs() < 1e-4);
        assert_eq!(position_index(sight, DVec3::NEG_Y), None);
        assert_eq!(position_index(DVec3::NEG_Z, DVec3::Y), None);
    }
}
