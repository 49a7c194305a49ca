//! Processor time and memory of this process.

/// Clock ticks in a second, as Linux reports process times on every architecture of today.
const TICKS_PER_S: f64 = 100.0;

/// User and system time of this process and its threads, s; `None` where the system does not tell.
pub(super) fn seconds() -> Option<f64> {
    ticks(&std::fs::read_to_string("/proc/self/stat").ok()?).map(|t| t / TICKS_PER_S)
}

/// Fields 14 and 15 (utime, stime) of `/proc/self/stat`; the second field may hold blanks and brackets.
fn ticks(stat: &str) -> Option<f64> {
    let (_, after_name) = stat.rsplit_once(')')?;
    let mut fields = after_name.split_whitespace().skip(11);
    let user: f64 = fields.next()?.parse().ok()?;
    let system: f64 = fields.next()?.parse().ok()?;
    Some(user + system)
}

/// Largest memory that this process has held so far, bytes; `None` where the system does not tell.
pub(super) fn peak_bytes() -> Option<u64> {
    high_water(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// The line `VmHWM` of `/proc/self/status`.
fn high_water(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kb| 1024 * kb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_found_behind_an_awkward_name() {
        let stat = "7 (a) b (c) R 1 2 3 4 5 6 7 8 9 10 250 50 0 0 20";
        assert_eq!(ticks(stat), Some(300.0));
        assert_eq!(ticks("7"), None);
    }

    #[test]
    fn the_high_water_mark_is_in_bytes() {
        assert_eq!(high_water("VmPeak:\t  9 kB\nVmHWM:\t    1024 kB\n"), Some(1 << 20));
        assert_eq!(high_water("VmRSS:\t 5 kB"), None);
    }
}
