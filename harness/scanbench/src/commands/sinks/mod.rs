//! What watches a run, a file each.

mod csv_files;
pub mod plan_cells;
mod worst_mistakes;
pub mod terminal;
pub mod of_every_run;
pub mod mcap_results;
pub mod detection_files;
pub mod rerun_recording;
pub mod agreement_of_detectors;
pub mod protocol_rows;
