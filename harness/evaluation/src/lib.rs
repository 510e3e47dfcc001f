//! Detectors run over labelled scans, and the outcome of every object: matching, metrics, runs, sweeps, training.
//!
//! Modules are declared in the order data reaches them; a module uses only modules declared above it.

pub mod journal;
pub mod scan_pass;
pub mod matching;
pub mod metrics;
pub mod object_box;
pub mod realism;
pub mod density_survey;
pub mod training;
pub mod partial;
pub mod process;
pub mod run;
pub mod protocols;
pub mod results_mcap;
pub mod streaming;
pub mod scoring;
pub mod sweep;
pub mod reproduction;
