//! The words that rows, numbers, verdicts and tables share.

pub mod named;
pub mod study;
pub mod shard;
pub mod class_traits;
pub mod class;
pub mod taxonomy;
pub mod task;
pub mod partial_class;
pub mod criterion;
pub mod forecast;
pub mod reason;
pub mod formula;
pub mod metric;
pub mod own_slice;
pub mod slice;
pub mod origin;
pub mod extent;
pub mod protocol;
pub mod thing_class;
pub mod ground_definition;
pub mod claim_verdict;
