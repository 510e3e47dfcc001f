//! Arguments of `scanbench boxes`.

use clap::Args;

use super::output::OutputArgs;
use super::parameters::{ConfigArgs, MatchingArgs};
use super::scans::DatasetArgs;

/// Arguments of `scanbench boxes`.
#[derive(Debug, Args)]
#[command(after_help = BOXES_EXAMPLES)]
pub struct BoxesArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Parameters of the hierarchical detector and of matching.
    #[command(flatten)]
    pub config: ConfigArgs,
    /// How clusters are matched.
    #[command(flatten)]
    pub matching: MatchingArgs,
    /// Where tables and plots are written.
    #[command(flatten)]
    pub output: OutputArgs,
}

const BOXES_EXAMPLES: &str = "\
Examples:
  scanbench boxes
  scanbench boxes streets ~/data/kitti_tracking -o runs/boxes

Fits a box to the convex hull and one along the principal axes to the same
clusters: those of the hierarchical detector that match an annotated car, van,
truck or bus, whatever it takes them for. Leaves in the directory boxes.csv, with
every box, box_errors.csv and box_errors.md, with the median errors by occlusion
and range and their 95 % intervals, a plot for simulated data and for each
recorded data set, and manifest.json.";
