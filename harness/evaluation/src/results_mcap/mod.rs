//! What detectors made of the scans of a run, as an MCAP file for Foxglove and whatever else reads MCAP.

pub mod outcome_scene;
pub mod scan_numbers;
pub mod writer;
