//! Captures of the packets that Velodyne's sensors send.

pub mod capture_file;
pub mod laser_table;
pub mod calibration_file;
pub mod data_packet;
pub mod turns;
pub mod revolutions;
