//! What every protocol can do with a scan.

use detector::Detections;
use reports::rows::ranked_box_row::RankedBoxRow;
use reports::rows::scan_name::ScanName;
use reports::vocabulary::protocol::Protocol;
use scans::dataset::official::OfficialObject;

use super::official_objects::OfficialScanView;

/// A protocol: from a scan's labels and detections to rows.
pub trait OfficialProtocol: Sync {
    /// Which it is.
    fn protocol(&self) -> Protocol;

    /// The rows of what one detector found in a scan, whatever the order of labels and detections.
    fn rows(&self, found: &FoundInScan<'_>) -> ProtocolRows;
}

/// What one detector found in a scan.
pub struct FoundInScan<'a> {
    /// Names the scan.
    pub name: ScanName,
    /// Name of the detector.
    pub detector: &'a str,
    /// The scan.
    pub view: &'a OfficialScanView<'a>,
    /// The detections.
    pub detections: &'a Detections,
    /// The same as objects, see [`OfficialScanView::found`].
    pub objects: &'a [OfficialObject],
}

/// The rows of a scan.
#[derive(Debug, Clone, PartialEq)]
pub enum ProtocolRows {
    /// Those of protocols that rank boxes by distance.
    RankedBoxes(Vec<RankedBoxRow>),
}
