//! Writes `experiments/weather/synthetic.wea`: a year of weather by formula, for scenes that need one.

mod synthetic;

fn main() -> clerestory::Result<()> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/weather/synthetic.wea");
    std::fs::write(&path, synthetic::wea()?).map_err(|e| clerestory::Error::io(&path, &e))?;
    println!("{}", path.display());
    Ok(())
}
