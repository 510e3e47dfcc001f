//! What detectors find under one condition after another.

use crate::rows::counts::Counts;
use crate::vocabulary::task::Task;

/// What was counted under one condition.
#[derive(Debug, Clone, PartialEq)]
pub struct ConditionScores {
    /// What conditions of this kind have in common, such as `sensor`.
    pub group: String,
    /// The condition, such as `vlp-16`.
    pub condition: String,
    /// Number of scans.
    pub n_scans: u64,
    /// What each detector found, in the order of the columns.
    pub detectors: Vec<DetectorCounts>,
}

/// What one detector found.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectorCounts {
    /// Its name.
    pub detector: String,
    /// Of all objects.
    pub objects: Counts,
    /// Of the vehicles.
    pub vehicles: Counts,
}

impl DetectorCounts {
    /// What was found in each task.
    pub fn tasks(&self) -> [(Task, Counts); 2] {
        [(Task::Objects, self.objects), (Task::Vehicles, self.vehicles)]
    }
}
