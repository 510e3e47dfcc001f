//! A layer of pointers that joins a recording which is finished.

use std::path::Path;

use evaluation::run::scan_recorder::MarksByDetector;
use re_sdk_types::archetypes::Clear;

use super::error::StreamError;
use super::layers::OneLayer;
use super::log_scan::log_marks;
use super::run_recording::RecordingElsewhere;
use super::{entity_paths, recording};

/// Writes a layer with these pointers into the folder of a recording.
///
/// # Errors
///
/// [`StreamError`] if it has no layers, or cannot be written.
pub fn write_marks(folder: &Path, marks: &MarksByDetector) -> Result<(), StreamError> {
    let (_, Some(whole)) = RecordingElsewhere::begin(&folder.join("marks.rrd"), false)? else {
        return Ok(());
    };
    let layer = OneLayer::join(folder, whole.path())?;
    for (detector, scans) in marks {
        let path = entity_paths::marks(detector);
        for (step, of_scan) in scans {
            layer.recording().set_time_sequence(entity_paths::SCAN_TIMELINE, *step);
            log_marks(layer.recording(), path.clone(), of_scan)?;
            // They would stay, otherwise.
            if !scans.contains_key(&(step + 1)) {
                layer.recording().set_time_sequence(entity_paths::SCAN_TIMELINE, step + 1);
                recording::log(layer.recording(), path.clone(), &Clear::flat())?;
            }
        }
    }
    layer.finish()?;
    whole.finish()
}
