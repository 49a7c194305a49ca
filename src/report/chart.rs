//! What a chart run writes: `chart.csv`, `chart.svg`, `chart.png`, `reference.csv`.

use std::path::{Path, PathBuf};

use glam::DVec2;

use super::canvas::{Colour, INK, LINE};
use super::drawing::{Anchor, Drawing, Mark};
use super::file::write_whole;
use super::panel::{Panel, heading, plain, style};
use super::text::Font;
use crate::chart::{Chart, Found, Point, pareto};
use crate::error::{Error, ErrorKind, Result};

const COLUMNS: [&str; 14] = [
    "method",
    "setting",
    "cpu_s",
    "wall_s",
    "rays",
    "form_factors",
    "peak_mem_mb",
    "rms_rel",
    "mbe_rel",
    "p95_rel",
    "max_rel",
    "stated_p95",
    "coverage",
    "resolved",
];

/// Writes a chart into `dir`, which is made if it is missing; answers the files written.
///
/// # Errors
///
/// Io with the file's name.
pub fn write_chart(dir: &Path, chart: &Chart) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(dir).map_err(|e| Error::io(dir, &e))?;
    let drawing = draw(chart);
    let files = [
        ("chart.csv", table(chart)?),
        ("reference.csv", reference(chart)?),
        ("chart.svg", drawing.to_svg().into_bytes()),
        ("chart.png", drawing.to_png()?),
    ];
    files
        .into_iter()
        .map(|(name, bytes)| {
            let path = dir.join(name);
            write_whole(&path, &bytes)?;
            Ok(path)
        })
        .collect()
}

