//! Arguments of `scanbench report`.

use std::path::PathBuf;

use clap::Args;

/// Arguments of `scanbench report`.
#[derive(Debug, Args)]
#[command(after_help = REPORT_EXAMPLES)]
pub struct ReportArgs {
    /// Directory of a run or of a sweep
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
}

const REPORT_EXAMPLES: &str = "\
Examples:
  scanbench report runs/latest
  scanbench report runs/cell-sizes         of a sweep: its plots and its table

Makes report.html and figures/ again from the other files of the run directory alone. The
page needs no network and no scripts. Of worst_points.json, which every run leaves, it takes
what the sensor saw around the worst mistakes; without it, these are drawn as boxes alone.";
