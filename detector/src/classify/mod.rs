//! Classes of objects.

pub mod size_gate;

// Boosted trees, and the file of every trained model.
pub mod forest;
pub mod model_file;

// A support vector machine: its kernel, its training, its use.
mod rbf_kernel;
mod kernel_rows;
pub mod nu_svc_solver;
pub mod svm_model;
pub mod svm_training;
pub mod nu_svm;

// Which objects are road users.
pub mod road_user_forests;
pub mod vehicle_model;
pub mod paper_model;

// Which groups are objects, and which vehicles.
pub mod refinement_forests;
pub mod grouping_model;
