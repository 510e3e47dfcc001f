//! What every protocol can do with a scan.

use detector::DetectorOutput;
use reports::rows::official_rows::OfficialRows;
use reports::rows::scan_name::ScanName;
use reports::vocabulary::protocol::Protocol;
use scans::dataset::Dataset;
use scans::dataset::kitti::label::KittiObject;
use scans::dataset::official::OfficialObject;

use super::official_objects::OfficialScanView;

/// A protocol: from a scan's labels and detections to rows.
pub trait OfficialProtocol: Sync {
    /// Which it is.
    fn protocol(&self) -> Protocol;

    /// What a data set lacks for it, as the rest of a sentence; `None` if nothing.
    fn lacks(&self, _dataset: &dyn Dataset) -> Option<&'static str> {
        None
    }

    /// The rows of what one detector found in a scan, whatever the order of labels and detections.
    fn rows(&self, found: &FoundInScan<'_>) -> OfficialRows;
}

/// What one detector found in a scan.
pub struct FoundInScan<'a> {
    /// Names the scan.
    pub name: ScanName,
    /// Name of the detector.
    pub detector: &'a str,
    /// The scan.
    pub view: &'a OfficialScanView<'a>,
    /// What it reported.
    pub output: &'a DetectorOutput,
    /// The same as objects, see [`OfficialScanView::found`].
    pub objects: &'a [OfficialObject],
    /// Of results in KITTI's files, what these say; `None` of others.
    pub kitti_objects: Option<&'a [KittiObject]>,
}
