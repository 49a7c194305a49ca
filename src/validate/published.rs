//! CIE 171:2006 as it is printed, beside the exact values and ours: the report's tables are known to hold errors.

use super::References;
use super::page::figure;
use super::sheet::{Sheet, Table};
use crate::Result;

const TABLE: &str = "cie171_published.csv";
/// Values below this share of the test's largest are told by that largest one.
const FAINT: f64 = 0.01;

/// One table of the tests, one of single printed values.
pub(super) fn tables(references: &References, sheet: &mut Sheet) -> Result<()> {
    let rows = references.rows(TABLE)?;
    let heads = |list: &[&str]| list.iter().map(|h| (*h).to_owned()).collect();
    let mut tests = Table::new(
        "CIE 171:2006, test by test: the largest difference between our values and the exact ones, in percent of the \
         exact value (or of a hundredth of the test's largest, where that is more)"
            .into(),
        heads(&["test", "cases", "largest difference", "errors known in the printed table"]),
    );
    let mut values = Table::new(
        "CIE 171:2006, printed values that are known: ours, exact, printed".into(),
        heads(&["case", "ours", "exact", "printed", "printed off by", ""]),
    );
    for row in &rows {
        let (case, remark) = (row.text("case")?, row.text("remark")?.to_owned());
        if row.text("printed")?.is_empty() {
            let (count, most) = largest(sheet, case);
            let off = format!("{:.3} %", 100.0 * most);
            tests.rows.push(vec![case.to_owned(), count.to_string(), off, remark]);
            continue;
        }
        let printed = row.number("printed")?;
        let (ours, exact) = sheet.named(case).fold((0.0, 0.0), |(o, e), c| (o + c.value, e + c.reference));
        let off = format!("{:+.2} %", 100.0 * (printed / exact - 1.0));
        values.rows.push(vec![case.to_owned(), figure(ours), figure(exact), figure(printed), off, remark]);
    }
    sheet.table(tests);
    sheet.table(values);
    Ok(())
}

/// How many cases a test has, and their largest relative difference.
fn largest(sheet: &Sheet, test: &str) -> (usize, f64) {
    let of_test = |name: &str| name.strip_prefix(test).is_some_and(|rest| rest.starts_with([' ', '-', 'a']));
    let cases = || sheet.cases().iter().filter(|c| of_test(&c.name));
    let brightest = cases().map(|c| c.reference.abs()).fold(0.0, f64::max);
    let off = cases().map(|c| (c.value - c.reference).abs() / c.reference.abs().max(FAINT * brightest));
    (cases().count(), off.fold(0.0, f64::max))
}
