//! What the protocols of others look at, in what detectors found.

pub mod kitti_object;
