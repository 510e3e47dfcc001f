//! The arguments of `scanbench init`.

use std::path::PathBuf;

use clap::Args;

/// Arguments of `scanbench init`.
#[derive(Debug, Args)]
#[command(after_help = INIT_EXAMPLES)]
pub struct InitArgs {
    /// Folder to write; a new or empty one
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

const INIT_EXAMPLES: &str = "\
Examples:
  scanbench init my-detector
  cd my-detector && scanbench run data/street -d cells,hierarchical

Writes a small detector in Python, a scanbench.toml that names it, a simulated street
with labels in KITTI's format, and a workflow for GitHub that runs `scanbench gate`.
Detectors in Python need the package: pip install ./harness/python in a checkout of
scanbench. No package index has it.";
