//! Arguments of `scanbench reproduce`.

use clap::{Args, ValueEnum};

use super::help_text::DETECTORS;
use super::output::OutputArgs;
use super::scans::DatasetArgs;
use super::timing::TimingArgs;

/// Arguments of `scanbench reproduce`.
#[derive(Debug, Args)]
#[command(after_help = REPRODUCE_EXAMPLES)]
pub struct ReproduceArgs {
    /// Which paper: hg (objects over a hierarchical grid), vm (vehicles by their model), or all
    #[arg(value_enum, ignore_case = true, default_value = "all", help_heading = clap::builder::Resettable::Reset)]
    pub paper: PaperName,
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// Joint settings of the values that the papers leave open, under each of which the claims are judged, too
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    #[arg(help_heading = DETECTORS)]
    pub settings: u32,
    /// Seed of the draw of settings
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = DETECTORS)]
    pub settings_seed: u64,
    /// Choose the values that the papers leave open by these scans, instead of judging claims
    #[arg(long, help_heading = DETECTORS, conflicts_with_all = ["output", "overwrite", "warmup"])]
    pub choose: bool,
    /// Where the page and the tables are written.
    #[command(flatten)]
    pub output: OutputArgs,
    /// What runs beside what.
    #[command(flatten)]
    pub timing: TimingArgs,
}

/// A paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PaperName {
    /// Objects over a hierarchical grid
    Hg,
    /// Vehicles by their model
    Vm,
    /// Both
    All,
}

impl PaperName {
    /// As it is written on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hg => "hg",
            Self::Vm => "vm",
            Self::All => "all",
        }
    }
}

const REPRODUCE_EXAMPLES: &str = "\
Examples:
  scanbench reproduce                              both papers, on simulated streets
  scanbench reproduce all streets ~/data/kitti_tracking -o runs/papers
  scanbench reproduce hg --settings 1000
  scanbench reproduce all --choose training-streets --scans 0..300:6

Runs the method of the papers and its rivals, judges each claim of the papers, and says
under which of the values that they leave open it holds. Writes reproduction.html, .md,
.tex and .json, settings.csv, and the files of a run.";
