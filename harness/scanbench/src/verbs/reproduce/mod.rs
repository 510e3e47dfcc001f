//! `scanbench reproduce`.

mod settings_study;
mod choose;
mod partial_objects;
mod observations;
mod backgrounds;
mod judge;
mod rate_tables;
mod step_losses;
pub mod papers_run;

use crate::cli::ReproduceArgs;
use crate::plumbing::failure::Failure;

/// Judges the claims of the papers, or chooses the values that they leave open.
pub fn reproduce(arguments: &ReproduceArgs) -> Result<(), Failure> {
    match arguments.choose {
        Some(detector) => choose::choose(arguments, detector),
        None => papers_run::papers_run(arguments),
    }
}

const METHOD: &str = "paper";
