//! Arguments of `scanbench serve`.

use std::path::PathBuf;

use clap::Args;

use super::detectors::detector_names;
use super::help_text::{DETECTORS, with_details};
use super::parameters::ConfigArgs;

/// Arguments of `scanbench serve`.
#[derive(Debug, Args)]
#[command(after_help = SERVE_EXAMPLE, after_long_help = with_details(SERVE_EXAMPLE, SERVE_DETAILS))]
pub struct ServeArgs {
    /// The detector.
    #[arg(value_name = "NAME", help = served_help(), help_heading = DETECTORS)]
    pub detector: String,
    /// Folder with DRIVE/NNNNNN.csv, which `results` answers
    #[arg(long, value_name = "DIR", help_heading = DETECTORS, required_if_eq("detector", RESULTS), hide_short_help = true)]
    pub results: Option<PathBuf>,
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
}

/// Name of the detector that answers what files say.
pub const RESULTS: &str = "results";

fn served_help() -> String {
    format!(
        "Detector: {}; or `nothing`, which finds nothing, or `{RESULTS}` of files",
        detector_names().join(", ")
    )
}

const SERVE_EXAMPLE: &str = "\
Example, in scanbench.toml:
  [detector.served]
  command = [\"scanbench\", \"serve\", \"kd-tree\"]";

const SERVE_DETAILS: &str = "\
Messages come and go through two pipes, whose numbers are in the environment;
docs/protocol.md describes them.";
