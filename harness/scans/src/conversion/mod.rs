//! Writers of labelled scans in other formats.
//!
//! Everything is written under another name and renamed at the end: it appears whole or not at all.

use nalgebra::Isometry3;

use crate::annotation::LabeledScan;

pub mod error;
pub mod output_format;
pub mod scene;
pub mod stable_summary;
pub mod mcap_writer;
pub mod whole_folder;
pub mod kitti_label_line;
pub mod kitti_writer;
pub mod instance_numbers;
pub mod semantic_kitti_writer;
pub mod object_folder_writer;
pub mod proposal_writer;
pub mod convert;
pub mod results;

pub use error::ConversionError;

/// One scan on its way to disk.
#[derive(Debug, Clone, Copy)]
pub struct ScanToWrite<'a> {
    /// The scan with its annotations.
    pub scan: &'a LabeledScan,
    /// When it was taken, in nanoseconds.
    pub time_ns: u64,
    /// Where the sensor was, as far as that is known.
    pub world_from_sensor: Option<Isometry3<f64>>,
}

/// A data set that is being written.
pub trait ScanWriter {
    /// Appends a scan.
    fn write(&mut self, scan: &ScanToWrite<'_>) -> Result<(), ConversionError>;

    /// Ends the data set, which appears under its name now.
    fn finish(self: Box<Self>) -> Result<(), ConversionError>;
}
