//! Arguments of `scanbench view`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use reports::vocabulary::task::Task;

use super::stream::StreamArgs;

/// Arguments of `scanbench view`.
#[derive(Debug, Args)]
#[command(after_help = VIEW_EXAMPLES)]
pub struct ViewArgs {
    /// Run directory
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// How many of the worst mistakes
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub worst: u32,
    /// Whose mistakes [default: those of the first detector of the run]
    #[arg(short, long, value_name = "NAME")]
    pub detector: Option<String>,
    /// At what
    #[arg(long, value_enum, value_name = "TASK", default_value = "vehicles")]
    pub task: TaskName,
    /// Of which kind [default: both]
    #[arg(long, value_enum, value_name = "OUTCOME")]
    pub outcome: Option<OutcomeName>,
    /// Only what is annotated as CLASS, or was taken for it
    #[arg(long, value_name = "CLASS")]
    pub class: Option<String>,
    /// What is streamed to Rerun.
    #[command(flatten)]
    pub stream: StreamArgs,
}

/// Tasks by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TaskName {
    /// Anything that stands on the street
    Objects,
    /// Vehicles against background
    Vehicles,
}

impl TaskName {
    /// The task.
    pub fn task(self) -> Task {
        match self {
            Self::Objects => Task::Objects,
            Self::Vehicles => Task::Vehicles,
        }
    }
}

/// Mistakes by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OutcomeName {
    /// Annotations that nothing found
    Missed,
    /// Detections of nothing
    False,
}

const VIEW_EXAMPLES: &str = "\
Examples:
  scanbench view runs/latest
  scanbench view runs/latest --worst 30 --outcome missed --class van
  scanbench view runs/latest -d pca --task objects --save-rrd=pca.rrd

Lists the mistakes with most points first, and why each is one. The scans they are in are
run again, as the manifest of the run says, and recorded alone, the worst first:
in worst.rrd of the run directory unless --save-rrd=FILE or --no-rrd says otherwise.
Paths of data are taken from the run: start it in the same folder.";
