//! The content of verdicts, before a format lays it out.

pub(crate) mod wording;
pub(crate) mod tolerated;
pub mod comparison;
pub mod comparison_in_short;
pub mod summary;
pub mod brief;
