//! The parameters of a run: those that ship, overridden by a file.

pub mod error;
mod matching_table;
mod override_file;
pub mod run_config;

pub use error::ConfigError;
pub use run_config::RunConfig;
