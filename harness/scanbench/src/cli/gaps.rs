//! Arguments of `scanbench gaps`.

use clap::Args;

use super::experiment::ExperimentArgs;
use super::help_text::DATA;
use super::output::OutputArgs;
use super::scans::sensor_help;

/// Arguments of `scanbench gaps`.
#[derive(Debug, Args)]
#[command(after_help = GAPS_EXAMPLES)]
pub struct GapsArgs {
    /// Pairs of each kind, layout and range; each is simulated with every gap
    #[arg(long, help_heading = DATA, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub pairs: u32,
    /// Sensor.
    #[arg(long, help_heading = DATA, value_name = "SENSOR", default_value = "hdl-64e-s2", help = sensor_help())]
    pub sensor: String,
    /// The detectors, in the order of tables and plots.
    #[command(flatten)]
    pub detectors: ExperimentArgs,
    /// Where curves and plots are written.
    #[command(flatten)]
    pub output: OutputArgs,
}

const GAPS_EXAMPLES: &str = "\
Examples:
  scanbench gaps
  scanbench gaps --pairs 100 --seed 7 -o runs/gaps
  scanbench gaps -d hierarchical,pca --sensor os1-128

Simulates pairs on an empty road: two cars, a car and a pedestrian, two pedestrians,
a car and a sign, a car and a bin; side by side and one behind the other, 0.2 to
1.2 m apart, 5 to 30 m away. Writes gaps.csv with every bin and its denominator,
gaps.svg and one plot for each kind of pair, pair.svg (a pair from above, as
simple-grid and hierarchical segment it) and the files of a run on these scans.";
