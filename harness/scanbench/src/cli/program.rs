//! The program and its verbs.

use std::path::PathBuf;

use clap::{ArgAction, Parser, Subcommand};

use super::ablation::AblationArgs;
use super::boxes::BoxesArgs;
use super::compare::CompareArgs;
use super::data::DataCommand;
use super::detect::DetectArgs;
use super::fit_density::FitDensityArgs;
use super::gaps::GapsArgs;
use super::gate::{BaselineCommand, GateArgs};
use super::help_text::{GENERAL, with_details};
use super::init::InitArgs;
use super::merge::MergeArgs;
use super::params::ParamsArgs;
use super::partial::PartialArgs;
use super::report::ReportArgs;
use super::reproduce::ReproduceArgs;
use super::robustness::RobustnessArgs;
use super::run::RunArgs;
use super::selftest::SelftestArgs;
use super::serve::ServeArgs;
use super::submit::SubmitCommand;
use super::sweep::SweepArgs;
use super::train::TrainCommand;
use super::view::ViewArgs;

/// Evaluates and benchmarks LiDAR object detectors side by side.
#[derive(Debug, Parser)]
#[command(
    name = "scanbench",
    version,
    max_term_width = 100,
    disable_help_flag = true,
    disable_version_flag = true
)]
#[command(after_help = EXAMPLES, after_long_help = with_details(EXAMPLES, EXIT_CODES))]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Print only errors and the directory of the result, or the result if there is none
    #[arg(short, long, global = true, conflicts_with = "verbose", help_heading = GENERAL)]
    pub quiet: bool,
    /// Print progress scan by scan, and all tables of a run
    #[arg(short, long, global = true, help_heading = GENERAL)]
    pub verbose: bool,
    /// Print help: -h a summary, --help everything
    #[arg(short, long, global = true, action = ArgAction::Help, help_heading = GENERAL)]
    help: Option<bool>,
    /// Print the version
    #[arg(short = 'V', long, action = ArgAction::Version, help_heading = GENERAL)]
    version: Option<bool>,
}

const EXAMPLES: &str = "\
Examples:
  scanbench run                                 simulated streets, five detectors
  scanbench run ~/data/kitti/tracking           KITTI tracking, recognised by its folders
  scanbench run kitti-object -d hierarchical,pca --criterion centre
  scanbench detect 000000.bin -o clusters.csv   the clusters of one scan
  scanbench data list                           the data sets of the catalogue";

const EXIT_CODES: &str = "\
Exit codes:
  0    success
  1    internal error
  2    wrong usage or configuration
  3    data missing or damaged
  4    nothing was evaluated
  5    the runs cannot be compared
  6    a detector of scanbench.toml failed
  100  worse than the baseline
  101  not worse, but results changed
  130  interrupted; 143 if by SIGTERM";

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run detectors on labelled scans and score them
    Run(Box<RunArgs>),
    /// Put the shards of a run together
    Merge(MergeArgs),
    /// Run one detector on one scan
    Detect(DetectArgs),
    /// Compare two runs, or two detectors of one run
    Compare(CompareArgs),
    /// Rebuild the HTML page and the plots of a run or a sweep
    Report(ReportArgs),
    /// List the worst mistakes of a run and record their scans
    View(ViewArgs),
    /// Check a run against the baseline: fail if it is worse or results changed
    Gate(GateArgs),
    /// Make and replace the baseline of `gate`
    #[command(
        subcommand,
        after_help = "Examples:\n  scanbench baseline init runs/latest -o ci\n  scanbench baseline accept runs/latest -b ci --why 'fences are no longer walls'"
    )]
    Baseline(BaselineCommand),
    /// Check the scoring: annotations used as detections must score exactly 1
    Selftest(SelftestArgs),
    /// List, fetch, check, convert, simulate, prelabel, hash and compare data sets
    #[command(subcommand, after_help = "Example:\n  scanbench data list")]
    Data(DataCommand),
    /// Train the models of detectors, and test them on held-out drives
    #[command(
        subcommand,
        after_help = "Example:\n  scanbench train groupings training-streets --scans 0..300:6 -o model"
    )]
    Train(TrainCommand),
    /// Fit the point density over range, which weights cells of the hierarchical detector
    FitDensity(Box<FitDensityArgs>),
    /// Measure what each part of the hierarchical detector contributes
    Ablation(AblationArgs),
    /// Run detectors with many parameter values and plot rates and times
    Sweep(Box<SweepArgs>),
    /// Measure how slopes, rain, sensors and mounting heights change the scores
    Robustness(RobustnessArgs),
    /// Judge the claims of the papers, under several readings of each
    Reproduce(Box<ReproduceArgs>),
    /// Classify objects of which only a part has been seen
    Partial(Box<PartialArgs>),
    /// Measure how far apart two objects must be for detectors to separate them
    Gaps(GapsArgs),
    /// Measure the errors of five ways to fit boxes
    Boxes(BoxesArgs),
    /// Run one of our detectors for a program that speaks the protocol
    Serve(ServeArgs),
    /// Print the parameters of detectors, with what they mean
    Params(ParamsArgs),
    /// Start a detector and leave nothing of it behind.
    #[command(hide = true)]
    Supervise {
        /// The program and its arguments.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, required = true)]
        command: Vec<String>,
    },
    /// Write the jobs of a run or a study for Slurm or Kubernetes
    #[command(
        subcommand,
        after_help = "Example:\n  scanbench submit slurm --shards 40 -o runs/fleet -- run data/fleet"
    )]
    Submit(SubmitCommand),
    /// Write a folder to start from: a detector in Python, labelled scans, a gate
    Init(InitArgs),
    /// Print a completion script for a shell, or write the manual pages
    #[command(
        after_help = "Example:\n  scanbench completions bash > ~/.local/share/bash-completion/completions/scanbench"
    )]
    Completions {
        /// The shell
        #[arg(required_unless_present = "man", conflicts_with = "man")]
        shell: Option<clap_complete::Shell>,
        /// Folder to write the manual pages into, one for each verb
        #[arg(long, value_name = "FOLDER", help_heading = "Output")]
        man: Option<PathBuf>,
    },
}
