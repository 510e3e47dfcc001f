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

// Boosted trees, and the file that trained ones come in.
pub mod forest;
pub mod model_file;

// Which objects are vehicles.
pub mod vehicle_model;
pub mod paper_model;

// Which groups are objects, and which vehicles.
pub mod object_looks;
pub mod grouping_model;
