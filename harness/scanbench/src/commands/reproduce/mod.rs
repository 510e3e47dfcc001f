//! `scanbench reproduce`.

mod choose;
mod settings_study;
mod judge;
mod rate_tables;
mod papers_run;

use crate::cli::ReproduceArgs;
use crate::commands::failure::Failure;

/// Judges the claims of the papers, or chooses the values that they leave open.
pub fn reproduce(arguments: &ReproduceArgs) -> Result<(), Failure> {
    if arguments.choose { choose::choose(arguments) } else { papers_run::papers_run(arguments) }
}

/// The method of the papers.
const METHOD: &str = "paper";
