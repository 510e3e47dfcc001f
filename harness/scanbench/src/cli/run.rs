//! Arguments of `scanbench run`.

use std::num::NonZeroUsize;

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
    /// How often each detector looks at each scan, in turns with the others and with the reference that `gate` measures times
    /// by; the shortest of all counts there, the first everywhere else
    #[arg(long, value_name = "N", default_value = "1", value_parser = repeats)]
    pub repeats: NonZeroUsize,
    /// What is streamed to Rerun.
    #[command(flatten)]
    pub stream: StreamArgs,
}

/// Number of repetitions.
fn repeats(text: &str) -> Result<NonZeroUsize, String> {
    let number = text.parse().ok().filter(|it: &NonZeroUsize| it.get() <= 1000);
    number.ok_or_else(|| "not a number from 1 to 1000".to_owned())
}

const RUN_EXAMPLES: &str = "\
Examples:
  scanbench run
  scanbench run --seed 7 --simulated-scans 100 --sensor vlp-16 -o runs/seed-7
  scanbench run ~/data/kitti_tracking -d hierarchical,pca --criterion centre
  scanbench run kitti-tracking -P tolerance_m=0.7 -P matching.min_points=50
  scanbench run street-narrow --mcap
  scanbench run --repeats 5                     times for a gate
  scanbench run kitti-tracking --connect rerun+http://127.0.0.1:9876/proxy

Leaves in the run directory, which runs/latest points at unless -o names it:
manifest.json, report.json, scans.csv, matches.csv, stages.csv,
precision_recall.csv, table_<task>.{csv,md,tex}, table_times.md, table_stages.md, worst_points.json,
report.html, figures/ and, unless --no-rrd, run.rrd for the Rerun viewer; with --mcap
run.mcap for Foxglove.";
