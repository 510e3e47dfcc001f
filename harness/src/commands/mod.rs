//! The verbs of the command line: from arguments to work done and a result printed.

pub mod standard_streams;
pub mod failure;
pub mod progress;
pub mod interruption;
pub mod open_datasets;
pub mod provenance;
pub mod run_directory;
pub mod run_rows;
pub mod run_manifest;
#[cfg(feature = "rerun")]
pub mod recording;
pub mod run;
pub mod selftest;
pub mod data_list;
pub mod data_realism;
pub mod fit_density;
pub mod dispatch;