pub(super) fn csv_of(header: &[&str], rows: impl Iterator<Item = Vec<String>>) -> Result<Vec<u8>> {
    let broken = |e: String| Error::new(ErrorKind::Internal, format!("table: {e}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header).map_err(|e| broken(e.to_string()))?;
    for row in rows {
        writer.write_record(&row).map_err(|e| broken(e.to_string()))?;
    }
    writer.into_inner().map_err(|e| broken(e.to_string()))
}

fn table(chart: &Chart) -> Result<Vec<u8>> {
    csv_of(&COLUMNS, chart.points.iter().map(row))
}

/// Empty cells where a method failed or does not tell.
fn row(p: &Point) -> Vec<String> {
    let f = |g: &dyn Fn(&Found) -> f64| p.found.as_ref().map_or(String::new(), |f| g(f).to_string());
    let maybe = |x: Option<f64>| x.map_or(String::new(), |x| x.to_string());
    let count = |x: Option<u64>| x.map_or(String::new(), |x| x.to_string());
    vec![
        p.method.clone(),
        p.setting.clone(),
        p.cpu_s.to_string(),
        p.wall_s.to_string(),
        count(p.rays),
        count(p.form_factors),
        maybe(p.peak_mem_mb),
        f(&|f| f.rms),
        f(&|f| f.bias),
        f(&|f| f.p95),
        f(&|f| f.largest),
        maybe(p.found.and_then(|f| f.stated_p95)),
        maybe(p.found.and_then(|f| f.coverage)),
        p.found.is_some_and(|f| f.resolved).to_string(),
    ]
}

fn reference(chart: &Chart) -> Result<Vec<u8>> {
    let rows = chart.reference.readings.iter().map(|r| {
        let mut row = vec![r.grid.clone(), r.point.to_string()];
        row.extend(r.position.to_array().iter().chain(&r.normal.to_array()).map(f64::to_string));
        row.extend([r.illuminance_lx.to_string(), r.standard_error_lx.to_string()]);
        row
    });
    let header = ["grid", "point", "x_m", "y_m", "z_m", "nx", "ny", "nz", "illuminance_lx", "standard_error_lx"];
    csv_of(&header, rows)
}

const SHADE: Colour = [236, 236, 240];
const FAILED: Colour = [200, 0, 0];

/// Size of the figure and places of its two panels, pixels.
const SIZE: (usize, usize) = (1640, 960);
const MAIN: [DVec2; 2] = [DVec2::new(130.0, 120.0), DVec2::new(900.0, 720.0)];
const HONEST: [DVec2; 2] = [DVec2::new(1080.0, 120.0), DVec2::new(1600.0, 720.0)];
const LEGEND_TOP: f64 = 810.0;

fn percent(x: f64) -> String {
    format!("{} %", plain(100.0 * x))
}

fn seconds(x: f64) -> String {
    format!("{} s", plain(x))
}

fn draw(chart: &Chart) -> Drawing {
    let mut d = Drawing::new(SIZE.0, SIZE.1);
    d.text(
        DVec2::new(30.0, 20.0),
        &format!("{}: speed against accuracy", chart.title),
        Font::Title,
        INK,
        Anchor::Start,
    );
    let sub = format!(
        "illuminance at {} points; reference: {} paths a point, its own error {} RMS; {} threads",
        chart.sensors,
        chart.reference.paths,
        percent(chart.reference.uncertainty),
        chart.threads
    );
    d.text(DVec2::new(30.0, 52.0), &sub, Font::Body, LINE, Anchor::Start);
    let mut methods: Vec<&str> = Vec::new();
    for p in &chart.points {
        if !methods.contains(&p.method.as_str()) {
            methods.push(&p.method);
        }
    }
    let style_of = |p: &Point| style(methods.iter().position(|m| *m == p.method).unwrap_or(0));
    speed_panel(&mut d, chart, &methods, &style_of);
    honesty_panel(&mut d, chart, &style_of);
    legend(&mut d, &methods, chart);
    d
}

fn speed_panel(d: &mut Drawing, chart: &Chart, methods: &[&str], style: &dyn Fn(&Point) -> (Colour, Mark)) {
    let floor = 2.0 * chart.reference.uncertainty;
    let found = |p: &Point| p.found.map(|f| [p.cpu_s, f.rms]);
    let mut values: Vec<[f64; 2]> = chart.points.iter().filter_map(found).collect();
    if let Some(first) = values.first().copied() {
        values.push([first[0], floor]);
        values.extend(chart.points.iter().filter(|p| p.found.is_none()).map(|p| [p.cpu_s, first[1]]));
    }
    let panel = Panel::new(MAIN, &values);
    let top = panel.place(1.0, floor).y.clamp(panel.low.y, panel.high.y);
    d.fill(DVec2::new(panel.low.x, top), panel.high, SHADE);
    panel.frame(d, ["processor time", "RMS error, of the mean"], [seconds, percent]);
    heading(d, &panel, "Lower left is better");
    d.text(
        DVec2::new(panel.high.x - 8.0, panel.high.y - 24.0),
        "below what the reference can tell",
        Font::Body,
        LINE,
        Anchor::End,
    );
    let front: Vec<DVec2> =
        pareto(&chart.points).iter().filter_map(|p| found(p)).map(|v| panel.place(v[0], v[1])).collect();
    d.line(&front, [190, 190, 190], 9.0);
    for method in methods {
        let own: Vec<&Point> = chart.points.iter().filter(|p| p.method == *method).collect();
        let places: Vec<DVec2> = own.iter().filter_map(|p| found(p)).map(|v| panel.place(v[0], v[1])).collect();
        if let Some(p) = own.first() {
            d.line(&places, style(p).0, if *method == "auto" { 3.0 } else { 1.2 });
        }
    }
    for p in &chart.points {
        let (colour, mark) = style(p);
        match p.found {
            Some(f) => {
                let size = if p.method == "auto" { 8.0 } else { 6.0 };
                d.mark(panel.place(p.cpu_s, f.rms), mark, size, colour, !f.resolved);
            }
            None => {
                let at = DVec2::new(panel.place(p.cpu_s.max(1e-6), 1.0).x, panel.low.y + 14.0);
                d.mark(at, Mark::Cross, 7.0, FAILED, false);
                d.text(
                    at + DVec2::new(12.0, -10.0),
                    &format!("{} failed", p.method),
                    Font::Label,
                    FAILED,
                    Anchor::Start,
                );
            }
        }
    }
}

fn honesty_panel(d: &mut Drawing, chart: &Chart, style: &dyn Fn(&Point) -> (Colour, Mark)) {
    let stated: Vec<(&Point, Found, [f64; 2])> = chart
        .points
        .iter()
        .filter_map(|p| p.found.and_then(|f| f.stated_p95.map(|s| (p, f, [f.p95, s]))))
        .filter(|(_, _, v)| v[0] > 0.0 && v[1] > 0.0)
        .collect();
    let mut values: Vec<[f64; 2]> = stated.iter().map(|s| s.2).collect();
    values.extend(stated.iter().map(|s| [s.2[1], s.2[0]])); // equal axes
    let panel = Panel::new(HONEST, &values);
    panel.frame(d, ["true error, 95th percentile", "stated error, 95th percentile"], [percent, percent]);
    heading(d, &panel, "Honesty: above the line, the stated error is the larger");
    let [low, high] = [panel.from.x.max(panel.from.y), panel.to.x.min(panel.to.y)].map(|v| 10f64.powf(v));
    d.line(&[panel.place(low, low), panel.place(high, high)], LINE, 1.5);
    for (p, f, v) in &stated {
        let (colour, mark) = style(p);
        let size = if p.method == "auto" { 8.0 } else { 5.0 };
        d.mark(panel.place(v[0], v[1]), mark, size, colour, !f.resolved);
    }
}

/// Methods with their styles, the marks' meaning and the coverage of the default.
fn legend(d: &mut Drawing, methods: &[&str], chart: &Chart) {
    let column = 400.0;
    let line = 26.0;
    let per_column = methods.len().div_ceil(3).max(1);
    for (k, method) in methods.iter().enumerate() {
        let at = DVec2::new(60.0 + column * (k / per_column) as f64, LEGEND_TOP + line * (k % per_column) as f64);
        let (colour, mark) = style(k);
        d.mark(at + DVec2::new(0.0, 10.0), mark, 6.0, colour, false);
        d.text(at + DVec2::new(18.0, 0.0), method, Font::Body, INK, Anchor::Start);
    }
    let x = 60.0 + 3.0 * column;
    let covered: Vec<f64> =
        chart.points.iter().filter(|p| p.method == "auto").filter_map(|p| p.found.and_then(|f| f.coverage)).collect();
    let mut words =
        vec!["grey band: nothing is faster and better".to_owned(), "hollow: not told from the reference".into()];
    if !covered.is_empty() {
        let mean = covered.iter().sum::<f64>() / covered.len() as f64;
        words.push(format!("auto: {:.1} % inside their error", 100.0 * mean));
    }
    for (k, text) in words.iter().enumerate() {
        d.text(DVec2::new(x - 40.0, LEGEND_TOP + line * k as f64), text, Font::Body, LINE, Anchor::Start);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::Reference;

    fn chart() -> Chart {
        let found = Found {
            rms: 0.02,
            resolved: true,
            p95: 0.03,
            stated_p95: Some(0.05),
            coverage: Some(0.97),
            ..Found::default()
        };
        let good =
            Point { method: "auto".into(), setting: "a, b".into(), cpu_s: 0.5, found: Some(found), ..Point::default() };
        let failed = Point { method: "hemicube".into(), cpu_s: 0.1, note: "too coarse".into(), ..Point::default() };
        Chart {
            title: "Room".into(),
            sensors: 4,
            reference: Reference { readings: Vec::new(), mean_lx: 10.0, uncertainty: 0.01, paths: 64 },
            points: vec![good, failed],
            threads: 2,
            notes: Vec::new(),
        }
    }

    #[test]
    fn the_table_has_the_fixed_columns_and_empty_cells_for_failures() {
        let text = String::from_utf8(table(&chart()).expect("a table")).expect("UTF-8");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines[0],
            "method,setting,cpu_s,wall_s,rays,form_factors,peak_mem_mb,rms_rel,mbe_rel,p95_rel,max_rel,stated_p95,coverage,resolved"
        );
        assert_eq!(lines[1], "auto,\"a, b\",0.5,0,,,,0.02,0,0.03,0,0.05,0.97,true");
        assert_eq!(lines[2], "hemicube,,0.1,0,,,,,,,,,,false");
    }

    #[test]
    fn the_picture_names_methods_units_and_failures() {
        let svg = draw(&chart()).to_svg();
        for word in
            ["auto", "hemicube failed", "processor time", "RMS error", "0.5 s", "2 %", "97.0 % inside their error"]
        {
            assert!(svg.contains(word), "{word}");
        }
        assert!(draw(&chart()).to_png().is_ok());
    }
}
