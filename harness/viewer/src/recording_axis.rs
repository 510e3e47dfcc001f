//! The axis of a recording: the meaning of its time.

use super::entity_paths::SCAN_TIMELINE;

/// The timeline of a recording, and the meaning of its series.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingAxis {
    /// The name of the timeline, with the unit of its steps.
    pub timeline: String,
    /// Steps a second when it is played.
    pub steps_per_s: f64,
    /// Title of the F-rates, such as `F-rate so far`.
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

    /// Whether the axis is a swept parameter, and not the scans.
    pub fn is_of_a_sweep(&self) -> bool {
        self.timeline != SCAN_TIMELINE
    }
}
