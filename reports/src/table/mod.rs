//! Tables: the papers', made of the numbers of a run with one row a data set and the papers' figures beside ours, and
//! that of how well the statistics of two collections of scans agree.

pub mod task_table;
mod grid;
mod task_grids;
mod notes;
pub mod terminal;
pub mod agreement;
pub mod csv;
pub mod markdown;
pub mod latex;

#[cfg(test)]
mod sample;
