//! The pictures of progressive refinement on its way, in one exposure, alone and side by side.

use std::path::{Path, PathBuf};

use super::canvas::{Canvas, INK};
use super::chart::csv_of;
use super::file::{Names, write_whole};
use super::png::{self, Film};
use super::text::Font;
use crate::error::{Error, Result};
use crate::measure::{Measurement, PictureStage, ViewResult};
use crate::scene::Scene;

/// Gap between the pictures of a strip, pixels.
const GAP: usize = 8;

/// Writes for each view `<view>_<number>_<stage>.png`, all of them side by side as `<view>_strip.png`, and
/// `progressive.csv` with what had been shot; answers the files written. `dir` is made if it is missing.
///
/// All pictures of a view are exposed as its last one.
///
/// # Errors
/// Io with the file's name.
pub fn write_stages(dir: &Path, scene: &Scene, m: &Measurement) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(dir).map_err(|e| Error::io(dir, &e))?;
    let mut files = Vec::new();
    let mut write = |name: &str, bytes: Vec<u8>| -> Result<()> {
        let path = dir.join(name);
        write_whole(&path, &bytes)?;
        files.push(path);
        Ok(())
    };
    let mut names = Names::default();
    for result in &m.views {
        let Some(last) = result.stages.last() else { continue };
        let film = Film::for_picture(scene, &last.xyz);
        let developed: Vec<Vec<[u8; 3]>> = result.stages.iter().map(|s| film.develop(&s.xyz)).collect();
        let endings: Vec<String> = result.stages.iter().zip(1..).map(|(s, k)| ending(s, k)).collect();
        let all: Vec<&str> = endings.iter().map(String::as_str).chain(["_strip"]).collect();
        let stem = names.claim(&result.view.name, &all);
        for (ending, rgb) in endings.iter().zip(&developed) {
            let bytes = png::encode(result.view.width, result.view.height, rgb.as_flattened())?;
            write(&format!("{stem}{ending}.png"), bytes)?;
        }
        write(&format!("{stem}_strip.png"), strip(result, &developed)?)?;
    }
    write("progressive.csv", table(m)?)?;
    Ok(files)
}

fn ending(stage: &PictureStage, number: usize) -> String {
    format!("_{number}_{}", stage.name.replace(' ', "-"))
}

fn strip(result: &ViewResult, developed: &[Vec<[u8; 3]>]) -> Result<Vec<u8>> {
    let (width, height) = (result.view.width, result.view.height);
    let across = developed.len() * (width + GAP) - GAP;
    let mut canvas = Canvas::new(across, height + GAP + Font::Label.height());
    for (k, (stage, rgb)) in result.stages.iter().zip(developed).enumerate() {
        let left = k * (width + GAP);
        for (i, colour) in rgb.iter().enumerate() {
            canvas.set(left + i % width, i / width, *colour);
        }
        canvas.text(left, height + GAP, &Font::Label.fit(&stage.name, width), Font::Label, INK);
    }
    canvas.into_png()
}

fn table(m: &Measurement) -> Result<Vec<u8>> {
    let rows = m.views.iter().flat_map(|v| {
        v.stages.iter().map(|s| vec![v.view.name.clone(), s.name.clone(), s.shots.to_string(), s.unshot.to_string()])
    });
    csv_of(&["view", "stage", "shots", "unshot_share"], rows)
}
