//! Arguments of `scanbench boxes`.

use clap::Args;

use super::output::OutputArgs;
use super::parameters::{ConfigArgs, MatchingArgs};
use super::scans::{BlocksArgs, DatasetArgs};

/// Arguments of `scanbench boxes`.
#[derive(Debug, Args)]
#[command(after_help = BOXES_EXAMPLES)]
pub struct BoxesArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Which of them belong together.
    #[command(flatten)]
    pub blocks: BlocksArgs,
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

Fits boxes to each cluster of the hierarchical detector that matches an annotated car,
van, truck or bus: to its convex hull, along its principal axes, closest to its points,
and along the outline that the sensor sees. The fifth is the reported box. Writes
boxes.csv with every box; box_errors.csv and box_errors.md with median errors and
shares by class, occlusion, range and number of points, and 95 % intervals;
box_points.csv with the positions of points in the boxes of each class; a plot and a
picture of these points for simulated data and each recorded data set; manifest.json.";
