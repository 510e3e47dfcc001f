//! `report.html`: a run as one page that needs nothing else, neither network nor scripts.
//!
//! It is made of the files of the run directory alone, so that it can be made again at any time.

mod markup;
mod again;
mod document;
mod overview;
mod task_tables;
mod classes;
mod ranges;
mod recall_parts;
mod curves;
mod agreement;
mod times;
mod protocols;
mod errors;
mod worst;
mod labels;
mod reproduction;
mod parameters;
#[cfg(test)]
mod sample_run;
pub mod run_page;
pub mod history_page;
pub mod streaming_page;
pub mod sweep_page;
pub mod partial_page;
pub mod reproduction_page;
