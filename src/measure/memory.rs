//! Memory: what a run takes at its peak, planned from counts and told before it is taken.
//!
//! Each part of the program says what it takes for an element, a ray, a pixel; here they are added up. Where the sum is
//! beyond the limit, bands are solved one block after the other, which changes no result; then a mesh is not refined where
//! longer paths will do; then the run stops and says what would need how much.

use super::adaptive::{ROW_RAYS, Task};
use super::gather::REPLICAS;
use super::options::Method;
use crate::error::{Error, Result};
use crate::mesh::{Elements, Surface};
use crate::scene::Face;
use crate::solve::{Abreast, bytes_to_solve};
use crate::transport::Rows;

/// The program, its tables and the stacks of its threads.
const PROGRAM: u64 = 24 << 20;
/// What the allocator adds to what is asked of it.
const SLACK: f64 = 1.15;
/// A polygon beside its vertices, with what finds its neighbours and the ray caster's share of it; and a vertex of it.
const FACE: u64 = (size_of::<Face>() + size_of::<Surface>()) as u64 + 480;
const VERTEX: u64 = 64;
/// What is seen at a pixel, beside its bands.
const PIXEL: u64 = 320;
const SENSOR: u64 = 1200;

/// What a run may take, and what its parts do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    limit: Option<u64>,
    /// Scene, sensors and pictures.
    fixed: u64,
    /// An element of a mesh, with its rows and its radiosity.
    element: u64,
    /// An element copied for pictures.
    copy: u64,
    /// An element while its mesh is solved, by how much is solved at once.
    solving: [u64; 3],
    bands: usize,
}

const WAYS: [Abreast; 3] = [Abreast::All, Abreast::Replica, Abreast::Block];

impl Budget {
    pub(super) fn new(task: &Task<'_>) -> Self {
        let (scene, optics) = (task.scene, task.optics);
        let vertices: usize = scene.faces.iter().map(|f| f.vertices.len()).sum();
        let sensors: usize = scene.grids.iter().map(|g| g.sensors.len()).sum();
        let pixels = scene.views.iter().map(|v| v.width * v.height).max().unwrap_or(0);
        let all_pixels: usize = scene.views.iter().map(|v| v.width * v.height).sum();
        let (pad, channels) = (optics.pad, optics.channels());
        let sums = 4 * (2 * REPLICAS * pad + 3 * pad + 8 * REPLICAS * channels) + 8 * (channels * channels + pad);
        let per_sensor = SENSOR + (REPLICAS * (sums + 8 * optics.columns())) as u64;
        let per_pixel = PIXEL + (8 * optics.columns() + 12 * pad) as u64;
        let result = (4 * (optics.bands.len() + 3)) as u64;
        let specular = task.world.has_specular();
        let rows = Rows::bytes_per_element(REPLICAS, ROW_RAYS, task.world.groups(), specular);
        let radiosity = REPLICAS * (4 * pad + 16 * channels);
        let is_auto = task.options.method == Method::Auto;
        let of_view = if scene.views.is_empty() { 0 } else { Elements::bytes_per_element() + radiosity / REPLICAS };
        let joined = if channels > 1 { 2 * (Elements::bytes_per_element() + REPLICAS * (4 * pad + 16)) } else { 0 };
        let threads = rayon::current_num_threads();
        let fixed = PROGRAM
            + scene.faces.len() as u64 * FACE
            + vertices as u64 * VERTEX
            + sensors as u64 * per_sensor
            + pixels as u64 * per_pixel
            + all_pixels as u64 * result
            + if is_auto { Rows::bytes_of_a_wave(ROW_RAYS) as u64 } else { 0 };
        Self {
            limit: task.options.max_memory,
            fixed,
            element: (Elements::bytes_per_element() + rows + radiosity) as u64,
            copy: (of_view + joined) as u64,
            solving: WAYS.map(|way| bytes_to_solve((REPLICAS, ROW_RAYS / REPLICAS), pad, way, threads) as u64),
            bands: optics.bands.len(),
        }
    }

    /// Bytes at the peak of a run with so many elements: those of the coarse twin are no more.
    pub(super) fn peak(&self, elements: usize, abreast: Abreast) -> u64 {
        let solving = WAYS.iter().position(|w| *w == abreast).map_or(0, |k| self.solving[k]);
        let each = 2 * self.element + solving.max(self.copy);
        (SLACK * (self.fixed + elements as u64 * each) as f64) as u64
    }

    /// Largest number of elements that keeps the limit.
    pub(super) fn most_elements(&self) -> usize {
        let Some(limit) = self.limit else { return usize::MAX };
        let each = self.peak(1 << 20, Abreast::Block) - self.peak(0, Abreast::Block);
        (limit.saturating_sub(self.peak(0, Abreast::Block)) as f64 / each as f64 * f64::from(1 << 20)) as usize
    }

