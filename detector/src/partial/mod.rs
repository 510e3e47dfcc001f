//! Bag of graphs: classifies objects of which only a part has been seen, by how often patterns of their surface occur.
//!
//! Objects are given in metres, in a frame with z up and the ground at z = 0. Paper: BG.

// Points, evened out, and their neighbourhoods.
pub mod thinned_points;
pub mod neighborhoods;
pub mod principal_frame;
pub mod level_spread;
pub mod seen_extents;
pub mod shape_statistics;

// Keypoints, where the surface turns most, and their descriptors.
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

// The decision by these.
pub mod decision;

// Parameters, and the order of the stages.
pub mod partial_params;
pub mod keypoint_description;
pub mod partial_model;
pub mod partial_model_file;
pub mod partial_classifier;

// Training.
pub mod class_weights;
pub mod sharpness;
pub mod training;
