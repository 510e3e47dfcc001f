//! A run over a grid of parameters: every combination of values on the same scans.

pub mod swept_values;
pub mod sweep_plan;
pub mod programs;
pub mod cells_of_scan;
pub mod scan_at_point;
pub mod quality_pass;
pub mod timing_pass;
pub mod sweep_tally;
pub mod drawn_sweep;
