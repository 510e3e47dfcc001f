//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::dataset::dataset_format::DatasetFormat;
use crate::run::config::override_option::OverrideOption;
use crate::run::detector_list::{DEFAULT_DETECTORS, DETECTORS};
use crate::simulator::sensor::EMBEDDED_SENSORS;
use crate::training::{CHOICE_SEED, GAMMA, HOLD_OUT_EVERY, NU, PROTOTYPES};

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
  scanbench detect 000000.bin -o clusters.csv   the clusters of one scan
  scanbench data list                        what is in the catalogue";

const EXIT_CODES: &str = "\
Examples:
  scanbench run                              simulated streets, all detectors
  scanbench run ~/data/kitti/tracking        KITTI tracking, recognised by its folders
  scanbench run kitti-object -d hierarchical,pca --criterion centre
  scanbench detect 000000.bin -o clusters.csv   the clusters of one scan
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
    /// Run one detector on one scan, and write the cluster of every point and the boxes
    Detect(DetectArgs),
    /// Measure what each part of the hierarchical detector is worth, by leaving it out
    Ablation(AblationArgs),
    /// Look at the catalogue of data sets
    #[command(subcommand, after_help = "Example:\n  scanbench data list")]
    Data(DataCommand),
    /// Learn from scans how the density of points falls with the range, for the weights of the hierarchical detector
    FitDensity(Box<FitDensityArgs>),
    /// Train the model that tells vehicles from background, and judge it by drives it has not seen
    Train(Box<TrainArgs>),
    /// Score annotations fed back as detections: everything must come out at exactly 1
    Selftest(SelftestArgs),
    /// Simulate pairs of objects with growing gaps and measure which detectors tell them apart
    Gaps(GapsArgs),
    /// Run detectors on the same simulated streets under one condition after another
    Robustness(RobustnessArgs),
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
    /// Which scans, by place in each data set, from 0: `7`, `0..500` (without 500), `0..500:5` (every fifth), or several
    /// of these by comma
    #[arg(long, value_name = "RANGE")]
    pub scans: Option<String>,
    /// How they are opened.
    #[command(flatten)]
    pub source: SourceArgs,
}

