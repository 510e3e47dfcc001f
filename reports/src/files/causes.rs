//! Errors with what caused them.

use std::error::Error;

/// The message of `error` and those of all its causes, in a line.
///
/// ```
/// use reports::files::archive::ArchiveError;
/// use reports::files::causes::with_causes;
///
/// let source = std::io::Error::other("the disk is gone");
/// let error = ArchiveError::Write { path: "scans.csv".into(), source };
/// assert_eq!(with_causes(&error), "cannot write \"scans.csv\": the disk is gone");
/// ```
pub fn with_causes(error: &(dyn Error + 'static)) -> String {
    let mut message = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        message += ": ";
        message += &error.to_string();
        cause = error.source();
    }
    message
}
