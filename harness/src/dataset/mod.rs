//! Labelled scans, wherever they come from.

use std::path::PathBuf;

use crate::annotation::{AnnotationClass, LabeledScan, ScanId};
use crate::task::Task;

/// A series of labelled scans that are read one at a time.
pub trait Dataset: Send + Sync {
    /// What is known about it without reading a scan.
    fn description(&self) -> &DatasetDescription;

    /// The scans, in the order of their drives and times.
    fn scan_ids(&self) -> &[ScanId];

    /// Reads scan `scan_idx` of [`Self::scan_ids`].
    ///
    /// # Errors
    ///
    /// [`DatasetError`] if a file is missing, damaged or contradicts another.
    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError>;
}

/// What is known about a data set without reading a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct DatasetDescription {
    /// The name used in tables and files.
    pub id: String,
    /// The format's name, such as `kitti-tracking`.
    pub format: String,
    /// Where it lies; `None` for what is simulated on the fly.
    pub root: Option<PathBuf>,
    /// Whether a simulator made it. Numbers measured on it are always labelled so.
    pub simulated: bool,
    /// What its annotations cover.
    pub annotated: AnnotatedClasses,
    /// Height of the sensor above the road, in metres.
    pub sensor_height_m: f32,
    /// Its licence, where known.
    pub licence: Option<String>,
    /// SHA-256 of what the scans are made of, where it was asked for or is cheap: of the parameters and seed of a simulation.
    pub checksum: Option<String>,
}

/// Which objects of the street a data set labels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum AnnotatedClasses {
    /// Every free-standing object: what is found beyond the annotations is false.
    EveryObject,
    /// These classes only: whether anything else that is found is false cannot be known.
    Only(Vec<AnnotationClass>),
}

impl AnnotatedClasses {
    /// Whether everything that `task` asks for is annotated, so that what is found beyond it is known to be false.
    ///
    /// A data set with cars among its classes is taken to label all vehicles, under its own names for them.
    pub fn covers(&self, task: Task) -> bool {
        match (self, task) {
            (Self::EveryObject, _) => true,
            (Self::Only(_), Task::Objects) => false,
            (Self::Only(classes), Task::Vehicles) => classes.contains(&AnnotationClass::Car),
        }
    }
}

/// Why labelled scans cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// The operating system refused.
    #[error("cannot read {path:?}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What it said.
        source: std::io::Error,
    },
}
