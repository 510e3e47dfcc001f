//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::run::detector_list::DETECTORS;
use crate::simulator::sensor::EMBEDDED_SENSORS;

/// Evaluates and benchmarks LiDAR object detectors side by side.
#[derive(Debug, Parser)]
#[command(name = "scanbench", version, max_term_width = 100, after_help = EXAMPLES, after_long_help = EXIT_CODES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  scanbench run                              simulated streets, all detectors
  scanbench run ~/data/kitti/tracking        KITTI tracking, recognised by its folders
  scanbench run kitti-object -d hierarchical,pca --criterion centre
  scanbench data list                        what is in the catalogue";

const EXIT_CODES: &str = "\
Examples:
  scanbench run                              simulated streets, all detectors
  scanbench run ~/data/kitti/tracking        KITTI tracking, recognised by its folders
  scanbench run kitti-object -d hierarchical,pca --criterion centre
  scanbench data list                        what is in the catalogue

Exit codes:
  0    good
  1    internal error
  2    wrong usage or configuration
  3    data missing or damaged
  4    nothing was evaluated
  130  interrupted";

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run detectors on labelled scans, score them, and leave a run directory
    Run(RunArgs),
    /// Look at the catalogue of data sets
    #[command(subcommand, after_help = "Example:\n  scanbench data list")]
    Data(DataCommand),
    /// Learn from scans how the density of points falls with the range, for the weights of the hierarchical detector
    FitDensity(Box<FitDensityArgs>),
    /// Score annotations fed back as detections: everything must come out at exactly 1
    Selftest(SelftestArgs),
    /// Print a completion script for a shell
    #[command(
        after_help = "Example:\n  scanbench completions bash > ~/.local/share/bash-completion/completions/scanbench"
    )]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

/// The verbs of `scanbench data`.
#[derive(Debug, Subcommand)]
pub enum DataCommand {
    /// List the data sets of the catalogue and whether they are there
    #[command(after_help = "Example:\n  scanbench data list --catalogue my-datasets.toml")]
    List(CatalogueArgs),
    /// Measure how like the scans of one data set are to those of another
    Realism(Box<RealismArgs>),
}

/// Where data sets are looked up.
#[derive(Debug, Clone, Args)]
pub struct CatalogueArgs {
    /// Catalogue to look ids up in, instead of the built-in one
    #[arg(long, value_name = "FILE", env = "SCANBENCH_DATASETS")]
    pub catalogue: Option<PathBuf>,
}

/// Which scans are taken.
#[derive(Debug, Clone, Args)]
pub struct DatasetArgs {
    /// Ids of the catalogue, or paths of data sets
    #[arg(value_name = "DATASET", default_value = crate::dataset::open::DEFAULT_DATASETS)]
    pub datasets: Vec<String>,
    /// Format of the data sets given as paths, instead of recognising it: `kitti-tracking` or `kitti-object`
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Which scans, by place in each data set, from 0: `7`, `0..500` (without 500), `0..500:5` (every fifth), or several
    /// of these by comma
    #[arg(long, value_name = "RANGE")]
    pub scans: Option<String>,
    /// Seed of simulated data sets, instead of the catalogue's
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Number of scans of simulated data sets, instead of the catalogue's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub simulated_scans: Option<u32>,
    /// Sensor of simulated data sets.
    #[arg(long, value_name = "SENSOR", help = sensor_help())]
    pub sensor: Option<String>,
    /// Where ids are looked up.
    #[command(flatten)]
    pub catalogue: CatalogueArgs,
}

fn sensor_help() -> String {
    let ids = EMBEDDED_SENSORS.map(|(id, _)| format!("`{id}`")).join(", ");
    format!("Sensor of simulated data sets: {ids}, or a TOML file that describes one")
}

fn detectors_help() -> String {
    let names: Vec<&str> = detector_names().collect();
    format!("Detectors, by comma [default: {}]", names.join(","))
}

fn detector_names() -> impl Iterator<Item = &'static str> {
    DETECTORS.iter().map(|it| it.name)
}

/// Where a verb leaves its files.
#[derive(Debug, Args)]
pub struct OutputArgs {
    /// Directory to write [default: one in `runs/`, named after time and data sets]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Replace the directory if there is an earlier one
    #[arg(long)]
    pub overwrite: bool,
}

/// How detections are judged.
#[derive(Debug, Args)]
pub struct MatchingArgs {
    /// When a detection may match an annotation
    #[arg(long, value_enum, value_name = "CRITERION")]
    pub criterion: Option<CriterionName>,
}

/// Names of the matching criteria.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CriterionName {
    /// Point sets agree: intersection over union of at least 0.5
    Points,
    /// Centres are less than 2 m apart on the ground plan
    Centre,
}

