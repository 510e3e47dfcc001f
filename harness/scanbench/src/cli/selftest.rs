//! Arguments of `scanbench selftest`.

use clap::Args;

use super::protocols::ProtocolArgs;
use super::scans::{DamageArgs, DatasetArgs};

/// Arguments of `scanbench selftest`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  scanbench selftest ../data/kitti_tracking --scans 0..10\n  scanbench selftest streets --protocol nuscenes"
)]
pub struct SelftestArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// What becomes of damaged ones.
    #[command(flatten)]
    pub damage: DamageArgs,
    /// What else is tested.
    #[command(flatten)]
    pub protocol: ProtocolArgs,
}
