//! What an object is.

pub mod size_gate;

// A support vector machine: its kernel, its training, its file, its use.
mod rbf_kernel;
mod kernel_rows;
pub mod nu_svc_solver;
pub mod svm_model_error;
mod support_lists;
pub mod svm_model;
pub mod svm_training;
pub mod nu_svm;

// The vehicle model: features, and the machine that decides by them.
pub mod object_classifier;
pub mod vehicle_model;
pub mod paper_model;

// Boosted trees: their use, their file, and what they decide about groups.
pub mod forest;
pub mod forest_file;
pub mod object_looks;
pub mod grouping_model;
