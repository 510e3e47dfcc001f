//! The verbs of the command line: from arguments to work done and a result printed.

pub mod run;
pub mod ablation;
pub mod detect;
#[cfg(target_os = "linux")]
pub mod serve;
mod selftest_checked;
mod selftest_doors;
pub mod selftest_protocols;
pub mod selftest;
pub mod params;
pub mod gaps;
pub mod boxes;
pub mod robustness;
pub mod partial;
pub mod sweep;
pub mod data;
pub mod fit_density;
pub mod train;
pub mod compare;
pub mod report;
pub mod reproduce;
pub mod merge;
pub mod worst_scans;
pub mod changed_scans;
pub mod suspect_project;
pub mod suspects;
pub mod view;
pub mod streaming;
pub mod score;
pub mod history;
pub mod gate;
pub mod gate_workflow;
pub mod baseline;
pub mod init;
pub mod submit;
pub mod completions;

use std::path::{Path, PathBuf};

use clap::{ArgAction, CommandFactory as _, Parser, Subcommand};
use evaluation::training::model_kind::ModelKind;
use jiff::Timestamp;
use reports::files::archive::ArchiveError;
use reports::files::whole_set::WholeSet;
use reports::vocabulary::study::Study;

use crate::cli::help_text::{GENERAL, with_details};
use crate::cli::{
    BaselineCommand, CompareArgs, DataCommand, GateArgs, OutputArgs, PartialArgs, ReproduceArgs, RunArgs,
    ServeArgs, ShardArgs, SubmitCommand, SweepArgs, TrainCommand, ViewArgs,
};
use crate::plumbing::failure::Failure;
#[cfg(not(target_os = "linux"))]
use crate::plumbing::failure::Usage;
use crate::plumbing::scan_study::WriteStudy;
use crate::plumbing::standard_streams::{Verbosity, set_verbosity};

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
    /// Print only errors and the result, or the directory that holds it
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
  7    results cannot be written: the disk is full, or standard output is closed
  100  worse than the baseline
  101  not worse, but results changed
  130  interrupted; 143 if by SIGTERM";

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run detectors on labelled scans and score them
    Run(Box<RunArgs>),
    /// Put the shards of a run together
    Merge(merge::MergeArgs),
    /// Run one detector on one scan
    Detect(detect::DetectArgs),
    /// Compare two runs, or two detectors of one run
    Compare(CompareArgs),
    /// Rebuild the HTML page and the plots of a run or a sweep
    Report(report::ReportArgs),
    /// List the worst mistakes of a run, or what changed between two, and record their scans
    View(ViewArgs),
    /// List labels that several detectors contradict, and record their scans
    Suspects(suspects::SuspectsArgs),
    /// Check a run against the baseline: fail if it is worse or results changed
    Gate(GateArgs),
    /// Judge the answers of a run at every moment, as late as they are
    Streaming(streaming::StreamingArgs),
    /// Show what became of the numbers of a branch: trends, and the runs where they changed
    History(history::HistoryArgs),
    /// Make and replace the baseline of `gate`
    #[command(
        subcommand,
        after_help = "Examples:\n  scanbench baseline init runs/latest -o ci\n  scanbench baseline accept runs/latest -b ci --why 'fences are no longer walls'"
    )]
    Baseline(BaselineCommand),
    /// Check the scoring: annotations used as detections must score exactly 1
    Selftest(selftest::SelftestArgs),
    /// List, fetch, check, convert, simulate, prelabel and hash data sets
    #[command(subcommand, after_help = "Example:\n  scanbench data list")]
    Data(DataCommand),
    /// Train the models of detectors, and test them on held-out drives
    #[command(
        subcommand,
        after_help = "Example:\n  scanbench train groupings training-streets --scans 0..300:6 -o model"
    )]
    Train(TrainCommand),
    /// Fit the point density over range, which weights cells of the hierarchical detector
    FitDensity(Box<fit_density::FitDensityArgs>),
    /// Measure what each part of the hierarchical detector contributes
    Ablation(ablation::AblationArgs),
    /// Run detectors with many parameter values and plot rates and times
    Sweep(Box<SweepArgs>),
    /// Measure how slopes, rain, sensors and mounting heights change the scores
    Robustness(robustness::RobustnessArgs),
    /// Judge the claims of the papers, under several readings of each
    Reproduce(Box<ReproduceArgs>),
    /// Classify objects of which only a part has been seen
    Partial(Box<PartialArgs>),
    /// Measure how far apart two objects must be for detectors to separate them
    Gaps(gaps::GapsArgs),
    /// Measure the errors of five ways to fit boxes
    Boxes(boxes::BoxesArgs),
    /// Judge annotations and detections that a program hands over
    #[command(hide = true)]
    Score(score::ScoreArgs),
    /// Run one of our detectors for a program that speaks the protocol
    Serve(ServeArgs),
    /// Print the parameters of detectors, with what they mean
    Params(params::ParamsArgs),
    /// Start a detector and leave nothing of it behind.
    #[command(hide = true)]
    Supervise {
        /// Keep the network from it, and what --hide names.
        #[arg(long)]
        sandbox: bool,
        /// A file or folder that it does not see.
        #[arg(long, requires = "sandbox")]
        hide: Vec<std::path::PathBuf>,
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
    Init(init::InitArgs),
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

/// Studies that are runs, and what each adds to the files of a run.
pub const SCAN_STUDIES: [(Study, WriteStudy); 2] =
    [(Study::Ablation, ablation::write_ablation), (Study::Robustness, robustness::write_robustness)];

/// A command whose work can be cut into shards.
pub struct Shareable<'a> {
    pub output: &'a OutputArgs,
    pub shard: &'a ShardArgs,
    /// Opens its data sets, detectors and models, and looks at nothing else.
    pub open: Box<dyn Fn() -> Result<(), Failure> + 'a>,
}

