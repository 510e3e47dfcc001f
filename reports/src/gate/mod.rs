//! One run judged by another over the same scans: whether they can be compared, what differs and how surely, which objects
//! changed, and the verdict.
//!
//! Nothing here looks at a detector's parameters: that they differ is what a comparison is for.

pub mod comparability;
pub mod paired_difference;
pub mod drift;
mod suggestion;
pub mod tolerances;
pub mod finding;
pub mod gated_metrics;
pub mod gated_speeds;
pub mod verdict;
mod wording;
pub mod comparison;
pub mod summary;
pub mod verdict_json;
pub mod junit;
pub mod benchmark_formats;
pub mod accept;
