//! Results of a run as an MCAP file for Foxglove and other readers of MCAP.

pub mod outcome_scene;
pub mod scan_numbers;
pub mod writer;
