//! When a detection is good enough for an annotation, and what it costs.

use detector::{Detections, OrientedBox};
use scans::annotation::{Annotation, LabeledScan};

use crate::matching::box_overlap::{bev_iou, iou_3d};
use crate::matching::hungarian::AdmissiblePair;
use crate::matching::point_overlap::PointOverlap;

/// What makes a pair admissible, and what it costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Criterion {
    /// Intersection over union of the point sets is at least `min_iou`; costs 1 − IoU. Judges what the sensor saw.
    Points {
        /// 0 to 1.
        min_iou: f64,
    },
    /// Intersection over union of the boxes on the ground plan is at least `min_iou`; costs 1 − IoU. Objects without a
    /// labelled box do not count.
    BevIou {
        /// 0 to 1.
        min_iou: f64,
    },
    /// Intersection over union of the boxes in space is at least `min_iou`; costs 1 − IoU. Objects without a labelled box do
    /// not count.
    Iou3d {
        /// 0 to 1.
        min_iou: f64,
    },
    /// The centres are closer than `max_distance_m` on the ground plan; costs the distance in metres.
    Centre {
        /// In metres, exclusive.
        max_distance_m: f64,
    },
}

impl Criterion {
    /// Point sets that agree by half, the default.
    pub const POINTS: Self = Self::Points { min_iou: 0.5 };
    /// Ground plans that agree by half.
    pub const BEV_IOU: Self = Self::BevIou { min_iou: 0.5 };
    /// Boxes that agree by half.
    pub const IOU_3D: Self = Self::Iou3d { min_iou: 0.5 };
    /// Centres within 2 m, as nuScenes has it.
    pub const CENTRE: Self = Self::Centre { max_distance_m: 2.0 };

    /// All of them, with their usual gates.
    pub const ALL: [Self; 4] = [Self::POINTS, Self::BEV_IOU, Self::IOU_3D, Self::CENTRE];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Points { .. } => "points",
            Self::BevIou { .. } => "bev-iou",
            Self::Iou3d { .. } => "iou-3d",
            Self::Centre { .. } => "centre",
        }
    }

    /// Whether an annotation can be judged only if it has a box.
    pub fn needs_boxes(self) -> bool {
        matches!(self, Self::BevIou { .. } | Self::Iou3d { .. })
    }

    /// The admissible pairs of annotations and detections, by annotation, then detection.
    pub fn admissible_pairs(
        self,
        scan: &LabeledScan,
        detections: &Detections,
        overlap: &PointOverlap,
    ) -> Vec<AdmissiblePair> {
        match self {
            Self::Points { min_iou } => pairs_by_points(scan, detections, overlap, min_iou),
            Self::BevIou { min_iou } => pairs_by_boxes(scan, detections, bev_iou, min_iou),
            Self::Iou3d { min_iou } => pairs_by_boxes(scan, detections, iou_3d, min_iou),
            Self::Centre { max_distance_m } => pairs_by_centre(scan, detections, max_distance_m),
        }
    }
}

fn pairs_by_points(
    scan: &LabeledScan,
    detections: &Detections,
    overlap: &PointOverlap,
    min_iou: f64,
) -> Vec<AdmissiblePair> {
    let annotations = scan.annotations.iter().enumerate();
    let pairs = annotations.flat_map(|(annotation_idx, annotation)| {
        let shared = overlap.of_annotation(annotation_idx).iter();
        shared.filter_map(move |&(detection_idx, n_shared)| {
            let n_detection = detections.get(detection_idx).point_indices.len();
            let n_union = annotation.point_indices.len() + n_detection - n_shared;
            let iou = n_shared as f64 / n_union as f64;
            // Not by the cost, which is rounded: 1 − (1 − 0.1) is less than 0.1.
            (iou >= min_iou).then_some(AdmissiblePair { annotation_idx, detection_idx, cost: 1.0 - iou })
        })
    });
    pairs.collect()
}

fn pairs_by_boxes(
    scan: &LabeledScan,
    detections: &Detections,
    iou: fn(&OrientedBox, &OrientedBox) -> f64,
    min_iou: f64,
) -> Vec<AdmissiblePair> {
    let mut pairs = Vec::new();
    for (annotation_idx, annotation) in scan.annotations.iter().enumerate() {
        let Some(labelled) = &annotation.bounding_box else { continue };
        for (detection_idx, detection) in detections.iter().enumerate() {
            let iou = iou(labelled, &detection.bounding_box);
            if iou >= min_iou {
                pairs.push(AdmissiblePair { annotation_idx, detection_idx, cost: 1.0 - iou });
            }
        }
    }
    pairs
}

fn pairs_by_centre(scan: &LabeledScan, detections: &Detections, max_distance_m: f64) -> Vec<AdmissiblePair> {
    let mut pairs = Vec::new();
    for (annotation_idx, annotation) in scan.annotations.iter().enumerate() {
        let Some(at_m) = center_m(scan, annotation) else { continue };
        for (detection_idx, detection) in detections.iter().enumerate() {
            let [x_m, y_m, _] = detection.bounding_box.center_m.map(f64::from);
            let cost = (x_m - at_m[0]).hypot(y_m - at_m[1]);
            if cost < max_distance_m {
                pairs.push(AdmissiblePair { annotation_idx, detection_idx, cost });
            }
        }
    }
    pairs
}

/// Centre of an annotation on the ground plan in metres: of its box, else of its points; `None` if it has neither.
pub fn center_m(scan: &LabeledScan, annotation: &Annotation) -> Option<[f64; 2]> {
    if let Some(bounding_box) = &annotation.bounding_box {
        let [x_m, y_m, _] = bounding_box.center_m.map(f64::from);
        return Some([x_m, y_m]);
    }
    let n_points = annotation.point_indices.len();
    let mut sum_m = [0.0; 2];
    for &point_idx in &annotation.point_indices {
        let [x_m, y_m, _] = scan.cloud.position_m(point_idx as usize);
        sum_m = [sum_m[0] + f64::from(x_m), sum_m[1] + f64::from(y_m)];
    }
    // Rounded as a box would hold it, so that an echoed annotation lies exactly where it was.
    (n_points > 0).then(|| sum_m.map(|it| f64::from((it / n_points as f64) as f32)))
}
