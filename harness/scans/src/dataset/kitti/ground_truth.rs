//! Makes a labelled scan of a scan and KITTI's labels for it.

use detector::OrientedBox;

use super::box_in_velodyne::box_in_velodyne;
use super::calibration::KittiCalibration;
use super::camera_field_of_view::{CameraFieldOfView, point_regions};
use super::label::{ImageBox, KittiLabel, KittiObject, Truncation};
use crate::annotation::{Annotation, LabeledArea, LabeledScan, PointRegion, ScanId};
use crate::dataset::data_sheet::LabeledRegion;
use crate::dataset::points_of_boxes::points_of_boxes;
use crate::dataset::positioned_points::PositionedPoints;

/// KITTI's labels and calibration for one scan.
#[derive(Debug, Clone, Copy)]
pub struct KittiGroundTruth<'a> {
    /// Transforms between camera and sensor.
    pub calibration: &'a KittiCalibration,
    /// Width and height of the camera's image in pixels.
    pub image_size_px: [u32; 2],
    /// The part of the scan that is labelled.
    pub labeled_region: LabeledRegion,
    /// The labels of the scan.
    pub labels: &'a [KittiLabel],
}

/// The scan `id` with its labels: annotations in the order of the labels, each with the points inside its box.
///
/// Where boxes overlap, [`points_of_boxes`] decides which one a point belongs to. An object marked as not to be judged stays
/// an annotation, and its points become unscorable.
pub fn label_scan(id: ScanId, points: PositionedPoints, truth: &KittiGroundTruth<'_>) -> LabeledScan {
    let (cloud, points_left_out) = points.into_parts();
    let (objects, dont_care) = objects_and_dont_care(truth.labels);
    let boxes: Vec<OrientedBox> = objects
        .iter()
        .map(|object| box_in_velodyne(&object.camera_box, &truth.calibration.velodyne_from_camera))
        .collect();
    let points_by_box = points_of_boxes(&cloud, &boxes);
    let annotations: Vec<Annotation> = objects
        .iter()
        .zip(boxes)
        .zip(points_by_box)
        .map(|((object, bounding_box), point_indices)| annotation_of(object, bounding_box, point_indices))
        .collect();

    let view = CameraFieldOfView {
        image_from_velodyne: &truth.calibration.image_from_velodyne,
        image_size_px: truth.image_size_px,
        dont_care: &dont_care,
    };
    let everything = || vec![PointRegion::Labeled; cloud.len()];
    let (mut point_regions, labeled_area) = match truth.labeled_region {
        LabeledRegion::Camera => (point_regions(&cloud, &annotations, &view), view.labeled_area()),
        LabeledRegion::Everywhere => (everything(), LabeledArea::Everywhere),
        LabeledRegion::PerPoint => (everything(), LabeledArea::AsPoints),
    };
    let ignored = objects.iter().zip(&annotations).filter(|(it, _)| it.truncation == Truncation::Ignored);
    for point_idx in ignored.flat_map(|(_, annotation)| &annotation.point_indices) {
        point_regions[*point_idx as usize] = PointRegion::Unscorable;
    }
    LabeledScan { id, cloud, annotations, point_regions, labeled_area, points_left_out }
}

fn objects_and_dont_care(labels: &[KittiLabel]) -> (Vec<&KittiObject>, Vec<ImageBox>) {
    let mut objects = Vec::new();
    let mut dont_care = Vec::new();
    for label in labels {
        match label {
            KittiLabel::Object(object) => objects.push(object),
            KittiLabel::DontCare(image_box) => dont_care.push(*image_box),
        }
    }
    (objects, dont_care)
}

/// The annotation for `object`, with its box in the frame of the sensor and the points in it.
pub fn annotation_of(object: &KittiObject, bounding_box: OrientedBox, point_indices: Vec<u32>) -> Annotation {
    Annotation {
        class: object.class,
        bounding_box: Some(bounding_box),
        point_indices,
        track: object.track,
        occlusion: object.occlusion,
        truncation: match object.truncation {
            Truncation::Share(share) => Some(share),
            Truncation::Unknown | Truncation::Ignored => None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::class_table::{ClassReader, ClassRules};
    use crate::dataset::kitti::calibration::parse_calibration;
    use crate::dataset::kitti::calibration::tests::FORWARD_CAMERA;
    use crate::dataset::kitti::label::{KITTI_VOCABULARY, parse_tracking_labels};
    use std::path::Path;

    /// A car ahead, cut off by the image to the level `truncated`, with one point in it and one behind it.
    #[track_caller]
    fn check(truncated: &str, expected_regions: [PointRegion; 2], expected_truncation: Option<f32>) {
        let labels = format!(
            "0 5 Car {truncated} 0 0 0 0 0 0 1.4 1.6 4 0 1.7 10 0\n0 -1 DontCare -1 -1 -10 0 0 1242 375 -1 -1 -1 0 0 0 0"
        );
        let rules = ClassRules::default();
        let mut classes = ClassReader::new(&rules, KITTI_VOCABULARY);
        let labels = parse_tracking_labels(Path::new("l.txt"), &labels, &mut classes).unwrap();
        let truth = KittiGroundTruth {
            calibration: &parse_calibration(Path::new("c.txt"), FORWARD_CAMERA).unwrap(),
            image_size_px: [1242, 375],
            labeled_region: LabeledRegion::Camera,
            labels: &labels[&0],
        };
        let mut points = PositionedPoints::default();
        for position_m in [[10.0, 1.5, -1.0], [20.0, 0.0, -1.0]] {
            points.push(position_m, 0.0).unwrap();
        }
        let scan = label_scan(ScanId { sequence: "0000".to_owned(), index: 0 }, points, &truth);
        assert_eq!(scan.annotations.len(), 1);
        assert_eq!(scan.annotations[0].point_indices, [0]);
        assert_eq!(scan.annotations[0].track, Some(5));
        assert_eq!(scan.annotations[0].truncation, expected_truncation);
        assert_eq!(scan.point_regions, expected_regions);
    }

    #[test]
    fn points_of_an_object_are_labeled_and_the_others_in_dont_care_are_not() {
        check("0", [PointRegion::Labeled, PointRegion::Unscorable], Some(0.0));
    }

    #[test]
    fn points_of_an_ignored_object_are_unscorable() {
        check("2", [PointRegion::Unscorable, PointRegion::Unscorable], None);
    }
}
