//! What becomes of annotations, detections and points under the protocols that others publish numbers under.

pub mod semantic_kitti;
