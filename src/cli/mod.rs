//! The command line: arguments into library calls, progress, exit codes. No physics.
//!
//! Results go to standard output, all else to standard error. Exit codes: 0 done; 2 bad input or usage;
//! 3 done, but fewer than 95 % of some grid's sensors hold the tolerance; 1 anything else.

mod annual;
mod chart;
mod check;
mod compare;
mod cpu;
mod luminaire;
mod progress;
mod solve;
mod validate;

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::error::ErrorKind;
use crate::measure::{self, Display, Method};
use crate::report::{self, Provenance};
use crate::scene;
use crate::{Error, Result};

/// Physically calibrated lighting simulation: illuminance maps and luminance images with honest error bars.
///
/// A scene file (TOML) names geometry (OBJ), materials and lamps in physical units, and asks for grids of
/// illuminance and for pictures. `clerestory check` finds its mistakes; `clerestory solve` answers it.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "\
Start with:
  clerestory check room.toml
  clerestory solve room.toml --tolerance 5%

Exit codes:
  0  done
  1  anything else
  2  bad input or usage
  3  done, but fewer than 95 % of some grid's sensors hold the tolerance";

#[derive(Debug, Subcommand)]
enum Command {
    /// Compute everything the scene asks for: tables, maps and pictures.
    Solve(SolveArgs),
    /// Compute a year of daylight, hour by hour, and its climate-based metrics.
    Annual(AnnualArgs),
    /// Measure speed against accuracy of every method on this scene: table and picture.
    Chart(ChartArgs),
    /// Find leaks, flipped normals and misplaced sensors before they cost an hour.
    Check(CheckArgs),
    /// Tell what a photometric file holds (IES LM-63, EULUMDAT), draw it, convert it.
    Luminaire(LuminaireArgs),
    /// Run the validation suite: computed against known values, with a report; exit code 1 if a case fails.
    Validate(ValidateArgs),
    /// Hold a result against measured values at its points: bias, RMS, share within the uncertainties, chart.
    Compare(CompareArgs),
    /// Print the JSON Schema of the scene file, for editors.
    Schema,
}

/// Arguments of `solve`.
#[derive(Args, Debug)]
#[command(after_help = SOLVE_HELP)]
struct SolveArgs {
    /// The scene file (TOML).
    scene: PathBuf,
    /// Folder for the results [default: ./out/<name of the scene file>].
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Error that each sensor may state, at 95 % confidence: 5% or 0.05.
    #[arg(long, default_value = "5%", value_parser = tolerance)]
    tolerance: f64,
    /// How to solve.
    #[arg(long, value_enum, default_value_t = MethodArg::Auto)]
    method: MethodArg,
    /// Report every band, and hold the tolerance in every band.
    #[arg(long)]
    spectral: bool,
    /// Unit of illuminance in the tables and on the terminal; run.json and maps stay in lux.
    #[arg(long, value_enum, default_value_t = UnitsArg::Lx)]
    units: UnitsArg,
    /// Report alpha-opic irradiances and melanopic EDI (CIE S 026), and hold the tolerance in every band.
    #[arg(long)]
    alpha_opic: bool,
    /// Patches along the longest side; with the classic methods only.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=512))]
    patches: Option<u32>,
    /// Shots; with --method progressive only.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    shots: Option<u64>,
    /// Write the pictures on the way into DIR: ambient light only, one light, two lights, 24 shots more, the full
    /// solution, for each view in one exposure; with --method progressive only.
    #[arg(long, value_name = "DIR")]
    progressive: Option<PathBuf>,
    /// What sensors on a patch show; with the classic methods only [default: gather].
    #[arg(long, value_enum)]
    display: Option<DisplayArg>,
    /// Most memory that the run may plan to take, as 500MB or 2GiB; with the default method and path-tracing only. Results
    /// depend on it only where a mesh would have been refined beyond it, and run.json says so.
    #[arg(long, value_name = "SIZE", value_parser = measure::parse_size)]
    max_memory: Option<u64>,
    /// Paths per sensor; with --method path-tracing only.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    paths: Option<u64>,
    #[command(flatten)]
    run: RunArgs,
}

/// Unit of illuminance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum UnitsArg {
    /// Lux.
    Lx,
    /// Footcandles: lumens per square foot, 10.764 lx.
    Fc,
}

impl From<UnitsArg> for report::Units {
    fn from(units: UnitsArg) -> Self {
        match units {
            UnitsArg::Lx => Self::Lux,
            UnitsArg::Fc => Self::Footcandles,
        }
    }
}

/// Arguments of every run.
#[derive(Args, Debug)]
struct RunArgs {
    /// Threads [default: all processors]. The results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    threads: Option<u32>,
    /// Seed of all random numbers.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Print the run's record (run.json) instead of the table.
    #[arg(long)]
    json: bool,
    /// No progress and no warnings.
    #[arg(short, long)]
    quiet: bool,
}

