//! Where a verb leaves its files.

use std::path::PathBuf;

use clap::Args;

use super::help_text::{OUTPUT, VIEWER};

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

/// The option of studies without a recording, so that a script may give it to all studies.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = VIEWER)]
pub struct NoRecordingArgs {
    /// Allowed, as in all studies: this one never writes a Rerun recording
    #[arg(long, hide_short_help = true)]
    pub no_rrd: bool,
}
