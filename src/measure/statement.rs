//! The error of every sensor: crossed replicas, a variance model from the rays themselves, a coarse twin.
//!
//! Four independent ray sets `a` are each looked up in four independent solutions `b`, which tells the noise of the
//! sensor's own rays from that of the rows for no further ray. A second solution on a mesh twice as coarse, looked up
//! by the same rays, gives the scale of what the mesh hides. Covered 96 to 98 % of the sensors of a hundred random
//! furnished rooms when it was designed.
//!
//! Few rays that meet something bright make a mean that is mostly too low, and its variance with it. A two-sided interval
//! of Student's t is then too short: at 95 % by about the square of the mean's skewness, relative (Edgeworth expansion of
//! Student's t to the second order, Hall 1992, The Bootstrap and Edgeworth Expansion, chapter 2; 1.08 times that square
//! less 0.07 times the kurtosis, which is 1.5 times the square for gamma distributions).

use std::sync::LazyLock;

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::gather::REPLICAS;

/// Degrees of freedom lent by the grid to the noise of a sensor's rays, and to that of the rows. The latter is small on
/// purpose: sensors of a room look at the same elements, and many of them hardly tell more of their noise than one.
const POOLED_RAYS: f64 = 6.0;
const POOLED_ROWS: f64 = 1.0;
const OWN: f64 = REPLICAS as f64 - 1.0;
/// Median of a squared standard normal: turns a median of squares into a mean square.
const MEDIAN_SQUARE: f64 = 0.455;
/// Well-spread rays are never much noisier than independent ones; four sets can make them seem so.
const WORST_DESIGN: f64 = 4.0;
/// Area of an element over that of its twin's.
const TWIN_AREA: f64 = 0.25;
/// Rounding of single-precision rays and sums, relative.
const ROUNDING: f64 = 2e-6;

/// What one sensor gives to the statement, for one quantity (a band, or Y).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Readings {
    /// `main[a][b]`: ray set `a` in solution `b`.
    pub(super) main: [[f64; REPLICAS]; REPLICAS],
    /// The same on the coarse twin.
    pub(super) twin: [[f64; REPLICAS]; REPLICAS],
    /// Naive variance of the mean: what independent rays would give.
    pub(super) naive: f64,
    /// Square of the skewness of that mean.
    pub(super) skewness: f64,
    /// What earlier rounds told of the noise.
    pub(super) memory: Memory,
}

impl Readings {
    fn difference(&self) -> [[f64; REPLICAS]; REPLICAS] {
        std::array::from_fn(|a| std::array::from_fn(|b| self.main[a][b] - self.twin[a][b]))
    }
}

/// What rounds before this one told of the noise of a sensor.
///
/// Four replicas alone tell a variance with three degrees of freedom: often far too small, and a loop that stops as
/// soon as the error looks small enough would stop on just those.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Memory {
    /// Variance that the rows leave. It goes with the area of an element.
    pub(super) rows: Known,
    /// Variance of well-spread rays against that of as many independent ones. It falls with their number.
    pub(super) design: Known,
}

/// A mean square, and the degrees of freedom with which it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Known {
    estimate: f64,
    freedom: f64,
}

impl Known {
    fn and(self, other: Self) -> Self {
        let freedom = self.freedom + other.freedom;
        let sum = self.freedom * self.estimate + other.freedom * other.estimate;
        Self { estimate: if freedom > 0.0 { sum / freedom } else { 0.0 }, freedom }
    }

    /// What it tells of a round in which it should be `factor` times as large; trusted by half, as that law is rough.
    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { estimate: self.estimate * factor, freedom: 0.5 * self.freedom }
    }
}

/// The value of one sensor, and the parts of its error (95 % half-widths).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Stated {
    pub(super) value: f64,
    pub(super) error: f64,
    /// Noise of the sensor's own rays.
    pub(super) rays: f64,
    /// Noise of the rows.
    pub(super) rows: f64,
    /// What the mesh hides.
    pub(super) mesh: f64,
    /// What this round and those before tell of the noise.
    pub(super) memory: Memory,
    /// What the error is to be compared with: the value, or a tenth of the grid's mean if that is more.
    pub(super) scale: f64,
}

impl Stated {
    /// Is the error inside the tolerance?
    pub(super) fn holds(&self, tolerance: f64) -> bool {
        self.error <= tolerance * self.scale
    }
}

struct Parts {
    value: f64,
    memory: Memory,
    /// Variances that rays and rows leave, as this round's replicas alone tell them.
    own_rays: f64,
    own_rows: f64,
    naive: f64,
    skewness: f64,
    x: f64,
}

impl Parts {
    fn v_rays(&self) -> f64 {
        self.memory.design.estimate * self.naive
    }
}

