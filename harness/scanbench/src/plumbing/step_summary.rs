//! The summary of a job on GitHub.

use std::io::Write as _;
use std::path::Path;

use crate::plumbing::failure::Failure;

/// The file that GitHub shows as the summary of a job.
const STEP_SUMMARY: &str = "GITHUB_STEP_SUMMARY";

/// Adds `text` to the summary of the job, if this runs in one. Other steps of the job have written there before.
pub fn append_to_step_summary(text: &str) -> Result<(), Failure> {
    let Some(path) = std::env::var_os(STEP_SUMMARY).filter(|it| !it.is_empty()) else { return Ok(()) };
    let path = Path::new(&path);
    let file = std::fs::File::options().append(true).create(true).open(path);
    let written = file.and_then(|mut it| it.write_all(text.as_bytes()));
    written.map_err(|error| {
        Failure::usage(format!("cannot write {}, the file that {STEP_SUMMARY} names", path.display()), error)
    })
}
