//! Windows with a BSDF: against sheets that do the same, sums of their own, path tracing, and where the light goes.

mod common;

use clerestory::measure::Method;
use clerestory::scene::{Material, MaterialKind, SkyName};
use clerestory::spectrum::SpectralValue;
use common::bsdf::{day, lambertian, office, slats, window};
use common::{Build, Cover, assert_balanced, at, diffuse, lux, only, paths, solve, within};

fn compare(name: &str, b: &Build, tolerance: f64, count: u64) {
    let quick = solve(&b.0, &within(tolerance));
    let judge = solve(&b.0, &paths(count));
    let mut cover = Cover::default();
    cover.enter_pair(&quick.grids[0], &judge.grids[0], name);
    let (mut sum, mut err, mut worst) = (0.0, 0.0, 0.0f64);
    for (q, j) in only(&quick).iter().zip(only(&judge)) {
        let off = q.xyz[1] / j.xyz[1] - 1.0;
        sum += off * off;
        worst = worst.max(off.abs());
        err += j.error_lx / j.xyz[1];
    }
    let n = only(&quick).len() as f64;
    let mean = |m: &clerestory::measure::Measurement| lux(m).iter().sum::<f64>() / n;
    eprintln!(
        "{name} at {tolerance}: mean {:.2} against {:.2} ({:+.2} %), rms {:.2} %, worst {:.2} %, judge's error {:.2} %, cover {:.3}, ratio {:.2}",
        mean(&quick),
        mean(&judge),
        100.0 * (mean(&quick) / mean(&judge) - 1.0),
        100.0 * (sum / n).sqrt(),
        100.0 * worst,
        100.0 * err / n,
        cover.share(),
        cover.median_ratio()
    );
    for part in [0, 1, 2, 3] {
        let of = |m: &clerestory::measure::Measurement| {
            only(m).iter().map(|s| [s.sun_lx, s.sky_lx, s.external_lx, s.reflected_lx][part]).sum::<f64>() / n
        };
        eprintln!("   part {part}: {:.2} {:.2}", of(&quick), of(&judge));
    }
    let l = &quick.ledger;
    eprintln!(
        "   ledger {:.4e} = {:.4e} + {:.4e} + {:.4e}, open {:.2e}, sampling {:.2e}; {:?}",
        l.emitted[0],
        l.absorbed[0],
        l.escaped[0],
        l.unexpanded[0],
        l.emitted[0] - l.absorbed[0] - l.escaped[0] - l.unexpanded[0],
        l.sampling_error[0],
        quick.record.timings_s
    );
    for (k, v) in &quick.record.counts {
        eprint!("   {k} {v}");
    }
    eprintln!();
}

/// The office with slats, a house 8 m before it and a slab over the window.
fn outdoors(rho: [f64; 3]) -> Build {
    let mut b = office(rho, window(slats(), 1.0));
    let stone = b.material(Material { outside: true, ..diffuse("stone", 0.4) });
    b.block(at(-6.0, -14.0, -3.0), at(3.0, -8.0, 6.0), stone);
    b.block(at(0.0, -1.2, 2.6), at(4.0, 0.0, 2.75), stone);
    b
}

#[test]
fn explore() {
    let rho = [0.2, 0.5, 0.8];
    for (name, pane) in
        [("glass", common::glass(0.5)), ("even", window(lambertian(0.4, 0.1), 1.0)), ("slats", window(slats(), 1.0))]
    {
        let mut b = office(rho, pane);
        let stone = b.material(Material { outside: true, ..diffuse("stone", 0.4) });
        b.block(at(-6.0, -14.0, -3.0), at(3.0, -8.0, 6.0), stone);
        b.block(at(0.0, -1.2, 2.6), at(4.0, 0.0, 2.75), stone);
        b.level("desks", at(0.25, 0.5, 0.8), at(3.75, 5.5, 0.8), 5);
        b.0.daytime = Some(day(SkyName::Cie(12), 6e4, (40.0, 200.0)));
        for seed in 1..4 {
            let quick = solve(&b.0, &clerestory::measure::SolveOptions { seed, ..within(0.02) });
            let l = &quick.ledger;
            let rest = l.emitted[0] - l.absorbed[0] - l.escaped[0] - l.unexpanded[0];
            eprintln!(
                "{name}: emitted {:.3} open {:.4} sampling {:.4} {:?}",
                l.emitted[0], rest, l.sampling_error[0], quick.record.timings_s
            );
        }
    }
    let mut b = outdoors(rho);
    b.level("desks", at(0.25, 0.5, 0.8), at(3.75, 5.5, 0.8), 10);
    b.0.daytime = Some(day(SkyName::Overcast, 0.0, (40.0, 200.0)));
    compare("outdoors overcast", &b, 0.05, 1 << 14);
}
