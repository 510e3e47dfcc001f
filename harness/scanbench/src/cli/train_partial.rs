//! Arguments of `scanbench train --task partial`.

use clap::{Args, ValueEnum};

use super::help_text::TRAINING;

/// What the model of the task partial learns from.
#[derive(Debug, Args)]
#[command(next_help_heading = TRAINING)]
pub struct PartialTrainingArgs {
    /// Train for this task, from objects instead of scans
    #[arg(long, value_enum, value_name = "TASK", hide_short_help = true, conflicts_with_all = OF_SCANS)]
    pub task: Option<TrainedTask>,
    /// Objects to train on, one set after the other [default: simulated ones, as the shipped model]
    ///
    /// Simulated objects, of which the training part is taken, or folders with a folder for each class.
    #[arg(
        long,
        value_name = "OBJECTS,...",
        value_delimiter = ',',
        requires = "task",
        hide_short_help = true
    )]
    pub objects: Vec<String>,
    /// Simulated objects of each set and class [default: as the shipped model]
    #[arg(long, value_name = "N", requires = "task", hide_short_help = true, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub per_class: Option<u32>,
}

/// What only models of scans need.
const OF_SCANS: [&str; 24] = [
    "datasets",
    "scans",
    "format",
    "topic",
    "annotation_topic",
    "classes",
    "seed",
    "simulated_scans",
    "sensor",
    "sensor_height",
    "transform",
    "detector",
    "clusters",
    "vehicles",
    "others",
    "parts_and_pairs",
    "any_size",
    "prototypes",
    "gamma",
    "nu",
    "choice_seed",
    "held_out",
    "sensors",
    "hold_out_every",
];

/// A task that has a model of its own beside those of detectors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TrainedTask {
    /// What an object is of which a part has been seen
    Partial,
}
