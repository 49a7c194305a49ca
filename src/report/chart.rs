//! What a chart run writes: `chart.csv`, `chart.svg`, `chart.png`, `reference.csv`.

use std::path::{Path, PathBuf};

use glam::DVec2;

use super::canvas::{Colour, INK, LINE};
use super::drawing::{Anchor, Drawing, Mark};
use super::file::write_whole;
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

/// Colours that stay apart for colour-blind eyes (after Okabe and Ito 2008) and the forms that go with them.
const STYLES: [(Colour, Mark); 12] = [
    ([213, 94, 0], Mark::Circle),
    ([0, 114, 178], Mark::Square),
    ([0, 158, 115], Mark::Diamond),
    ([204, 121, 167], Mark::Up),
    ([86, 180, 233], Mark::Down),
    ([148, 103, 25], Mark::Circle),
    ([120, 94, 240], Mark::Square),
    ([90, 90, 90], Mark::Diamond),
    ([200, 160, 0], Mark::Up),
    ([100, 140, 17], Mark::Down),
    ([160, 30, 60], Mark::Square),
    ([30, 60, 120], Mark::Up),
];
const GRID: Colour = [226; 3];
const SHADE: Colour = [236, 236, 240];
const FAILED: Colour = [200, 0, 0];

/// Size of the figure and places of its two panels, pixels.
const SIZE: (usize, usize) = (1640, 960);
const MAIN: [DVec2; 2] = [DVec2::new(130.0, 120.0), DVec2::new(900.0, 720.0)];
const HONEST: [DVec2; 2] = [DVec2::new(1080.0, 120.0), DVec2::new(1600.0, 720.0)];
const LEGEND_TOP: f64 = 810.0;

/// A panel with logarithmic axes.
struct Panel {
    low: DVec2,
    high: DVec2,
    /// Decimal logarithms at its lower left and upper right corner.
    from: DVec2,
    to: DVec2,
}

impl Panel {
    fn new([low, high]: [DVec2; 2], values: &[[f64; 2]]) -> Self {
        let logs =
            || values.iter().filter(|v| v[0] > 0.0 && v[1] > 0.0).map(|v| DVec2::new(v[0].log10(), v[1].log10()));
        let (from, to) = logs().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let (from, to) = if from.is_finite() { (from, to) } else { (DVec2::splat(-1.0), DVec2::ZERO) };
        let air = ((to - from) * 0.05).max(DVec2::splat(0.15));
        Self { low, high, from: from - air, to: to + air }
    }

    fn place(&self, x: f64, y: f64) -> DVec2 {
        let share = (DVec2::new(x.log10(), y.log10()) - self.from) / (self.to - self.from);
        DVec2::new(
            self.low.x + share.x * (self.high.x - self.low.x),
            self.high.y - share.y * (self.high.y - self.low.y),
        )
    }

    /// Values 1, 2 and 5 of each decade in sight of one axis.
    fn ticks(&self, axis: usize) -> Vec<f64> {
        let (from, to) = (self.from[axis], self.to[axis]);
        let fine = to - from < 2.6;
        (from.floor() as i32..=to.ceil() as i32)
            .flat_map(|d| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(d)))
            .filter(|v| (from..=to).contains(&v.log10()))
            .filter(|v| fine || (v.log10() - v.log10().round()).abs() < 1e-9)
            .collect()
    }

    fn frame(&self, d: &mut Drawing, names: [&str; 2], shown: [fn(f64) -> String; 2]) {
        for v in self.ticks(0) {
            let x = self.place(v, 1.0).x;
            d.line(&[DVec2::new(x, self.low.y), DVec2::new(x, self.high.y)], GRID, 1.0);
            d.text(DVec2::new(x, self.high.y + 10.0), &shown[0](v), Font::Body, INK, Anchor::Middle);
        }
        for v in self.ticks(1) {
            let y = self.place(1.0, v).y;
            d.line(&[DVec2::new(self.low.x, y), DVec2::new(self.high.x, y)], GRID, 1.0);
            d.text(DVec2::new(self.low.x - 10.0, y - 10.0), &shown[1](v), Font::Body, INK, Anchor::End);
        }
        let corners = [self.low, DVec2::new(self.high.x, self.low.y), self.high, DVec2::new(self.low.x, self.high.y)];
        d.line(&[corners[0], corners[1], corners[2], corners[3], corners[0]], LINE, 1.5);
        let middle = (self.low + self.high) * 0.5;
        d.text(DVec2::new(middle.x, self.high.y + 38.0), names[0], Font::Body, INK, Anchor::Middle);
        d.text_up(DVec2::new(self.low.x - 100.0, middle.y), names[1], Font::Body, INK);
    }
}

fn percent(x: f64) -> String {
    format!("{} %", plain(100.0 * x))
}

fn seconds(x: f64) -> String {
    format!("{} s", plain(x))
}

/// Two digits without zeros at the end.
fn plain(x: f64) -> String {
    let decimals = (1.0 - x.log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
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
    let style = |p: &Point| {
        let k = methods.iter().position(|m| *m == p.method).unwrap_or(0);
        STYLES[k % STYLES.len()]
    };
    speed_panel(&mut d, chart, &methods, &style);
    honesty_panel(&mut d, chart, &style);
    legend(&mut d, &methods, chart);
    d
}

fn heading(d: &mut Drawing, panel: &Panel, text: &str) {
    d.text(DVec2::new(panel.low.x, panel.low.y - 26.0), text, Font::Label, INK, Anchor::Start);
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
        let (colour, mark) = STYLES[k % STYLES.len()];
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
