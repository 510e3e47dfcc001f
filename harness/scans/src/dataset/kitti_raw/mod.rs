//! KITTI's raw recordings: whole drives, boxes in the frame of the sensor where the left colour camera sees.

pub mod tracklet_file;
pub mod drive_calibration;
pub mod inertial_poses;
pub mod drives;
