//! Completion of objects by points that are no foreground.

pub mod completion;
pub mod completed_object;
