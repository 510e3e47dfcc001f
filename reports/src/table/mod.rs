//! The papers' table, made of the numbers of a run: one row a data set, the papers' figures beside ours.

pub mod task_table;
mod grid;
mod task_grids;
mod notes;
pub mod terminal;
pub mod csv;
pub mod markdown;
pub mod latex;

#[cfg(test)]
mod sample;
