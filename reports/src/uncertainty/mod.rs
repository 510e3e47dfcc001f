//! Uncertainty of numbers: how they would vary with other scans.

pub mod wilson_interval;
pub mod bootstrap;
pub mod value_interval;
pub mod sample;
pub mod estimates;
mod time_estimates;
