//! What light does to receptors other than those of photopic vision, through reflections at coloured walls.

mod common;

use clerestory::measure::SolveOptions;
use clerestory::scene::Emission;
use clerestory::spectrum::{
    ALPHA_OPIC, Action, BandMode, Beyond, SpectralValue, Spectrum, daylight_efficacy_ratio, illuminant,
};
use common::{Build, at, painted, solve};
use glam::DVec3;

/// A closed cube whose walls all glow alike: `E(λ) = M(λ) / (1 − ρ(λ))` at every point.
fn furnace(paint: SpectralValue, lamp: &Spectrum) -> Build {
    let mut b = Build::new();
    b.bands(BandMode::Auto);
    let mut wall = painted("wall", paint);
    wall.emission = Some(Emission { radiance: lamp.clone(), two_sided: false, group: None });
    let wall = b.material(wall);
    b.room(DVec3::ZERO, DVec3::splat(2.0), [wall; 6]);
    b.points("inside", &[(at(1.0, 1.0, 1.0), DVec3::Z), (at(0.5, 1.2, 0.7), DVec3::X)]);
    b
}

fn asked() -> SolveOptions {
    SolveOptions { alpha_opic: true, tolerance: 0.02, ..SolveOptions::default() }
}

#[test]
fn grey_walls_keep_the_melanopic_ratio_of_the_lamp() {
    let lamp = illuminant("LED-B3").unwrap();
    let m = solve(&furnace(SpectralValue::Grey(0.6), &lamp).0, &asked());
    assert_eq!(m.bands.len(), 1, "one band is exact for grey walls");
    let scale = m.alpha_opic.as_ref().unwrap();
    let ratio = daylight_efficacy_ratio(Action::Melanopic, &lamp).unwrap();
    for sensor in &m.grids[0].sensors {
        let (edi_lx, _) = scale.read(sensor).melanopic_edi_lx;
        // Both are the one band's value times a constant; transport is in 32 bits.
        assert!((edi_lx / sensor.xyz[1] / ratio - 1.0).abs() < 1e-5, "{edi_lx} {}", edi_lx / sensor.xyz[1] / ratio);
    }
}

#[test]
fn coloured_walls_change_every_receptor_as_the_furnace_says() {
    let paint = Spectrum::new(vec![420.0, 520.0, 620.0], vec![0.1, 0.3, 0.7], Beyond::Hold).unwrap();
    let lamp = illuminant("F11").unwrap();
    let m = solve(&furnace(SpectralValue::Spectrum(paint.clone()), &lamp).0, &asked());
    let scale = m.alpha_opic.as_ref().unwrap();
    let nm: Vec<f64> = (0..4010).map(|i| 380.05 + 0.1 * f64::from(i)).collect();
    for (k, action) in ALPHA_OPIC.iter().enumerate() {
        let at = |nm: f64| std::f64::consts::PI * lamp.at(nm) / (1.0 - paint.at(nm)) * action.at(nm);
        // The middle of every tenth of a nanometre: what curvature leaves is below 1e-5.
        let exact: f64 = nm.iter().map(|&nm| 0.1 * at(nm)).sum();
        for sensor in &m.grids[0].sensors {
            let (value, error) = scale.read(sensor).irradiance[k];
            assert!((value - exact).abs() <= error, "{action:?}: {value} ± {error}, exactly {exact}");
            // A statement that says nothing would be easy to hold.
            assert!(error <= 0.05 * exact, "{action:?}: {value} ± {error}");
        }
    }
}

#[test]
fn three_channels_are_too_few_for_five_receptors() {
    let mut b = furnace(SpectralValue::Rgb([0.5, 0.4, 0.3]), &illuminant("D65").unwrap());
    b.bands(BandMode::Rgb);
    let refused = clerestory::measure::solve(&b.0, &asked(), &clerestory::measure::Silent).unwrap_err();
    assert!(refused.to_string().contains("red, green and blue"), "{refused}");
    assert!(refused.is_input());
}
