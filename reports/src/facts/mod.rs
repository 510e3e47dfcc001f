//! All facts that are shown of a run: gathered row by row, during the run or from its directory.

pub mod seen_boxes;
pub mod gathered_run;
mod of_some_runs;
pub mod run_facts;
