//! What is streamed to Rerun.

use std::path::PathBuf;

use clap::Args;

/// What is streamed to Rerun.
#[derive(Debug, Args)]
pub struct StreamArgs {
    /// Save the Rerun recording as `run.rrd` in the run directory (the default), or as FILE
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    pub save_rrd: Option<Option<PathBuf>>,
    /// Write no Rerun recording
    #[arg(long, conflicts_with_all = ["save_rrd", "connect", "spawn"])]
    pub no_rrd: bool,
    /// Stream to a running Rerun viewer as well
    #[arg(long, value_name = "URL")]
    pub connect: Option<String>,
    /// Start a Rerun viewer and stream to it as well
    #[arg(long, conflicts_with = "connect")]
    pub spawn: bool,
}
