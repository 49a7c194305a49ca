//! The polar diagram of a luminous intensity distribution.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use glam::DVec2;

use super::canvas::{Colour, INK, LINE};
use super::drawing::{Anchor, Drawing};
use super::file::write_whole;
use super::scale::round_step;
use super::text::Font;
use crate::error::{Error, Result};
use crate::light::photometry::{PhotometricType, Photometry, Web};

/// Size of the figure and its middle and radius, pixels.
const SIZE: (usize, usize) = (760, 860);
const MIDDLE: DVec2 = DVec2::new(380.0, 460.0);
const RADIUS: f64 = 300.0;
const GRID: Colour = [205; 3];
const CURVES: [Colour; 2] = [[0, 84, 166], [200, 60, 20]];
/// Steps of a curve, degrees.
const STEP_DEG: f64 = 0.5;

/// Writes the polar diagram of a luminaire as `<stem>_polar.png` and `.svg` into `dir`, which is made if it is missing.
///
/// # Errors
/// Io with the file's name.
pub fn write_polar(dir: &Path, stem: &str, photometry: &Photometry) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(dir).map_err(|e| Error::io(dir, &e))?;
    let drawing = draw(photometry);
    [("png", drawing.to_png()?), ("svg", drawing.to_svg().into_bytes())]
        .into_iter()
        .map(|(ending, bytes)| {
            let path = dir.join(format!("{stem}_polar.{ending}"));
            write_whole(&path, &bytes)?;
            Ok(path)
        })
        .collect()
}

fn draw(photometry: &Photometry) -> Drawing {
    let web = &photometry.web;
    let mut drawing = Drawing::new(SIZE.0, SIZE.1);
    let width = SIZE.0 - 48;
    let title = Font::Title.fit(photometry.name(), width);
    drawing.text(DVec2::new(24.0, 20.0), &title, Font::Title, INK, Anchor::Start);
    let facts = format!("{:.0} lm, peak {:.0} cd", web.flux_lm(), web.peak().0);
    drawing.text(DVec2::new(24.0, 52.0), &facts, Font::Body, INK, Anchor::Start);
    let peak = web.peak().0.max(f64::MIN_POSITIVE);
    let step = round_step(peak / 4.0);
    let rings = (peak / step).ceil().max(1.0);
    let scale = RADIUS / (rings * step);
    frame(&mut drawing, rings as usize, step, scale);
    for (k, (name, curve)) in curves(web).into_iter().enumerate() {
        let points: Vec<DVec2> =
            curve.into_iter().map(|(angle, candela)| MIDDLE + towards(angle) * (candela * scale)).collect();
        drawing.line(&points, CURVES[k], 2.5);
        let top = SIZE.1 as f64 - 60.0 + 26.0 * k as f64;
        drawing.line(&[DVec2::new(24.0, top + 10.0), DVec2::new(64.0, top + 10.0)], CURVES[k], 2.5);
        drawing.text(DVec2::new(76.0, top), name, Font::Body, INK, Anchor::Start);
    }
    drawing
}

/// The direction of an angle on the figure: 0 down, positive to the right.
fn towards(angle_deg: f64) -> DVec2 {
    let (sine, cosine) = angle_deg.to_radians().sin_cos();
    DVec2::new(sine, cosine)
}

fn frame(drawing: &mut Drawing, rings: usize, step: f64, scale: f64) {
    for ring in 1..=rings {
        let radius = ring as f64 * step * scale;
        let circle: Vec<DVec2> =
            (0..=120).map(|k| MIDDLE + DVec2::from_angle(TAU * f64::from(k) / 120.0) * radius).collect();
        drawing.line(&circle, GRID, 1.0);
        let place = MIDDLE + DVec2::new(4.0, radius - 20.0);
        drawing.text(place, &format!("{}", ring as f64 * step), Font::Label, LINE, Anchor::Start);
    }
    for k in 0..12 {
        let angle = 30.0 * f64::from(k) - 180.0;
        drawing.line(&[MIDDLE, MIDDLE + towards(angle) * RADIUS], GRID, 1.0);
        let place = MIDDLE + towards(angle) * (RADIUS + 22.0) - DVec2::new(0.0, 9.0);
        drawing.text(place, &format!("{:.0}°", angle.abs()), Font::Label, LINE, Anchor::Middle);
    }
    drawing.text(DVec2::new(SIZE.0 as f64 - 24.0, 52.0), "cd", Font::Body, LINE, Anchor::End);
}

/// The two curves with their names: angle on the figure, candela.
fn curves(web: &Web) -> [(&'static str, Vec<(f64, f64)>); 2] {
    let steps = (180.0 / STEP_DEG) as i32;
    let sample = |candela: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        (-steps..=steps).map(|k| f64::from(k) * STEP_DEG).map(|angle| (angle, candela(angle))).collect()
    };
    let half_planes = |c: f64| sample(&move |angle: f64| web.at(angle.abs(), if angle < 0.0 { c + 180.0 } else { c }));
    match web.kind() {
        PhotometricType::C => [("C0 right, C180 left", half_planes(0.0)), ("C90 right, C270 left", half_planes(90.0))],
        _ => [("vertical", sample(&|angle| web.at(angle, 0.0))), ("horizontal", sample(&|angle| web.at(0.0, angle)))],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_of_even_light_is_a_circle() {
        let web = Web::new(PhotometricType::C, vec![0.0, 180.0], vec![0.0], vec![50.0, 50.0]).unwrap();
        let [(_, curve), _] = curves(&web);
        assert_eq!(curve.len(), 721);
        assert!(curve.iter().all(|(_, candela)| *candela == 50.0));
        assert_eq!((towards(0.0), towards(90.0).x), (DVec2::Y, 1.0), "nadir is below, 90 degrees to the right");
    }
}
