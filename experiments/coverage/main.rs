//! Are the stated errors true? Random furnished rooms against path tracing.
//!
//! `cargo run --release --example coverage [ROOMS]` prints a line for each room and tolerance and writes `results.csv`.

#[path = "../../tests/common/mod.rs"]
mod common;

use std::fmt::Write;

use clerestory::chart::cpu_seconds;
use clerestory::measure::{Measurement, SensorResult, Status};
use common::rooms::random_room;
use common::{Cover, paths, solve, within};

/// Paths per sensor of the reference.
const PATHS: u64 = 1 << 17;
const TOLERANCES: [f64; 3] = [0.1, 0.05, 0.02];

fn main() -> std::io::Result<()> {
    let rooms: u64 = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(36);
    let mut csv =
        String::from("room,tolerance,sensors,inside,median_ratio,median_error,largest_error,holding,cpu_s,mesh\n");
    let mut pooled: [Pool; 3] = Default::default();
    for number in 0..rooms {
        let room = random_room(number);
        let reference = solve(&room.0, &paths(PATHS));
        for (tolerance, pool) in TOLERANCES.iter().zip(&mut pooled) {
            let before = cpu_seconds().unwrap_or(f64::NAN);
            let m = solve(&room.0, &within(*tolerance));
            let cpu_s = cpu_seconds().unwrap_or(f64::NAN) - before;
            let room = Room::new(&m, &reference);
            let (share, ratio) = (room.cover.share(), room.cover.median_ratio());
            println!(
                "room {number:>3} {:>4} %: {:>3} sensors, {:>5.1} % inside, ratio {ratio:>4.1}, true error {:>5.2} % median, \
                 {:>5.2} % largest, {:>3.0} % hold, {cpu_s:.2} CPU s",
                100.0 * tolerance,
                room.cover.list.len(),
                100.0 * share,
                100.0 * room.median,
                100.0 * room.largest,
                100.0 * room.holding,
            );
            // Writing to a string cannot fail.
            let _ = writeln!(
                csv,
                "{number},{tolerance},{},{share:.4},{ratio:.2},{:.5},{:.5},{:.3},{cpu_s:.2},{}",
                room.cover.list.len(),
                room.median,
                room.largest,
                room.holding,
                m.record.settings.iter().find(|s| s.name == "element size").map_or("", |s| s.value.as_str()),
            );
            pool.worst = pool.worst.min(share);
            pool.cover.list.extend(room.cover.list);
        }
    }
    for (tolerance, pool) in TOLERANCES.iter().zip(&pooled) {
        println!(
            "{} %: {:.2} % of {} sensors inside, worst room {:.1} %, median of stated over true error {:.2}",
            100.0 * tolerance,
            100.0 * pool.cover.share(),
            pool.cover.list.len(),
            100.0 * pool.worst,
            pool.cover.median_ratio()
        );
    }
    std::fs::write(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/coverage/results.csv"), csv)
}

struct Pool {
    cover: Cover,
    worst: f64,
}

impl Default for Pool {
    fn default() -> Self {
        Self { cover: Cover::default(), worst: 1.0 }
    }
}

/// One room at one tolerance; errors are fractions of each reading, but of no less than a tenth of the grid's mean.
struct Room {
    cover: Cover,
    median: f64,
    largest: f64,
    holding: f64,
}

impl Room {
    fn new(m: &Measurement, reference: &Measurement) -> Self {
        let mut cover = Cover::default();
        let mut errors = Vec::new();
        for (grid, truth) in m.grids.iter().zip(&reference.grids) {
            let lit = |s: &&SensorResult| s.status == Status::Ok;
            let mean = truth.sensors.iter().filter(lit).map(|s| s.xyz[1]).sum::<f64>();
            let mean = mean / truth.sensors.iter().filter(lit).count().max(1) as f64;
            for (s, t) in grid.sensors.iter().zip(&truth.sensors).filter(|(s, t)| lit(s) && lit(t)) {
                // The reference has an error of its own.
                cover.enter(s.xyz[1], s.error_lx.hypot(t.error_lx), 0.0, t.xyz[1], &grid.name);
                errors.push((s.xyz[1] - t.xyz[1]).abs() / t.xyz[1].max(0.1 * mean));
            }
        }
        errors.sort_by(f64::total_cmp);
        let holding: usize = m.grids.iter().map(|g| g.holding).sum();
        Self {
            median: errors[errors.len() / 2],
            largest: errors[errors.len() - 1],
            holding: holding as f64 / errors.len() as f64,
            cover,
        }
    }
}
