//! KITTI's evaluation of objects as one of the protocols.

use reports::rows::kitti_object_row::KittiObjectRow;
use reports::rows::official_rows::OfficialRows;
use reports::vocabulary::protocol::Protocol;
use scans::dataset::Dataset;
use scans::dataset::kitti::label::KittiLabel;

use super::label_facts::{facts_of_detections, facts_of_results};
use crate::protocols::official_protocol::{FoundInScan, OfficialProtocol};

/// KITTI's evaluation of objects.
pub struct KittiObjectProtocol;

impl OfficialProtocol for KittiObjectProtocol {
    fn protocol(&self) -> Protocol {
        Protocol::KittiObject
    }

    fn lacks(&self, dataset: &dyn Dataset) -> Option<&'static str> {
        let has_labels = dataset.scan_ids().is_empty() || dataset.kitti_labels(0).is_some();
        if !has_labels {
            return Some("has no labels in KITTI's layouts, which say where objects are in the image");
        }
        let labels = (0..dataset.scan_ids().len()).filter_map(|it| dataset.kitti_labels(it)).flatten();
        let mut objects = labels.filter_map(KittiLabel::object).peekable();
        // Converted data have no image.
        let has_no_image = objects.peek().is_some()
            && objects.all(|it| it.in_image.image_box.left_top_right_bottom_px == [-1.0; 4]);
        has_no_image.then_some("has labels that do not say where objects are in the image")
    }

    fn rows(&self, found: &FoundInScan<'_>) -> OfficialRows {
        let facts = found.view.kitti.as_ref().and_then(|(labels, frame)| match found.kitti_objects {
            Some(objects) => Some(facts_of_results(labels, objects)),
            None => facts_of_detections(labels, found.output, frame),
        });
        let row =
            |fact| KittiObjectRow { scan: found.name.clone(), detector: found.detector.to_owned(), fact };
        let kitti = facts.unwrap_or_default().into_iter().map(row).collect();
        OfficialRows { kitti, ..OfficialRows::default() }
    }
}
