//! The verbs of `scanbench data`.

use clap::{Args, Subcommand};

use super::data_check::{CheckArgs, HashArgs};
use super::data_convert::{CONVERT_EXAMPLES, ConvertArgs, SIMULATE_EXAMPLES};
use super::data_prelabel::PrelabelArgs;
use super::output::OutputArgs;
use super::scans::{CatalogueArgs, DatasetArgs};

/// The verbs of `scanbench data`.
#[derive(Debug, Subcommand)]
pub enum DataCommand {
    /// List the data sets of the catalogue and whether they are there
    #[command(after_help = "Example:\n  scanbench data list --catalogue my-datasets.toml")]
    List(CatalogueArgs),
    /// Read scans and say what they are and what may be wrong with them
    Check(Box<CheckArgs>),
    /// Print the checksums of data sets, or write them into a catalogue
    Hash(HashArgs),
    /// Write scans and annotations in another format
    #[command(after_help = CONVERT_EXAMPLES)]
    Convert(Box<ConvertArgs>),
    /// Write scans with the vehicles that a detector finds, for an annotation tool to correct
    Prelabel(Box<PrelabelArgs>),
    /// Write simulated streets to disk, as others read them
    #[command(after_help = SIMULATE_EXAMPLES)]
    Simulate(Box<ConvertArgs>),
    /// Measure how like the scans of one data set are to those of another
    Realism(Box<RealismArgs>),
}

/// Arguments of `scanbench data realism`.
#[derive(Debug, Args)]
#[command(after_help = REALISM_EXAMPLES)]
pub struct RealismArgs {
    /// The scans that are judged.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Data set to judge by: an id of the catalogue, or a path
    #[arg(long, value_name = "DATASET")]
    pub against: String,
    /// Format of the data set to judge by, if it is given as a path
    #[arg(long, value_name = "FORMAT")]
    pub against_format: Option<String>,
    /// Which of its scans, as `--scans`
    #[arg(long, value_name = "RANGE")]
    pub against_scans: Option<String>,
    /// Where curves and plots are written.
    #[command(flatten)]
    pub output: OutputArgs,
}

const REALISM_EXAMPLES: &str = "\
Examples:
  scanbench data realism --against ~/data/kitti_tracking
  scanbench data realism street-main-road --seed 7 --against kitti-tracking -o look
  scanbench data realism kitti-object --against kitti-tracking --against-scans 0..40

Compares returns, share of ground, density, points per car, clusters, heights and
cells of the scans, bin by bin. Leaves in the directory realism.csv, with every
bin, a plot of each statistic as SVG, and manifest.json.";
