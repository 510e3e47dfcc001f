//! Sinks of a run beside its rows, a file each.

pub mod plan_cells;
pub mod terminal;
pub mod mcap_results;
pub mod detection_files;
pub mod rerun_recording;
