//! The arguments of `scanbench data get`.

use std::path::PathBuf;

use clap::Args;

use super::help_text::{DATA, OUTPUT};
use super::scans::CatalogueArgs;

/// Arguments of `scanbench data get`.
#[derive(Debug, Args)]
#[command(after_help = GET_EXAMPLES)]
pub struct GetArgs {
    /// Data set: an id of the catalogue
    #[arg(value_name = "DATASET")]
    pub dataset: String,
    /// Accept the licence, which is shown without this
    #[arg(long, help_heading = DATA)]
    pub accept_licence: bool,
    /// Drives to fetch, separated by commas [default: all]
    #[arg(long = "drive", value_name = "NAME", value_delimiter = ',', help_heading = DATA)]
    pub drives: Vec<String>,
    /// Fetch the file at this address, as its makers send it after a login
    #[arg(long, value_name = "URL", conflicts_with = "drives", help_heading = DATA)]
    pub link: Option<String>,
    /// Where ids are looked up.
    #[command(flatten)]
    pub catalogue: CatalogueArgs,
    /// Folder to fetch into [default: where the catalogue has the data set]
    #[arg(long, value_name = "DIR", help_heading = OUTPUT)]
    pub into: Option<PathBuf>,
    /// Size in GB that the files of an archive may have [default: 200 times that of the archive]
    #[arg(long, value_name = "GB", help_heading = OUTPUT, hide_short_help = true)]
    pub unpack_at_most: Option<u64>,
    /// Say what would be fetched, and fetch nothing
    #[arg(long, help_heading = OUTPUT)]
    pub dry_run: bool,
}

const GET_EXAMPLES: &str = "\
Examples:
  scanbench data get kitti-raw --drive 2011_09_26_drive_0001 --accept-licence
  scanbench data get nuscenes --link 'https://…/v1.0-mini.tgz?…' --accept-licence

After an interruption, the same command goes on with what has arrived (.NAME.partial-…).
Zip files are unpacked. SHA256SUMS has the checksums of all files. A server that sends
less than a kilobyte a second for a minute, or SCANBENCH_PATIENCE_S seconds, is given up.";
