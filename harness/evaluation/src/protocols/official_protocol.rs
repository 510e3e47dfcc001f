//! Interface of the protocols that evaluate boxes.

use detector::DetectorOutput;
use reports::rows::official_rows::OfficialRows;
use reports::rows::scan_name::ScanName;
use reports::vocabulary::protocol::Protocol;
use scans::dataset::Dataset;
use scans::dataset::kitti::label::KittiObject;
use scans::dataset::official::OfficialObject;

use super::official_objects::OfficialScanView;

/// A protocol: it makes rows of the labels and detections of a scan.
pub trait OfficialProtocol: Sync {
    /// Name of the protocol.
    fn protocol(&self) -> Protocol;

    /// A requirement that a data set lacks, as the rest of a sentence; `None` if it lacks nothing.
    fn lacks(&self, _dataset: &dyn Dataset) -> Option<&'static str> {
        None
    }

    /// The rows of one detector in a scan, independent of the order of labels and detections.
    fn rows(&self, found: &FoundInScan<'_>) -> OfficialRows;
}

/// Results of one detector in a scan.
pub struct FoundInScan<'a> {
    /// Name of the scan.
    pub name: ScanName,
    /// Name of the detector.
    pub detector: &'a str,
    /// The scan.
    pub view: &'a OfficialScanView<'a>,
    /// Output of the detector.
    pub output: &'a DetectorOutput,
    /// Its detections as objects, see [`OfficialScanView::found`].
    pub objects: &'a [OfficialObject],
    /// Objects of results in KITTI's files; `None` for other results.
    pub kitti_objects: Option<&'a [KittiObject]>,
}
