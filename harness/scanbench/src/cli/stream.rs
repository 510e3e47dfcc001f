//! What is streamed to Rerun.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueEnum};

use super::help_text::VIEWER;

/// What is streamed to Rerun.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = VIEWER)]
#[allow(dead_code, reason = "read by the viewer, where there is one")]
pub struct StreamArgs {
    /// Save the Rerun recording as FILE, all in one [default: layers in the folder `recording` of the run directory, or a file of the verb: `worst.rrd`, `changes.rrd`, `suspects.rrd`]
    #[arg(long, hide_short_help = true, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    #[allow(clippy::option_option, reason = "both the option and its value may be left out")]
    pub save_rrd: Option<Option<PathBuf>>,
    /// Write no Rerun recording
    #[arg(
        long,
        conflicts_with_all = ["save_rrd", "connect", "spawn", "serve", "rerun_every", "rerun_points", "blueprint"]
    )]
    pub no_rrd: bool,
    /// Stream to a running Rerun viewer, too
    ///
    /// For example, `rerun+http://127.0.0.1:9876/proxy`.
    #[arg(long, value_name = "URL")]
    pub connect: Option<String>,
    /// Start a Rerun viewer and stream to it, too
    #[arg(long, hide_short_help = true, conflicts_with = "connect")]
    pub spawn: bool,
    /// Serve the recording to Rerun viewers at PORT of this machine until Ctrl-C, too [default port: 9876]
    #[arg(
        long,
        hide_short_help = true,
        value_name = "PORT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "9876",
        conflicts_with_all = ["connect", "spawn"]
    )]
    pub serve: Option<u16>,
    /// Record only every Nth scan; all are evaluated [default: 1, or more so that at most 2000 scans are recorded]
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub rerun_every: Option<u32>,
    /// Record at most N points of a scan, or `all` [default: one in each cube of 10 cm, or of 25 cm in recordings of more
    /// than 20 scans]; detectors get all
    #[arg(long, hide_short_help = true, value_name = "N")]
    pub rerun_points: Option<RecordedPoints>,
    /// Tab that the recording opens with
    #[arg(long, hide_short_help = true, value_enum, value_name = "TAB", default_value = "compare")]
    pub blueprint: TabName,
}

/// Scans of a recording, unless more are asked for. Its index is in memory until its end and grows by a tenth of a megabyte
/// with each.
const MOST_RECORDED: usize = 2000;

impl StreamArgs {
    /// Every so many of `n_scans` scans are recorded.
    pub fn every(&self, n_scans: usize) -> u32 {
        self.rerun_every.unwrap_or_else(|| n_scans.div_ceil(MOST_RECORDED).max(1) as u32)
    }
}

/// How many points of a scan are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code, reason = "read by the viewer, where there is one")]
pub enum RecordedPoints {
    /// All.
    All,
    /// At most so many.
    AtMost(usize),
}

impl FromStr for RecordedPoints {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "all" => Ok(Self::All),
            _ => text.parse().map(Self::AtMost).map_err(|_| "neither a number nor `all`".to_owned()),
        }
    }
}

/// Tabs of a recording by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TabName {
    /// Detectors side by side
    Compare,
    /// The first detector, stage by stage
    Stages,
    /// The drive in a fixed frame, if its poses are known
    Drive,
}
