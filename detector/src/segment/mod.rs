//! From cells to separate objects.

pub mod terrain;
pub mod ground_segmentation;
// Between ground and foreground belongs the refinement of walls (HG section 3.1, Hough transform).
pub mod foreground;
pub mod connected_components;
pub mod disjoint_sets;
pub mod dense_reach;
pub mod dense_separation;
pub mod object_points;
pub mod clusters;
