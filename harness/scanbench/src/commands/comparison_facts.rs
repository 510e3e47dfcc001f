//! How a comparison came about.

use evaluation::metrics::counts::SCORING_VERSION;

use crate::cli::CompareArgs;
use crate::commands::provenance::{command_line, git_state};

/// What was compared, and by what.
pub fn comparison_facts(arguments: &CompareArgs) -> serde_json::Value {
    serde_json::json!({
        "scanbench_version": env!("CARGO_PKG_VERSION"),
        "scoring_version": SCORING_VERSION,
        "argv": command_line(),
        "git": git_state(),
        "before": arguments.run,
        "after": arguments.other,
        "detectors": arguments.detectors,
    })
}
