//! Scans as others evaluate them: from labels and detections to the rows that numbers of a protocol are made of.

pub mod official_objects;
pub mod official_protocol;
mod ranked_boxes;
pub mod nuscenes;
pub mod argoverse2;
pub mod kitti_object;
pub mod semantic_kitti;
pub mod known_protocols;
pub mod chosen_protocols;
