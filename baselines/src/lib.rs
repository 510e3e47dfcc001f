//! What the detectors of the papers must beat, behind the same trait.

pub mod kd_tree_components;
