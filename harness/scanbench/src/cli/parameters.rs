//! Parameters of detectors and matching.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use evaluation::run::config::override_option::OverrideOption;

/// How detections are judged.
#[derive(Debug, Args)]
pub struct MatchingArgs {
    /// When a detection may match an annotation
    #[arg(long, value_enum, value_name = "CRITERION")]
    pub criterion: Option<CriterionName>,
}

/// Names of the matching criteria.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CriterionName {
    /// Point sets agree: intersection over union of at least 0.5
    Points,
    /// Boxes agree on the ground plan: intersection over union of at least 0.5
    BevIou,
    /// Boxes agree in space: intersection over union of at least 0.5
    #[value(name = "iou-3d")]
    Iou3d,
    /// Centres are less than 2 m apart on the ground plan
    Centre,
}

/// Parameters of detectors and matching.
#[derive(Debug, Args)]
pub struct ConfigArgs {
    /// TOML file that overrides parameters of detectors and matching, by the names under `config` in manifest.json
    #[arg(short, long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Override one parameter, after the file; may be repeated. The end of a name will do where only one parameter of
    /// the detectors that run has it
    #[arg(short = 'P', long = "param", value_name = "NAME=VALUE")]
    pub parameters: Vec<OverrideOption>,
}
