//! The arguments of `scanbench data convert` and `scanbench data simulate`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use scans::conversion::mcap_writer::ChunkCompression;
use scans::conversion::output_format::OutputFormat;

use super::scans::{DamageArgs, DatasetArgs};

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
    pub to: Option<FormatName>,
    /// How recordings are compressed
    #[arg(long, value_enum, value_name = "METHOD", default_value = "zstd")]
    pub compression: CompressionName,
}

/// Formats to write by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FormatName {
    /// One recording with clouds and scenes as Foxglove has them
    Mcap,
    /// KITTI tracking: drives with tracks
    KittiTracking,
    /// KITTI object: single scans
    KittiObject,
    /// `SemanticKITTI`: drives with a label for every point
    SemanticKitti,
}

impl FormatName {
    /// The format.
    pub fn format(self) -> OutputFormat {
        match self {
            Self::Mcap => OutputFormat::Mcap,
            Self::KittiTracking => OutputFormat::KittiTracking,
            Self::KittiObject => OutputFormat::KittiObject,
            Self::SemanticKitti => OutputFormat::SemanticKitti,
        }
    }
}

/// Ways to compress a recording by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CompressionName {
    /// Smallest
    Zstd,
    /// Fastest to read of the compressed ones
    Lz4,
    /// Not at all
    None,
}

impl CompressionName {
    /// The way.
    pub fn compression(self) -> ChunkCompression {
        match self {
            Self::Zstd => ChunkCompression::Zstd,
            Self::Lz4 => ChunkCompression::Lz4,
            Self::None => ChunkCompression::None,
        }
    }
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
