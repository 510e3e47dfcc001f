//! What experiments on simulated scans have in common.

use clap::Args;

use super::detectors::detector_names;
use super::parameters::ConfigArgs;

/// What experiments on simulated scans have in common.
#[derive(Debug, Args)]
pub struct ExperimentArgs {
    /// The detectors.
    #[arg(short, long, value_name = "NAMES", value_delimiter = ',', help = experiment_detectors_help())]
    pub detectors: Vec<String>,
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// Seed of all that is drawn
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

fn experiment_detectors_help() -> String {
    format!(
        "Detectors, by comma, of {} [default: all but pca for gaps, else all]",
        detector_names().join(", ")
    )
}