const SOLVE_HELP: &str = "\
Writes illuminance.csv, summary.csv, a map of each grid, pictures of each view and run.json.
The tolerance is a stated error: a sensor holds it when its 95 % interval is within
tolerance x max(E, mean of its grid / 10). The program chooses mesh, rays and bands to meet it.";

/// Arguments of `annual`.
#[derive(Args, Debug)]
struct AnnualArgs {
    /// The scene file (TOML), with [sky] and [site].
    scene: PathBuf,
    /// Weather in place of the scene's: an EPW or WEA file.
    #[arg(long, value_name = "FILE")]
    weather: Option<PathBuf>,
    /// Folder for the results [default: ./out/<name of the scene file>/annual].
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Error that each sensor may state under an even sky, at 95 % confidence: 5% or 0.05.
    #[arg(long, default_value = "5%", value_parser = tolerance)]
    tolerance: f64,
    /// Patches of the sky whose reflected light is told apart [default: from the tolerance].
    #[arg(long, value_enum, value_name = "N")]
    sky_patches: Option<PatchCount>,
    #[command(flatten)]
    run: RunArgs,
}

/// Divisions of the sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PatchCount {
    /// Tregenza's patches of 12°.
    #[value(name = "145")]
    Coarse,
    /// Patches of 6°.
    #[value(name = "577")]
    Middle,
    /// Patches of 4°.
    #[value(name = "1297")]
    Fine,
    /// Patches of 3°.
    #[value(name = "2305")]
    Finest,
}

impl PatchCount {
    /// Parts of a side of Tregenza's patches.
    fn parts(self) -> usize {
        match self {
            Self::Coarse => 1,
            Self::Middle => 2,
            Self::Fine => 3,
            Self::Finest => 4,
        }
    }
}

/// Arguments of `check`.
#[derive(Args, Debug)]
struct CheckArgs {
    /// The scene file (TOML).
    scene: PathBuf,
    /// Print the findings as JSON.
    #[arg(long)]
    json: bool,
}

/// Arguments of `luminaire`.
#[derive(Args, Debug)]
struct LuminaireArgs {
    /// The photometric file: IES LM-63 or EULUMDAT.
    file: PathBuf,
    /// Print the findings as JSON.
    #[arg(long)]
    json: bool,
    /// Write the polar diagram (PNG and SVG) into DIR [with --to: ./out/<name of the file>].
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write the luminaire in this format too.
    #[arg(long, value_enum)]
    to: Option<LuminaireFormat>,
}

/// Formats that luminaires are written in.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum LuminaireFormat {
    /// IES LM-63-2002.
    Ies,
    /// EULUMDAT.
    Ldt,
}

/// Arguments of `chart`.
#[derive(Args, Debug)]
struct ChartArgs {
    /// The scene file (TOML); its grids are compared, its views are not.
    scene: PathBuf,
    /// Folder for the results [default: ./out/<name of the scene file>].
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Measured points of other programs: a CSV with the columns of chart.csv (method, cpu_s and rms_rel at least).
    #[arg(long, value_name = "FILE")]
    peer: Vec<PathBuf>,
    /// Five repeats, longer ladders, a better reference and a second one: an hour instead of minutes.
    #[arg(long)]
    full: bool,
    /// Threads [default: all processors].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    threads: Option<u32>,
    /// Seed of all random numbers.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// No progress.
    #[arg(long)]
    quiet: bool,
}

/// Arguments of `validate`.
#[derive(Args, Debug)]
struct ValidateArgs {
    /// Suites to run [default: all]: form-factors, radiosity, energy, stability, colour, sky, cie-171, luminaires,
    /// cornell, ferren, growth-chamber, coverage.
    #[arg(value_name = "SUITE")]
    suites: Vec<String>,
    /// Folder of the measured room's data, which growth-chamber needs and is skipped without.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Folder for the report: index.html, validation.csv, validation.json, VALIDATION.md [default: ./out/validate].
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the cases as JSON; without -o no file is written.
    #[arg(long)]
    json: bool,
    /// Threads [default: all processors]. The results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    threads: Option<u32>,
    /// No progress.
    #[arg(short, long)]
    quiet: bool,
}

/// Arguments of `compare`.
#[derive(Args, Debug)]
struct CompareArgs {
    /// The folder that `solve` wrote, or its illuminance.csv.
    result: PathBuf,
    /// Measured values: a CSV with the columns grid and point; illuminance_lx with uncertainty_lx, luminance_cd_m2 with
    /// uncertainty_cd_m2, or cie_x and cie_y with uncertainty_xy (uncertainties at 95 %). Luminance needs a column
    /// reflectance: a number, or a file of a spectrum beside the table; with a spectrum cie_x and cie_y are those of the
    /// face, by the bands of solve --spectral. Empty fields were not measured; other columns are left alone.
    #[arg(long, value_name = "FILE")]
    measured: PathBuf,
    /// Folder for compare.csv and compare.svg [default: none are written].
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the figures as JSON.
    #[arg(long)]
    json: bool,
}

