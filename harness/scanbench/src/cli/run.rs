//! Arguments of `scanbench run`.

use clap::Args;
use evaluation::run::detector_list::DEFAULT_DETECTORS;

use super::detectors::detectors_help;
use super::output::OutputArgs;
use super::parameters::{ConfigArgs, MatchingArgs};
use super::scans::{DamageArgs, DatasetArgs};
use super::stream::StreamArgs;
use super::timing::TimingArgs;

/// Arguments of `scanbench run`.
#[derive(Debug, Args)]
#[command(after_help = RUN_EXAMPLES)]
pub struct RunArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// What becomes of damaged ones.
    #[command(flatten)]
    pub damage: DamageArgs,
    /// The detectors, in the order of the tables.
    #[arg(short, long, value_name = "NAMES", value_delimiter = ',', help = detectors_help(), hide_default_value = true)]
    #[arg(default_values = DEFAULT_DETECTORS)]
    pub detectors: Vec<String>,
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// How detections are judged.
    #[command(flatten)]
    pub matching: MatchingArgs,
    /// Where the run directory is written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// Record scans and results for Foxglove as well: run.mcap in the run directory, of several data sets one each
    #[arg(long)]
    pub mcap: bool,
    /// What runs beside what.
    #[command(flatten)]
    pub timing: TimingArgs,
    /// What is streamed to Rerun.
    #[command(flatten)]
    pub stream: StreamArgs,
}

const RUN_EXAMPLES: &str = "\
Examples:
  scanbench run
  scanbench run --seed 7 --simulated-scans 100 --sensor vlp-16 -o runs/seed-7
  scanbench run ~/data/kitti_tracking -d hierarchical,pca --criterion centre
  scanbench run kitti-tracking -P tolerance_m=0.7 -P matching.min_points=50
  scanbench run street-narrow --mcap
  scanbench run kitti-tracking --connect rerun+http://127.0.0.1:9876/proxy

Leaves in the run directory, which runs/latest points at unless -o names it:
manifest.json, report.json, scans.csv, matches.csv, precision_recall.csv,
table_<task>.{csv,md,tex}, table_times.md, table_stages.md, worst_points.json,
report.html, figures/ and, unless --no-rrd, run.rrd for the Rerun viewer; with --mcap
run.mcap for Foxglove.";
