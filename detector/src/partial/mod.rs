//! Bag of graphs: what an object is of which only a part has been seen, from how patterns of its surface occur.
//!
//! Objects are given in metres, in a frame with z up and the ground at z = 0. Paper: BG.

// Points, evened out, and what is around them.
pub mod thinned_points;
pub mod neighborhoods;
pub mod principal_frame;
pub mod level_spread;
pub mod seen_extents;
pub mod shape_statistics;

// Keypoints: where the surface turns most, and what it is like there.
pub mod local_surface;
pub mod keypoints;
pub mod hull_volume;
pub mod point_pair_angles;
pub mod patch_descriptor;

// Their labels, their graphs, and how often each pattern occurs.
pub mod k_means;
pub mod labels;
pub mod patterns;
pub mod bag;

// What that means.
pub mod decision;

// Their parameters, and how they follow each other.
pub mod partial_params;
pub mod keypoint_description;
pub mod partial_model;
pub mod partial_model_file;
pub mod partial_classifier;

// Learning all of it.
pub mod class_weights;
pub mod sharpness;
pub mod training;
