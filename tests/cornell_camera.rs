//! Photographs of the Cornell box: a photograph made here, shifted, turned, scaled and noisy by known amounts, is recovered.

#[allow(dead_code, unreachable_pub, reason = "shared with the program")]
#[path = "../experiments/cornell-camera/main.rs"]
mod camera;

use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

use camera::filters::{Camera, Stack, write_exr};
use camera::photograph::{homography, mapped};
use tiff::encoder::{TiffEncoder, colortype::Gray16};

const SIZE: usize = 256;
/// From computed to photographed pixels: scaled, turned, shifted, and a little from aside.
const MAP: [f64; 9] = [1.31, 0.04, 17.3, -0.03, 1.29, 11.6, 2e-5, -3e-5, 1.0];
const FACTOR: f64 = 9000.0;
const NOISE: f64 = 0.02;
/// Corners of the room, mm.
const CORNERS: [[f64; 3]; 6] = [
    [552.8, 0.0, 0.0],
    [0.0, 0.0, 0.0],
    [556.0, 548.8, 0.0],
    [549.6, 0.0, 559.2],
    [0.0, 548.8, 559.2],
    [0.0, 0.0, 559.2],
];

/// A smooth picture: brighter in the middle, another slope in every band.
fn light(band: usize, [x, y]: [f64; 2]) -> f64 {
    let (u, v) = (x / SIZE as f64, y / SIZE as f64);
    (1.0 + 0.3 * band as f64) * (1.0 + 0.5 * u + 0.3 * (1.0 - 0.1 * band as f64) * v * v)
}

/// Numbers of a normal distribution, by Box and Muller's rule from a counter's golden-ratio sequence.
fn normal(k: usize) -> f64 {
    let even = |step: f64| ((k as f64 + 0.5) * step).fract();
    (-2.0 * even(0.754_877_666).ln()).sqrt() * (TAU * even(0.569_840_291)).cos()
}

fn computed() -> Stack {
    let middle = |p: usize| [(p % SIZE) as f64 + 0.5, (p / SIZE) as f64 + 0.5];
    let picture = |band: usize| (0..SIZE * SIZE).map(|p| light(band, middle(p)) as f32).collect();
    let pictures = ["filter_02", "filter_08", "filter_16"].iter().enumerate();
    Stack { width: SIZE, height: SIZE, pictures: pictures.map(|(b, n)| ((*n).to_owned(), picture(b))).collect() }
}

/// The photograph: every pixel asks the computed scene through the inverse map.
fn photographed(band: usize, gain: f64) -> (usize, Vec<f64>) {
    let size = 400;
    let corners = [[0.0, 0.0], [256.0, 0.0], [0.0, 256.0], [256.0, 256.0], [100.0, 40.0]];
    let back = homography(&corners.map(|p| (mapped(&MAP, p), p))).expect("no three in a line");
    let pixel = |p: usize| {
        let place = mapped(&back, [(p % size) as f64 + 0.5, (p / size) as f64 + 0.5]);
        gain * FACTOR * light(band, place) * (1.0 + NOISE * normal(p + 7919 * band))
    };
    (size, (0..size * size).map(pixel).collect())
}

fn written(dir: &Path, name: &str, size: usize, values: &[f64]) -> String {
    let path = dir.join(format!("{name}.tif"));
    let file = std::fs::File::create(&path).expect("the folder is ours");
    let data: Vec<u16> = values.iter().map(|v| v.clamp(0.0, 65535.0).round() as u16).collect();
    TiffEncoder::new(file)
        .expect("the folder is ours")
        .write_image::<Gray16>(size as u32, size as u32, &data)
        .expect("the folder is ours");
    path.display().to_string()
}

fn corners_file(dir: &Path) -> std::path::PathBuf {
    let mut text = "corner,x_mm,y_mm,z_mm,column,row\n".to_owned();
    for (k, c) in CORNERS.iter().enumerate() {
        let [x, y] = mapped(&MAP, camera::seen(*c, SIZE as f64));
        let _ = writeln!(text, "{k},{},{},{},{x},{y}", c[0], c[1], c[2]);
    }
    let path = dir.join("corners.csv");
    std::fs::write(&path, text).expect("the folder is ours");
    path
}

