//! Tables: the papers', made of the numbers of a run with one row a data set and the papers' figures beside ours, and
//! those of comparisons and experiments.

pub mod task_table;
mod grid;
mod task_grids;
mod notes;
pub mod terminal;
pub mod agreement;
pub mod csv;
pub mod markdown;
pub mod latex;
pub mod gap_table;
pub mod robustness_table;

#[cfg(test)]
mod sample;
