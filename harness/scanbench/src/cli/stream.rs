//! What is streamed to Rerun.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// What is streamed to Rerun.
#[derive(Debug, Clone, Args)]
#[allow(dead_code, reason = "read by the viewer, where there is one")]
pub struct StreamArgs {
    /// Save the Rerun recording as `run.rrd` in the run directory (the default), or as FILE
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    #[allow(clippy::option_option, reason = "both the option and its value may be left out")]
    pub save_rrd: Option<Option<PathBuf>>,
    /// Write no Rerun recording
    #[arg(
        long,
        conflicts_with_all = ["save_rrd", "connect", "spawn", "serve", "rerun_every", "rerun_points", "blueprint"]
    )]
    pub no_rrd: bool,
    /// Stream to a running Rerun viewer as well
    #[arg(long, value_name = "URL")]
    pub connect: Option<String>,
    /// Start a Rerun viewer and stream to it as well
    #[arg(long, conflicts_with = "connect")]
    pub spawn: bool,
    /// Serve the recording to viewers that connect to PORT of this machine as well, until Ctrl-C [default port: 9876]
    #[arg(
        long,
        value_name = "PORT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "9876",
        conflicts_with_all = ["connect", "spawn"]
    )]
    pub serve: Option<u16>,
    /// Record every Nth scan alone; all are evaluated
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub rerun_every: u32,
    /// Draw at most N points of a scan; detectors are given all
    #[arg(long, value_name = "N")]
    pub rerun_points: Option<usize>,
    /// Which tab of the recording is in front when it is opened
    #[arg(long, value_enum, value_name = "TAB", default_value = "compare")]
    pub blueprint: TabName,
}

/// Tabs of a recording by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TabName {
    /// Detectors side by side
    Compare,
    /// The first detector, stage by stage
    Stages,
    /// The drive in a frame that rests, where poses are known
    Drive,
}
