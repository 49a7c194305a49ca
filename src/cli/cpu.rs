//! Processor time of this process.

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_found_behind_an_awkward_name() {
        let stat = "7 (a) b (c) R 1 2 3 4 5 6 7 8 9 10 250 50 0 0 20";
        assert_eq!(ticks(stat), Some(300.0));
        assert_eq!(ticks("7"), None);
    }
}
