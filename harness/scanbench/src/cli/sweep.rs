//! Arguments of `scanbench sweep`.

use std::path::PathBuf;

use clap::Args;
use evaluation::sweep::swept_values::{ListOption, SweepOption};

use super::detectors::detector_names;
use super::output::OutputArgs;
use super::parameters::MatchingArgs;
use super::scans::{DamageArgs, DatasetArgs};

/// Arguments of `scanbench sweep`.
#[derive(Debug, Args)]
#[command(after_help = SWEEP_EXAMPLES)]
pub struct SweepArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// What becomes of damaged ones; all scans are read once more to find them.
    #[command(flatten)]
    pub damage: DamageArgs,
    /// Give a parameter every value of a range, STOP included; or, for all points, a value, or a NUMBER over the value of a
    /// swept parameter (rounded where a count is asked for); may be repeated
    #[arg(short = 'P', long = "param", value_name = "NAME=START:STOP:STEP|VALUE|NUMBER/SWEPT")]
    #[arg(allow_hyphen_values = true)]
    pub parameters: Vec<SweepOption>,
    /// Give a parameter every value of a list; may be repeated
    #[arg(short = 'L', long = "list", value_name = "NAME=VALUE,VALUE,…")]
    pub lists: Vec<ListOption>,
    /// The detectors, in the order of the tables.
    #[arg(short, long, value_name = "NAMES", value_delimiter = ',', help = sweep_detectors_help(), hide_default_value = true)]
    #[arg(default_values = DETECTORS)]
    pub detectors: Vec<String>,
    /// TOML file that overrides parameters at all points, before any -P
    #[arg(short, long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// How detections are judged.
    #[command(flatten)]
    pub matching: MatchingArgs,
    /// Where the files are written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// Scans that are looked at at once; times are taken one after the other [default: number of cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Scans of each data set that are timed; 0 for no times
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pub timed_scans: u32,
    /// Write no Rerun recording
    #[arg(long)]
    pub no_rrd: bool,
}

/// What is swept unless something else is asked for.
const DETECTORS: [&str; 1] = ["hierarchical"];

fn sweep_detectors_help() -> String {
    format!("Detectors, by comma, of {} [default: {}]", detector_names().join(", "), DETECTORS.join(","))
}

const SWEEP_EXAMPLES: &str = "\
Examples:
  scanbench sweep streets -P cell_size_m=0.2:2.0:0.1
  scanbench sweep streets -P cell_size_m=0.4:1.0:0.2 -L xi=2,3 -o runs/cells
  scanbench sweep street-narrow -d kd-tree -P tolerance_m=0.3:0.8:0.1 -L foreground=short,refined
  scanbench sweep streets -P cell_size_m=0.2:2.0:0.1 -P min_length_cells=7.2/cell_size_m

All combinations of values are run on each scan; the first one that is swept is the
axis of plots. Leaves in the directory sweep.csv, with what every rate and every
reading of the cell fitness is made of, times.csv, f_rate_<data set>.svg,
pareto_<data set>.svg and manifest.json; where cell sizes are swept also
fitness_<data set>.svg, cell_fitness.csv and cell_fitness.md; and sweep.rrd, one
scan at all points, unless the program was built without Rerun.

A sweep that was ended goes on when the same command is given again: what is done is
in DIR.unfinished. The same sweep gives the same bytes, ended in between or not, but
for times (times.csv, pareto_*.svg, sweep.rrd) and the date in manifest.json.";
