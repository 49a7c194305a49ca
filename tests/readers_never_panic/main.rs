//! Every reader against spoilt files: none panics, hangs or takes the machine's memory, and what is accepted is finite.
//!
//! Files are spoilt by counted random numbers: the same ones on every run. `READERS_SECONDS` tells for how long each reader
//! is fed (0.3 s unless given); `fuzz` does the same guided by coverage, from samples written to `READERS_SAMPLES`.

mod found;
mod mutate;
mod readers;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use mutate::Mutator;
use readers::{ALL, Reader};

/// A file of a few kilobytes takes a millisecond; this is for busy machines.
const LONGEST: Duration = Duration::from_secs(10);

fn seconds() -> f64 {
    std::env::var("READERS_SECONDS").ok().and_then(|s| s.parse().ok()).unwrap_or(0.3)
}

/// Feeds a reader until its time is over, a hundred files at least: how many it got and accepted, or the file that broke it.
fn feed(reader: &Reader, number: u64) -> Result<(usize, usize), String> {
    let samples = (reader.samples)();
    let mut mutator = Mutator::new(number);
    let begun = Instant::now();
    let (mut count, mut accepted) = (0, 0);
    while count < 100 || begun.elapsed().as_secs_f64() < seconds() {
        let file = mutator.spoil(&samples);
        let at = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| (reader.read)(&file)));
        let took = at.elapsed();
        if outcome.is_err() || took > LONGEST {
            let how = if outcome.is_ok() { "returned" } else { "panicked" };
            return Err(format!("{}, file {count}: {how} after {took:?}\n{}", reader.name, file.escape_ascii()));
        }
        count += 1;
        accepted += usize::from(outcome.is_ok_and(|a| a));
    }
    Ok((count, accepted))
}

#[test]
fn the_samples_are_accepted() {
    for reader in ALL {
        let samples = (reader.samples)();
        assert!((reader.read)(&samples[0]), "{}: the first sample is refused", reader.name);
        let Ok(folder) = std::env::var("READERS_SAMPLES") else { continue };
        let folder = Path::new(&folder).join(reader.name);
        std::fs::create_dir_all(&folder).expect("a folder");
        for (number, sample) in samples.iter().enumerate() {
            std::fs::write(folder.join(format!("sample-{number}")), sample).expect("written");
        }
    }
}

#[test]
fn what_once_broke_a_reader_is_read_or_refused() {
    for (name, file, right) in found::FOUND {
        let reader = ALL.iter().find(|r| r.name == name).expect("a reader of that name");
        assert_eq!((reader.read)(file), right, "{name}: {}", file.escape_ascii());
    }
}

#[test]
fn no_spoilt_file_breaks_a_reader() {
    let mut broken = Vec::new();
    for (number, reader) in ALL.iter().enumerate() {
        match feed(reader, number as u64) {
            Ok((count, accepted)) => eprintln!("{:>10}: {count} files, {accepted} accepted", reader.name),
            Err(what) => broken.push(what),
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    if let Some(mb) = peak_memory_mb() {
        assert!(mb < 1024.0, "the readers took {mb} MB");
    }
}

/// Largest memory of this process so far, MB, where the system tells it.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<f64>().ok().map(|kb| kb / 1024.0)
}