/// How data sets are opened.
#[derive(Debug, Clone, Args)]
pub struct SourceArgs {
    /// Format of data sets given as paths, instead of recognising it.
    #[arg(long, value_name = "FORMAT", help = format_help())]
    pub format: Option<String>,
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

fn format_help() -> String {
    let names = DatasetFormat::names().join("`, `");
    format!("Format of data sets given as paths, instead of recognising it: `{names}`")
}

fn sensor_help() -> String {
    let ids = EMBEDDED_SENSORS.map(|(id, _)| format!("`{id}`")).join(", ");
    format!("Sensor of simulated data sets: {ids}, or a TOML file that describes one")
}

fn detectors_help() -> String {
    let names: Vec<&str> = DETECTORS.iter().map(|it| it.name).collect();
    format!("Detectors, by comma, of {} [default: {}]", names.join(", "), DEFAULT_DETECTORS.join(","))
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

/// Parameters of detectors and matching.
#[derive(Debug, Args)]
pub struct ConfigArgs {
    /// TOML file that overrides parameters of detectors and matching, by the names under `config` in manifest.json
    #[arg(short, long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Override one parameter, after the file; may be repeated. The end of a name will do where only one parameter of
    /// the detectors that run has it
    #[arg(short = 'P', long = "param", value_name = "NAME=VALUE")]
    pub parameters: Vec<OverrideOption>,
}

/// What runs beside what, so that times mean something.
#[derive(Debug, Args)]
pub struct TimingArgs {
    /// Scans read or simulated at once; detectors always run alone [default: number of cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Detections of the first scan that are thrown away before anything is timed
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub warmup: u16,
}

impl TimingArgs {
    /// Scans that are read at once.
    pub fn n_jobs(&self) -> usize {
        let n_cores = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        self.jobs.map_or_else(n_cores, usize::from)
    }
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
    #[arg(default_values = DEFAULT_DETECTORS)]
    pub detectors: Vec<String>,
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// How detections are judged.
    #[command(flatten)]
    pub matching: MatchingArgs,
    /// Where the run directory is written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// What runs beside what.
    #[command(flatten)]
    pub timing: TimingArgs,
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
  scanbench run kitti-tracking -P tolerance_m=0.7 -P matching.min_points=50
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
  scanbench run kitti-tracking -P tolerance_m=0.7 -P matching.min_points=50

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

/// Arguments of `scanbench detect`.
#[derive(Debug, Args)]
#[command(after_help = DETECT_EXAMPLES)]
pub struct DetectArgs {
    /// Scan: a Velodyne `.bin` file; or, with --scan, a data set: its id in the catalogue or its path
    #[arg(value_name = "SCAN")]
    pub input: String,
    /// Which scan of a data set: `0000/000110`, or `110` if only one drive has a scan of that number
    #[arg(long, value_name = "ID")]
    pub scan: Option<String>,
    /// The detector.
    #[arg(short, long, value_name = "NAME", help = detector_help(), default_value = DETECTORS[0].name)]
    pub detector: String,
    /// File for the cluster of every point, in the order of the scan: `.csv`, or `.u32` (little endian, 4294967295
    /// for points of no cluster); `-` prints the CSV
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// CSV file for the boxes; `-` prints it
    #[arg(long, value_name = "FILE")]
    pub boxes: Option<PathBuf>,
    /// Height of the sensor above the road in metres [default: the data set's; 1.73 for a file]
    #[arg(long, value_name = "M", value_parser = sensor_height_m)]
    pub sensor_height: Option<f32>,
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// Detections of the scan; with several, the least and the median of their times are printed
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub repeat: u32,
    /// How the data set is opened.
    #[command(flatten)]
    pub source: SourceArgs,
}

const DETECT_EXAMPLES: &str = "\
Examples:
  scanbench detect 000000.bin -o clusters.csv --boxes boxes.csv
  scanbench detect 000000.bin -d kd-tree -P tolerance_m=0.5 -P foreground=all -o clusters.u32
  scanbench detect street-narrow --scan 10 --sensor vlp-16 --repeat 20
  scanbench detect ~/data/kitti_tracking --scan 0000/000110 --boxes - | head

Clusters are numbered from 0, as in the column id of the boxes. Points of no
cluster have an empty one. Files are written whole or not at all.";

fn detector_help() -> String {
    format!("Detector: {}", detector_names().join(", "))
}

/// A height from that of the road itself, for clouds that are given from there, to that of a house.
fn sensor_height_m(text: &str) -> Result<f32, String> {
    let height_m: f32 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (0.0..=100.0).contains(&height_m) { Ok(height_m) } else { Err("outside of 0 to 100 m".to_owned()) }
}

/// Arguments of `scanbench ablation`.
#[derive(Debug, Args)]
#[command(after_help = ABLATION_EXAMPLES)]
pub struct AblationArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Parameters of the whole method.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// How detections are judged.
    #[command(flatten)]
    pub matching: MatchingArgs,
    /// Where the table is written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// What runs beside what.
    #[command(flatten)]
    pub timing: TimingArgs,
}

const ABLATION_EXAMPLES: &str = "\
Examples:
  scanbench ablation
  scanbench ablation streets ~/data/kitti_tracking -o runs/ablation
  scanbench ablation street-narrow --seed 7 -P hierarchical.grid.xi=2

All variants look at each scan, one after the other. Leaves in the directory
ablation.csv, ablation.md and manifest.json.";

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

/// Arguments of `scanbench train`.
#[derive(Debug, Args)]
#[command(after_help = TRAIN_EXAMPLES)]
pub struct TrainArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Hold out the last of every N drives of each data set to judge by
    #[arg(long, value_name = "N", default_value_t = HOLD_OUT_EVERY, value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub hold_out_every: u32,
    /// Most vehicles to train on
    #[arg(long, value_name = "N", default_value_t = 3000, value_parser = clap::value_parser!(u32).range(2..=20_000))]
    pub vehicles: u32,
    /// Most other objects to train on, for each vehicle
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=20))]
    pub others: u32,
    /// Most side profiles of each kind of vehicle to compare with
    #[arg(long, value_name = "N", default_value_t = PROTOTYPES, value_parser = clap::value_parser!(u32).range(1..=20))]
    pub prototypes: u32,
    /// Width of the Gaussian kernel over standardised values; the paper has 0.1078
    #[arg(long, value_name = "X", default_value_t = GAMMA)]
    pub gamma: f32,
    /// Share of vehicles and background that may lie inside the margin; the paper has 0.0377
    #[arg(long, value_name = "X", default_value_t = NU)]
    pub nu: f64,
    /// Seed of the choice among objects, and of the regions that are cut out
    #[arg(long, value_name = "N", default_value_t = CHOICE_SEED)]
    pub choice_seed: u64,
    /// Where model, prototypes, curves and plots are written.
    #[command(flatten)]
    pub output: OutputArgs,
}

