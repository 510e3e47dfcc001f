//! Rows for every scan, object, detection or point: all that numbers are made of.

pub mod counts;
pub mod scan_name;
pub mod scan_row;
pub mod stage_row;
pub mod pose_row;
pub mod match_outcome;
pub mod match_row;
pub mod confusion_row;
pub mod error_row;
pub mod suspect_row;
pub mod box_row;
pub mod cluster_of_point;
pub mod training_row;
pub mod agreement_row;
pub mod partial_row;
pub mod kitti_object_row;
pub mod ranked_box_row;
pub mod label_score_row;
pub mod official_rows;
