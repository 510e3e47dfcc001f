//! What the time of a recording counts.

use super::entity_paths::SCAN_TIMELINE;

/// The timeline of a recording, and what its series are.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingAxis {
    /// The name of the timeline, with the unit of its steps.
    pub timeline: String,
    /// Steps a second when it is played.
    pub steps_per_s: f64,
    /// What the F-rates are of.
    pub rates: String,
    /// Names of further series, a view each.
    pub further_series: Vec<&'static str>,
}

impl RecordingAxis {
    /// One scan after the other.
    pub fn scans() -> Self {
        Self {
            timeline: SCAN_TIMELINE.to_owned(),
            steps_per_s: 10.0,
            rates: "F-rate so far".to_owned(),
            further_series: Vec::new(),
        }
    }

    /// Whether it is a parameter, and not scans, that goes on.
    pub fn is_of_a_sweep(&self) -> bool {
        self.timeline != SCAN_TIMELINE
    }
}
