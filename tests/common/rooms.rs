//! Random furnished rooms in which an error statement has to prove itself. No constant of the program was chosen on them.

use super::{Build, at, diffuse, lit};
use clerestory::transport::points::mix;
use glam::{DVec2, DVec3};

/// Numbers from a counter (SplitMix64).
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }
}

/// The room of one number: 2.5 to 8 m wide and deep, 2.4 to 4 m high, every surface of its own reflectance (0.1 to 0.9); one
/// or two lamps (ceiling or wall); 2 to 6 boxes against a wall, turned on the floor, or floating. Every third has a
/// partition with a slit of 0.1 to 0.5 m, every third a plate under half of its first lamp. 40 sensors: 20 at 0.8 m, 10 on
/// the floor 2 to 15 cm from a box, 10 on walls 2 to 20 cm from an edge.
pub fn random_room(number: u64) -> Build {
    let mut d = Dice(mix(number ^ 0x00c1_e4e5_7042));
    let size = at(d.within(2.5, 8.0), d.within(2.5, 8.0), d.within(2.4, 4.0));
    let mut b = Build::new();
    let paint = |d: &mut Dice, b: &mut Build| b.material(diffuse("paint", d.within(0.1, 0.9)));
    let walls = [0; 6].map(|_| paint(&mut d, &mut b));
    b.room(DVec3::ZERO, size, walls);
    let lamps = 1 + d.below(2);
    for k in 0..lamps {
        let emission = d.within(1000.0, 5000.0);
        let lamp = b.material(lit(diffuse("lamp", d.within(0.0, 0.8)), emission));
        let (w, l) = (d.within(0.1, 0.35) * size.x, d.within(0.1, 0.35) * size.y);
        if k == 1 && d.below(2) == 0 {
            // On the wall x = 0, looking into the room.
            let (y, z) = (d.within(0.1, size.y - l - 0.1), d.within(0.4 * size.z, 0.7 * size.z));
            b.rectangle(at(0.01, y, z), at(0.0, l, 0.0), at(0.0, 0.0, 0.2 * size.z), lamp);
            continue;
        }
        let (x, y) = (d.within(0.1, size.x - w - 0.1), d.within(0.1, size.y - l - 0.1));
        let z = size.z - 0.01 - 0.01 * k as f64;
        b.rectangle(at(x, y, z), at(0.0, l, 0.0), at(w, 0.0, 0.0), lamp);
        if k == 0 && number % 3 == 1 {
            let plate = paint(&mut d, &mut b);
            let below = z - d.within(0.25, 0.7);
            let low = at(x - 0.05, y - 0.05, below - 0.02);
            b.block(low, at(x + 0.5 * w, y + l + 0.05, below), plate);
        }
    }
    if number.is_multiple_of(3) {
        let partition = paint(&mut d, &mut b);
        let x = d.within(0.35, 0.65) * size.x;
        let slit = d.within(0.1, 0.5);
        b.block(at(x, 0.0, 0.0), at(x + 0.05, size.y - slit, size.z), partition);
    }
    let boxes: Vec<Foot> = (0..2 + d.below(5)).filter_map(|_| furniture(&mut d, &mut b, size)).collect();
    let level: Vec<(DVec3, DVec3)> =
        (0..20).map(|_| (at(d.within(0.1, size.x - 0.1), d.within(0.1, size.y - 0.1), 0.8), DVec3::Z)).collect();
    b.points("0.8 m", &level);
    let near: Vec<(DVec3, DVec3)> = (0..10).filter_map(|_| beside(&mut d, &boxes, size)).collect();
    if !near.is_empty() {
        b.points("beside boxes", &near);
    }
    let on_walls: Vec<(DVec3, DVec3)> = (0..10)
        .map(|_| {
            let (from_edge, z) = (d.within(0.02, 0.2), d.within(0.1, size.z - 0.1));
            if d.below(2) == 0 {
                (at(0.0, from_edge, z), DVec3::X)
            } else {
                (at(size.x - from_edge, size.y, z), -DVec3::Y)
            }
        })
        .collect();
    b.points("on walls", &on_walls);
    b
}

/// Outline on the floor of a box.
type Foot = [DVec2; 4];

/// Adds a box; answers its outline where it stands on the floor.
fn furniture(d: &mut Dice, b: &mut Build, size: DVec3) -> Option<Foot> {
    let material = b.material(diffuse("paint", d.within(0.1, 0.9)));
    let half = DVec2::new(d.within(0.15, 0.6), d.within(0.15, 0.6));
    let height = d.within(0.2, 0.6 * size.z);
    let kind = d.below(3);
    let turn = if kind == 0 { 0.0 } else { d.within(0.0, 1.5) };
    let reach = if kind == 0 { half } else { DVec2::splat(half.length()) };
    let centre = DVec2::new(
        if kind == 0 { half.x } else { d.within(reach.x + 0.02, (size.x - reach.x - 0.02).max(reach.x + 0.03)) },
        d.within(reach.y + 0.02, (size.y - reach.y - 0.02).max(reach.y + 0.03)),
    );
    let axis = DVec2::from_angle(turn);
    let corner = |x: f64, y: f64| centre + axis * (x * half.x) + axis.perp() * (y * half.y);
    let foot = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let (low, high) = match kind {
        2 => {
            let low = d.within(0.3, 0.5) * size.z;
            (low, low + 0.05)
        }
        _ => (0.0, height),
    };
    let at_height = |p: DVec2, z: f64| p.extend(z);
    for k in 0..4 {
        let (p, q) = (foot[k], foot[(k + 1) % 4]);
        b.face(&[at_height(p, low), at_height(q, low), at_height(q, high), at_height(p, high)], material);
    }
    b.face(&foot.map(|p| at_height(p, high)), material);
    let mut bottom = foot.map(|p| at_height(p, low));
    bottom.reverse();
    b.face(&bottom, material);
    (kind != 2).then_some(foot)
}

/// A place on the floor 2 to 15 cm from a box.
fn beside(d: &mut Dice, boxes: &[Foot], size: DVec3) -> Option<(DVec3, DVec3)> {
    if boxes.is_empty() {
        return None;
    }
    let foot = boxes[d.below(boxes.len() as u64) as usize];
    let side = d.below(4) as usize;
    let (p, q) = (foot[side], foot[(side + 1) % 4]);
    let place = p.lerp(q, d.within(0.05, 0.95)) - (q - p).perp().normalize() * d.within(0.02, 0.15);
    let inside = place.cmpgt(DVec2::splat(0.01)).all() && place.cmplt(size.truncate() - 0.01).all();
    inside.then(|| (place.extend(0.0), DVec3::Z))
}
