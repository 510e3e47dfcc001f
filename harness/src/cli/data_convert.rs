//! The arguments of `scanbench data convert` and `scanbench data simulate`.

use std::path::PathBuf;

use clap::Args;

use super::scans::{DamageArgs, DatasetArgs};
use crate::conversion::mcap_writer::ChunkCompression;
use crate::conversion::output_format::OutputFormat;

/// Arguments of `scanbench data convert` and `scanbench data simulate`.
#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// What becomes of damaged ones.
    #[command(flatten)]
    pub damage: DamageArgs,
    /// File or folder to write; with several data sets, the folder to write them into
    #[arg(short, long, value_name = "PATH")]
    pub output: PathBuf,
    /// Format to write [default: mcap if the path ends in .mcap]
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub to: Option<OutputFormat>,
    /// How recordings are compressed
    #[arg(long, value_enum, value_name = "METHOD", default_value = "zstd")]
    pub compression: ChunkCompression,
}

pub(super) const CONVERT_EXAMPLES: &str = "\
Examples:
  scanbench data convert ~/data/kitti_tracking -o drive.mcap
  scanbench data convert recording.mcap --topic /lidar_top/points --to kitti-tracking -o drive
  scanbench data convert semantic-kitti --scans 0..100 --to mcap --compression lz4 -o out.mcap

Recordings keep everything: run on one gives the counts that the original gives.
The layouts of KITTI keep points and boxes; an object without a box gets the one
around its points. SemanticKITTI keeps points and which object they belong to.";

pub(super) const SIMULATE_EXAMPLES: &str = "\
Examples:
  scanbench data simulate street-narrow --seed 7 --simulated-scans 100 -o narrow.mcap
  scanbench data simulate streets --sensor vlp-16 --to semantic-kitti -o streets

What is written says that it is simulated, and of which seed.";
