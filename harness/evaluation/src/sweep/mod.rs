//! A run over a grid of parameters: every combination of values on the same scans.

pub mod swept_values;
pub mod sweep_plan;
pub mod programs;
pub mod scan_at_point;
pub mod journal_entry;
pub mod quality_pass;
pub mod timing_pass;
pub mod sweep_tally;
pub mod block_resamples;
pub mod summary;
pub mod paired_points;
