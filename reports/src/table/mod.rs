//! Tables: the papers', made of the numbers of a run with one row a data set and the papers' figures beside ours; that of
//! what each part of a method is worth; those of experiments; and that of how well the statistics of two collections of
//! scans agree.

pub mod task_table;
pub mod ablation_score;
pub mod sweep_score;
pub mod sweep_curve;
pub mod fitness_verdict;
pub(crate) mod grid;
pub(crate) mod task_grids;
pub(crate) mod notes;
pub mod terminal;
pub mod agreement;
pub mod csv;
pub mod markdown;
pub mod latex;
pub mod times_table;
pub mod stage_table;
pub mod ablation_table;
pub mod gap_table;
pub mod box_table;
pub mod robustness_table;
pub mod sweep_table;
pub mod fitness_table;

#[cfg(test)]
pub(crate) mod sample;
