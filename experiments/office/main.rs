//! Is an hour of the year what `solve` says of that moment? Sunny and cloudy hours, drawn by chance, are solved again.
//!
//! ```text
//! cargo run --release --example year-by-moments -- SCENE.toml [SUNNY CLOUDY [PATCHES [WEATHER]]]
//! ```

#[path = "../../tests/common/mod.rs"]
mod common;

use std::error::Error;
use std::path::Path;

use clerestory::annual::{self, AnnualOptions, Hour, Year};
use clerestory::measure::{Silent, SolveOptions};
use clerestory::scene::{self, Scene};
use clerestory::transport::points::seed;
use common::year::{Agreement, against_moment, hours_of, is_cloudy, is_sunny};

/// Of the year, and of the moments, which are to be nearer the truth.
const TOLERANCES: [f64; 2] = [0.05, 0.02];

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let word = |k: usize, otherwise: &'static str| args.get(k).map_or(otherwise, String::as_str);
    let mut scene = scene::load(Path::new(args.first().ok_or("the scene is missing")?))?;
    let counts: [usize; 2] = [word(1, "20").parse()?, word(2, "20").parse()?];
    let parts = match word(3, "577") {
        "145" => 1,
        "577" => 2,
        "2305" => 4,
        _ => return Err("145, 577 or 2305 patches".into()),
    };
    if let Some(weather) = args.get(4) {
        let site = scene.daytime.as_mut().and_then(|d| d.site.as_mut()).ok_or("the scene has no site")?;
        site.weather = Some((weather.into(), std::fs::read(weather)?));
    }
    let options = AnnualOptions {
        solve: SolveOptions { tolerance: TOLERANCES[0], ..SolveOptions::default() },
        parts: Some(parts),
        ..AnnualOptions::default()
    };
    let year = annual::annual(&scene, &options, &Silent)?;
    print("sunny", &of_kind(&scene, &year, is_sunny, ("sunny", counts[0])));
    print("cloudy", &of_kind(&scene, &year, is_cloudy, ("cloudy", counts[1])));
    Ok(())
}

/// Hours of a kind, drawn by chance: each and all.
fn of_kind(scene: &Scene, year: &Year, wanted: fn(&Hour) -> bool, (name, count): (&str, usize)) -> Agreement {
    let mut chosen = hours_of(year, wanted);
    chosen.sort_by_key(|number| seed(&[*number as u64]));
    chosen.truncate(count);
    chosen.sort_unstable();
    chosen.into_iter().fold(Agreement::default(), |all, number| {
        let found = against_moment(scene, year, TOLERANCES[1], number);
        let hour = &year.climate.hours[number];
        print(&format!("{name} {:>2}/{:<2} {:>4.1} h", hour.month, hour.day, hour.sun_h), &found);
        all.with(found)
    })
}

fn print(name: &str, a: &Agreement) {
    let percent = |part: usize| 100.0 * part as f64 / a.count.max(1) as f64;
    println!(
        "{name:<22} {:>6} values: RMS {:>5.2} %, bias {:>+6.2} %, {:>5.1} % inside both errors",
        a.count,
        100.0 * a.rms(),
        100.0 * a.bias(),
        percent(a.inside)
    );
}
