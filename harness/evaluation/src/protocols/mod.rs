//! Official protocols: rows made of labels and detections, from which the numbers of a protocol are made.

pub mod official_objects;
pub mod official_protocol;
mod ranked_boxes;
pub mod nuscenes;
pub mod nuscenes_agnostic;
pub mod argoverse2;
pub mod kitti_object;
pub mod semantic_kitti;
pub mod chosen_protocols;

/// Every protocol that evaluates boxes, in the order of tables.
pub const PROTOCOLS: &[&dyn official_protocol::OfficialProtocol] = &[
    &kitti_object::protocol::KittiObjectProtocol,
    &nuscenes::Nuscenes,
    &nuscenes_agnostic::NuscenesAgnostic,
    &argoverse2::Argoverse2,
];
