//! Tables: the papers', made of the numbers of a run with one row a data set and the papers' figures beside ours; those of
//! studies; and those that say what a comparison came to.

pub mod paper_figures;
pub(crate) mod grid;
pub mod task_table;
pub(crate) mod task_grids;
pub(crate) mod notes;
pub mod terminal;
pub mod csv;
pub mod markdown;
pub mod latex;
pub mod times_table;
pub mod stage_table;
pub mod studies;
pub mod verdict;

#[cfg(test)]
pub(crate) mod sample;
