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
  scanbench report runs/cell-sizes         a sweep

Makes report.html and figures/ from the other files of the run directory; no data set
is read. The page needs no network and no scripts. Without worst_points.json, the
pictures of the worst mistakes show boxes only, no points.";
