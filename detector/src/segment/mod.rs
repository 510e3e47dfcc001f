//! From cells to separate objects.

pub mod terrain;
pub mod ground_segmentation;
pub mod hough_lines;
pub mod wall_refinement;
pub mod foreground;
pub mod connected_components;
pub mod disjoint_sets;
pub mod dense_reach;
pub mod dense_separation;
pub mod merge_graph;
pub mod object_points;
pub mod object_cells;
pub mod clusters;
