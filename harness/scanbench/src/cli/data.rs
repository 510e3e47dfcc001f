//! The verbs of `scanbench data`.

use clap::{Args, Subcommand};

use super::data_check::{CheckArgs, HashArgs};
use super::data_convert::{CONVERT_EXAMPLES, ConvertArgs, SIMULATE_EXAMPLES};
use super::data_get::GetArgs;
use super::data_objects::DataObjectsArgs;
use super::data_prelabel::PrelabelArgs;
use super::help_text::{DATA, JUDGING};
use super::output::OutputArgs;
use super::scans::{CatalogueArgs, DatasetArgs, SourceArgs};

/// The verbs of `scanbench data`.
#[derive(Debug, Subcommand)]
pub enum DataCommand {
    /// List the data sets of the catalogue, and which are on this machine
    #[command(after_help = "Example:\n  scanbench data list --catalogue my-datasets.toml")]
    List(CatalogueArgs),
    /// Fetch a public data set of the catalogue
    Get(GetArgs),
    /// Write an entry for a data set into a catalogue of your own
    Add(Box<AddArgs>),
    /// Check scans and annotations, and print what may be wrong
    Check(Box<CheckArgs>),
    /// Print checksums of data sets, or write them into a catalogue
    Hash(HashArgs),
    /// Convert scans and annotations to another format
    #[command(after_help = CONVERT_EXAMPLES)]
    Convert(Box<ConvertArgs>),
    /// Write detected vehicles as proposals for an annotation tool
    Prelabel(Box<PrelabelArgs>),
    /// Simulate streets and write them to disk
    #[command(after_help = SIMULATE_EXAMPLES)]
    Simulate(Box<ConvertArgs>),
    /// Write single objects, simulated or cut out of a data set, a folder for each class
    Objects(Box<DataObjectsArgs>),
    /// Compare the statistics of two data sets, such as simulated and recorded
    Realism(Box<RealismArgs>),
}

/// Arguments of `scanbench data add`.
#[derive(Debug, Args)]
#[command(after_help = ADD_EXAMPLES)]
pub struct AddArgs {
    /// Path of the data set
    #[arg(value_name = "PATH")]
    pub path: String,
    /// Its id in the catalogue [default: the name of the folder]
    #[arg(long, value_name = "ID", help_heading = DATA)]
    pub id: Option<String>,
    /// Its licence
    #[arg(long, value_name = "TEXT", help_heading = DATA)]
    pub licence: Option<String>,
    /// How it is opened.
    #[command(flatten)]
    pub source: SourceArgs,
}

const ADD_EXAMPLES: &str = "\
Examples:
  scanbench data add ~/data/robot --catalogue mine.toml
  scanbench data add ~/data/robot --id robot-yard --sensor vlp-16 --catalogue mine.toml
  scanbench run robot-yard --catalogue mine.toml

Reads the first scans, and writes sensor and height as they show them, unless the
options say otherwise. Adds to the catalogue, or makes it; other entries do not change.";

/// Arguments of `scanbench data realism`.
#[derive(Debug, Args)]
#[command(after_help = REALISM_EXAMPLES)]
pub struct RealismArgs {
    /// The scans that are judged.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Data set to compare with: an id of the catalogue, or a path
    #[arg(long, help_heading = JUDGING, value_name = "DATASET")]
    pub against: String,
    /// Format of that data set, if it is a path [default: recognised by its files]
    #[arg(long, help_heading = JUDGING, hide_short_help = true, value_name = "FORMAT")]
    pub against_format: Option<String>,
    /// Scans to take from it, written as in --scans
    #[arg(long, help_heading = JUDGING, value_name = "RANGE")]
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
cells, bin by bin. Writes realism.csv with every bin, an SVG plot of each statistic,
and manifest.json.";
