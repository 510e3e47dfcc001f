//! `scanbench train`.

pub mod data;
pub mod clusters;
pub mod files;
pub mod summary;
pub mod cross_validation;
pub mod svm;
pub mod groupings;
pub mod cluster_model;
pub mod rivals;
pub mod boxes;
pub mod partial;
