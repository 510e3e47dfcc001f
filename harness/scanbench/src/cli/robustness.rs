//! Arguments of `scanbench robustness`.

use std::path::PathBuf;

use clap::Args;

use super::experiment::{ExperimentArgs, experiment_detectors_help};
use super::help_text::{DATA, DETECTORS};
use super::output::OutputArgs;
use super::shard::ShardArgs;

/// Arguments of `scanbench robustness`.
#[derive(Debug, Args)]
#[command(after_help = ROBUSTNESS_EXAMPLES)]
#[command(mut_arg("detectors", |it| it.help(experiment_detectors_help(DETECTORS_BY_DEFAULT))))]
pub struct RobustnessArgs {
    /// Scans of each of the three kinds of street, under each condition
    #[arg(long, help_heading = DATA, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub scans: u32,
    /// Also run hierarchical with the trees in DIR, such as of fewer conditions, as "hierarchical, other training"
    ///
    /// DIR is what `scanbench train groupings` wrote.
    #[arg(long, value_name = "DIR", help_heading = DETECTORS)]
    pub other_training: Option<PathBuf>,
    /// Which part of them.
    #[command(flatten)]
    pub shard: ShardArgs,
    /// The detectors, in the order of the table.
    #[command(flatten)]
    pub detectors: ExperimentArgs,
    /// Where the tables are written.
    #[command(flatten)]
    pub output: OutputArgs,
}

const DETECTORS_BY_DEFAULT: &str = "hierarchical,kd-tree-tree,kd-tree,pca,simple-grid";

const ROBUSTNESS_EXAMPLES: &str = "\
Examples:
  scanbench robustness
  scanbench robustness --scans 20 --seed 7 -o runs/robustness
  scanbench robustness -d hierarchical -P walls.enabled=false
  scanbench robustness --other-training docs/models/streets-and-rain
  scanbench robustness --shard 1/2 -o shards  # and 2/2, then: scanbench merge shards

Simulates the same streets under one condition after another: slopes and hills,
kerbs, a truck ahead, mounting heights, sensors, rain, rolling shutter. Writes
robustness.csv with the counts behind every rate, robustness.md and the files of a
run whose data sets are the conditions.";
