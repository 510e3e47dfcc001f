//! How similar two collections of scans are, for example simulated and recorded ones.
//!
//! Every statistic has a type for its numbers of one scan, and a function that makes a pair of curves of both collections.

pub mod distribution;

// The statistics, a file each.
pub mod ring_density;
pub mod points_per_car;
pub mod whole_scans;
pub mod points_per_track;
pub mod height_histogram;
pub mod cell_classes;

// All of them, of many scans.
pub mod survey;
pub mod comparison;

#[cfg(test)]
pub(crate) mod drawn_scan;
