//! What experiments on simulated scans have in common.

use clap::Args;

use super::detectors::detector_names;
use super::help_text::{DATA, DETECTORS};
use super::parameters::ConfigArgs;

/// What experiments on simulated scans have in common.
#[derive(Debug, Args)]
pub struct ExperimentArgs {
    /// The detectors.
    #[arg(short, long, value_name = "NAMES", value_delimiter = ',', help_heading = DETECTORS)]
    #[arg(help = experiment_detectors_help("simple-grid,hierarchical,kd-tree"))]
    pub detectors: Vec<String>,
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// Seed of the simulator
    #[arg(long, help_heading = DATA, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Help of `--detectors` where `default` run if none is named.
pub fn experiment_detectors_help(default: &str) -> String {
    format!("Detectors, separated by commas: {} [default: {default}]", detector_names().join(", "))
}
