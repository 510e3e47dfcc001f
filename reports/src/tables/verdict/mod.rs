//! What verdicts look like, for people and for other programs.

pub mod standing;
mod wording;
pub mod comparison;
pub mod summary;
pub mod verdict_json;
pub mod junit;
pub mod benchmark_formats;
