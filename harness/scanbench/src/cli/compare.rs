//! Arguments of `scanbench compare`.

use std::path::PathBuf;

use clap::Args;

use super::help_text::{DETECTORS, OUTPUT};

/// Arguments of `scanbench compare`.
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of the command line")]
#[derive(Debug, Args)]
#[command(after_help = COMPARE_EXAMPLES)]
pub struct CompareArgs {
    /// Run directory
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Directory of another run over the same scans
    #[arg(value_name = "RUN", required_unless_present = "detectors")]
    pub other: Option<PathBuf>,
    /// Two detectors of one run; of two runs those to compare
    #[arg(
        short,
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        num_args = 1,
        help_heading = DETECTORS
    )]
    pub detectors: Option<Vec<String>>,
    /// Compare slices, too: by class, range, number of points and occlusion
    #[arg(long, help_heading = OUTPUT)]
    pub slices: bool,
    /// Print all numbers, not only those that detectors are known by and those that surely differ
    #[arg(long, help_heading = OUTPUT)]
    pub full: bool,
    /// Also write the table as CSV, Markdown and LaTeX, and a figure, into this directory
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub output: Option<PathBuf>,
    /// Replace the directory if it exists
    #[arg(long, requires = "output", help_heading = OUTPUT)]
    pub overwrite: bool,
    /// Print Markdown
    #[arg(long, help_heading = OUTPUT)]
    pub markdown: bool,
}

const COMPARE_EXAMPLES: &str = "\
Examples:
  scanbench compare runs/before runs/after
  scanbench compare runs/before runs/after -d hierarchical
  scanbench compare runs/latest -d kd-tree,hierarchical
  scanbench compare runs/before runs/after --slices --markdown > slices.md
  scanbench compare runs/latest -d kd-tree,hierarchical -o paper/comparison

Every difference has a 95 % interval from a paired bootstrap, and the smallest
difference that such scans can show.";
