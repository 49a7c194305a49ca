//! Daylight coefficients: what each patch of the sky gives to each sensor, by the same rows as any other solution.
//!
//! In: a scene and a tolerance. Out: [`Coefficients`], illuminance per unit luminance of a patch (Tregenza and Waters
//! 1983). What a sensor sees of the sky itself is divided finely; what comes by reflection has every patch as a
//! right-hand side of the same system. So has what windows with a BSDF send on, where the sun in each patch of the BSDF is one
//! more. The four independent sets of rays and their coarse twins are kept apart, so that every hour of a year has an error of
//! its own.

mod light;
mod reflected;
mod sums;

use std::borrow::Cow;

use glam::DVec3;

use self::light::{Look, Received};
use self::reflected::Reads;
use super::adaptive::{Adapted, Task, stream};
use super::gather::REPLICAS;
use super::probe::Probe;
use super::result::Status;
use super::solved::Solved;
use crate::error::Result;
use crate::light::sky::Patches;
use crate::solve;
use crate::transport::points::seed;
use crate::transport::{
    DAYLIGHT_GROUPS, DirectScratch, Openings, Optics, PanelColumns, PanelSun, Rows, SUN, SunImages, World,
    mirrored_sun, sun_factor, sun_through,
};

/// Parts of a side of Tregenza's patches into which the sky itself is divided.
const SEEN_PARTS: usize = 4;
/// Independent estimates: as many of the mesh, then as many of its coarse twin.
pub const ESTIMATES: usize = 2 * REPLICAS;

/// Illuminance of sensors per unit luminance of patches, lx/(cd/m²).
#[derive(Debug)]
pub struct Coefficients {
    /// Patches in which the sky itself is seen.
    pub seen_patches: Patches,
    /// Patches whose reflected light is told apart.
    pub patches: Patches,
    /// Divisions of the light by the blinds that it passes: none, then each. Their columns follow each other.
    pub openings: usize,
    /// Sheets of columns: those of the openings, and where there are windows with a BSDF those of the light that they send on.
    pub sheets: usize,
    /// By grid.
    pub grids: Vec<GridCoefficients>,
    panels: Option<PanelColumns>,
    world: World,
    optics: Optics,
    /// Blind of each surface, from 1; 0 where there is none.
    blinds: Vec<u8>,
    /// Share of each band in the sun's luminance.
    sun_weights: Vec<f64>,
}

/// Column (opening · patches + patch) and coefficient, where it is not zero.
type SeenPatches = Vec<(u32, f32)>;

/// The coefficients of a grid.
#[derive(Debug)]
pub struct GridCoefficients {
    /// The sensors as they look.
    probes: Vec<Probe>,
    /// Where each sensor sees the sky; `None` where rays had to tell.
    skylights: Vec<Option<Openings>>,
    /// What each sensor sees of the sky and the ground.
    pub seen: Vec<SeenPatches>,
    /// What it sees of the ground under the sun's spectrum, where that is not the sky's.
    pub seen_of_sun: Vec<SeenPatches>,
    /// What comes by reflection and by windows with a BSDF, under the spectrum of the sky and under that of the sun (once,
    /// where they are the same): by estimate, `[sensor][sheet][patch]`. The sun's own light comes without such windows.
    pub reflected: Vec<[Vec<f32>; ESTIMATES]>,
    /// Sky and ground seen in mirrors, by sensor and set: the sun's image there is no part of it.
    mirrored: Vec<[Vec<(u32, f32)>; REPLICAS]>,
    /// Illuminance by the sun on zones of windows with a BSDF per unit of their irradiance, by estimate: `[sensor][column]`.
    by_panels: [Vec<f32>; ESTIMATES],
}

impl GridCoefficients {
    /// Can the sensor see?
    #[must_use]
    pub fn status(&self, sensor: usize) -> Status {
        self.probes[sensor].status
    }

