//! The arguments of `scanbench data check` and `scanbench data hash`.

use clap::Args;

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

Reads the scans and says what they are, how many points, annotations and points in
boxes there are, where the ground is, how dense points are, and what may be wrong:
boxes without points, gaps in time, repeated scans. Exit code 3 if a scan is damaged,
unless --skip-damaged.";

/// Arguments of `scanbench data hash`.
#[derive(Debug, Args)]
#[command(after_help = HASH_EXAMPLES)]
pub struct HashArgs {
    /// Ids of the catalogue, or paths of data sets
    #[arg(value_name = "DATASET", required = true)]
    pub datasets: Vec<String>,
    /// Write the checksums into the catalogue, which is to be named by --catalogue
    #[arg(long, requires = "catalogue")]
    pub write: bool,
    /// Where ids are looked up.
    #[command(flatten)]
    pub catalogue: CatalogueArgs,
}

const HASH_EXAMPLES: &str = "\
Examples:
  scanbench data hash ~/data/kitti_tracking
  scanbench data hash my-drive --catalogue my-datasets.toml --write

A data set of the catalogue whose files have another checksum is refused by every verb.";
