//! Separate objects found among cells.

// Which points are foreground.
pub mod ground_plane;
pub mod terrain;
pub mod ground_segmentation;
pub mod hough_lines;
pub mod wall_segments;
pub mod wall_params;
pub mod walls;
pub mod printed_walls;
pub mod cut_off_walls;
pub mod wall_refinement;
pub mod foreground;
pub mod ground_points;

// Which of them belong together.
pub mod dense_level;
pub mod connected_components;
pub mod disjoint_sets;
pub mod dense_reach;
pub mod expected_density;
pub mod dense_separation;
pub mod object_points;

// Clusters, for detectors that label points instead of cells.
pub mod clusters;

#[cfg(test)]
pub(crate) mod drawn_ground;
