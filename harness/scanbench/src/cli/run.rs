//! Arguments of `scanbench run`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use evaluation::run::detector_list::DEFAULT_DETECTORS;
use evaluation::run::side_by_side::OnDetectorFailure;

use super::detectors::detectors_help;
use super::help_text::{DATA, DETECTORS, OUTPUT, with_details};
use super::output::OutputArgs;
use super::parameters::{ConfigArgs, MatchingArgs};
use super::protocols::ProtocolArgs;
use super::results::{ForeignArgs, ResultFilesArgs};
use super::scans::{BlocksArgs, DamageArgs, DatasetArgs};
use super::shard::ShardArgs;
use super::stream::StreamArgs;
use super::timing::TimingArgs;

/// Arguments of `scanbench run`.
#[derive(Debug, Args)]
#[command(after_help = RUN_EXAMPLES, after_long_help = with_details(RUN_EXAMPLES, RUN_DETAILS))]
pub struct RunArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Which of them belong together.
    #[command(flatten)]
    pub blocks: BlocksArgs,
    /// Which part of them.
    #[command(flatten)]
    pub shard: ShardArgs,
    /// What becomes of damaged ones.
    #[command(flatten)]
    pub damage: DamageArgs,
    /// Say that the labels are right, where they look suspect
    ///
    /// Labels that do not lie where the points are leave a run without a verdict. This overrules such doubts. They are still
    /// reported, and the run says that they were overruled.
    #[arg(long, hide_short_help = true, help_heading = DATA)]
    pub labels_are_right: bool,
    /// The detectors, in the order of the tables.
    #[arg(short, long, value_name = "NAMES", value_delimiter = ',', help = detectors_help(), hide_default_value = true)]
    #[arg(default_values = DEFAULT_DETECTORS, help_heading = DETECTORS)]
    pub detectors: Vec<String>,
    /// What other programs found.
    #[command(flatten)]
    pub foreign: ForeignArgs,
    /// Add the detectors of -d, or --detections, to a finished run
    ///
    /// They run alone on its scans, as its own detectors did; then the run is made again of the rows of both. Everything else
    /// is as the run says.
    #[arg(
        long,
        value_name = "RUN",
        help_heading = DETECTORS,
        hide_short_help = true,
        conflicts_with_all = [
            "datasets", "scans", "config", "parameters", "criterion", "only", "protocols", "output", "overwrite", "shard",
            "skip_damaged", "labels_are_right", "mcap", "detections_out", "result_format", "save_rrd", "connect", "serve",
            "spawn", "blocks", "repeats", "warmup", "jobs", "seed", "simulated_scans", "sensor", "sensor_height", "labels_ahead", "transform",
            "columns", "classes", "on_detector_failure", "count"
        ]
    )]
    pub add_to: Option<PathBuf>,
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// What runs beside what.
    #[command(flatten)]
    pub timing: TimingArgs,
    /// Detections of each scan; `gate` needs 5
    ///
    /// Detectors take turns, and with them the plain grid write that `gate` compares times with. `gate` takes the shortest
    /// times; everything else takes the first.
    #[arg(long, value_name = "N", default_value = "1", value_parser = repeats, help_heading = DETECTORS)]
    pub repeats: NonZeroUsize,
    /// Count instructions and memory of each detection, too
    ///
    /// They hardly depend on what else the machine does. The processor counts, if the system lets it; else valgrind can, which
    /// takes 50 times as long, counts built-in detectors alone, and measures no times: take few scans.
    #[arg(long, value_enum, value_name = "BY", num_args = 0..=1, require_equals = true, default_missing_value = "processor")]
    #[arg(hide_short_help = true, help_heading = DETECTORS)]
    pub count: Option<CountedBy>,
    /// What to do if a detector of scanbench.toml fails
    #[arg(long, value_enum, value_name = "RULE", default_value = "stop", help_heading = DETECTORS)]
    #[arg(hide_short_help = true)]
    pub on_detector_failure: FailureRule,
    /// How detections are judged.
    #[command(flatten)]
    pub matching: MatchingArgs,
    /// What else they are evaluated by.
    #[command(flatten)]
    pub protocol: ProtocolArgs,
    /// Where the run directory is written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// Write an MCAP recording for Foxglove, too
    ///
    /// Writes run.mcap into the run directory, or a file for each of several data sets.
    #[arg(long, help_heading = OUTPUT, conflicts_with = "shard")]
    pub mcap: bool,
    /// What is written for the evaluators of others.
    #[command(flatten)]
    pub result_files: ResultFilesArgs,
    /// What is streamed to Rerun.
    #[command(flatten)]
    pub stream: StreamArgs,
}

/// Who counts instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CountedBy {
    /// The processor, through the kernel's `perf_event`
    Processor,
    /// valgrind, which simulates one
    Valgrind,
}

/// What becomes of a run where a detector gives no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FailureRule {
    /// End the run with exit code 6
    Stop,
    /// Count nothing as found on the scan, and go on
    Skip,
}

impl FailureRule {
    /// The rule.
    pub fn rule(self) -> OnDetectorFailure {
        match self {
            Self::Stop => OnDetectorFailure::Stop,
            Self::Skip => OnDetectorFailure::Skip,
        }
    }
}

/// Number of repetitions.
fn repeats(text: &str) -> Result<NonZeroUsize, String> {
    let number = text.parse().ok().filter(|it: &NonZeroUsize| it.get() <= 1000);
    number.ok_or_else(|| "not a number from 1 to 1000".to_owned())
}

const RUN_EXAMPLES: &str = "\
Examples:
  scanbench run
  scanbench run --seed 7 --simulated-scans 100 -P tolerance_m=0.7 -o runs/seed-7
  scanbench run ~/data/kitti_tracking -d hierarchical,pca --criterion centre
  scanbench run ~/data/kitti_tracking --detections pointrcnn=results/pointrcnn";

const RUN_DETAILS: &str = "\
The run directory (docs/run-directory.md) holds
  report.html, figures/, worst_points.json  page of the run
  recording/                                recording for Rerun, unless --no-rrd
  run.mcap                                  recording for Foxglove, with --mcap
  report.json, manifest.json                all numbers, and what made them
  scans.csv, matches.csv, stages.csv, errors.csv, precision_recall.csv
  table_<task>.{csv,md,tex}, table_times.md, table_stages.md
  protocols.json, protocol_*.csv, table_protocol_<name>.*  with --protocol

`scanbench run --add-to runs/latest -d pca` adds a detector to a finished run.
Unless -o names it, runs/latest points at it. With -o, an interrupted run goes on when
the same command is given again; --mcap, --detections-out and --save-rrd=FILE begin anew.";
