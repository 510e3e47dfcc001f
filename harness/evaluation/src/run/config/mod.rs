//! The parameters of a run: the shipped ones, overridden by a file, and then by options of the command line.

pub mod error;
pub mod slice_table;
mod matching_table;
mod parameter_tree;
mod value_problem;
mod vehicle_model_table;
mod detector_table;
mod override_file;
pub mod override_option;
pub mod run_config;
mod config_schema;

pub use config_schema::config_schema;
pub use detector_table::{DETECTOR_TABLE, TAKEN_NAMES, check_name};
pub use error::ConfigError;
pub use run_config::RunConfig;
pub use vehicle_model_table::{
    BOXES_FILE, CLUSTERS_FILE, COMPONENTS_FILE, GROUPINGS_FILE, NESTED_FILE, PAPER_FILE, PCA_FILE,
    TrainedModel, VEHICLE_MODEL, VEHICLE_MODEL_TOML, VehicleModels,
};
