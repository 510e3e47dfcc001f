//! The worst mistakes of detectors: which they are, where, and what the sensor saw there.

pub mod mistakes;
pub mod suspects;
pub mod objects;
pub mod points;
pub mod recorded;
