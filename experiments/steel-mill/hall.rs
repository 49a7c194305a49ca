//! The hall, bay by bay: each bay is one aisle wide and one truss long.

use clerestory::transport::points::{Points, seed};
use glam::{DMat3, DVec3};

use super::parts::{Part, block, cuboid, member, panel, round};

/// Width of an aisle, length of a bay, height of the roof; m.
pub(crate) const SPAN_M: f64 = 24.0;
pub(crate) const BAY_M: f64 = 6.0;
pub(crate) const HEIGHT_M: f64 = 16.0;
/// Radius of the luminous octagon of a lamp, m.
const LAMP_RADIUS_M: f64 = 0.22;
/// Bays of an aisle that one crane serves.
const CRANE_BAYS: usize = 10;

/// Size of a hall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    pub(crate) aisles: usize,
    pub(crate) bays: usize,
}

impl Size {
    /// Width and length, m.
    pub(crate) fn extent_m(self) -> [f64; 2] {
        [self.aisles as f64 * SPAN_M, self.bays as f64 * BAY_M]
    }
}

/// All parts of a hall.
pub(crate) fn hall(size: Size) -> Vec<Part> {
    let mut parts = shell(size);
    for aisle in 0..size.aisles {
        for bay in 0..size.bays {
            let origin = DVec3::new(aisle as f64 * SPAN_M, bay as f64 * BAY_M, 0.0);
            let points = Points::new(seed(&[aisle as u64, bay as u64]));
            structure(origin, &mut parts);
            services(origin, &mut parts);
            rollers(origin, &mut parts);
            match (aisle + bay) % 3 {
                0 => furnace(origin, &mut parts),
                1 => ingots(origin, &points, &mut parts),
                _ => bars(origin, &points, &mut parts),
            }
            if bay % CRANE_BAYS == CRANE_BAYS / 2 {
                crane(origin, &mut parts);
            }
        }
    }
    parts
}

/// Floor, roof and walls, all seen from inside.
fn shell(size: Size) -> Vec<Part> {
    let [x, y, z] = [DVec3::X * SPAN_M, DVec3::Y * BAY_M, DVec3::Z * HEIGHT_M];
    let [width, length] = size.extent_m();
    let mut parts = Vec::new();
    for aisle in 0..size.aisles {
        let low = x * aisle as f64;
        for bay in 0..size.bays {
            let corner = low + y * bay as f64;
            parts.push(panel("floor", corner, [x, y], "concrete"));
            parts.push(panel("roof", corner + z, [y, x], "sheet"));
        }
        parts.push(panel("gable", low, [z, x], "sheet"));
        parts.push(panel("gable", low + DVec3::Y * length, [x, z], "sheet"));
    }
    for bay in 0..size.bays {
        let low = y * bay as f64;
        parts.push(panel("wall", low, [y, z], "sheet"));
        parts.push(panel("wall", low + DVec3::X * width, [z, y], "sheet"));
    }
    parts
}

/// Columns, runways, truss, purlins and lamps.
fn structure(o: DVec3, parts: &mut Vec<Part>) {
    let at = |x: f64, y: f64, z: f64| o + DVec3::new(x, y, z);
    for (x, inward) in [(0.6, 1.0), (SPAN_M - 0.6, -1.0)] {
        // Flange, web, flange.
        for (half, y) in [([0.15, 0.01], 2.8), ([0.01, 0.19], 3.0), ([0.15, 0.01], 3.2)] {
            let (low, high) = (at(x - half[0], y - half[1], 0.0), at(x + half[0], y + half[1], 12.6));
            parts.push(block("column", low, high, "steel"));
        }
        let runway = x + inward * 0.6;
        let along = |z0: f64, z1: f64, half: f64| (at(runway - half, 0.005, z0), at(runway + half, BAY_M - 0.005, z1));
        let (low, high) = along(8.5, 9.3, 0.15);
        parts.push(block("runway", low, high, "steel"));
        let (low, high) = along(9.3, 9.4, 0.04);
        parts.push(block("rail", low, high, "bright"));
        handrail(at(runway - inward * 0.3, 0.0, 9.3), parts);
    }
    truss(at(0.0, 3.0, 0.0), parts);
    for k in 0..9 {
        let x = 1.0 + 2.75 * f64::from(k);
        parts.push(block("purlin", at(x - 0.05, 0.005, 15.45), at(x + 0.05, BAY_M - 0.005, 15.65), "steel"));
    }
    for k in 0..4 {
        let x = 3.6 + 5.6 * f64::from(k);
        let ends = [at(x, 1.0, 12.3), at(x, 1.0, 12.0)];
        parts.push(round("lamp", ends, [0.1, LAMP_RADIUS_M], 8, ["housing", "housing", "lamp"]));
    }
}

