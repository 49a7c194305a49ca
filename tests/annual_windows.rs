//! A year through windows of all kinds: against the same moments solved one by one.

mod common;

use clerestory::spectrum::illuminant;
use common::bsdf::{slats, window};
use common::year::{Agreement, against_moments, is_cloudy, is_sunny, room, room_of, year};
use common::{diffuse, glass, glazed, mirror, painted, rgb};

fn tell(what: &str, a: &Agreement) {
    println!("{what}: n {} inside {} rms {:.4} bias {:.4}", a.count, a.inside, a.rms(), a.bias());
}

#[test]
fn the_sun_in_a_mirror_behind_a_pane_is_in_the_year() {
    let b = room_of(diffuse("wall", 0.5), mirror(0.9), glass(0.8));
    let y = year(&b.0, 0.05, 2);
    let sunny = against_moments(&b.0, &y, (0.02, 10), is_sunny);
    tell("mirror sunny", &sunny);
    let cloudy = against_moments(&b.0, &y, (0.02, 10), is_cloudy);
    tell("mirror cloudy", &cloudy);
    sunny.assert(200, 0.03);
    cloudy.assert(200, 0.03);
}

#[test]
fn coloured_panes_before_coloured_walls_are_in_the_year_as_in_its_moments() {
    let mut b = room_of(
        painted("wall", rgb([0.2, 0.4, 0.7])),
        painted("north", rgb([0.7, 0.4, 0.2])),
        glazed(1, rgb([0.15, 0.4, 0.8])),
    );
    let y = year(&b.0, 0.05, 2);
    let sunny = against_moments(&b.0, &y, (0.02, 10), is_sunny);
    tell("colour sunny", &sunny);
    let cloudy = against_moments(&b.0, &y, (0.02, 10), is_cloudy);
    tell("colour cloudy", &cloudy);
    sunny.assert(200, 0.03);
    cloudy.assert(200, 0.03);
    // A sun of another colour than the sky.
    b.0.daytime.as_mut().expect("a sky").sun_spectrum = illuminant("A").expect("it is known");
    let y = year(&b.0, 0.05, 2);
    let sunny = against_moments(&b.0, &y, (0.02, 10), is_sunny);
    tell("two colours", &sunny);
    sunny.assert(200, 0.03);
}

#[test]
fn slats_in_a_year_are_slats_in_its_moments() {
    let b = room(window(slats(), 1.0));
    let y = year(&b.0, 0.05, 2);
    let sunny = against_moments(&b.0, &y, (0.02, 10), is_sunny);
    tell("slats sunny", &sunny);
    let cloudy = against_moments(&b.0, &y, (0.02, 10), is_cloudy);
    tell("slats cloudy", &cloudy);
    sunny.assert(200, 0.03);
    cloudy.assert(200, 0.03);
}
