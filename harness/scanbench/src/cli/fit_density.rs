//! Arguments of `scanbench fit-density`.

use std::path::PathBuf;

use clap::Args;

use super::scans::DatasetArgs;

/// Arguments of `scanbench fit-density`.
#[derive(Debug, Args)]
#[command(after_help = FIT_DENSITY_EXAMPLES)]
pub struct FitDensityArgs {
    /// The scans, all of one sensor.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// File to write, which `scanbench run --config` takes
    #[arg(short, long, value_name = "FILE", default_value = "density.toml")]
    pub output: PathBuf,
    /// Write both curves, measured and fitted, as CSV and SVG into a directory
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// Replace file and directory if there are earlier ones
    #[arg(long)]
    pub overwrite: bool,
}

const FIT_DENSITY_EXAMPLES: &str = "\
Examples:
  scanbench fit-density ~/data/kitti_tracking -o density.toml --figures figures
  scanbench fit-density training-streets --seed 1000 --simulated-scans 40 --sensor my-sensor.toml
  scanbench run ~/data/kitti_tracking --config density.toml

Without such a file, a run takes the curve that comes with the program for the
sensor of each data set: hdl-64e-s2, hdl-32e, vlp-16 or os1-128.";