/// picture, region, ratio, spread, pixels.
fn told(text: &str) -> Vec<(String, String, f64, f64, f64)> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let number = |t: &str| t.parse().unwrap_or(f64::NAN);
    reader
        .records()
        .map(|r| r.expect("the folder is ours"))
        .map(|r| (r[0].to_owned(), r[1].to_owned(), number(&r[2]), number(&r[3]), number(&r[4])))
        .collect()
}

#[test]
fn a_photograph_of_known_map_factor_and_noise_is_recovered() {
    let dir = tempfile::tempdir().expect("the folder is ours");
    let ours = dir.path().join("computed.exr");
    write_exr(&ours, &computed()).expect("the folder is ours");
    // The last filter lets 5 % more by than was thought.
    let files: Vec<String> = [("filter_02", 0, 1.0), ("filter_08", 1, 1.0), ("filter_16", 2, 1.05)]
        .into_iter()
        .map(|(name, band, gain)| {
            let (size, values) = photographed(band, gain);
            written(dir.path(), name, size, &values)
        })
        .collect();
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    let list = told(&camera::compare(&ours, &corners_file(dir.path()), &files).unwrap());
    assert_eq!(list.len(), 1 + 3 * 8, "the factor, three pictures, eight regions");
    let factor = list[0].2;
    assert!((1.0..1.05).contains(&(factor / FACTOR)), "the factor lies between both gains: {factor}");
    for (picture, region, ratio, spread, pixels) in &list[1..] {
        let gain = if picture == "filter_16" { 1.05 } else { 1.0 };
        // Noise of the mean (neighbours share pixels of the photograph: half as many count), rounding to 16 bit and half
        // floats (5e-4).
        let allowed = 4.0 * NOISE / (0.5 * pixels).sqrt() + 5e-4;
        assert!((ratio * factor / FACTOR - gain).abs() < allowed, "{picture} {region}: {ratio}, allowed {allowed}");
        // Linear interpolation averages noise of four pixels: 0.44 to 1 of it is left.
        assert!((0.4 * NOISE..1.1 * NOISE).contains(spread), "{picture} {region}: {spread}");
    }
}

#[test]
fn registration_matters_and_its_faults_are_told() {
    let dir = tempfile::tempdir().unwrap();
    let ours = dir.path().join("computed.exr");
    write_exr(&ours, &computed()).unwrap();
    let (size, values) = photographed(0, 1.0);
    let file = written(dir.path(), "filter_02", size, &values);
    let corners = corners_file(dir.path());
    let text = std::fs::read_to_string(&corners).unwrap();
    let few = dir.path().join("few.csv");
    std::fs::write(&few, text.lines().take(4).collect::<Vec<_>>().join("\n")).unwrap();
    let said = camera::compare(&ours, &few, &[&file]).unwrap_err().to_string();
    assert!(said.contains("the corners tell no map"), "{said}");
    let other = written(dir.path(), "holiday", size, &values);
    let said = camera::compare(&ours, &corners, &[&other]).unwrap_err().to_string();
    assert!(said.contains("no photograph has the name of a filter"), "{said}");
    let said = camera::compare(&ours, &corners, &["none.tif"]).unwrap_err().to_string();
    assert!(said.contains("none.tif"), "{said}");
}

#[test]
fn a_filter_passes_what_its_curve_says() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/cornell-camera/camera.csv");
    let camera = Camera::read(&path).unwrap();
    assert_eq!(camera.filters.len(), 7);
    // One band at a time: of light at 508 to 512 nm filter 06, whose peak is there, passes most.
    let record = camera.record(&[(506.0, vec![0.0]), (510.0, vec![1.0]), (514.0, vec![0.0])], 1, 1);
    let passed: Vec<f32> = record.pictures.iter().map(|p| p.1[0]).collect();
    let most = (0..7).max_by(|a, b| passed[*a].total_cmp(&passed[*b])).unwrap();
    assert_eq!(record.pictures[most].0, "filter_06");
    // Four nm × 0.717 × the lens at 510 nm, less the fall from the peak over 2 nm.
    let lens: f32 = std::fs::read_to_string(&path)
        .unwrap()
        .lines()
        .find_map(|l| l.strip_prefix("510,")?.split(',').next()?.parse().ok())
        .unwrap();
    assert!((passed[most] / (4.0 * 0.717 * lens) - 1.0).abs() < 0.05, "{passed:?}");
}
