//! What numbers are about: the words that rows, numbers, verdicts and tables share.

pub mod metric;
pub mod slice;
pub mod extent;
pub mod origin;
