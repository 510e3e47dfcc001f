//! Parameters of detectors and matching.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use evaluation::run::config::override_option::OverrideOption;

use super::help_text::{DETECTORS, JUDGING};

/// How detections are judged.
#[derive(Debug, Args)]
#[command(next_help_heading = JUDGING)]
pub struct MatchingArgs {
    /// How detections match
    ///
    /// The default is `points`, unless the configuration says otherwise.
    #[arg(long, value_enum, value_name = "RULE")]
    pub criterion: Option<CriterionName>,
    /// Judge nothing outside this slice of the configuration: [slice.NAME]
    #[arg(long, value_name = "NAME", hide_short_help = true)]
    pub only: Option<String>,
}

/// Names of the matching criteria.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CriterionName {
    /// Same points: intersection over union of at least 0.5
    Points,
    /// Boxes seen from above: intersection over union of at least 0.5
    BevIou,
    /// Boxes in space: intersection over union of at least 0.5
    #[value(name = "iou-3d")]
    Iou3d,
    /// Centres less than 2 m apart, seen from above
    Centre,
}

/// Parameters of detectors and matching.
#[derive(Debug, Args)]
#[command(next_help_heading = DETECTORS)]
pub struct ConfigArgs {
    /// TOML file with parameters of detectors and matching
    ///
    /// The manifest.json of every run lists all parameters under `config`. The file needs only those that differ.
    #[arg(short, long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Set one parameter; may be repeated
    ///
    /// It has priority over the file of -c. The last parts of a name are enough if only one parameter ends in them:
    /// `xi=2` sets `hierarchical.grid.xi`.
    #[arg(short = 'P', long = "param", value_name = "NAME=VALUE")]
    pub parameters: Vec<OverrideOption>,
}