impl Command {
    /// `None` if the verb has no shards.
    pub fn shareable(&self) -> Option<Shareable<'_>> {
        let now = Timestamp::now();
        let (output, shard, open): (_, _, Box<dyn Fn() -> Result<(), Failure> + '_>) = match self {
            Self::Run(it) => {
                (&it.output, &it.shard, Box::new(|| run::setup::ChosenRun::of(it)?.open(it).map(drop)))
            }
            Self::Sweep(it) => {
                let open =
                    move || sweep::setup::Sweep::open(it, sweep::setup::sweep_plan(it)?, now).map(drop);
                (&it.output, &it.shard, Box::new(open))
            }
            Self::Ablation(it) => {
                (&it.output, &it.shard, Box::new(move || ablation::open_ablation(it, now).map(drop)))
            }
            Self::Robustness(it) => {
                (&it.output, &it.shard, Box::new(move || robustness::open_robustness(it, now).map(drop)))
            }
            Self::Reproduce(it) => {
                (&it.output, &it.shard, Box::new(|| reproduce::papers_run::open(it).map(drop)))
            }
            Self::Partial(it) => (&it.output, &it.shard, Box::new(|| partial::sets::open_all(it).map(drop))),
            _ => return None,
        };
        Some(Shareable { output, shard, open })
    }
}

pub fn dispatch(cli: &Cli) -> Result<(), Failure> {
    set_verbosity(match (cli.quiet, cli.verbose) {
        (true, _) => Verbosity::Quiet,
        (false, true) => Verbosity::Verbose,
        (false, false) => Verbosity::Usual,
    });
    match &cli.command {
        Command::Run(arguments) => run::run(arguments),
        Command::Merge(arguments) => merge::merge(arguments),
        Command::Detect(arguments) => detect::detect(arguments),
        Command::Ablation(arguments) => ablation::ablation(arguments),
        Command::Data(command) => data::data(command),
        Command::FitDensity(arguments) => fit_density::fit_density(arguments),
        Command::Train(TrainCommand::Groupings(arguments)) => train::groupings::train_groupings(arguments),
        Command::Train(TrainCommand::Rivals(arguments)) => train::rivals::train_rivals(arguments),
        Command::Train(TrainCommand::Clusters(arguments)) => train::cluster_model::train_clusters(arguments),
        Command::Train(TrainCommand::Boxes(arguments)) => train::boxes::train_boxes(arguments),
        Command::Train(TrainCommand::Paper(arguments)) => train::svm::train_svm(arguments, ModelKind::Paper),
        Command::Train(TrainCommand::Pca(arguments)) => train::svm::train_svm(arguments, ModelKind::Pca),
        Command::Train(TrainCommand::Partial(arguments)) => train::partial::train_partial(arguments),
        Command::Gaps(arguments) => gaps::gaps(arguments),
        Command::Boxes(arguments) => boxes::boxes(arguments),
        Command::Partial(arguments) => partial::partial(arguments),
        Command::Reproduce(arguments) => reproduce::reproduce(arguments),
        Command::Robustness(arguments) => robustness::robustness(arguments),
        Command::Compare(arguments) => compare::compare(arguments),
        Command::Report(arguments) => report::report(arguments),
        Command::View(arguments) => view::view(arguments),
        Command::Suspects(arguments) => suspects::suspects(arguments),
        Command::Gate(arguments) => gate::gate(arguments),
        Command::Streaming(arguments) => streaming::streaming(arguments),
        Command::Score(arguments) => score::score(arguments),
        Command::History(arguments) => history::history(arguments),
        Command::Baseline(BaselineCommand::Init(arguments)) => baseline::baseline_init(arguments),
        Command::Baseline(BaselineCommand::Accept(arguments)) => baseline::baseline_accept(arguments),
        Command::Selftest(arguments) => selftest::selftest(arguments),
        Command::Sweep(arguments) => sweep::sweep(arguments),
        Command::Submit(SubmitCommand::Slurm(arguments)) => submit::slurm::submit_slurm(arguments),
        Command::Submit(SubmitCommand::Kubernetes(arguments)) => {
            submit::kubernetes::submit_kubernetes(arguments)
        }
        Command::Init(arguments) => init::init(arguments),
        Command::Params(arguments) => params::params(arguments),
        #[cfg(target_os = "linux")]
        Command::Serve(arguments) => serve::serve(arguments),
        #[cfg(target_os = "linux")]
        Command::Supervise { .. } => unreachable!("it was begun before"),
        #[cfg(not(target_os = "linux"))]
        Command::Serve(_) | Command::Supervise { .. } => {
            Err(Usage("detectors that are programs of their own need Linux".to_owned()).into())
        }
        Command::Completions { shell: Some(shell), .. } => completions::completions(*shell),
        Command::Completions { man, .. } => manual(man.as_deref().expect("clap asks for one of both")),
    }
}

fn manual(folder: &Path) -> Result<(), Failure> {
    let pages = WholeSet::within(folder)?;
    clap_mangen::generate_to(Cli::command(), pages.staged())
        .map_err(|source| ArchiveError::Write { path: folder.to_path_buf(), source })?;
    Ok(pages.finish()?)
}

#[cfg(test)]
mod help_tests;
