//! One call to Rerun, with its error as ours.

use rerun::{AsComponents, EntityPath, RecordingStream};

use super::error::StreamError;

/// Logs `archetype` at the current time of `recording`.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log(
    recording: &RecordingStream,
    path: impl Into<EntityPath>,
    archetype: &impl AsComponents,
) -> Result<(), StreamError> {
    let path = path.into();
    recording.log(path.clone(), archetype).map_err(|refused| log_error(&path, &refused))
}

/// Logs `archetype` for all times of `recording`.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_static(
    recording: &RecordingStream,
    path: impl Into<EntityPath>,
    archetype: &impl AsComponents,
) -> Result<(), StreamError> {
    let path = path.into();
    recording.log_static(path.clone(), archetype).map_err(|refused| log_error(&path, &refused))
}

fn log_error(path: &EntityPath, refused: &rerun::RecordingStreamError) -> StreamError {
    StreamError::Log { entity: path.to_string(), reason: refused.to_string() }
}
