//! Writes the shipped luminaires into this folder: `cargo run --release --example luminaires`.

#![allow(dead_code, unreachable_pub, reason = "the test takes what this program does not")]

mod catalogue;

use std::path::Path;

use clerestory::Result;
use clerestory::light::photometry::{to_eulumdat, to_ies};
use clerestory::report;

fn main() -> Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("luminaires");
    for shipped in catalogue::catalogue() {
        let photometry = shipped.photometry();
        report::write_text(&folder, &format!("{}.ies", shipped.stem), &to_ies(&photometry))?;
        report::write_text(&folder, &format!("{}.ldt", shipped.stem), &to_eulumdat(&photometry)?)?;
        println!(
            "| {} | {} | {} | {:.3} | {:.1} |",
            shipped.stem,
            shipped.title,
            shipped.flux_lm,
            photometry.web.flux_lm(),
            photometry.web.peak().0
        );
    }
    Ok(())
}
