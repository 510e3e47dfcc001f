//! What became of the numbers of a branch, run by run.

pub mod change_points;
pub mod history_file;
pub mod trends;
pub mod since;
