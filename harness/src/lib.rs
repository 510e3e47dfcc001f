//! The evaluation half of scanbench: data sets, simulator, matching, metrics, runs and streams.
//!
//! Modules are declared in the order data reaches them; a module uses only what is declared above it.

pub mod annotation;
pub mod simulator;
pub mod dataset;
pub mod matching;
