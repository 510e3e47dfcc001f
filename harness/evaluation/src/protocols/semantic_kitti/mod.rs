//! Scores of SemanticKITTI's labels, which have a class and an instance for every point, at any range and however few points
//! an object has.

pub mod label_numbers;
pub mod segment_overlaps;
pub mod instance_scores;
pub mod thing_counts;
pub mod same_label_clusters;
pub mod segmentation_entropies;
pub mod ground_points;
pub mod label_scores;

#[cfg(test)]
mod makers_numbers;
