//! Arguments of `scanbench sweep`.

use std::path::PathBuf;

use clap::Args;
use evaluation::sweep::swept_values::{ListOption, SweepOption};

use super::detectors::detector_names;
use super::help_text::{DETECTORS as DETECTORS_HEADING, VIEWER, with_details};
use super::output::OutputArgs;
use super::parameters::MatchingArgs;
use super::protocols::ProtocolArgs;
use super::scans::{BlocksArgs, DamageArgs, DatasetArgs};
use super::shard::ShardArgs;

/// Arguments of `scanbench sweep`.
#[derive(Debug, Args)]
#[command(after_help = SWEEP_EXAMPLES, after_long_help = with_details(SWEEP_EXAMPLES, SWEEP_DETAILS))]
pub struct SweepArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Which of them belong together.
    #[command(flatten)]
    pub blocks: BlocksArgs,
    /// Which part of them.
    #[command(flatten)]
    pub shard: ShardArgs,
    /// What becomes of damaged ones; all scans are read once more to find them.
    #[command(flatten)]
    pub damage: DamageArgs,
    /// Sweep a parameter over START:STOP:STEP, or set it; may be repeated
    ///
    /// NAME=START:STOP:STEP takes every value of the range, STOP included. NAME=VALUE sets one value. NAME=NUMBER/SWEPT
    /// divides NUMBER by the value of a swept parameter; counts are rounded.
    #[arg(short = 'P', long = "param", value_name = "NAME=RANGE")]
    #[arg(allow_hyphen_values = true, help_heading = DETECTORS_HEADING)]
    pub parameters: Vec<SweepOption>,
    /// Sweep a parameter over a list, such as xi=2,3; may be repeated
    #[arg(short = 'L', long = "list", value_name = "NAME=VALUES", help_heading = DETECTORS_HEADING)]
    pub lists: Vec<ListOption>,
    /// The detectors, in the order of the tables.
    #[arg(short, long, value_name = "NAMES", value_delimiter = ',', help = sweep_detectors_help(), hide_default_value = true)]
    #[arg(default_values = DETECTORS, help_heading = DETECTORS_HEADING)]
    pub detectors: Vec<String>,
    /// TOML file with parameters for all points; -P and -L have priority
    #[arg(short, long, value_name = "FILE", help_heading = DETECTORS_HEADING)]
    pub config: Option<PathBuf>,
    /// Scans to process at once; detections are timed one at a time [default: number of cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    #[arg(help_heading = DETECTORS_HEADING, hide_short_help = true)]
    pub jobs: Option<u16>,
    /// Scans of each data set to time; 0 times none
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    #[arg(help_heading = DETECTORS_HEADING)]
    pub timed_scans: u32,
    /// How detections are judged.
    #[command(flatten)]
    pub matching: MatchingArgs,
    /// What else they are evaluated by.
    #[command(flatten)]
    pub protocol: ProtocolArgs,
    /// Where the files are written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// Write no Rerun recording
    #[arg(long, help_heading = VIEWER)]
    pub no_rrd: bool,
}

/// What is swept unless something else is asked for.
const DETECTORS: [&str; 1] = ["hierarchical"];

fn sweep_detectors_help() -> String {
    format!(
        "Detectors, separated by commas: {} [default: {}]",
        detector_names().join(", "),
        DETECTORS.join(",")
    )
}

const SWEEP_EXAMPLES: &str = "\
Examples:
  scanbench sweep streets -P cell_size_m=0.2:2.0:0.1
  scanbench sweep streets -P cell_size_m=0.4:1.0:0.2 -L xi=2,3 -o runs/cells
  scanbench sweep street-narrow -d kd-tree -P tolerance_m=0.3:0.8:0.1 -L foreground=short,refined
  scanbench sweep streets -P cell_size_m=0.2:2.0:0.1 -P min_length_cells=7.2/cell_size_m
  scanbench sweep streets -L grouping.ranked_probability=0.05,0.2,0.5 --protocol nuscenes
  scanbench sweep streets -L xi=2,3 --shard 1/2 -o shards  # and 2/2, then: scanbench merge shards";

const SWEEP_DETAILS: &str = "\
Runs every combination of values on each scan. The first swept parameter is the axis
of the plots. Writes sweep.csv with the counts behind every rate and every reading of
the cell fitness, times.csv, f_rate_<data set>.svg, pareto_<data set>.svg and
manifest.json; if cell sizes are swept, also fitness_<data set>.svg, cell_fitness.csv
and cell_fitness.md; with --protocol, sweep_protocols.{csv,json,md,tex} and
protocol_<name>_<data set>.svg; and sweep.rrd, one scan at all points, unless the
program was built without Rerun.

To continue an interrupted sweep, give the same command again: its results so far are
in DIR.unfinished. The same sweep writes the same bytes, interrupted or not, except
times (times.csv, pareto_*.svg, sweep.rrd) and the date in manifest.json.

With --shard it looks at some of the scans, at all points; shards have no recording.";
