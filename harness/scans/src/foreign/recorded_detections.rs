//! Detections in an MCAP recording: `foxglove.SceneUpdate` or `vision_msgs/Detection3DArray`.

use std::path::{Path, PathBuf};

use super::detections::ForeignDetections;
use super::result_reader::{ResultReader, ResultsOf};
use crate::annotation::LabeledScan;
use crate::dataset::DatasetError;

/// `path` and the topic behind `.mcap:`, if there is no such file and one is named.
pub fn split_topic(path: &Path) -> (PathBuf, Option<String>) {
    match path.to_str().and_then(|it| it.rsplit_once(":/")) {
        Some((file, topic)) if !path.exists() && Path::new(file).is_file() => {
            (PathBuf::from(file), Some(format!("/{topic}")))
        }
        _ => (path.to_path_buf(), None),
    }
}

/// The detections of a topic.
pub struct RecordedDetections;

impl RecordedDetections {
    /// Later.
    ///
    /// # Errors
    ///
    /// Always.
    pub fn open(path: &Path, _topic: Option<&str>, _of: ResultsOf<'_, '_>) -> Result<Self, DatasetError> {
        Err(DatasetError::UnusableResults { path: path.to_path_buf(), problem: "is a recording".to_owned() })
    }
}

impl ResultReader for RecordedDetections {
    fn has(&self, _scan_idx: usize) -> bool {
        false
    }

    fn read(
        &mut self,
        _scan_idx: usize,
        _scan: &LabeledScan,
    ) -> Result<Option<ForeignDetections>, DatasetError> {
        Ok(None)
    }

    fn left_over(&self) -> Vec<String> {
        Vec::new()
    }
}
