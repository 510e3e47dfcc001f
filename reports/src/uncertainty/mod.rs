//! How sure numbers are: what they would be, had other scans been seen.

pub mod wilson_interval;
pub mod bootstrap;
pub mod value_interval;
pub mod sample;
pub mod estimates;
mod time_estimates;
