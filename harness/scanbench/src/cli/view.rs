//! Arguments of `scanbench view`.

use std::path::PathBuf;

use clap::builder::Resettable;
use clap::{Args, ValueEnum};

use super::help_text::{DATA, MISTAKES};
use super::stream::StreamArgs;

/// Arguments of `scanbench view`.
#[derive(Debug, Args)]
#[command(after_help = VIEW_EXAMPLES, next_help_heading = MISTAKES)]
pub struct ViewArgs {
    /// Run directory; before AFTER also a baseline
    #[arg(value_name = "RUN", help_heading = Resettable::Reset)]
    pub run: PathBuf,
    /// Directory of a later run over the same scans: list and show what changed since the first one
    #[arg(value_name = "AFTER", help_heading = Resettable::Reset)]
    pub after: Option<PathBuf>,
    /// Also fetch data from the addresses, and start the programs, that the run names
    #[arg(long, help_heading = DATA)]
    pub trust: bool,
    /// Number of mistakes, or changes, to list, the worst first
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub worst: u32,
    /// Detector to list mistakes of [default: the first of the run]
    #[arg(short, long, value_name = "NAME")]
    pub detector: Option<String>,
    /// Task to list mistakes of: objects, vehicles, or a class that detectors give
    #[arg(long, value_name = "TASK", default_value = "vehicles")]
    pub task: String,
    /// Only mistakes of this scan, or this one: as the list, the page and the gate name them
    #[arg(long, value_name = "SCAN[/OBJECT]")]
    pub at: Option<String>,
    /// Kind of mistake [default: both]
    #[arg(long, value_enum, value_name = "OUTCOME", conflicts_with = "after")]
    pub outcome: Option<OutcomeName>,
    /// Only mistakes with this annotated or detected class
    #[arg(long, value_name = "CLASS", conflicts_with = "after")]
    pub class: Option<String>,
    /// What is streamed to Rerun.
    #[command(flatten)]
    pub stream: StreamArgs,
}

/// Mistakes by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OutcomeName {
    /// Missed annotations
    Missed,
    /// False detections
    False,
    /// Detections that no other detector has, where nothing is labelled
    Alone,
}

const VIEW_EXAMPLES: &str = "\
Examples:
  scanbench view runs/latest
  scanbench view runs/latest --worst 30 --outcome missed --class van
  scanbench view runs/latest --at street-narrow/narrow-803597/000003
  scanbench view runs/latest -d pca --task objects --save-rrd=pca.rrd
  scanbench view runs/before runs/latest

Lists the mistakes with the most points first, each with its reason. Then runs their
scans again with the parameters of the run and records them as worst.rrd in the run
directory. Of two runs, lists what was lost first, then new false detections, other
classes, and what was gained, and records both side by side as changes.rrd, as they were
judged: nothing runs again. Paths of data are those of the run: start it in the same
folder. What a run of somebody else names is neither fetched nor started without --trust.";
