//! Arguments of `scanbench partial`.

use clap::{Args, ValueEnum};

use super::data_objects::ObjectArgs;
use super::help_text::{JUDGING, TRAINING};
use super::output::OutputArgs;
use super::scans::SourceArgs;

/// Arguments of `scanbench partial`.
#[derive(Debug, Args)]
#[command(after_help = PARTIAL_EXAMPLES)]
pub struct PartialArgs {
    /// Objects that are judged: simulated ones, a folder with a folder for each class, or a data set
    #[arg(value_name = "OBJECTS", default_value = "objects-around")]
    pub objects: Vec<String>,
    /// Which objects.
    #[command(flatten)]
    pub choice: ObjectArgs,
    /// How data sets are opened.
    #[command(flatten)]
    pub source: SourceArgs,
    /// Objects to learn from [default: the training part of what is judged, or of objects-around]
    ///
    /// Of recorded objects that are also judged, every second is learned from, and the others are judged.
    #[arg(long, value_name = "OBJECTS", help_heading = TRAINING)]
    pub train: Option<String>,
    /// Learn from whole clouds, as the paper does, from parts, or each in turn
    #[arg(long, value_enum, value_delimiter = ',', value_name = "WHAT", default_value = "whole,parts", help_heading = TRAINING)]
    pub trained_on: Vec<LearnedFrom>,
    /// Compare the method with itself without each part, instead of with rivals
    #[arg(long, help_heading = JUDGING)]
    pub ablation: bool,
    /// Also fences, hedges and the like, which are none of the four
    #[arg(long, help_heading = JUDGING)]
    pub others: bool,
    /// Show objects of objects-approach as the drive does, and not step by step
    #[arg(long, help_heading = JUDGING)]
    pub drives: bool,
    /// Where everything is written.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// What methods learn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LearnedFrom {
    /// Whole clouds
    Whole,
    /// All parts of them
    Parts,
}

const PARTIAL_EXAMPLES: &str = "\
Examples:
  scanbench partial --per-class 60
  scanbench partial objects-approach --drives --per-class 60 --part judging
  scanbench partial ~/data/object_clouds --train ~/data/object_clouds
  scanbench partial ~/data/object_clouds --train objects-air

Every object is uncovered in ten steps, from below and from above, each a tenth of
its largest extent more.";
