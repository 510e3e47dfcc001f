//! The names of detectors.

use evaluation::run::detector_list::{DEFAULT_DETECTORS, DETECTORS};

pub(super) fn detectors_help() -> String {
    let names: Vec<&str> = DETECTORS.iter().map(|it| it.name).collect();
    format!(
        "Detectors, separated by commas: {}, or of scanbench.toml [default: {}]",
        names.join(", "),
        DEFAULT_DETECTORS.join(",")
    )
}

/// The names of all detectors, in the order of tables.
pub fn detector_names() -> Vec<&'static str> {
    DETECTORS.iter().map(|it| it.name).collect()
}
