//! Argoverse 2, the sensor data set: sweeps of two lidars in the frame of the car, boxes all round.

pub mod log_truth;
pub mod sensor_logs;
