//! Clocks of the benches.

use std::time::Instant;

/// Clock ticks in a second, as Linux reports process times.
const TICKS_PER_S: f64 = 100.0;

/// What something took.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Took {
    /// Wall time, s.
    pub(crate) wall_s: f64,
    /// Processor time of all threads, s; not a number where the system does not tell.
    pub(crate) cpu_s: f64,
}

/// Runs `work` and tells what it took.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, Took) {
    let (start, cpu) = (Instant::now(), cpu_s());
    let out = work();
    (out, Took { wall_s: start.elapsed().as_secs_f64(), cpu_s: cpu_s() - cpu })
}

/// User and system time of this process, s.
fn cpu_s() -> f64 {
    let ticks = || -> Option<f64> {
        let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
        let (_, fields) = stat.rsplit_once(')')?;
        let mut fields = fields.split_whitespace().skip(11);
        let user: f64 = fields.next()?.parse().ok()?;
        let system: f64 = fields.next()?.parse().ok()?;
        Some(user + system)
    };
    ticks().map_or(f64::NAN, |t| t / TICKS_PER_S)
}
