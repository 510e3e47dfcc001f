//! Arguments of `scanbench detect`.

use std::path::PathBuf;

use clap::Args;
use evaluation::run::detector_list::DETECTORS;

use super::detectors::detector_names;
use super::parameters::ConfigArgs;
use super::scans::SourceArgs;

/// Arguments of `scanbench detect`.
#[derive(Debug, Args)]
#[command(after_help = DETECT_EXAMPLES)]
pub struct DetectArgs {
    /// Scan: a Velodyne `.bin` file; or, with --scan, a data set: its id in the catalogue or its path
    #[arg(value_name = "SCAN")]
    pub input: String,
    /// Which scan of a data set: `0000/000110`, or `110` if only one drive has a scan of that number
    #[arg(long, value_name = "ID")]
    pub scan: Option<String>,
    /// The detector.
    #[arg(short, long, value_name = "NAME", help = detector_help(), default_value = DETECTORS[0].name)]
    pub detector: String,
    /// File for the cluster of every point, in the order of the scan: `.csv`, or `.u32` (little endian, 4294967295
    /// for points of no cluster); `-` prints the CSV
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// CSV file for the boxes; `-` prints it
    #[arg(long, value_name = "FILE")]
    pub boxes: Option<PathBuf>,
    /// Height of the sensor above the road in metres [default: the data set's; 1.73 for a file]
    #[arg(long, value_name = "M", value_parser = sensor_height_m)]
    pub sensor_height: Option<f32>,
    /// Parameters.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// Detections of the scan; with several, the least and the median of their times are printed
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub repeat: u32,
    /// How the data set is opened.
    #[command(flatten)]
    pub source: SourceArgs,
}

const DETECT_EXAMPLES: &str = "\
Examples:
  scanbench detect 000000.bin -o clusters.csv --boxes boxes.csv
  scanbench detect 000000.bin -d kd-tree -P tolerance_m=0.5 -P foreground=all -o clusters.u32
  scanbench detect street-narrow --scan 10 --sensor vlp-16 --repeat 20
  scanbench detect ~/data/kitti_tracking --scan 0000/000110 --boxes - | head

Clusters are numbered from 0, as in the column id of the boxes. Points of no
cluster have an empty one. Files are written whole or not at all.";

pub(super) fn detector_help() -> String {
    format!("Detector: {}", detector_names().join(", "))
}

/// A height from that of the road itself, for clouds that are given from there, to that of a house.
fn sensor_height_m(text: &str) -> Result<f32, String> {
    let height_m: f32 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (0.0..=100.0).contains(&height_m) { Ok(height_m) } else { Err("outside of 0 to 100 m".to_owned()) }
}
