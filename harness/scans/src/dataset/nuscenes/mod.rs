//! nuScenes: scenes of twenty seconds, boxes all round on two scans a second.

pub mod table;
mod velocities;
pub mod world_objects;
pub mod lidar_tables;
pub mod keyframes;
