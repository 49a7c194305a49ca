//! Points of other programs, measured by them or by a script, from a CSV of the chart's own columns.

use std::path::Path;

use super::{Found, Point};
use crate::error::{Error, Result};

/// Reads a peer file. `method`, `cpu_s` and `rms_rel` must be there; other columns of `chart.csv` may be.
///
/// # Errors
///
/// Io, or malformed with file and line.
pub fn read(path: &Path) -> Result<Vec<Point>> {
    let mut reader = csv::Reader::from_path(path).map_err(|e| match e.into_kind() {
        csv::ErrorKind::Io(e) => Error::io(path, &e),
        other => Error::malformed(format!("{other:?}")).in_file(path),
    })?;
    let headers = reader.headers().map_err(|e| Error::malformed(e.to_string()).in_file(path))?.clone();
    let column = |name: &str| headers.iter().position(|h| h.trim() == name);
    for name in ["method", "cpu_s", "rms_rel"] {
        if column(name).is_none() {
            return Err(Error::malformed(format!("no column {name:?}"))
                .mend("the header is that of chart.csv; method, cpu_s and rms_rel must be there")
                .in_file(path)
                .at_line(1));
        }
    }
    let mut points = Vec::new();
    for row in reader.records() {
        let row = row.map_err(|e| Error::malformed(e.to_string()).in_file(path))?;
        let line = row.position().map_or(0, |p| p.line() as usize);
        let text = |name: &str| column(name).and_then(|c| row.get(c)).map_or("", str::trim);
        let number = |name: &str| -> Result<Option<f64>> {
            match text(name) {
                "" => Ok(None),
                t => match t.parse::<f64>() {
                    Ok(v) if v.is_finite() => Ok(Some(v)),
                    _ => Err(Error::malformed(format!("{name} is {t:?}, not a number")).in_file(path).at_line(line)),
                },
            }
        };
        let positive = |name: &str| -> Result<f64> {
            number(name)?.filter(|v| *v > 0.0).ok_or_else(|| {
                Error::malformed(format!("{name} must be above zero"))
                    .mend("seconds of processor time; the error as a fraction of the mean")
                    .in_file(path)
                    .at_line(line)
            })
        };
        points.push(Point {
            method: text("method").to_owned(),
            setting: text("setting").to_owned(),
            cpu_s: positive("cpu_s")?,
            wall_s: number("wall_s")?.unwrap_or(0.0),
            rays: number("rays")?.map(|v| v as u64),
            form_factors: number("form_factors")?.map(|v| v as u64),
            peak_mem_mb: number("peak_mem_mb")?,
            found: Some(Found {
                rms: positive("rms_rel")?,
                bias: number("mbe_rel")?.unwrap_or(0.0),
                p95: number("p95_rel")?.unwrap_or(0.0),
                largest: number("max_rel")?.unwrap_or(0.0),
                stated_p95: number("stated_p95")?,
                coverage: number("coverage")?,
                resolved: text("resolved") != "false",
            }),
            note: "peer".into(),
        });
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Vec<Point>> {
        let dir = tempfile::tempdir().map_err(|e| Error::io("temporary", &e))?;
        let path = dir.path().join("peer.csv");
        std::fs::write(&path, text).map_err(|e| Error::io(&path, &e))?;
        read(&path)
    }

    #[test]
    fn a_peer_needs_a_name_a_time_and_an_error() {
        let points = of("method,setting,cpu_s,rms_rel\nrtrace,-ab 3,1.5,0.02\n").expect("a peer");
        assert_eq!(
            (points[0].method.as_str(), points[0].cpu_s, points[0].found.map(|f| f.rms)),
            ("rtrace", 1.5, Some(0.02))
        );
        for (bad, word) in [
            ("method,cpu_s\na,1\n", "rms_rel"),
            ("method,cpu_s,rms_rel\na,fast,0.1\n", "2: cpu_s is \"fast\""),
            ("method,cpu_s,rms_rel\na,0,0.1\n", "above zero"),
        ] {
            let error = of(bad).expect_err("malformed").to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