/// Posts and two rails along a runway.
fn handrail(o: DVec3, parts: &mut Vec<Part>) {
    for k in 0..6 {
        let foot = o + DVec3::new(0.0, 0.5 + f64::from(k), 0.0);
        parts.push(block("handrail", foot - DVec3::new(0.02, 0.02, 0.0), foot + DVec3::new(0.02, 0.02, 1.0), "yellow"));
    }
    for z in [0.53, 1.03] {
        let ends = [o + DVec3::new(0.05, 0.01, z), o + DVec3::new(0.05, BAY_M - 0.01, z)];
        parts.push(member("handrail", ends, [0.04, 0.04], "yellow"));
    }
}

/// A truss across the aisle with 11 panels; members end short of the chords.
fn truss(o: DVec3, parts: &mut Vec<Part>) {
    const PANELS: u32 = 11;
    let (low, high) = (12.8, 15.2);
    let x = |k: u32| 1.0 + 2.0 * f64::from(k);
    let at = |k: u32, z: f64| o + DVec3::new(x(k), 0.0, z);
    let mut add = |ends: [DVec3; 2], size: f64, gap: f64| {
        let along = (ends[1] - ends[0]).normalize() * gap;
        parts.push(member("truss", [ends[0] + along, ends[1] - along], [size, size], "steel"));
    };
    for k in 0..PANELS {
        add([at(k, low), at(k + 1, low)], 0.2, 0.001);
        add([at(k, high), at(k + 1, high)], 0.2, 0.001);
        let ends = if k % 2 == 0 { [at(k, low), at(k + 1, high)] } else { [at(k, high), at(k + 1, low)] };
        add(ends, 0.1, 0.25);
        if k > 0 {
            add([at(k, low), at(k, high)], 0.08, 0.11);
        }
    }
}

/// Pipes with flanges along both sides.
fn services(o: DVec3, parts: &mut Vec<Part>) {
    for (k, radius) in [0.08, 0.12, 0.15, 0.1, 0.06, 0.2].into_iter().enumerate() {
        let z = 4.0 + 0.65 * k as f64;
        for x in [0.25, SPAN_M - 0.25] {
            let at = |y: f64| o + DVec3::new(x, y, z);
            let paint = if k % 2 == 0 { "pipe" } else { "bright" };
            parts.push(round("pipe", [at(0.06), at(BAY_M - 0.06)], [radius; 2], 12, [paint; 3]));
            for y in [0.02, BAY_M - 0.06] {
                parts.push(round("flange", [at(y), at(y + 0.04)], [1.5 * radius.min(0.14); 2], 16, ["steel"; 3]));
            }
        }
    }
}

/// A roller table down the middle of the aisle.
fn rollers(o: DVec3, parts: &mut Vec<Part>) {
    for k in 0..10 {
        let y = 0.3 + 0.6 * f64::from(k);
        let at = |x: f64, z: f64| o + DVec3::new(x, y, z);
        parts.push(round("roller", [at(11.25, 0.9), at(12.75, 0.9)], [0.15; 2], 16, ["bright"; 3]));
        for x in [11.1, 12.9] {
            parts.push(block(
                "bearing",
                at(x - 0.1, 0.0) - 0.15 * DVec3::Y,
                at(x + 0.1, 1.1) + 0.15 * DVec3::Y,
                "pipe",
            ));
        }
    }
}

