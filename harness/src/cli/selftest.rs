//! Arguments of `scanbench selftest`.

use clap::Args;

use super::scans::DatasetArgs;

/// Arguments of `scanbench selftest`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  scanbench selftest ../data/kitti_tracking --scans 0..10")]
pub struct SelftestArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
}
