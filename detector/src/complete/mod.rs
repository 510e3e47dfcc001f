//! The points of objects that are no foreground.

pub mod completion;
pub mod completed_object;
