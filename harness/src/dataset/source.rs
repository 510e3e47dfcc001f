//! What a reader is told about the data set it is to open.

use std::path::PathBuf;

use super::dataset_format::DatasetFormat;
use super::{AnnotatedClasses, DatasetDescription};

/// Where a data set lies, and what its files do not say.
#[derive(Debug, Clone, PartialEq)]
pub struct DatasetSource {
    /// The name used in tables and files.
    pub id: String,
    /// The file, or the folder that holds the scans and labels in the layout of the format.
    pub path: PathBuf,
    /// What its annotations cover. Labels of any other class are refused.
    pub annotated: AnnotatedClasses,
    /// Height of the sensor above the road, in metres.
    pub sensor_height_m: f32,
    /// The sensor, see [`DatasetDescription::sensor`].
    pub sensor: String,
    /// Its licence, where known.
    pub licence: Option<String>,
}

impl DatasetSource {
    /// The description of the recorded data set, once its files are known.
    pub fn describe(self, format: DatasetFormat, checksum: String) -> DatasetDescription {
        DatasetDescription {
            id: self.id,
            format: format.name().to_owned(),
            root: Some(self.path),
            annotated: self.annotated,
            sensor_height_m: self.sensor_height_m,
            sensor: self.sensor,
            licence: self.licence,
            checksum: Some(checksum),
            simulation: None,
        }
    }
}
