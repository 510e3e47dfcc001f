//! Logs what was missed or is false, and why, in words.

use evaluation::matching::mistake::{Mistake, MistakeKind};
use re_sdk_types::archetypes::TextLog;
use re_sdk_types::components::TextLogLevel;
use reports::vocabulary::task::Task;
use rerun::RecordingStream;

use super::error::StreamError;
use super::{entity_paths, legend, palette, recording};

/// Logs a line for each of the `mistakes` of `detector` at the current time.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_mistakes(
    stream: &RecordingStream,
    detector: &str,
    task: Task,
    mistakes: &[Mistake],
) -> Result<(), StreamError> {
    for mistake in mistakes {
        let (level, color) = match mistake.kind {
            MistakeKind::Missed => ("MISSED", palette::MISSED),
            MistakeKind::False => ("FALSE", palette::FALSE),
        };
        let line = TextLog::new(mistake.text.as_str())
            .with_level(TextLogLevel::from(level))
            .with_color(legend::rgba(color));
        recording::log(stream, entity_paths::mistakes(detector, task), &line)?;
    }
    Ok(())
}
