//! The arguments of `scanbench data convert` and `scanbench data simulate`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use scans::conversion::mcap_writer::ChunkCompression;
use scans::conversion::output_format::OutputFormat;

use super::help_text::OUTPUT;
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
    /// File or folder to write; for several data sets, a folder for all
    #[arg(short, long, help_heading = OUTPUT, value_name = "PATH")]
    pub output: PathBuf,
    /// Format to write [default: mcap if the path ends in .mcap]
    #[arg(long, value_enum, value_name = "FORMAT", help_heading = OUTPUT)]
    pub to: Option<FormatName>,
    /// Compression of MCAP recordings
    #[arg(long, value_enum, value_name = "METHOD", default_value = "zstd", help_heading = OUTPUT)]
    pub compression: CompressionName,
}

/// Formats to write by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FormatName {
    /// MCAP: one recording with point clouds and scenes for Foxglove
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
    /// Smallest file
    Zstd,
    /// Larger file, faster to read
    Lz4,
    /// No compression
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

MCAP keeps everything: a run gives the same counts as on the original. The KITTI
formats keep points and boxes; an object without a box gets one around its points.
SemanticKITTI keeps points and the object that each belongs to.";

pub(super) const SIMULATE_EXAMPLES: &str = "\
Examples:
  scanbench data simulate street-narrow --seed 7 --simulated-scans 100 -o narrow.mcap
  scanbench data simulate streets --sensor vlp-16 --to semantic-kitti -o streets

The files say that they are simulated, and name the seed.";
