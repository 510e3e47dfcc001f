//! What verdicts say, before a format lays it out.

pub(crate) mod wording;
pub mod comparison;
pub mod summary;
