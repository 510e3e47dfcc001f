//! Rules of a detector beside finding clusters.

use std::fmt;

/// A rule that only some detectors have. It matters when detectors are compared, beside their clusters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// Walls are no foreground.
    Walls,
    /// Trained trees predict the expected IoU of each group of points. Groups above a threshold are kept. Those a little
    /// below it are kept if they are classified as vehicles. Walls are one of the values that the trees look at.
    TrainedGroups,
    /// Groups hold groups; of all ways to cut them, the one with the highest predicted IoU is taken.
    BestCut,
    /// A cluster of few points, at least `min_points`, is kept if a model classifies it as a vehicle.
    SmallVehicles {
        /// Fewest points.
        min_points: usize,
    },
    /// Objects that do not have the size of a vehicle are background, whatever a model would predict.
    SizeBounds,
    /// Objects get the points in their boxes that are no foreground.
    Completion,
    /// Boxes are fitted anew to the seen points, and are those of whole vehicles.
    WholeBoxes,
}

impl fmt::Display for Rule {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Walls => formatter.write_str("walls removed"),
            Self::SmallVehicles { min_points } => write!(formatter, "vehicles from {min_points} points"),
            Self::SizeBounds => formatter.write_str("size bounds of vehicles"),
            Self::TrainedGroups => formatter.write_str("groups judged by trained trees"),
            Self::BestCut => formatter.write_str("best cut of groups within groups"),
            Self::Completion => formatter.write_str("completion"),
            Self::WholeBoxes => formatter.write_str("boxes of whole vehicles"),
        }
    }
}
