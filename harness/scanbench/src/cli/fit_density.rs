//! Arguments of `scanbench fit-density`.

use std::path::PathBuf;

use clap::Args;

use super::help_text::OUTPUT;
use super::scans::DatasetArgs;

/// Arguments of `scanbench fit-density`.
#[derive(Debug, Args)]
#[command(after_help = FIT_DENSITY_EXAMPLES)]
pub struct FitDensityArgs {
    /// The scans, all of one sensor.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// File to write, for --config
    #[arg(short, long, help_heading = OUTPUT, value_name = "FILE", default_value = "density.toml")]
    pub output: PathBuf,
    /// Directory for the measured and the fitted curve, as CSV and SVG
    #[arg(long, help_heading = OUTPUT, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// Replace file and directory if they exist
    #[arg(long, help_heading = OUTPUT)]
    pub overwrite: bool,
}

const FIT_DENSITY_EXAMPLES: &str = "\
Examples:
  scanbench fit-density ~/data/kitti_tracking -o density.toml --figures figures
  scanbench fit-density training-streets --seed 1000 --simulated-scans 40 --sensor my-sensor.toml
  scanbench run ~/data/kitti_tracking --config density.toml

The curve says how the density of points falls with the range. All scans must be of
one sensor. The program has curves for hdl-64e-s2, hdl-32e, vlp-16, os1-128 and
argoverse2. For another sensor, `scanbench run` learns one from five scans.";
