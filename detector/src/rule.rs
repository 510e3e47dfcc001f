//! What a detector does beside finding clusters.

use std::fmt;

/// A rule that some detectors have and others have not, so that a comparison is not about clusters alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// Walls are no foreground.
    Walls,
    /// Trained trees say how well each group of points is an object. Those that are taken for one are kept, and beside them some that
    /// are taken for one a little less, if they are told vehicles. Walls are one of the values that the trees look at.
    TrainedGroups,
    /// Groups hold groups, and of all ways to part them that is taken which the trees like best.
    BestCut,
    /// A cluster of so few points is kept if a model takes it for a vehicle.
    SmallVehicles {
        /// How few.
        min_points: usize,
    },
    /// What has no vehicle's size is background, whatever a model would say.
    SizeBounds,
    /// Objects get the points in their boxes that are no foreground.
    Completion,
    /// Boxes are fitted anew to what the sensor sees, and are those of whole vehicles.
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
