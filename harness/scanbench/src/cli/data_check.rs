//! The arguments of `scanbench data check` and `scanbench data hash`.

use clap::Args;

use super::help_text::OUTPUT;
use super::scans::{CatalogueArgs, DamageArgs, DatasetArgs};

/// Arguments of `scanbench data check`.
#[derive(Debug, Args)]
#[command(after_help = CHECK_EXAMPLES)]
pub struct CheckArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// What becomes of damaged ones.
    #[command(flatten)]
    pub damage: DamageArgs,
}

const CHECK_EXAMPLES: &str = "\
Examples:
  scanbench data check ~/data/kitti_tracking
  scanbench data check recording.mcap --topic /lidar_top/points --scans 0..1000:10

Prints the numbers of points, annotations and points in boxes, the height of the
ground and the density of points; and warnings about boxes without points, gaps in
time and repeated scans. Exit code 3 if a scan is damaged, unless --skip-damaged.";

/// Arguments of `scanbench data hash`.
#[derive(Debug, Args)]
#[command(after_help = HASH_EXAMPLES)]
pub struct HashArgs {
    /// Data sets: ids of the catalogue, or paths
    #[arg(value_name = "DATASET", required = true)]
    pub datasets: Vec<String>,
    /// Where ids are looked up.
    #[command(flatten)]
    pub catalogue: CatalogueArgs,
    /// Write the checksums into the file of --catalogue
    #[arg(long, help_heading = OUTPUT, requires = "catalogue")]
    pub write: bool,
}

const HASH_EXAMPLES: &str = "\
Examples:
  scanbench data hash ~/data/kitti_tracking
  scanbench data hash my-drive --catalogue my-datasets.toml --write

The checksum is of the content of labels, and of the names and sizes of files with scans,
which would take long to read. If the catalogue has one, every verb refuses data that
differ from it. scans.csv of a run has a checksum of the content of every scan, by which
`gate` and `compare` see any change.";
