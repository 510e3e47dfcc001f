//! What an object is.

pub mod size_gate;
mod rbf_kernel;
mod kernel_rows;
pub mod nu_svc_solver;
pub mod svm_model_error;
mod support_lists;
pub mod svm_model;
pub mod svm_training;
pub mod nu_svm;
pub mod object_classifier;
pub mod regrouping_params;
pub mod cut_places;
pub mod joinable;
pub mod regrouping;
