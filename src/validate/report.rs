//! The suite's outcome as JSON, CSV, a page for browsers and a page for the repository.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::figure::{escaped, strip};
use super::page;
use super::{Case, Suite, Table};
use crate::error::{Error, ErrorKind, Result};
use crate::report::write_text;

/// `{"suites": [{"name", "about", "skipped", "cases": [...]}]}`; numbers that are not finite become null.
#[must_use]
pub fn json(suites: &[Suite]) -> Value {
    let suites: Vec<Value> = suites
        .iter()
        .map(|s| json!({ "name": s.name, "about": s.about, "skipped": s.skipped, "cases": s.cases }))
        .collect();
    json!({ "suites": suites })
}

/// Writes `validation.json`, `validation.csv`, `index.html` and `VALIDATION.md` into `dir`, which is made if it is
/// missing; answers the files.
///
/// # Errors
/// Io with the file's name.
pub fn write(dir: &Path, suites: &[Suite]) -> Result<Vec<PathBuf>> {
    let mut files = vec![
        write_text(dir, "validation.json", &format!("{:#}\n", json(suites)))?,
        write_text(dir, "validation.csv", &table(suites)?)?,
        write_text(dir, "index.html", &html(suites))?,
        write_text(dir, "VALIDATION.md", &page::markdown(suites))?,
    ];
    for (name, text) in suites.iter().flat_map(|s| &s.files) {
        files.push(write_text(dir, name, text)?);
    }
    Ok(files)
}

const COLUMNS: [&str; 11] =
    ["suite", "name", "holds", "source", "unit", "comparison", "reference", "uncertainty", "value", "error", "pass"];

fn table(suites: &[Suite]) -> Result<String> {
    let broken = |e: csv::Error| Error::new(ErrorKind::Internal, format!("validation.csv: {e}"));
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(COLUMNS).map_err(broken)?;
    for (suite, c) in suites.iter().flat_map(|s| s.cases.iter().map(move |c| (s, c))) {
        let numbers = [c.reference, c.uncertainty, c.value, c.error].map(|v| v.to_string());
        let [reference, uncertainty, value, error] = numbers;
        let (comparison, pass) = (format!("{:?}", c.comparison), c.pass.to_string());
        let fields: [&str; 11] = [
            suite.name,
            &c.name,
            &c.holds,
            &c.source,
            c.unit,
            &comparison,
            &reference,
            &uncertainty,
            &value,
            &error,
            &pass,
        ];
        table.write_record(fields).map_err(broken)?;
    }
    let bytes = table.into_inner().map_err(|e| Error::new(ErrorKind::Internal, format!("validation.csv: {e}")))?;
    String::from_utf8(bytes).map_err(|e| Error::new(ErrorKind::Internal, format!("validation.csv: {e}")))
}

const STYLE: &str = "body{font:15px/1.5 sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;color:#222}\
table{border-collapse:collapse;width:100%;font-size:13px}td,th{padding:2px 8px;text-align:left;\
border-bottom:1px solid #ddd}td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}\
tr.bad{background:#fdd}summary{cursor:pointer;color:#2a6fb0}.bad b{color:#b00}";

fn html(suites: &[Suite]) -> String {
    let (cases, failed) = page::counts(suites);
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'><title>clerestory: validation</title>\
         <style>{STYLE}</style></head><body>\n<h1>Validation</h1>\n<p>{cases} cases, {failed} failed. A case passes \
         where value and reference differ by at most the stated error and the uncertainty of the reference; where the \
         error is a statistical one (95 %), the interval of a single case is widened to 99.9 %.</p>\n"
    );
    let _ =
        write!(text, "<table><tr><th>suite</th><th>about</th><th class='n'>cases</th><th class='n'>failed</th></tr>");
    for s in suites {
        let _ = write!(
            text,
            "<tr><td><a href='#{0}'>{0}</a></td><td>{1}</td><td class='n'>{2}</td><td class='n'>{3}</td></tr>",
            s.name,
            escaped(s.about),
            s.cases.len(),
            s.failures().count()
        );
    }
    text.push_str("</table>\n");
    for s in suites {
        section(&mut text, s);
    }
    text.push_str(&page::html_limits());
    text.push_str("</body></html>\n");
    text
}

fn section(text: &mut String, s: &Suite) {
    let _ = write!(text, "<h2 id='{}'>{}</h2><p>{}</p>\n{}\n", s.name, s.name, escaped(s.about), strip(&s.cases));
    if let Some(why) = s.skipped {
        let _ = writeln!(text, "<p>Skipped: {}. What follows is the stored outcome.</p>", escaped(why));
    }
    s.tables.iter().for_each(|t| table_of(text, t));
    for (caption, svg) in &s.figures {
        let _ = writeln!(text, "<figure>{svg}<figcaption>{}</figcaption></figure>", escaped(caption));
    }
    let open = if s.failures().next().is_some() { " open" } else { "" };
    let _ = writeln!(
        text,
        "<details{open}><summary>{} cases</summary><table><tr><th>case</th><th>holds</th><th>source</th>\
         <th class='n'>reference</th><th class='n'>its uncertainty</th><th class='n'>value</th>\
         <th class='n'>stated error</th><th></th></tr>",
        s.cases.len()
    );
    for c in &s.cases {
        line(text, c);
    }
    text.push_str("</table></details>\n");
}

fn table_of(text: &mut String, t: &Table) {
    let cells = |tag: &str, row: &[String]| -> String {
        row.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell))).collect()
    };
    let _ = writeln!(text, "<p>{}</p><table><tr>{}</tr>", escaped(&t.caption), cells("th", &t.heads));
    for row in &t.rows {
        let _ = writeln!(text, "<tr>{}</tr>", cells("td", row));
    }
    text.push_str("</table>\n");
}

fn line(text: &mut String, c: &Case) {
    let (class, verdict) = if c.pass { ("", "pass") } else { ("bad", "<b>fail</b>") };
    let sign = match c.comparison {
        super::Comparison::AtLeast => "≥ ",
        super::Comparison::AtMost => "≤ ",
        _ => "",
    };
    let _ = writeln!(
        text,
        "<tr class='{class}'><td>{}</td><td>{}</td><td>{}</td><td class='n'>{sign}{} {unit}</td><td class='n'>{}</td>\
         <td class='n'>{} {unit}</td><td class='n'>{}</td><td>{verdict}</td></tr>",
        escaped(&c.name),
        escaped(&c.holds),
        escaped(&c.source),
        page::figure(c.reference),
        page::figure(c.uncertainty),
        page::figure(c.value),
        page::figure(c.error),
        unit = escaped(c.unit)
    );
}
