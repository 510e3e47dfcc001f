//! What a detector does beside finding clusters.

use std::fmt;

/// A rule that some detectors have and others have not, so that a comparison is not about clusters alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// Walls are no foreground.
    Walls,
    /// Of all groupings that is taken which a trained model likes best, and beside it groups that it likes a little less, if they are
    /// told vehicles. Walls are one of its values.
    BestCut,
    /// A cluster of so few points is kept if a model takes it for a vehicle.
    SmallVehicles {
        /// How few.
        min_points: usize,
    },
    /// What has no vehicle's size is background, whatever a model would say.
    SizeBounds,
    /// Clusters are cut and joined where a model likes the parts, or the whole, better.
    Regrouping,
    /// Objects get the points in their boxes that are no foreground.
    Completion,
}

impl fmt::Display for Rule {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Walls => formatter.write_str("walls removed"),
            Self::SmallVehicles { min_points } => write!(formatter, "vehicles from {min_points} points"),
            Self::SizeBounds => formatter.write_str("size bounds of vehicles"),
            Self::Regrouping => formatter.write_str("regrouping"),
            Self::BestCut => formatter.write_str("best cut of a tree of groupings"),
            Self::Completion => formatter.write_str("completion"),
        }
    }
}