/// Arguments of `scanbench run`.
#[derive(Debug, Args)]
#[command(after_help = RUN_EXAMPLES)]
pub struct RunArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// The detectors, in the order of the tables.
    #[arg(short, long, value_name = "NAMES", value_delimiter = ',', help = detectors_help(), hide_default_value = true)]
    #[arg(default_values = detector_names())]
    pub detectors: Vec<String>,
    /// TOML file that overrides parameters of detectors and matching, by the names under `config` in manifest.json
    #[arg(short, long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// How detections are judged.
    #[command(flatten)]
    pub matching: MatchingArgs,
    /// Where the run directory is written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// Scans read or simulated at once; detectors always run alone [default: number of cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Detections of the first scan that are thrown away before anything is timed
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub warmup: u16,
    /// What is streamed to Rerun.
    #[cfg(feature = "rerun")]
    #[command(flatten)]
    pub stream: StreamArgs,
}

#[cfg(feature = "rerun")]
const RUN_EXAMPLES: &str = "\
Examples:
  scanbench run
  scanbench run --seed 7 --simulated-scans 100 --sensor vlp-16 -o runs/seed-7
  scanbench run ~/data/kitti_tracking -d hierarchical,pca --criterion centre
  scanbench run kitti-tracking --connect rerun+http://127.0.0.1:9876/proxy

Leaves in the run directory, which runs/latest points at unless -o names it:
manifest.json, report.json, scans.csv, matches.csv,
table_<task>.{csv,md,tex} and, unless --no-rrd, run.rrd for the Rerun viewer.";

#[cfg(not(feature = "rerun"))]
const RUN_EXAMPLES: &str = "\
Examples:
  scanbench run
  scanbench run --seed 7 --simulated-scans 100 --sensor vlp-16 -o runs/seed-7
  scanbench run ~/data/kitti_tracking -d hierarchical,pca --criterion centre

Leaves in the run directory, which runs/latest points at unless -o names it:
manifest.json, report.json, scans.csv, matches.csv
and table_<task>.{csv,md,tex}. This program was built without Rerun.";

/// What is streamed to Rerun.
#[cfg(feature = "rerun")]
#[derive(Debug, Args)]
pub struct StreamArgs {
    /// Save the Rerun recording as `run.rrd` in the run directory (the default), or as FILE
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    pub save_rrd: Option<Option<PathBuf>>,
    /// Write no Rerun recording
    #[arg(long, conflicts_with_all = ["save_rrd", "connect", "spawn"])]
    pub no_rrd: bool,
    /// Stream to a running Rerun viewer as well
    #[arg(long, value_name = "URL")]
    pub connect: Option<String>,
    /// Start a Rerun viewer and stream to it as well
    #[arg(long, conflicts_with = "connect")]
    pub spawn: bool,
}

/// Arguments of `scanbench selftest`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  scanbench selftest ../data/kitti_tracking --scans 0..10")]
pub struct SelftestArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
}

/// Arguments of `scanbench fit-density`.
#[derive(Debug, Args)]
#[command(after_help = FIT_DENSITY_EXAMPLES)]
pub struct FitDensityArgs {
    /// The scans, all of one sensor.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// File to write, which `scanbench run --config` takes
    #[arg(short, long, value_name = "FILE", default_value = "density.toml")]
    pub output: PathBuf,
    /// Write both curves, measured and fitted, as CSV and SVG into a directory
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// Replace file and directory if there are earlier ones
    #[arg(long)]
    pub overwrite: bool,
}

const FIT_DENSITY_EXAMPLES: &str = "\
Examples:
  scanbench fit-density ~/data/kitti_tracking -o density.toml --figures figures
  scanbench fit-density streets --seed 1000 --sensor my-sensor.toml
  scanbench run ~/data/kitti_tracking --config density.toml

Without such a file, a run takes the curve that comes with the program for the
sensor of each data set: hdl-64e-s2, hdl-32e, vlp-16 or os1-128.";

/// Arguments of `scanbench data realism`.
#[derive(Debug, Args)]
#[command(after_help = REALISM_EXAMPLES)]
pub struct RealismArgs {
    /// The scans that are judged.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Data set to judge by: an id of the catalogue, or a path
    #[arg(long, value_name = "DATASET")]
    pub against: String,
    /// Format of the data set to judge by, if it is given as a path
    #[arg(long, value_name = "FORMAT")]
    pub against_format: Option<String>,
    /// Which of its scans, as `--scans`
    #[arg(long, value_name = "RANGE")]
    pub against_scans: Option<String>,
    /// Where curves and plots are written.
    #[command(flatten)]
    pub output: OutputArgs,
}

const REALISM_EXAMPLES: &str = "\
Examples:
  scanbench data realism --against ~/data/kitti_tracking
  scanbench data realism street-main-road --seed 7 --against kitti-tracking -o look
  scanbench data realism kitti-object --against kitti-tracking --against-scans 0..40

Compares returns, share of ground, density, points per car, clusters, heights and
cells of the scans, bin by bin. Leaves in the directory realism.csv, with every
bin, a plot of each statistic as SVG, and manifest.json.";
