//! Arguments of `scanbench ablation`.

use std::path::PathBuf;

use clap::Args;

use super::help_text::DETECTORS;
use super::output::OutputArgs;
use super::parameters::{ConfigArgs, MatchingArgs};
use super::scans::{BlocksArgs, DatasetArgs};
use super::shard::ShardArgs;
use super::timing::TimingArgs;

/// Arguments of `scanbench ablation`.
#[derive(Debug, Args)]
#[command(after_help = ABLATION_EXAMPLES)]
pub struct AblationArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Which of them belong together.
    #[command(flatten)]
    pub blocks: BlocksArgs,
    /// Which part of them.
    #[command(flatten)]
    pub shard: ShardArgs,
    /// Parameters of the whole method.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// How detections are judged.
    #[command(flatten)]
    pub matching: MatchingArgs,
    /// Also run variants with trees that were trained without the part
    ///
    /// DIR has folders such as without-walls and one-round, written by `train groupings` with
    /// `-P hierarchical.walls.enabled=false` and `-P hierarchical.grouping.rounds=1`.
    #[arg(long, value_name = "DIR", help_heading = DETECTORS)]
    pub models: Option<PathBuf>,
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
  scanbench ablation streets --shard 1/2 -o shards  # and 2/2, then: scanbench merge shards

Runs the whole method and one variant without each part. Writes ablation.csv,
ablation.md and the files of a run whose detectors are the variants:
  scanbench compare DIR --detectors 'whole method,without terrain'";
