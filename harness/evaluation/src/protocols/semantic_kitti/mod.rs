//! Scores of SemanticKITTI's labels: for every point its class and instance, whatever its range and however few points an
//! object has.

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
