//! Facts for KITTI's evaluation, made of KITTI's labels and the results of a detector.

use detector::{DetectedClass, DetectorOutput};
use nalgebra::{Matrix3x4, Matrix4};
use reports::protocols::kitti_object::scan::{KittiAnnotation, KittiDetection};
use reports::rows::kitti_object_row::{KittiBox, KittiFact};
use reports::vocabulary::class::{AnnotationClass, DetectionClass};
use scans::conversion::results::detection_rows::detection_class;
use scans::dataset::foreign_frame::ForeignFrame;
use scans::dataset::kitti::box_in_velodyne::box_in_camera;
use scans::dataset::kitti::image_box::image_box;
use scans::dataset::kitti::label::{CameraBox, KittiLabel, KittiObject};

use super::overlaps::ImageRectangle;
use super::scan_facts::scan_facts;

/// Score of a detection without one, so that all such detections rank equally.
const SCORE_OF_NONE: f64 = 1.0;

/// Rectangle of an object outside the image.
const UNSEEN_PX: ImageRectangle = [-1.0; 4];

/// Facts of a scan with these labels and found objects, both in the order of their files.
pub fn facts_of_results(labels: &[KittiLabel], found: &[KittiObject]) -> Vec<KittiFact> {
    let detection =
        |it: &KittiObject| KittiDetection { object: box_of(it), score: it.score.unwrap_or(SCORE_OF_NONE) };
    let detections: Vec<KittiDetection> = found.iter().map(detection).collect();
    facts_of(labels, &detections)
}

/// Facts of a scan with these labels and the output of a detector, in the frame of the sensor, by the classes that the
/// detector gives. Vehicles without one are cars, the unlikely ones, too, since scores rank them. The rectangle in the
/// image is that
/// around the corners of the box.
///
/// `None` if the scan has no camera.
pub fn facts_of_detections(
    labels: &[KittiLabel],
    output: &DetectorOutput,
    frame: &ForeignFrame,
) -> Option<Vec<KittiFact>> {
    let ForeignFrame::Camera { velodyne_from_camera, image_from_velodyne, image_size_px } = frame else {
        return None;
    };
    let camera =
        Camera { velodyne: velodyne_from_camera, image_from_velodyne, image_size_px: *image_size_px };
    let all = output.detections.iter().chain(output.unlikely.iter());
    let detections = all.filter_map(|it| {
        let class = match (detection_class(&it), it.class) {
            (DetectionClass::Given(class), _) => class,
            (_, DetectedClass::Vehicle) => AnnotationClass::Car,
            (_, DetectedClass::Object) => return None,
        };
        Some(camera.detection(&it, class))
    });
    let detections: Vec<KittiDetection> = detections.collect();
    Some(facts_of(labels, &detections))
}

/// Camera of the scan, relative to the sensor.
struct Camera<'a> {
    velodyne: &'a Matrix4<f64>,
    image_from_velodyne: &'a Matrix3x4<f64>,
    image_size_px: [u32; 2],
}

impl Camera<'_> {
    fn detection(&self, it: &detector::Detection<'_>, class: AnnotationClass) -> KittiDetection {
        let camera_box = box_in_camera(&it.bounding_box, self.velodyne);
        let CameraBox { bottom_center_m, height_width_length_m, rotation_y_rad } = camera_box;
        let in_image = image_box(&it.bounding_box, self.image_from_velodyne, self.image_size_px);
        let object = KittiBox {
            class,
            left_top_right_bottom_px: in_image.unwrap_or(UNSEEN_PX),
            // Relative to the ray to the object, not to the axis of the camera.
            alpha_rad: rotation_y_rad - bottom_center_m[0].atan2(bottom_center_m[2]),
            bottom_center_m,
            height_width_length_m,
            rotation_y_rad,
        };
        KittiDetection { object, score: it.box_score().map_or(SCORE_OF_NONE, f64::from) }
    }
}

fn facts_of(labels: &[KittiLabel], detections: &[KittiDetection]) -> Vec<KittiFact> {
    let (mut annotations, mut dont_care) = (Vec::new(), Vec::new());
    for label in labels {
        match label {
            KittiLabel::Object(it) => annotations.push(KittiAnnotation {
                object: box_of(it),
                occlusion: it.in_image.occlusion,
                truncation: it.in_image.truncation,
            }),
            KittiLabel::DontCare(region) => dont_care.push(region.left_top_right_bottom_px),
        }
    }
    scan_facts(&annotations, &dont_care, detections)
}

fn box_of(it: &KittiObject) -> KittiBox {
    let CameraBox { bottom_center_m, height_width_length_m, rotation_y_rad } = it.camera_box;
    KittiBox {
        class: it.class,
        left_top_right_bottom_px: it.in_image.image_box.left_top_right_bottom_px,
        alpha_rad: it.in_image.alpha_rad,
        bottom_center_m,
        height_width_length_m,
        rotation_y_rad,
    }
}
