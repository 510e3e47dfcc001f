//! Where a verb leaves its files.

use std::path::PathBuf;

use clap::Args;

use super::help_text::OUTPUT;

/// Where a verb leaves its files.
#[derive(Debug, Args)]
#[command(next_help_heading = OUTPUT)]
pub struct OutputArgs {
    /// Directory to write [default: a new one in `runs/`]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Replace the directory if it exists
    #[arg(long)]
    pub overwrite: bool,
}