fn crossed(m: &[[f64; REPLICAS]; REPLICAS]) -> (f64, f64, f64) {
    let r = REPLICAS as f64;
    let by_set: [f64; REPLICAS] = std::array::from_fn(|a| m[a].iter().sum::<f64>() / r);
    let by_solution: [f64; REPLICAS] = std::array::from_fn(|b| m.iter().map(|row| row[b]).sum::<f64>() / r);
    let mean = by_set.iter().sum::<f64>() / r;
    let variance = |v: &[f64; REPLICAS]| v.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (OWN * r);
    (mean, variance(&by_set), variance(&by_solution))
}

/// Square of the mean, without what noise adds to it.
fn square(m: &[[f64; REPLICAS]; REPLICAS]) -> f64 {
    let (mean, v_rays, v_rows) = crossed(m);
    mean * mean - v_rays - v_rows
}

/// Square of the relative difference between mesh and twin that all sensors of a grid share. Noise drowns it in each.
fn shared_square(readings: &[Readings], scales: &[f64]) -> f64 {
    let mut mean = [[0.0; REPLICAS]; REPLICAS];
    for (r, scale) in readings.iter().zip(scales).filter(|(_, s)| **s > 0.0) {
        let d = r.difference();
        for (sum, d) in mean.as_flattened_mut().iter_mut().zip(d.as_flattened()) {
            *sum += d / (scale * readings.len() as f64);
        }
    }
    square(&mean)
}

fn parts(reading: &Readings) -> Parts {
    let (value, v_rays, v_rows) = crossed(&reading.main);
    let (_, _, twin_rows) = crossed(&reading.twin);
    let own = |estimate: f64| Known { estimate, freedom: OWN };
    // The square of a mean, taken from another mean, can come out much too small.
    let naive = reading.naive.max(v_rays / WORST_DESIGN);
    let memory = Memory {
        rows: own(v_rows).and(own(twin_rows * TWIN_AREA)).and(reading.memory.rows),
        design: own(if naive > 0.0 { v_rays / naive } else { 0.0 }).and(reading.memory.design),
    };
    Parts {
        value,
        memory,
        own_rays: v_rays,
        own_rows: v_rows,
        naive,
        skewness: reading.skewness,
        x: square(&reading.difference()),
    }
}

/// Variance of well-spread rays against that of as many independent ones, pooled.
pub(super) fn design_effect(readings: &[Readings]) -> f64 {
    let (own, naive) = readings.iter().map(parts).fold((0.0, 0.0), |(v, n), p| {
        let scale = p.value * p.value;
        if scale > 0.0 { (v + p.v_rays() / scale, n + p.naive / scale) } else { (v, n) }
    });
    if naive > 0.0 { own / naive } else { 0.0 }
}

/// States the errors of all sensors of a grid, for one quantity. `iteration` is the relative error left by the solver.
pub(super) fn state(readings: &[Readings], iteration: f64) -> Vec<Stated> {
    let parts: Vec<Parts> = readings.iter().map(parts).collect();
    let count = parts.len().max(1) as f64;
    let mean = parts.iter().map(|p| p.value).sum::<f64>() / count;
    let scales: Vec<f64> = parts.iter().map(|p| p.value.max(0.1 * mean)).collect();
    let relative = |f: &dyn Fn(&Parts) -> f64| -> Vec<f64> {
        parts.iter().zip(&scales).map(|(p, s)| if *s > 0.0 { f(p) / (s * s) } else { 0.0 }).collect()
    };
    let sum = |v: &[f64]| v.iter().sum::<f64>();
    let design_of_grid = sum(&relative(&Parts::v_rays)) / sum(&relative(&|p| p.naive)).max(1e-300);
    let rows_of_grid = sum(&relative(&|p| p.memory.rows.estimate)) / count;
    let x = relative(&|p| p.x);
    let typical = (median(x.iter().map(|x| x.max(0.0)).collect()) / MEDIAN_SQUARE).min(sum(&x) / count);
    let floor = typical.max(shared_square(readings, &scales));
    parts
        .iter()
        .zip(&scales)
        .zip(&x)
        .map(|((p, scale), x)| {
            let pool = |estimate, freedom| Known { estimate, freedom };
            let design = p.memory.design.and(pool(design_of_grid, POOLED_RAYS));
            let of_rows = p.memory.rows.and(pool(rows_of_grid * scale * scale, POOLED_ROWS));
            // What is pooled may warn, but not soothe.
            let (rays, rows) = ((design.estimate * p.naive).max(p.own_rays), of_rows.estimate.max(p.own_rows));
            let freedom =
                (rays + rows).powi(2) / (rays * rays / design.freedom + rows * rows / of_rows.freedom).max(1e-300);
            let t = student(freedom);
            let mesh = x.max(floor).max(0.0).sqrt() * scale;
            let wide = t * (1.0 + p.skewness);
            let noise = wide * wide * rays + t * t * rows;
            Stated {
                value: p.value,
                error: (noise + mesh * mesh).sqrt() + (iteration + ROUNDING) * p.value,
                rays: wide * rays.sqrt(),
                rows: t * rows.sqrt(),
                mesh,
                memory: p.memory,
                scale: *scale,
            }
        })
        .collect()
}