    /// How to solve a mesh: the fastest way that keeps the limit.
    ///
    /// # Errors
    /// When none does.
    pub(super) fn way(&self, elements: usize) -> Result<Abreast> {
        let fastest = Abreast::fastest(elements);
        let mut ways = WAYS.into_iter().skip_while(|w| *w != fastest);
        let keeps = |way: &Abreast| self.limit.is_none_or(|limit| self.peak(elements, *way) <= limit);
        ways.find(keeps).ok_or_else(|| self.exceeded(elements))
    }

    /// # Errors
    /// When scene, sensors and pictures alone are beyond the limit.
    pub(super) fn check(&self) -> Result<()> {
        match self.limit {
            Some(limit) if self.peak(0, Abreast::Block) > limit => Err(self.exceeded(0)),
            _ => Ok(()),
        }
    }

    /// The error of a run that would need so many elements, or more.
    pub(super) fn exceeded(&self, elements: usize) -> Error {
        let needed = self.peak(elements, Abreast::Block);
        let what = match elements {
            0 => "scene, sensors and pictures alone need".to_owned(),
            n => format!("{n} elements in {} bands need", self.bands),
        };
        let allowed = self.limit.map_or_else(String::new, |limit| format!(", and --max-memory allows {}", size(limit)));
        Error::unsupported(format!("{what} {} of memory at the peak{allowed}", size(needed))).mend(format!(
            "allow more (--max-memory {}), or ask for less: a larger --tolerance, fewer bands or pixels, a simpler drawing",
            size(needed + needed / 10)
        ))
    }
}

/// Bytes in the unit that reads best, as [`parse_size`] reads it.
#[must_use]
pub(super) fn size(bytes: u64) -> String {
    let unit = [(1e9, "GB"), (1e6, "MB"), (1e3, "kB")].into_iter().find(|(unit, _)| bytes as f64 >= *unit);
    unit.map_or_else(
        || format!("{bytes}B"),
        |(unit, name)| format!("{:.1}{name}", (bytes as f64 / unit * 10.0).ceil() / 10.0),
    )
}

/// Bytes of a size: a number with B, kB, MB, GB (powers of a thousand) or KiB, MiB, GiB (of 1,024); `B` may be left out.
///
/// # Errors
/// In words, when it is none.
pub fn parse_size(text: &str) -> std::result::Result<u64, String> {
    let text = text.trim();
    let digits = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let (number, unit) = (&text[..digits], text[digits..].trim().to_lowercase());
    let factor = match unit.trim_end_matches('b') {
        "" => 1.0,
        "k" => 1e3,
        "m" => 1e6,
        "g" => 1e9,
        "t" => 1e12,
        "ki" => 1024.0,
        "mi" => 1024.0 * 1024.0,
        "gi" => 1024.0 * 1024.0 * 1024.0,
        _ => return Err(format!("{text:?} is no size: write 500MB, 2GB or 1.5GiB")),
    };
    match number.parse::<f64>() {
        Ok(n) if n > 0.0 && n * factor < 1e18 => Ok((n * factor) as u64),
        _ => Err(format!("{text:?} is no size: write 500MB, 2GB or 1.5GiB")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn budget(limit: Option<u64>) -> Budget {
        Budget { limit, fixed: 50_000_000, element: 500, copy: 200, solving: [3000, 1500, 800], bands: 3 }
    }

    #[test]
    fn the_fastest_way_that_keeps_the_limit_is_taken() {
        let n = 100_000;
        assert_eq!(budget(None).way(n).ok(), Some(Abreast::Replica));
        let peaks = [Abreast::Replica, Abreast::Block].map(|w| budget(None).peak(n, w));
        assert_eq!(budget(Some(peaks[0])).way(n).ok(), Some(Abreast::Replica));
        assert_eq!(budget(Some(peaks[0] - 1)).way(n).ok(), Some(Abreast::Block));
        let error = budget(Some(peaks[1] - 1)).way(n).expect_err("too little").to_string();
        assert!(error.contains("100000 elements in 3 bands need") && error.contains("mend"), "{error}");
    }

    #[test]
    fn as_many_elements_are_made_as_keep_the_limit() {
        let own = budget(Some(400_000_000));
        let most = own.most_elements();
        assert!(own.peak(most, Abreast::Block) <= 400_000_000);
        assert!(own.peak(most + 2, Abreast::Block) > 400_000_000);
    }

    #[test]
    fn sizes_are_read_as_they_are_written() {
        let read = ["500MB", "2g", "1.5 GiB", "64kB", "7"].map(|t| parse_size(t).ok());
        assert_eq!(read, [500_000_000, 2_000_000_000, 1_610_612_736, 64_000, 7].map(Some));
        for bad in ["", "MB", "-3MB", "1.2.3G", "5 apples", "nan", "0"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
        for bytes in [7, 64_001, 512_345_678, 2_345_678_901] {
            let told = parse_size(&size(bytes)).expect("a size");
            assert!(told >= bytes && told as f64 <= 1.2 * bytes as f64 + 1.0, "{bytes}: {told}");
        }
    }
}
