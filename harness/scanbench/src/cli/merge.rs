//! Arguments of `scanbench merge`.

use std::path::PathBuf;

use clap::Args;

use super::output::OutputArgs;

/// Arguments of `scanbench merge`.
#[derive(Debug, Args)]
#[command(after_help = MERGE_EXAMPLES)]
pub struct MergeArgs {
    /// All shards of a run or of another study, in any order, or the folder that holds them
    #[arg(value_name = "SHARD", required = true)]
    pub shards: Vec<PathBuf>,
    /// Where the run is written.
    #[command(flatten)]
    pub output: OutputArgs,
}

const MERGE_EXAMPLES: &str = "\
Examples:
  scanbench run --shard 1/2 -o shards && scanbench run --shard 2/2 -o shards
  scanbench merge shards -o runs/whole
  scanbench sweep -L xi=2,3 --shard 1/1 -o cells && scanbench merge cells -o runs/cells

The result equals that of the verb in one piece, except for times. Shards are refused
(exit code 5) if one is missing or duplicate, or if data, parameters or programs
differ. Times of different processors are separate, in table_times.md and
times_of_processors.csv. docs/many-machines.md says more.";
