//! Arguments of `scanbench selftest`.

use clap::Args;

use super::scans::{DamageArgs, DatasetArgs};

/// Arguments of `scanbench selftest`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  scanbench selftest ../data/kitti_tracking --scans 0..10")]
pub struct SelftestArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// What becomes of damaged ones.
    #[command(flatten)]
    pub damage: DamageArgs,
}
