//! Arguments of `scanbench train partial`.

use clap::Args;

use super::help_text::TRAINING;
use super::output::OutputArgs;
use super::scans::CatalogueArgs;

/// Arguments of `scanbench train partial`.
#[derive(Debug, Args)]
pub struct PartialTrainingArgs {
    /// The catalogue.
    #[command(flatten)]
    pub catalogue: CatalogueArgs,
    /// Objects to train on, one set after the other [default: simulated ones, as the shipped model]
    ///
    /// Simulated objects, of which the training part is taken, or folders with a folder for each class.
    #[arg(long, value_name = "OBJECTS,...", value_delimiter = ',', help_heading = TRAINING)]
    pub objects: Vec<String>,
    /// Simulated objects of each set and class [default: as the shipped model]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = TRAINING)]
    pub per_class: Option<u32>,
    /// Where the model is written.
    #[command(flatten)]
    pub output: OutputArgs,
}
