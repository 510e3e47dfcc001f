//! Which detection found which annotation.

pub mod outcome;
pub mod hungarian;
pub mod point_overlap;
pub mod box_overlap;
pub mod criterion;
pub mod eligibility;
pub mod assign;
pub mod mistake;