/// How to solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodArg {
    /// Sensor-driven radiosity with a final gather: the program chooses all settings.
    Auto,
    /// The unbiased reference: simple, slow, the judge of the others.
    PathTracing,
    /// Classic: analytic form factors, Gaussian elimination.
    FullMatrix,
    /// Classic: analytic form factors, Gauss-Seidel gathering.
    Gathering,
    /// Classic: analytic form factors, Southwell shooting.
    Shooting,
    /// Classic: shooting with form factors on demand and the ambient term.
    Progressive,
    /// Classic: analytic form factors, conjugate gradients.
    ConjugateGradients,
    /// Classic: hemicube form factors, gathering.
    Hemicube,
    /// Classic: form factors by rays to discs, shooting.
    Discs,
    /// Classic: links between patches of all sizes, refined by what they carry.
    Hierarchical,
}

impl From<MethodArg> for Method {
    fn from(arg: MethodArg) -> Self {
        match arg {
            MethodArg::Auto => Self::Auto,
            MethodArg::PathTracing => Self::PathTracing,
            MethodArg::FullMatrix => Self::FullMatrix,
            MethodArg::Gathering => Self::Gathering,
            MethodArg::Shooting => Self::Shooting,
            MethodArg::Progressive => Self::Progressive,
            MethodArg::ConjugateGradients => Self::ConjugateGradients,
            MethodArg::Hemicube => Self::Hemicube,
            MethodArg::Discs => Self::Discs,
            MethodArg::Hierarchical => Self::Hierarchical,
        }
    }
}

/// What sensors on a patch show.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum DisplayArg {
    /// A gather from all patches at the sensor itself.
    Gather,
    /// Linear between patches.
    Bilinear,
    /// The value of the patch.
    Constant,
}

impl From<DisplayArg> for Display {
    fn from(arg: DisplayArg) -> Self {
        match arg {
            DisplayArg::Gather => Self::Gather,
            DisplayArg::Bilinear => Self::Bilinear,
            DisplayArg::Constant => Self::Constant,
        }
    }
}

/// A tolerance as `5%` or `0.05`, as a fraction.
fn tolerance(text: &str) -> std::result::Result<f64, String> {
    let (number, unit) = match text.trim().strip_suffix('%') {
        Some(percent) => (percent.trim(), 0.01),
        None => (text.trim(), 1.0),
    };
    let value: f64 = number.parse().map_err(|_| "expected a share such as 5% or 0.05".to_owned())?;
    let value = value * unit;
    if value > 0.0 && value < 1.0 {
        return Ok(value);
    }
    Err(format!("{} % is not between 0 and 100 %: write 5% or 0.05", 100.0 * value))
}

/// Runs the program with the process's arguments.
#[must_use]
pub fn run() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => {
            // A closed pipe is the reader's choice.
            let _ = e.print();
            return ExitCode::from(u8::try_from(e.exit_code()).unwrap_or(2));
        }
    };
    let outcome = match &cli.command {
        Command::Solve(args) => solve::run(args),
        Command::Annual(args) => annual::run(args),
        Command::Chart(args) => chart::run(args),
        Command::Check(args) => check::run(args),
        Command::Luminaire(args) => luminaire::run(args),
        Command::Validate(args) => validate::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Schema => schema(),
    };
    outcome.unwrap_or_else(|e| fail(&e))
}

/// Threads to work with: as many as asked for, or one for each processor.
fn pool(threads: Option<u32>) -> Result<rayon::ThreadPool> {
    let count = threads.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), |n| n as usize);
    rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build()
        .map_err(|e| Error::new(ErrorKind::Internal, format!("no threads: {e}")))
}

/// How a run came about that began at `start`.
fn provenance(pool: &rayon::ThreadPool, start: Instant) -> Provenance {
    Provenance {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        command: std::env::args().collect(),
        threads: pool.current_num_threads(),
        cpu_s: cpu::seconds(),
        peak_bytes: cpu::peak_bytes(),
        wall_s: start.elapsed().as_secs_f64(),
    }
}

/// Prints an error and gives its exit code.
fn fail(error: &Error) -> ExitCode {
    // Standard error may be closed too; the exit code still tells.
    let _ = writeln!(io::stderr(), "error: {error}");
    ExitCode::from(if error.is_input() { 2 } else { 1 })
}

fn schema() -> Result<ExitCode> {
    print(&format!("{:#}\n", scene::json_schema()))?;
    Ok(ExitCode::SUCCESS)
}

/// Prints results; a reader who has gone away is no error.
fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Error::io("standard output", &e)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arguments_are_consistent() {
        <Cli as clap::CommandFactory>::command().debug_assert();
    }

    #[test]
    fn a_tolerance_is_a_share() {
        assert_eq!(tolerance("5%"), Ok(0.05));
        assert_eq!(tolerance(" 0.5 % "), Ok(0.005));
        assert_eq!(tolerance("0.02"), Ok(0.02));
        for bad in ["5", "0", "-1%", "x", "nan", "100%", ""] {
            assert!(tolerance(bad).is_err(), "{bad}");
        }
    }
}
