//! Arguments of `scanbench reproduce`.

use clap::{Args, ValueEnum};
use reports::vocabulary::task::Task;

use super::help_text::DETECTORS;
use super::output::OutputArgs;
use super::scans::DatasetArgs;
use super::shard::ShardArgs;
use super::stream::StreamArgs;
use super::timing::TimingArgs;

/// Arguments of `scanbench reproduce`.
#[derive(Debug, Args)]
#[command(after_help = REPRODUCE_EXAMPLES)]
pub struct ReproduceArgs {
    /// Which paper: hg (objects over a hierarchical grid), vm (vehicles by their model), or all, with bg (partial clouds of
    /// objects)
    #[arg(value_enum, ignore_case = true, default_value = "all", help_heading = clap::builder::Resettable::Reset)]
    pub paper: PaperName,
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Which part of them.
    #[command(flatten)]
    pub shard: ShardArgs,
    /// Number of joint settings of the values that the papers leave open; each claim is judged under all
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    #[arg(help_heading = DETECTORS)]
    pub settings: u32,
    /// Seed of the random settings
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = DETECTORS, hide_short_help = true)]
    pub settings_seed: u64,
    /// Simulated objects of each class that the method of BG learns from, and as many others that judge it
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    #[arg(help_heading = DETECTORS, hide_short_help = true)]
    pub per_class: u32,
    /// Choose the open values of paper or of a rival on these scans, instead of judging claims
    ///
    /// The setting with the greatest mean rate wins: of paper over both tasks, of a rival in its own. Half of the settings
    /// are drawn, the others come of a search from the best of these, one value after another.
    #[arg(long, value_enum, value_name = "DETECTOR", num_args = 0..=1, require_equals = true, default_missing_value = "paper")]
    #[arg(help_heading = DETECTORS, conflicts_with_all = IDLE_OF_CHOICE)]
    pub choose: Option<ChosenFor>,
    /// Where the page and the tables are written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// What runs beside what.
    #[command(flatten)]
    pub timing: TimingArgs,
    /// What is recorded: 30 scans unless --rerun-every says otherwise, with a view for each figure of the papers.
    #[command(flatten)]
    pub stream: StreamArgs,
}

/// What says nothing about a choice of values: it leaves no files, and no recording.
const IDLE_OF_CHOICE: [&str; 12] = [
    "output",
    "overwrite",
    "warmup",
    "shard",
    "save_rrd",
    "no_rrd",
    "connect",
    "spawn",
    "serve",
    "rerun_every",
    "rerun_points",
    "blueprint",
];

/// A paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PaperName {
    /// Objects over a hierarchical grid
    Hg,
    /// Vehicles by their model
    Vm,
    /// Both, and BG: partial clouds of objects
    All,
}

/// A detector of the papers that has open values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ChosenFor {
    /// The method of the papers
    Paper,
    /// The rival of objects
    KdTree,
    /// The rival of vehicles
    Pca,
}

impl ChosenFor {
    /// Its name among detectors.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::KdTree => "kd-tree",
            Self::Pca => "pca",
        }
    }

    /// What it is chosen for.
    pub fn tasks(self) -> &'static [Task] {
        match self {
            Self::Paper => &Task::ALL,
            Self::KdTree => &[Task::Objects],
            Self::Pca => &[Task::Vehicles],
        }
    }
}

impl PaperName {
    /// As it is written on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hg => "hg",
            Self::Vm => "vm",
            Self::All => "all",
        }
    }
}

const REPRODUCE_EXAMPLES: &str = "\
Examples:
  scanbench reproduce                              all three papers, on simulations
  scanbench reproduce all streets ~/data/kitti_tracking -o runs/papers
  scanbench reproduce hg --settings 1000
  scanbench reproduce all --choose=kd-tree training-streets --scans 0..300:6

Runs the method of the papers and its rivals, and judges each claim of the papers, also
under other settings of the values that they leave open. Writes reproduction.html, .md,
.tex and .json, settings.csv, and the files of a run. The recording has 30 scans, unless
--rerun-every says otherwise, and opens with a view for each figure of the papers.";
