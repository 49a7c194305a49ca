//! A1: the cube of 1984, 49 patches a side: flat patches, bilinear interpolation, one gather.

use clerestory::mesh::{Linear, PatchMesh};
use clerestory::solve::dense::Solver;
use clerestory::transport::World;
use clerestory::transport::caster::Ray;
use clerestory::transport::form_factor::{Analytic, FormFactors, Method, Work};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{Build, Outcome, Table, analytic, folder, mesh, system};

/// Reflectances by face: x0 (left), x1 (right), y0 (the emitter), y1, floor, ceiling.
const RHO: [f64; 6] = [0.1, 0.6, 0.0, 0.7, 0.7, 0.7];
const EMITTED: [f64; 6] = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
/// Points along a side at which radiosities are compared, and patches of the reference.
const POINTS: usize = 42;
const FINE: usize = 21;

/// A solved cube.
struct Cube {
    world: World,
    mesh: PatchMesh,
    radiosity: Vec<f64>,
}

/// Factors from the centre of each patch, instead of its mean.
struct Centres<'a>(&'a World, &'a PatchMesh);

impl Method for Centres<'_> {
    fn describe(&self) -> String {
        "exact factors from the centres of patches".into()
    }

    fn row(&self, i: usize, row: &mut [f64], work: &mut Work) {
        let p = &self.1.list[i];
        let analytic = Analytic::new(self.0, self.1);
        for (j, f) in row.iter_mut().enumerate() {
            *f = analytic.at_point(self.0.lift(p.centre, p.normal), p.normal, j, work);
        }
    }
}

impl Cube {
    fn new(patches: usize, from_centres: bool) -> Outcome<Self> {
        let mut b = Build::new(6);
        b.cuboid(DVec3::ZERO, DVec3::ONE, [0, 1, 2, 3, 4, 5], true);
        let world = World::new(&b.scene);
        let mesh = mesh(&world, 1.0 / patches as f64);
        let mut factors = if from_centres {
            FormFactors::new(&world, &mesh, &Centres(&world, &mesh))
        } else {
            analytic(&world, &mesh)?
        };
        factors.balance(&mesh, &world, 0.2)?;
        let radiosity =
            system(&world, &mesh.list, &RHO, &EMITTED).solve(&factors, Solver::ConjugateGradients, 1e-9)?.radiosity;
        Ok(Self { world, mesh, radiosity })
    }

    fn flat(&self, face: usize, uv: DVec2) -> f64 {
        self.mesh.find(face, true, uv).map_or(0.0, |i| self.radiosity[i as usize])
    }

    fn bilinear(&self, face: usize, uv: DVec2) -> f64 {
        Linear::at(&self.mesh, face, true, uv).map_or(0.0, |shown| shown.value(|i| self.radiosity[i]))
    }

    fn gather(&self, face: usize, uv: DVec2) -> f64 {
        let surface = &self.world.surfaces.list[face];
        let x = self.world.lift(surface.point(uv), surface.normal);
        let analytic = Analytic::new(&self.world, &self.mesh);
        let mut work = Work::default();
        let h: f64 = (0..self.mesh.list.len())
            .map(|j| self.radiosity[j] * analytic.at_point(x, surface.normal, j, &mut work))
            .sum();
        EMITTED[face] + RHO[face] * h
    }

    /// One value at every point of every face.
    fn field(&self, value: impl Fn(&Self, usize, DVec2) -> f64 + Sync) -> Vec<f64> {
        let place = |k: usize| (k as f64 + 0.5) / POINTS as f64;
        // The emitter reflects nothing and is right by itself: the five other faces are compared.
        [0, 1, 3, 4, 5]
            .map(|face| (0..POINTS * POINTS).map(move |k| (face, k)))
            .into_iter()
            .flatten()
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|(face, k)| {
                let (i, j) = (k % POINTS, k / POINTS);
                value(self, face, self.world.surfaces.list[face].extent * DVec2::new(place(i), place(j)))
            })
            .collect()
    }
}

pub(super) fn run(out: &mut Table) -> Outcome<()> {
    let truth = Cube::new(FINE, false)?.field(Cube::gather);
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    let targets: [(usize, [&str; 3]); 3] = [
        (3, ["13.0 % (59)", "5.96 % (27)", "1.36 % (14)"]),
        (7, ["6.07 % (39)", "1.99 % (19)", "0.46 % (6.4)"]),
        (14, ["3.07 % (28)", "0.86 % (12.6)", "0.17 % (3.4)"]),
    ];
    for (patches, target) in targets {
        let cube = Cube::new(patches, false)?;
        let centred = Cube::new(patches, true)?;
        let fields = [
            ("flat", cube.field(Cube::flat), target[0]),
            ("bilinear", cube.field(Cube::bilinear), target[1]),
            ("gather", cube.field(Cube::gather), target[2]),
            ("gather, factors from centres", centred.field(Cube::gather), target[2]),
        ];
        for (name, field, target) in fields {
            let off = || field.iter().zip(&truth).map(|(a, b)| (a - b).abs() / mean * 100.0);
            let rms = (off().map(|e| e * e).sum::<f64>() / truth.len() as f64).sqrt();
            let largest = off().fold(0.0, f64::max);
            out.enter("A1", &format!("{patches} patches a side, {name}: RMS % of mean"), rms, target);
            out.enter("A1", &format!("{patches} patches a side, {name}: largest %"), largest, "in brackets above");
        }
    }
    picture(&Cube::new(7, false)?)
}

/// Flat, bilinear and gathered, side by side, seen through the emitting face.
fn picture(cube: &Cube) -> Outcome<()> {
    const SIDE: u32 = 320;
    let eye = cube.world.surfaces.frame.to_local(DVec3::new(0.5, -1.2, 0.5));
    let mut image = image::RgbImage::from_pixel(3 * SIDE + 40, SIDE, image::Rgb([255; 3]));
    for (panel, show) in [Cube::flat, Cube::bilinear, Cube::gather].into_iter().enumerate() {
        let shades: Vec<u8> = (0..SIDE * SIDE)
            .into_par_iter()
            .map(|k| {
                // A little off the middle: no ray runs along an edge.
                let place = |p: u32| (f64::from(p) + 0.43) / f64::from(SIDE) - 0.5;
                // The window y = 0 fills the picture.
                let d = DVec3::new(place(k % SIDE), 1.2, -place(k / SIDE)).normalize();
                let start = eye + d * (1.21 / (d.y * cube.world.surfaces.frame.size_m));
                let ray = Ray::new(start, d);
                let hit = cube.world.caster.closest(&ray);
                let Some(s) = cube.world.surfaces.list.get(hit.surface as usize) else { return 255 };
                let shown = show(cube, hit.surface as usize, s.uv(ray.at(hit.t))) / 0.6;
                (255.0 * shown.clamp(0.0, 1.0).powf(1.0 / 2.2)) as u8
            })
            .collect();
        for (k, shade) in (0u32..).zip(shades) {
            image.put_pixel(panel as u32 * (SIDE + 20) + k % SIDE, k / SIDE, image::Rgb([shade; 3]));
        }
    }
    image.save(folder().join("goral_1984.png"))?;
    Ok(())
}
