//! The evaluation half of scanbench: data sets, simulator, matching, metrics, runs and streams.
//!
//! Modules are declared in the order data reaches them; a module uses only what is declared above it.

pub mod annotation;
pub mod simulator;
pub mod dataset;
pub mod conversion;
pub mod data_check;
pub mod matching;
pub mod metrics;
pub mod object_box;
pub mod realism;
pub mod density_survey;
pub mod training;
pub mod run;
pub mod results_recording;
pub mod sweep;
#[cfg(feature = "rerun")]
pub mod stream;
pub mod cli;
pub mod commands;