/// A vessel with electrodes under a hood.
fn furnace(o: DVec3, parts: &mut Vec<Part>) {
    let at = |x: f64, z: f64| o + DVec3::new(x, 3.0, z);
    let half = DVec3::new(2.4, 2.2, 0.0);
    parts.push(block("furnace", at(5.5, 0.0) - half, at(5.5, 1.0) + half, "brick"));
    parts.push(round("furnace", [at(5.5, 1.0), at(5.5, 4.5)], [1.8, 2.0], 24, ["brick"; 3]));
    for k in 0..3 {
        let (sine, cosine) = (2.1 * f64::from(k)).sin_cos();
        let foot = at(5.5, 4.5) + 0.6 * DVec3::new(cosine, sine, 0.0);
        parts.push(round("electrode", [foot, foot + 1.2 * DVec3::Z], [0.15; 2], 12, ["steel"; 3]));
    }
    parts.push(round("hood", [at(5.5, 6.4), at(5.5, 7.8)], [2.2, 0.6], 24, ["bright"; 3]));
    parts.push(round("duct", [at(5.5, 7.8), at(5.5, 11.8)], [0.5; 2], 16, ["bright"; 3]));
    for k in 0..16 {
        let low = at(18.0 + 0.9 * f64::from(k % 4), 0.0) + DVec3::Y * (0.9 * f64::from(k / 4) - 1.8);
        parts.push(block("brick stack", low, low + DVec3::new(0.7, 0.6, 0.5 + 0.1 * f64::from(k % 5)), "brick"));
    }
}

/// Beds of ingots, some of them glowing; their bottoms are dark.
fn ingots(o: DVec3, points: &Points, parts: &mut Vec<Part>) {
    for k in 0..32_u32 {
        let turn = 0.3 * (points.get(k, 0) - 0.5);
        let column = f64::from(k % 8);
        let x = 3.0 + 1.0 * column + if k % 8 < 4 { 0.0 } else { 10.5 };
        let centre = o + DVec3::new(x, 0.9 + 1.4 * f64::from(k / 8), 0.35);
        let paint = if k % 8 == 2 && k < 16 { "glowing" } else { "scale" };
        let solid = (centre, DMat3::from_rotation_z(turn), DVec3::new(0.3, 0.5, 0.35));
        parts.push(cuboid("ingot", solid, [paint, "scale"]));
    }
}

/// Stacks of bars with bearers between the layers.
fn bars(o: DVec3, points: &Points, parts: &mut Vec<Part>) {
    for (stack, x0) in [3.0, 6.5, 15.5, 18.5].into_iter().enumerate() {
        for layer in 0..5 {
            let z = 0.1 + 0.22 * f64::from(layer);
            for y in [1.0, 5.0] {
                let low = o + DVec3::new(x0, y - 0.05, z - 0.1);
                parts.push(block("bearer", low, low + DVec3::new(2.0, 0.1, 0.1), "wood"));
            }
            for k in 0..10_u32 {
                let at = stack as u32 * 64 + layer as u32 * 10 + k;
                let slip = 0.6 * (points.get(at, 0) - 0.5);
                let low = o + DVec3::new(x0 + 0.02 + 0.2 * f64::from(k), 0.5 + slip, z);
                parts.push(block("bar", low, low + DVec3::new(0.12, 4.9, 0.12), "bright"));
            }
        }
    }
}

/// A bridge of two girders with a trolley.
fn crane(o: DVec3, parts: &mut Vec<Part>) {
    let at = |x: f64, y: f64, z: f64| o + DVec3::new(x, y, z);
    for y in [2.0, 4.0] {
        parts.push(block("crane", at(1.4, y - 0.25, 9.9), at(SPAN_M - 1.4, y + 0.25, 11.1), "yellow"));
    }
    for x in [1.0, SPAN_M - 1.4] {
        parts.push(block("crane", at(x, 1.5, 9.41), at(x + 0.4, 4.5, 9.89), "yellow"));
    }
    parts.push(block("trolley", at(14.0, 1.8, 11.11), at(16.5, 4.2, 11.7), "yellow"));
    parts.push(block("hook", at(15.2, 2.95, 5.0), at(15.3, 3.05, 11.1), "steel"));
}
