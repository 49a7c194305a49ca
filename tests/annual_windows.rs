//! A year through windows of all kinds: against the same moments solved one by one, and against sheets that do the same.

mod common;

use clerestory::scene::{Material, MaterialKind};
use clerestory::spectrum::{BandMode, SpectralValue, illuminant};
use common::bsdf::{lambertian, slats, window};
use common::year::{against_moments, is_cloudy, is_sunny, room, room_of, year};
use common::{diffuse, glass, glazed, mirror, painted, rgb};

/// Most by which a year at 5 % may be off its moments, root of the mean square: what `solve` itself leaves at 5 % and at 2 %,
/// and the sun's reflected light between patches of 6 degrees.
const RMS: f64 = 0.03;

#[test]
fn the_sun_in_a_mirror_behind_a_pane_is_in_the_year() {
    let b = room_of(diffuse("wall", 0.5), mirror(0.9), glass(0.8));
    let y = year(&b.0, 0.05, 2);
    against_moments(&b.0, &y, (0.02, 5), is_sunny).assert(100, RMS);
    // Errors of what mirrors show of the sky are stated a little too small, for a moment too: 92 to 96 % are inside.
    let cloudy = against_moments(&b.0, &y, (0.02, 3), is_cloudy);
    assert!(cloudy.count >= 60 && cloudy.rms() < RMS, "{cloudy:?}: RMS {}", cloudy.rms());
}

#[test]
fn coloured_panes_before_coloured_walls_are_in_the_year_as_in_its_moments() {
    let mut b = room_of(
        painted("wall", rgb([0.2, 0.4, 0.7])),
        painted("north", rgb([0.7, 0.4, 0.2])),
        glazed(1, rgb([0.15, 0.4, 0.8])),
    );
    b.bands(BandMode::Rgb);
    // A sun of another colour than the sky: so the ground has the colour of neither.
    b.0.daytime.as_mut().expect("a sky").sun_spectrum = illuminant("A").expect("it is known");
    let y = year(&b.0, 0.05, 2);
    against_moments(&b.0, &y, (0.02, 4), is_sunny).assert(80, RMS);
    against_moments(&b.0, &y, (0.02, 2), is_cloudy).assert(40, RMS);
}

#[test]
fn slats_in_a_year_are_slats_in_its_moments() {
    let b = room(window(slats(), 1.0));
    let y = year(&b.0, 0.05, 2);
    against_moments(&b.0, &y, (0.02, 4), is_sunny).assert(80, RMS);
    against_moments(&b.0, &y, (0.02, 2), is_cloudy).assert(40, RMS);
}

#[test]
fn an_even_bsdf_is_a_translucent_sheet_all_year() {
    let [rho, tau] = [0.3, 0.5].map(SpectralValue::Grey);
    let kind = MaterialKind::Translucent { front: rho.clone(), back: rho, transmittance: tau, maintenance_factor: 1.0 };
    let sheet = year(&room(Material { kind, ..diffuse("sheet", 0.0) }).0, 0.05, 2);
    let bsdf = year(&room(window(lambertian(0.5, 0.3), 1.0)).0, 0.05, 2);
    let [sheet, bsdf] = [&sheet, &bsdf].map(|y| &y.grids[0].series);
    let (mut inside, mut all, mut sums) = (0, 0, [0.0; 2]);
    for k in (0..sheet.lux.len()).filter(|k| sheet.lux[*k] > 50.0) {
        let (a, b) = (sheet.lux[k], bsdf.lux[k]);
        inside += usize::from((a - b).abs() <= sheet.error[k] + bsdf.error[k]);
        all += 1;
        sums[0] += f64::from(a);
        sums[1] += f64::from(b);
    }
    assert!(all > 1000 && inside * 100 >= 95 * all, "{inside} of {all}");
    // A third of a single point's tolerance for the mean of all points and hours.
    assert!((sums[1] / sums[0] - 1.0).abs() < 0.017, "{sums:?}");
}

#[test]
fn a_year_with_a_bsdf_has_the_same_bits_for_any_number_of_threads() {
    let b = room(window(slats(), 1.0));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| year(&b.0, 0.1, 1).grids[0].series.clone())
    };
    let (one, three) = (on(1), on(3));
    assert!(one.lux == three.lux && one.error == three.error && one.sun == three.sun);
}
