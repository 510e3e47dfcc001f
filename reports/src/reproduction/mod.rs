//! The claims of the papers, judged.

pub mod claim;
pub mod steps;
pub mod judged_claim;
pub mod lead;
pub mod sensitivity;
