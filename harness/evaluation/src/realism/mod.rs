//! How like one collection of scans is to another: simulated ones to recorded ones, say.
//!
//! Every statistic has what it takes from one scan, and the pair of curves that both collections make of it.

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
