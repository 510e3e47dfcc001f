//! Tables: the papers', made of the numbers of a run with one row a data set and the papers' figures beside ours; those of
//! studies; and those of comparisons. Their content is apart from the formats that they are written in.

pub mod paper_figures;
pub(crate) mod grid;
pub mod task_table;
pub(crate) mod notes;
pub(crate) mod folding;
pub mod sheet;
pub(crate) mod task_grids;
pub mod class_table;
pub mod slice_table;
pub mod times_table;
pub mod stage_table;
pub mod error_table;
pub mod protocol_in_short;
pub mod protocol_table;
pub mod agreement_table;
pub mod run_in_short;
pub mod studies;
pub mod verdict;
pub mod formats;

#[cfg(test)]
pub(crate) mod sample;
