//! The meaning of numbers: how detectors rank in a run, and one run judged by another over the same scans.
//!
//! Nothing here looks at a detector's parameters: that they differ is what a comparison is for.

pub mod paired_difference;
pub mod protocol_differences;
pub mod partial_differences;
pub mod comparability;
pub mod classes_of_both;
pub mod times_doubt;
pub mod task_ranking;
pub mod run_sentence;
pub mod reason_gains;
pub mod change;
pub mod drift;
pub mod changed_claims;
pub mod suggestion;
pub mod rule_problems;
pub mod tolerances;
pub mod tolerances_file;
pub mod built_in_tolerances;
pub mod annotated_tolerances;
pub mod least_loss;
pub mod finding;
pub mod gated_metrics;
mod gated_protocols;
pub mod gated_streams;
mod gated_objects;
pub mod verdict;
pub mod accept;
pub mod fitness_verdict;