    /// Coefficients of light of the sky and the ground on a sensor that is not seen directly, of `columns` columns.
    #[must_use]
    pub fn of_sky(&self, estimate: usize, sensor: usize, columns: usize) -> Cow<'_, [f32]> {
        let row = &self.reflected[0][estimate][sensor * columns..(sensor + 1) * columns];
        let mirrored = &self.mirrored[sensor][estimate % REPLICAS];
        if mirrored.is_empty() {
            return Cow::Borrowed(row);
        }
        let mut row = row.to_vec();
        mirrored.iter().for_each(|(column, c)| row[*column as usize] += c);
        Cow::Owned(row)
    }

    /// Coefficients of reflected light of the sun.
    #[must_use]
    pub fn of_sun(&self) -> &[Vec<f32>; ESTIMATES] {
        &self.reflected[self.reflected.len() - 1]
    }

    /// Coefficients of the sun on windows with a BSDF: the columns of a sensor.
    #[must_use]
    pub fn by_panels(&self, estimate: usize, sensor: usize) -> &[f32] {
        let columns = self.by_panels[estimate].len() / self.probes.len();
        &self.by_panels[estimate][sensor * columns..(sensor + 1) * columns]
    }
}

impl Coefficients {
    /// Illuminance of a sensor by the sun's disc about `direction`, per unit of its illuminance face on; and the opening by
    /// which it comes.
    #[must_use]
    pub fn sun(&self, grid: usize, sensor: usize, direction: DVec3, scratch: &mut SunScratch) -> (f64, usize) {
        let p = &self.grids[grid].probes[sensor];
        let SunScratch { direct, factors } = scratch;
        factors.clear();
        factors.resize(self.optics.columns() - self.optics.lamps, 0.0);
        let sample = seed(&[grid as u64, sensor as u64]);
        let (world, at) = (&self.world, (p.eye, p.normal));
        match &self.grids[grid].skylights[sensor] {
            Some(openings) => sun_through(world, at, openings, direction, direct, factors),
            None => direct.rays += sun_factor(world, at, direction, sample, direct, factors),
        }
        let tinted = factors.get(DAYLIGHT_GROUPS + SUN * self.optics.pad..).unwrap_or_default();
        let tinted: f64 = tinted.iter().zip(&self.sun_weights).map(|(f, w)| f * w).sum();
        let factor = factors[SUN] + tinted;
        (factor, if factor > 0.0 { opening(&self.blinds, direct.panes()) } else { 0 })
    }

    /// A sun in a direction in the scene's mirrors and panes.
    #[must_use]
    pub fn images(&self, direction: DVec3) -> SunImages {
        self.world.images_of(direction)
    }

    /// Any mirrors or panes?
    #[must_use]
    pub fn has_images(&self) -> bool {
        self.world.has_specular()
    }

    /// Illuminance of a sensor by images of the sun, per unit of its illuminance face on, by opening.
    pub fn mirrored_sun(
        &self,
        grid: usize,
        sensor: usize,
        images: &SunImages,
        scratch: &mut SunScratch,
        by_opening: &mut [f64],
    ) {
        let p = &self.grids[grid].probes[sensor];
        let (sample, direct) = (seed(&[grid as u64, sensor as u64]), &mut scratch.direct);
        let look = Look { patches: &self.patches, blinds: &self.blinds, weights: &self.sun_weights };
        direct.rays += mirrored_sun(&self.world, (p.eye, p.normal), images, sample, direct, |cosine, tint, panes| {
            by_opening[opening(&self.blinds, panes)] += cosine * look.left(tint);
        });
    }

    /// The sun about `direction` on windows with a BSDF, each with the opening by which it comes.
    #[must_use]
    pub fn suns_on_panels(&self, direction: DVec3, scratch: &mut SunScratch) -> Vec<(PanelSun, usize)> {
        let of = |panels: &PanelColumns| panels.sun(&self.world, direction, &mut scratch.direct);
        let suns = self.panels.as_ref().map(of).unwrap_or_default();
        suns.into_iter().map(|sun| (opening(&self.blinds, &sun.panes), sun)).map(|(o, sun)| (sun, o)).collect()
    }

    /// Any windows with a BSDF?
    #[must_use]
    pub fn has_panels(&self) -> bool {
        self.panels.is_some()
    }