const TRAIN_EXAMPLES: &str = "\
Examples:
  scanbench train streets --seed 2000 --simulated-scans 300 --scans 0..300:6 -o model
  scanbench train ~/data/kitti_tracking -o model
  scanbench train streets --seed 3000 --nu 0.3 --gamma 0.1078

Objects are what the hierarchical detector finds: those that match an annotated
car, van, truck or bus, and those without points of any, with regions cut out
anywhere. Leaves in the directory model.toml and prototypes.toml, which a run takes
with -P vehicle_model.directory=DIR, objects.csv with every held-out object,
importance.csv, curves.csv, curves.svg and manifest.json. The same scans and options
give the same bytes, but for the date in the manifest.";

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

/// Arguments of `scanbench gaps`.
#[derive(Debug, Args)]
#[command(after_help = GAPS_EXAMPLES)]
pub struct GapsArgs {
    /// The detectors, in the order of tables and plots.
    #[command(flatten)]
    pub detectors: ExperimentArgs,
    /// Pairs of each kind and layout at each range; each is put up with every gap
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub pairs: u32,
    /// Sensor.
    #[arg(long, value_name = "SENSOR", default_value = "hdl-64e-s2", help = sensor_help())]
    pub sensor: String,
    /// Where curves and plots are written.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// What experiments on simulated scans have in common.
#[derive(Debug, Args)]
pub struct ExperimentArgs {
    /// The detectors.
    #[arg(short, long, value_name = "NAMES", value_delimiter = ',', help = experiment_detectors_help())]
    pub detectors: Vec<String>,
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// Seed of all that is drawn
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

fn experiment_detectors_help() -> String {
    format!(
        "Detectors, by comma, of {} [default: all but pca for gaps, else all]",
        detector_names().join(", ")
    )
}

fn detector_names() -> Vec<&'static str> {
    DETECTORS.iter().map(|it| it.name).collect()
}

const GAPS_EXAMPLES: &str = "\
Examples:
  scanbench gaps
  scanbench gaps --pairs 100 --seed 7 -o runs/gaps
  scanbench gaps -d hierarchical,pca --sensor os1-128

Puts up two cars, a car and a pedestrian, two pedestrians, a car and a sign, and
a car and a bin, side by side and one behind the other, 0.2 to 1.2 m apart, 5 to
30 m away, on a bare road. Leaves in the directory gaps.csv, with every bin and
its denominator, gaps.svg and one plot for each kind of pair, pair.svg (a pair
from above as simple-grid and hierarchical see it) and manifest.json.";

/// Arguments of `scanbench robustness`.
#[derive(Debug, Args)]
#[command(after_help = ROBUSTNESS_EXAMPLES)]
pub struct RobustnessArgs {
    /// The detectors, in the order of the table.
    #[command(flatten)]
    pub detectors: ExperimentArgs,
    /// Scans of each of the three kinds of street under each condition
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub scans: u32,
    /// Where the tables are written.
    #[command(flatten)]
    pub output: OutputArgs,
}

const ROBUSTNESS_EXAMPLES: &str = "\
Examples:
  scanbench robustness
  scanbench robustness --scans 20 --seed 7 -o runs/robustness
  scanbench robustness -d hierarchical -P walls.enabled=false

Conditions: slopes and hills, kerbs, a truck ahead, mounting heights, sensors,
rain, rolling shutter. Leaves in the directory robustness.csv, with what every
rate is made of, robustness.md and manifest.json.";
