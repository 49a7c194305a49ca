//! A steel mill of any size: writes the scene, and measures what a solve of it costs against its size.
//!
//! ```text
//! cargo run --release --example steel-mill -- write 1 20 out/steel-mill
//! cargo run --release --example steel-mill -- chart target/release/clerestory out/steel-mill 9
//! ```

mod chart;
mod files;
mod hall;
mod parts;

use std::path::Path;

use hall::Size;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Outcome<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    match words[..] {
        ["write", aisles, bays, folder] => {
            let size = Size { aisles: aisles.parse()?, bays: bays.parse()? };
            let polygons = write(size, Some([800, 500]), Path::new(folder))?;
            println!("{polygons} polygons");
            Ok(())
        }
        ["chart", binary, folder, count] => {
            let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/steel-mill");
            chart::chart(Path::new(binary), Path::new(folder), &home, count.parse()?)
        }
        _ => Err("write AISLES BAYS FOLDER, or chart PROGRAM FOLDER COUNT".into()),
    }
}

/// Writes `hall.obj`, `scene.toml` and, where pixels are asked for, `picture.toml`; answers the number of polygons.
fn write(size: Size, pixels: Option<[usize; 2]>, folder: &Path) -> Outcome<usize> {
    std::fs::create_dir_all(folder)?;
    let (polygons, text) = files::obj(size);
    std::fs::write(folder.join("hall.obj"), text)?;
    std::fs::write(folder.join("scene.toml"), files::scene(size, None))?;
    if pixels.is_some() {
        std::fs::write(folder.join("picture.toml"), files::scene(size, pixels))?;
    }
    Ok(polygons)
}
