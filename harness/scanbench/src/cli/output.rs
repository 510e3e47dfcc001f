//! Where a verb leaves its files.

use std::path::PathBuf;

use clap::Args;

/// Where a verb leaves its files.
#[derive(Debug, Args)]
pub struct OutputArgs {
    /// Directory to write [default: one in `runs/`, named after time and data sets]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Replace the directory if there is an earlier one
    #[arg(long)]
    pub overwrite: bool,
}
