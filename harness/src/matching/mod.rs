//! Which detection found which annotation.

pub mod outcome;
