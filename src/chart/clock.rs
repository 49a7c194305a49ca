//! What a run costs: processor time, wall time, memory.

use std::time::Instant;

/// What something took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    /// Processor time of all threads, s; wall time where the system does not tell.
    pub cpu_s: f64,
    /// Wall time, s.
    pub wall_s: f64,
    /// Most memory in use, 10⁶ bytes, where the system tells.
    pub peak_mem_mb: Option<f64>,
}

/// Lets the peak of memory begin anew, where the system lets one.
pub(super) fn settle() {
    // A system without this file keeps its old peak, which is then the peak so far.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// Runs `work` and tells what it took.
pub(super) fn timed<T>(work: impl FnOnce() -> T) -> (T, Cost) {
    let (start, before) = (Instant::now(), cpu_seconds());
    let out = work();
    let wall_s = start.elapsed().as_secs_f64();
    let cpu_s = cpu_seconds().zip(before).map_or(wall_s, |(after, before)| after - before);
    (out, Cost { cpu_s, wall_s, peak_mem_mb: peak_mem_mb() })
}

/// Processor time of all threads of this process that still run, s; `None` where the system does not tell.
#[must_use]
pub fn cpu_seconds() -> Option<f64> {
    let tasks = std::fs::read_dir("/proc/self/task").ok()?;
    let ns = |path: std::path::PathBuf| -> Option<u64> {
        std::fs::read_to_string(path.join("schedstat")).ok()?.split_whitespace().next()?.parse().ok()
    };
    let times: Vec<u64> = tasks.filter_map(|t| ns(t.ok()?.path())).collect();
    (!times.is_empty()).then(|| times.iter().sum::<u64>() as f64 * 1e-9)
}

fn peak_mem_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024.0 / 1e6)
}