    /// The patches of the sky that a sensor sees, and those beside them: the sun shines on it from nowhere else.
    #[must_use]
    pub fn sunny_patches(&self, grid: usize, sensor: usize) -> Vec<bool> {
        let patches = &self.seen_patches;
        let mut sunny = vec![false; patches.all()];
        for (column, _) in &self.grids[grid].seen[sensor] {
            let p = *column as usize % patches.all();
            if p < patches.sky() {
                patches.beside(p).for_each(|q| sunny[q] = true);
            }
        }
        sunny
    }

    /// Buffers for the sun.
    #[must_use]
    pub fn scratch(&self) -> SunScratch {
        SunScratch { direct: DirectScratch::default().in_bands(&self.optics), factors: Vec::new() }
    }
}

/// Buffers of one thread.
#[derive(Debug)]
pub struct SunScratch {
    direct: DirectScratch,
    factors: Vec<f64>,
}

/// The opening to which a way through panes belongs: the first pane with a blind tells.
fn opening(blinds: &[u8], panes: &[u32]) -> usize {
    panes.iter().map(|p| usize::from(blinds[*p as usize])).find(|b| *b > 0).unwrap_or(0)
}

/// Of the directions from which the sun shines into windows with a BSDF, the one nearest to their mean.
#[must_use]
pub(super) fn typical_sun(world: &World, suns: &[DVec3]) -> Option<DVec3> {
    let surfaces = || world.surfaces.list.iter().enumerate();
    let shines_in = |sun: &&DVec3| {
        surfaces().any(|(i, s)| {
            let cosine = s.normal.dot(**sun);
            world.scatterer(i as u32).is_some_and(|scatterer| scatterer.incoming(cosine > 0.0) > 0)
        })
    };
    let lit: Vec<DVec3> = suns.iter().filter(shines_in).copied().collect();
    let mean: DVec3 = lit.iter().sum();
    lit.into_iter().max_by(|a, b| a.dot(mean).total_cmp(&b.dot(mean)))
}

/// What has a right-hand side of its own.
struct Columns {
    /// Patches by opening.
    patches: usize,
    /// Light of windows with a BSDF.
    panels: Option<PanelColumns>,
}

impl Columns {
    fn spots(&self) -> usize {
        self.panels.as_ref().map_or(0, PanelColumns::spots)
    }
}

/// One mesh with its rows, ready for any sky.
struct Side<'a> {
    solved: &'a Solved,
    columns: solve::Columns,
    /// Direct light of the elements, by replica.
    light: Vec<Received>,
}

