//! Made-up results for the tests of the reports: a side-lit room.

use glam::DVec3;

use crate::measure::{
    BandValue, GridResult, Ledger, LeftOut, Measurement, Record, SensorResult, Setting, Status, ViewResult,
};
use crate::scene::{Axes, Emission, GridLayout, InputFile, Material, MaterialKind, Projection, Scene, View};
use crate::spectrum::{BandMode, Bands, SpectralValue, illuminant};

pub(super) fn scene() -> Scene {
    let d65 = illuminant("D65").unwrap();
    Scene {
        title: "Side-lit office".into(),
        faces: Vec::new(),
        objects: Vec::new(),
        materials: vec![Material {
            name: "lamp".into(),
            kind: MaterialKind::Mirror { reflectance: SpectralValue::Grey(0.0) },
            // The lamp of `view`.
            emission: Some(Emission { radiance: d65.scaled(6000.0 / d65.luminous()), two_sided: false, group: None }),
            outside: false,
        }],
        bands: BandMode::Auto,
        grids: Vec::new(),
        views: Vec::new(),
        daytime: None,
        luminaires: Vec::new(),
        modelling: Vec::new(),
        requirements: Vec::new(),
        power: None,
        observers: Vec::new(),
        states: Vec::new(),
        occupancy: Default::default(),
        blinds: Vec::new(),
        axes: Axes::ZUp,
        inputs: vec![InputFile { path: "office.obj".into(), sha256: "00ff".into() }],
        warnings: vec!["the scene says so".into()],
    }
}

/// Light falling off from a window at x = 0, more at some spots.
fn room_light(x: f64, y: f64) -> f64 {
    let window = 1800.0 / (1.0 + x * x);
    let lamp = 420.0 * (-((x - 3.0).powi(2) + (y - 4.0).powi(2)) / 1.2).exp();
    60.0 + window * (1.0 + 0.3 * (1.3 * y).sin()) + lamp
}

pub(super) fn grid(name: &str, nu: usize, nv: usize, size: [f64; 2]) -> GridResult {
    let mut sensors = Vec::new();
    let mut index = Vec::new();
    for j in 0..nv {
        for i in 0..nu {
            let x = 0.25 + size[0] * (i as f64 + 0.5) / nu as f64;
            let y = 0.25 + size[1] * (j as f64 + 0.5) / nv as f64;
            let in_corner = x > 0.25 + 0.8 * size[0] && y < 0.25 + 0.15 * size[1];
            let on_desk = (1.4..2.4).contains(&x) && (1.0..1.8).contains(&y);
            if in_corner {
                index.push(None);
                continue;
            }
            index.push(Some(sensors.len()));
            let status = if on_desk { Status::Covered } else { Status::Ok };
            sensors.push(sensor(x, y, status, size[0] * size[1] / (nu * nv) as f64));
        }
    }
    let ok = sensors.iter().filter(|s| s.status == Status::Ok).count();
    GridResult {
        name: name.into(),
        layout: GridLayout::Raster {
            origin: DVec3::new(0.25, 0.25, 0.85),
            u: DVec3::new(size[0], 0.0, 0.0),
            v: DVec3::new(0.0, size[1], 0.0),
            nu,
            nv,
            index,
        },
        sensors,
        holding: ok - ok / 50,
    }
}

fn sensor(x: f64, y: f64, status: Status, area_m2: f64) -> SensorResult {
    let lx = room_light(x, y);
    SensorResult {
        position: DVec3::new(x, y, 0.85),
        normal: DVec3::Z,
        area_m2: Some(area_m2),
        status,
        xyz: [0.9505 * lx, lx, 1.089 * lx],
        error_lx: 0.01 * lx,
        direct_lx: 0.5 * lx,
        sun_lx: 0.0,
        sky_lx: 0.25 * lx,
        external_lx: 0.0,
        reflected_lx: 0.25 * lx,
        spectral: vec![BandValue { irradiance: 1e-3 * lx, error: 1e-5 * lx }; 3],
    }
}

/// A picture with floor, wall and a lamp.
pub(super) fn view(name: &str, width: usize, height: usize, bands: usize) -> ViewResult {
    let mut xyz = Vec::new();
    let mut radiance = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let (a, b) = (x as f64 / width as f64, y as f64 / height as f64);
            let lamp = (0.4..0.6).contains(&a) && (0.08..0.14).contains(&b);
            let wall = 20.0 + 120.0 * (-8.0 * (a - 0.5).powi(2) - 3.0 * b).exp();
            let level = if lamp { 6000.0 } else { wall };
            let tint = if a < 0.2 && !lamp { [1.25, 1.0, 0.4] } else { [0.9505, 1.0, 1.089] };
            xyz.push(tint.map(|t: f64| (t * level) as f32));
            radiance.extend((0..bands).map(|k| (level * (1.0 + k as f64) / 700.0) as f32));
        }
    }
    ViewResult {
        view: View {
            name: name.into(),
            position: DVec3::new(1.0, 2.0, 1.5),
            direction: DVec3::Y,
            up: DVec3::Z,
            projection: Projection::Perspective { horizontal: 60f64.to_radians(), vertical: 45f64.to_radians() },
            width,
            height,
        },
        radiance,
        xyz,
        error_median: 0.012,
        error_p95: 0.046,
        stages: Vec::new(),
    }
}

pub(super) fn measurement(mode: &BandMode) -> Measurement {
    let lamp = illuminant("D65").unwrap();
    let paint = SpectralValue::Rgb([0.6, 0.5, 0.4]);
    let (bands, note) = Bands::plan(mode, &[(&paint, 1.0)], &[(&lamp, 1.0)], 0.05).unwrap();
    let n = bands.len();
    Measurement {
        views: vec![view("camera", 96, 64, n)],
        bands,
        grids: vec![grid("workplane", 16, 24, [3.5, 5.5])],
        states: Vec::new(),
        outdoor_lx: Some(10_000.0),
        glare: Vec::new(),
        appraisal: Default::default(),
        alpha_opic: None,
        ledger: Ledger {
            emitted: vec![10.0; n],
            absorbed: vec![9.0; n],
            escaped: vec![0.5; n],
            unexpanded: vec![0.25; n],
            sampling_error: vec![0.1; n],
        },
        record: Record {
            method: "gathering".into(),
            seed: 7,
            tolerance: 0.05,
            settings: vec![Setting { name: "bands".into(), value: n.to_string(), why: note }],
            left_out: vec![LeftOut { what: "fluorescence".into(), bound: "unknown".into() }],
            counts: vec![("rays".into(), 123_456)],
            timings_s: vec![("solve".into(), 0.5)],
            warnings: vec!["the run says so".into()],
            planned_bytes: Some(2 << 20),
            max_memory: None,
        },
    }
}
