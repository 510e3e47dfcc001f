//! Arguments of `scanbench compare`.

use std::path::PathBuf;

use clap::Args;

/// Arguments of `scanbench compare`.
#[derive(Debug, Args)]
#[command(after_help = COMPARE_EXAMPLES)]
pub struct CompareArgs {
    /// Run directory
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Directory of another run over the same scans
    #[arg(value_name = "RUN", required_unless_present = "detectors")]
    pub other: Option<PathBuf>,
    /// Compare two detectors of one run instead
    #[arg(
        short,
        long,
        value_name = "NAME,NAME",
        value_delimiter = ',',
        num_args = 1,
        conflicts_with = "other"
    )]
    pub detectors: Option<Vec<String>>,
    /// Compare every slice as well: by class, range, number of points and occlusion
    #[arg(long)]
    pub slices: bool,
    /// Print Markdown
    #[arg(long)]
    pub markdown: bool,
}

const COMPARE_EXAMPLES: &str = "\
Examples:
  scanbench compare runs/before runs/after
  scanbench compare runs/latest -d kd-tree,hierarchical
  scanbench compare runs/before runs/after --slices --markdown > slices.md

Every difference comes with a 95 % interval, for which both sides are drawn from
in the same way, and with the least difference that the scans could have shown.";