impl Task<'_> {
    /// The coefficients of all sensors, for a sky in `parts` of Tregenza's patches a side and a sun in the directions `suns`.
    pub(super) fn coefficients(&self, adapted: &Adapted, parts: usize, suns: &[DVec3]) -> Result<Coefficients> {
        let (patches, seen_patches) = (Patches::new(parts), Patches::new(SEEN_PARTS));
        let weights = self.source_weights();
        let blinds = self.blinds();
        let look = Look { patches: &patches, blinds: &blinds, weights: &weights[0] };
        let openings = 1 + self.scene.blinds.len();
        let panels = self.world.has_bsdf().then(|| {
            self.progress.stage("sky seen by windows with a BSDF", 0);
            let skies = (openings * patches.all(), look.width());
            let stream = seed(&[self.options.seed, stream::PATCHES]);
            PanelColumns::new(self.world, skies, &|seen| look.column(seen), suns, stream)
        });
        let columns = Columns { patches: openings * patches.all(), panels };
        let sides = [
            self.side(&adapted.main, &adapted.rows, (look, &columns), 0)?,
            self.side(&adapted.twin, &adapted.twin_rows, (look, &columns), 1)?,
        ];
        let of_grid = |(g, states): (usize, &Vec<_>)| {
            let probes: Vec<Probe> = states.iter().map(|s: &super::sensor_state::SensorState| s.probe).collect();
            let seen_by = |weights: &[f64]| {
                let look = Look { patches: &seen_patches, blinds: &blinds, weights };
                self.seen(&probes, look, openings * seen_patches.all())
            };
            let (seen, skylights) = seen_by(&weights[0]);
            let seen_of_sun = weights.get(1).map_or_else(Vec::new, |weights| {
                let mut seen = seen_by(weights).0;
                let is_ground = |column: u32| column as usize % seen_patches.all() == seen_patches.sky();
                seen.iter_mut().for_each(|list| list.retain(|(column, _)| is_ground(*column)));
                seen
            });
            self.progress.stage(&format!("grid {}: rays", self.scene.grids[g].name), states.len() as u64);
            let mut reads: Vec<[Reads; REPLICAS]> = self.reads(adapted, g, (look, &columns), &weights);
            self.progress.stage(&format!("grid {}: patches of the sky", self.scene.grids[g].name), 0);
            let mut reflected = self.by_patches(&sides, &reads, columns.patches, &weights);
            let by_panels = match &columns.panels {
                Some(panels) => {
                    let all = self.by_panels(&sides, &reads, panels, &weights);
                    append(&mut reflected, &all, panels.count())
                }
                None => Default::default(),
            };
            let mirrored = reads.iter_mut().map(|r| r.each_mut().map(|r| std::mem::take(&mut r.mirrored))).collect();
            GridCoefficients { probes, skylights, seen, seen_of_sun, reflected, mirrored, by_panels }
        };
        let grids = adapted.grids.iter().enumerate().map(of_grid).collect();
        Ok(Coefficients {
            seen_patches,
            openings,
            sheets: openings * if columns.panels.is_some() { 2 } else { 1 },
            grids,
            panels: columns.panels,
            world: self.world.clone(),
            optics: self.optics.clone(),
            blinds,
            sun_weights: weights.into_iter().next_back().unwrap_or_default(),
            patches,
        })
    }

    /// Blind of each surface, from 1; 0 where there is none.
    fn blinds(&self) -> Vec<u8> {
        let of = |face: &crate::scene::Face| {
            let at = self.scene.blinds.iter().position(|b| b.covers(self.scene, face));
            at.map_or(0, |k| k as u8 + 1)
        };
        self.scene.faces.iter().map(of).collect()
    }

    /// Share of each band in the luminance of the sky, and of the sun where that differs.
    fn source_weights(&self) -> Vec<Vec<f64>> {
        let Some(light) = self.world.daylight() else { return Vec::new() };
        let shares = |spectrum| -> Vec<f64> {
            let radiance = self.optics.bands.radiance(spectrum);
            let parts: Vec<f64> = radiance.iter().zip(&self.optics.xyz[1]).map(|(r, y)| r * f64::from(*y)).collect();
            let sum: f64 = parts.iter().sum();
            parts.iter().map(|p| p / sum).collect()
        };
        let (sky, sun) = (shares(&light.sky_irradiance), shares(&light.sun_irradiance));
        let is_same = sky.iter().zip(&sun).all(|(a, b)| (a - b).abs() < 1e-6);
        if is_same { vec![sky] } else { vec![sky, sun] }
    }

    fn side<'a>(
        &self,
        solved: &'a Solved,
        rows: &Rows,
        (look, columns): (Look<'_>, &Columns),
        number: u64,
    ) -> Result<Side<'a>> {
        let balanced = solve::Columns::new(self.world, self.optics, &solved.mesh, rows, self.accuracy())?;
        self.progress.stage("sky seen by the elements", solved.mesh.len() as u64);
        let light = self.element_light(&solved.mesh, rows, (look, columns), number);
        Ok(Side { solved, columns: balanced, light })
    }
}

/// Appends the columns of sky and ground of windows with a BSDF to the rows of all others; what is left are those of the sun.
fn append(
    rows: &mut [[Vec<f32>; ESTIMATES]],
    panels: &[[Vec<f32>; ESTIMATES]],
    [skies, suns]: [usize; 2],
) -> [Vec<f32>; ESTIMATES] {
    for (rows, panels) in rows.iter_mut().flatten().zip(panels.iter().flatten()) {
        let both = rows.chunks_exact(skies).zip(panels.chunks_exact(skies + suns));
        *rows = both.flat_map(|(row, panel)| row.iter().chain(&panel[..skies])).copied().collect();
    }
    let of_sun = &panels[panels.len() - 1];
    of_sun.each_ref().map(|all| all.chunks_exact(skies + suns).flat_map(|row| &row[skies..]).copied().collect())
}
