//! SemanticKITTI: KITTI's odometry drives with a label for every point, all round.

pub mod semantic_class;
pub mod label_file;
pub mod upright_components;
pub mod ground_truth;
pub mod pose_file;
pub mod sequence;
