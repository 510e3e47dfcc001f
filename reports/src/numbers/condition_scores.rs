//! What detectors find under one condition after another.

use crate::numbers::blocks::Interval;
use crate::rows::counts::Counts;
use crate::vocabulary::task::Task;

/// What was counted under one condition.
#[derive(Debug, Clone, PartialEq)]
pub struct ConditionScores {
    /// What conditions of this kind have in common, such as `sensor`.
    pub group: String,
    /// The condition, such as `vlp-16`.
    pub condition: String,
    /// Whether trees that come with the program were trained under it, on other drives.
    pub trained: bool,
    /// Number of scans.
    pub n_scans: u64,
    /// What each detector found, in the order of the columns.
    pub detectors: Vec<DetectorRates>,
}

/// What one detector found.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectorRates {
    /// Its name.
    pub detector: String,
    /// Of all objects.
    pub objects: RateOfTask,
    /// Of the vehicles.
    pub vehicles: RateOfTask,
}

/// What was found in one task.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateOfTask {
    /// What was found, missed and false.
    pub counts: Counts,
    /// How sure the F-rate is, where that is known.
    pub f_rate_within: Option<Interval>,
}

impl DetectorRates {
    /// What was found in each task.
    pub fn tasks(&self) -> [(Task, RateOfTask); 2] {
        [(Task::Objects, self.objects), (Task::Vehicles, self.vehicles)]
    }
}
