//! Headings of the options, and the text below them.

/// Options that say which scans are taken.
pub const DATA: &str = "Data";
/// Options that say which detectors run, and how.
pub const DETECTORS: &str = "Detectors";
/// Options that say what a model is trained on.
pub const TRAINING: &str = "Training";
/// Options that say when a detection is right, and a run good enough.
pub const JUDGING: &str = "Judging";
/// Options that say which mistakes are listed.
pub const MISTAKES: &str = "Mistakes";
/// Options that say what is written, and where.
pub const OUTPUT: &str = "Output";
/// Options of what shards are handed to.
pub const ENGINE: &str = "Engine";
/// Options of the Rerun viewer.
pub const VIEWER: &str = "Viewer";
/// Options of every verb.
pub const GENERAL: &str = "General";

/// The end of `--help`: the examples that `-h` has, too, and the `details`.
pub fn with_details(examples: &str, details: &str) -> String {
    format!("{examples}\n\n{details}")
}
