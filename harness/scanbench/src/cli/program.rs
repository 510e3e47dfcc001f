//! The program and its verbs.

use clap::{Parser, Subcommand};

use super::ablation::AblationArgs;
use super::boxes::BoxesArgs;
use super::compare::CompareArgs;
use super::data::DataCommand;
use super::detect::DetectArgs;
use super::fit_density::FitDensityArgs;
use super::gaps::GapsArgs;
use super::gate::{BaselineCommand, GateArgs};
use super::report::ReportArgs;
use super::robustness::RobustnessArgs;
use super::run::RunArgs;
use super::selftest::SelftestArgs;
use super::sweep::SweepArgs;
use super::train::TrainArgs;
use super::view::ViewArgs;

/// Evaluates and benchmarks LiDAR object detectors side by side.
#[derive(Debug, Parser)]
#[command(name = "scanbench", version, max_term_width = 100, after_help = EXAMPLES, after_long_help = EXIT_CODES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Say nothing but results and errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say what is done, scan by scan
    #[arg(short, long, global = true)]
    pub verbose: bool,
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
  5    runs that cannot be compared
  100  regression
  101  no regression, but scans are judged otherwise
  130  interrupted; 143 if by SIGTERM";

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
    /// Compare two runs over the same scans, or two detectors of a run, with intervals
    Compare(CompareArgs),
    /// Make the page of a run or a sweep, from its directory alone
    Report(ReportArgs),
    /// List the worst mistakes of a run, and record the scans they are in
    View(ViewArgs),
    /// Judge a run by an accepted one: fail if it is worse, or judged otherwise on any scan
    Gate(GateArgs),
    /// Keep the run that others are judged by
    #[command(
        subcommand,
        after_help = "Example:\n  scanbench baseline accept runs/latest --why 'fences are no longer walls'"
    )]
    Baseline(BaselineCommand),
    /// Score annotations fed back as detections: everything must come out at exactly 1
    Selftest(SelftestArgs),
    /// Simulate pairs of objects with growing gaps and measure which detectors tell them apart
    Gaps(GapsArgs),
    /// Measure how far boxes of two fits are from those of annotated vehicles, on the same clusters
    Boxes(BoxesArgs),
    /// Run detectors on the same simulated streets under one condition after another
    Robustness(RobustnessArgs),
    /// Run detectors with every combination of parameter values, for rates, times and cell fitness over a parameter
    Sweep(Box<SweepArgs>),
    /// Print a completion script for a shell
    #[command(
        after_help = "Example:\n  scanbench completions bash > ~/.local/share/bash-completion/completions/scanbench"
    )]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}
