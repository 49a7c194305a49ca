//! A steel mill of any size: writes the scene, and measures what a solve of it costs against its size.
//!
//! ```text
//! cargo run --release --example steel-mill -- write 1 20 out/steel-mill
//! ```

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
        _ => Err("write AISLES BAYS FOLDER".into()),
    }
}

/// Writes `hall.obj`, `scene.toml` and `picture.toml`; answers the number of polygons.
fn write(size: Size, pixels: Option<[usize; 2]>, folder: &Path) -> Outcome<usize> {
    std::fs::create_dir_all(folder)?;
    let (polygons, text) = files::obj(size);
    std::fs::write(folder.join("hall.obj"), text)?;
    std::fs::write(folder.join("scene.toml"), files::scene(size, None))?;
    std::fs::write(folder.join("picture.toml"), files::scene(size, pixels))?;
    Ok(polygons)
}