pub(super) fn median(mut v: Vec<f64>) -> f64 {
    if v.is_empty() {
        return 0.0;
    }
    let middle = v.len() / 2;
    *v.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Two-sided 95 % quantile of Student's t.
pub(crate) fn student(freedom: f64) -> f64 {
    const STEP: f64 = 0.25;
    static TABLE: LazyLock<Vec<f64>> = LazyLock::new(|| {
        (0..=400)
            .map(|k| {
                let freedom = (f64::from(k) * STEP).max(1.0);
                StudentsT::new(0.0, 1.0, freedom).map_or(12.7, |t| t.inverse_cdf(0.975))
            })
            .collect()
    });
    let at = (freedom / STEP).clamp(4.0, 399.0);
    let k = at as usize;
    TABLE[k] + (TABLE[k + 1] - TABLE[k]) * (at - k as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn student_matches_the_tables() {
        // Fisher and Yates, two-sided 95 %: 3 -> 3.182, 6 -> 2.447, 15 -> 2.131, 30 -> 2.042.
        for (nu, t) in [(3.0, 3.182), (6.0, 2.447), (15.0, 2.131), (30.0, 2.042)] {
            assert!((student(nu) - t).abs() < 6e-4, "{nu}: {}", student(nu));
        }
    }

    #[test]
    fn equal_replicas_state_rounding_alone() {
        let r = Readings { main: [[5.0; 4]; 4], twin: [[5.0; 4]; 4], ..Readings::default() };
        let s = state(&[r; 10], 0.0);
        assert!(s.iter().all(|s| s.value == 5.0 && s.error <= 5.0 * ROUNDING + 1e-12), "{:?}", s[0]);
    }

    fn uniform() -> impl FnMut() -> f64 {
        let mut state = 1u64;
        move || {
            state = crate::transport::points::mix(state);
            (state >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    #[test]
    fn skewed_rays_are_covered_too() {
        // Squares of exponential numbers, 64 in a set: skewness 6.6, mean 2. 4,000 sensors in grids of 40.
        const RAYS: usize = 64;
        let mut uniform = uniform();
        let mut share = |mends: bool| {
            let mut inside = 0;
            for _ in 0..100 {
                let readings: Vec<Readings> = (0..40)
                    .map(|_| {
                        let rays: [[f64; RAYS]; 4] = [[(); RAYS]; 4].map(|set| set.map(|()| uniform().ln().powi(2)));
                        let main = rays.map(|set| [set.iter().sum::<f64>() / RAYS as f64; 4]);
                        let n = (4 * RAYS) as f64;
                        let moment = |k: i32| rays.iter().flatten().map(|y| y.powi(k)).sum::<f64>() / n;
                        let (mean, variance) = (moment(1), moment(2) - moment(1).powi(2));
                        let third = moment(3) - 3.0 * mean * moment(2) + 2.0 * mean.powi(3);
                        let skewness = if mends { third.powi(2) / variance.powi(3) / n } else { 0.0 };
                        Readings { main, twin: main, naive: variance / n, skewness, ..Readings::default() }
                    })
                    .collect();
                inside += state(&readings, 0.0).iter().filter(|s| (s.value - 2.0).abs() <= s.error).count();
            }
            inside as f64 / 4000.0
        };
        let (without, with) = (share(false), share(true));
        // Binomial: 2 sigma of 4,000 at 95 % is 0.7 %; the skewness of a sample is less than the true one.
        assert!(with > 0.935 && with > without + 0.01, "{without} without, {with} with");
    }

    #[test]
    fn normal_noise_is_covered_at_its_level() {
        // Additive noise of rays (by set) and rows (by solution, twice as much in the twin); the truth is 1. 2,000 sensors in grids of 50.
        let mut uniform = uniform();
        // Sum of twelve uniforms: kurtosis -0.1, good enough for a level of 95 %.
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        let (mut inside, mut total, mut width) = (0, 0, 0.0);
        for _ in 0..40 {
            let readings: Vec<Readings> = (0..50)
                .map(|_| {
                    let mut noise = |sd: f64| -> [f64; 4] { std::array::from_fn(|_| sd * normal()) };
                    let (a, b, c) = (noise(0.02), noise(0.01), noise(0.02));
                    let read = |b: [f64; 4]| std::array::from_fn(|i| std::array::from_fn(|j| 1.0 + a[i] + b[j]));
                    Readings { main: read(b), twin: read(c), naive: 0.02f64.powi(2) / 4.0, ..Readings::default() }
                })
                .collect();
            for s in state(&readings, 0.0) {
                inside += usize::from((s.value - 1.0).abs() <= s.error);
                total += 1;
                width += s.error;
            }
        }
        let share = f64::from(inside as u32) / f64::from(total as u32);
        // Binomial: 3 sigma of 2,000 at 95 % is 1.5 %; the t factors make it conservative, not loose.
        assert!((0.935..0.995).contains(&share), "{share}");
        assert!(width / f64::from(total as u32) < 4.0 * 0.0112, "mean half-width {width}");
    }
}
