//! What the journal of a sweep holds.

use serde::{Deserialize, Serialize};

use crate::sweep::scan_at_point::ScanAtPoint;
use crate::sweep::timed_scan::TimedScan;

/// A result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JournalEntry {
    /// Of the detections.
    Quality(ScanAtPoint),
    /// Of the clock.
    Times(TimedScan),
}
