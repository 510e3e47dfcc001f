//! Arguments of `scanbench params`.

use clap::Args;
use evaluation::run::detector_list::DETECTORS;

/// Arguments of `scanbench params`.
#[derive(Debug, Args)]
#[command(after_help = PARAMS_EXAMPLES)]
pub struct ParamsArgs {
    /// Detectors; all that are built in if none is named
    #[arg(value_name = "NAME", value_parser = DETECTORS.iter().map(|it| it.name).collect::<Vec<_>>())]
    pub detectors: Vec<String>,
}

const PARAMS_EXAMPLES: &str = "\
Examples:
  scanbench params paper
  scanbench params kd-tree pca > mine.toml      a file for -c, to be changed";
