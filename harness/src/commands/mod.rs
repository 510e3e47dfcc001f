//! The verbs of the command line: from arguments to work done and a result printed.

pub mod standard_streams;
pub mod failure;
pub mod progress;
pub mod interruption;
pub mod config;
pub mod open_datasets;
pub mod open_scan;
pub mod provenance;
pub mod run_directory;
pub mod run_rows;
pub mod run_manifest;
#[cfg(feature = "rerun")]
pub mod recording;
pub mod run;
pub mod ablation;
pub mod result_file;
pub mod detect;
pub mod selftest;
pub mod experiment;
pub mod gaps;
pub mod robustness;
pub mod data_list;
pub mod data_realism;
pub mod fit_density;
pub mod dispatch;
