//! Arguments of `scanbench detect`.

use std::path::PathBuf;

use clap::Args;
use evaluation::run::detector_list::DETECTORS;

use super::detectors::detector_names;
use super::help_text::{DATA, DETECTORS as DETECTORS_HEADING, OUTPUT};
use super::parameters::ConfigArgs;
use super::scans::SourceArgs;

/// Arguments of `scanbench detect`.
#[derive(Debug, Args)]
#[command(after_help = DETECT_EXAMPLES)]
pub struct DetectArgs {
    /// File of a scan, such as a Velodyne `.bin`; or, with --scan, the id or path of a data set
    #[arg(value_name = "SCAN")]
    pub input: String,
    /// Scan of the data set: `0000/000110`, or `110` if only one drive has that number
    #[arg(long, value_name = "ID", help_heading = DATA)]
    pub scan: Option<String>,
    /// How the data set is opened.
    #[command(flatten)]
    pub source: SourceArgs,
    /// The detector.
    #[arg(short, long, value_name = "NAME", help = detector_help(), default_value = DETECTORS[0].name)]
    #[arg(help_heading = DETECTORS_HEADING)]
    pub detector: String,
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// Detect N times, and print the shortest and the median time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    #[arg(help_heading = DETECTORS_HEADING)]
    pub repeat: u32,
    /// File for the cluster of each point: `.csv` or `.u32`; `-` prints the CSV
    ///
    /// Rows are in the order of the points. 0 is no cluster; clusters are numbered from 1. In `.u32`, numbers have four
    /// bytes, little endian.
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT)]
    pub output: Option<PathBuf>,
    /// CSV file for the boxes; `-` prints it
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub boxes: Option<PathBuf>,
}

const DETECT_EXAMPLES: &str = "\
Examples:
  scanbench detect 000000.bin -o clusters.csv --boxes boxes.csv
  scanbench detect 000000.bin -d kd-tree -P tolerance_m=0.5 -P foreground=all -o clusters.u32
  scanbench detect street-narrow --seed 7 --scan narrow-7/000000 --sensor vlp-16 --repeat 20
  scanbench detect ~/data/kitti_tracking --scan 0000/000110 --boxes - | head

Clusters are numbered from 1; the column id of the boxes has the same numbers. Points
of no cluster have 0. Boxes of whole vehicles have a score of their own (box_score), the
sides that are seen, and whether the front is sure.";

fn detector_help() -> String {
    format!("Detector: {}, or one of scanbench.toml", detector_names().join(", "))
}
