//! All that is said about a run: gathered row by row, while it goes on or from its directory.

pub mod seen_boxes;
pub mod gathered_run;
mod of_some_runs;
pub mod run_facts;
