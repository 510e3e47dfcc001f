//! When a detection is good enough for an annotation, and the cost of the pair.

use std::collections::BTreeSet;

use detector::{Detections, OrientedBox};
use reports::vocabulary::criterion::CriterionKind;
use scans::annotation::LabeledScan;

use crate::matching::box_overlap::{bev_iou, iou_3d};
use crate::matching::hungarian::AdmissiblePair;
use crate::matching::point_overlap::PointOverlap;

/// Rule that makes a pair admissible and gives it a cost.
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
        self.kind().name()
    }

    /// The measure that is compared, without the gate.
    pub fn kind(self) -> CriterionKind {
        match self {
            Self::Points { .. } => CriterionKind::Points,
            Self::BevIou { .. } => CriterionKind::BevIou,
            Self::Iou3d { .. } => CriterionKind::Iou3d,
            Self::Centre { .. } => CriterionKind::Centre,
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
            let n_of_others = n_points_of_others(scan, detections, overlap, [annotation_idx, detection_idx]);
            let n_union = annotation.point_indices.len() + n_detection - n_shared - n_of_others;
            let iou = n_shared as f64 / n_union as f64;
            // Not by the cost, which is rounded: 1 − (1 − 0.1) is less than 0.1.
            (iou >= min_iou).then_some(AdmissiblePair { annotation_idx, detection_idx, cost: 1.0 - iou })
        })
    });
    pairs.collect()
}

/// How many points a detection that is a box has only since boxes of labels overlap: points in the box of the annotation that
/// belong to another annotation, as [`points_of_boxes`] has decided. They speak neither for the detection nor against it, so
/// that the box of the label itself has an intersection over union of 1.
///
/// [`points_of_boxes`]: scans::dataset::points_of_boxes::points_of_boxes
fn n_points_of_others(
    scan: &LabeledScan,
    detections: &Detections,
    overlap: &PointOverlap,
    [annotation_idx, detection_idx]: [usize; 2],
) -> usize {
    let (annotation, detection) = (&scan.annotations[annotation_idx], detections.get(detection_idx));
    let Some(bounding_box) = annotation.bounding_box.filter(|_| detection.box_details.has_points_of_box)
    else {
        return 0;
    };
    let others = overlap.of_detection(detection_idx).iter().filter(|(it, _)| *it != annotation_idx);
    let of_others = others.flat_map(|&(other_idx, _)| &scan.annotations[other_idx].point_indices);
    let is_in = |points: &[u32], point_idx: &u32| points.binary_search(point_idx).is_ok();
    let undecided: BTreeSet<u32> = of_others
        .copied()
        .filter(|it| is_in(detection.point_indices, it) && !is_in(&annotation.point_indices, it))
        .filter(|it| bounding_box.contains(scan.cloud.position_m(*it as usize)))
        .collect();
    undecided.len()
}

fn pairs_by_boxes(
    scan: &LabeledScan,
    detections: &Detections,
    iou: fn(&OrientedBox, &OrientedBox) -> f64,
    min_iou: f64,
) -> Vec<AdmissiblePair> {
    // Boxes whose circles do not meet share nothing. A little larger, so that rounding never loses a pair.
    let radius_m = |it: &OrientedBox| {
        let [length_m, width_m, _] = it.length_width_height_m.map(f64::from);
        0.501 * length_m.hypot(width_m) + 1e-3
    };
    let circles: Vec<([f64; 2], f64)> =
        detections.iter().map(|it| (plan_m(it.bounding_box.center_m), radius_m(&it.bounding_box))).collect();
    let mut pairs = Vec::new();
    for (annotation_idx, annotation) in scan.annotations.iter().enumerate() {
        let Some(labelled) = &annotation.bounding_box else { continue };
        let (at_m, reach_m) = (plan_m(labelled.center_m), radius_m(labelled));
        for (detection_idx, (center_m, radius_m)) in circles.iter().enumerate() {
            if is_apart(at_m, *center_m, reach_m + radius_m) {
                continue;
            }
            let iou = iou(labelled, &detections.get(detection_idx).bounding_box);
            if iou >= min_iou {
                pairs.push(AdmissiblePair { annotation_idx, detection_idx, cost: 1.0 - iou });
            }
        }
    }
    pairs
}

fn pairs_by_centre(scan: &LabeledScan, detections: &Detections, max_distance_m: f64) -> Vec<AdmissiblePair> {
    let centers_m: Vec<[f64; 2]> = detections.iter().map(|it| plan_m(it.bounding_box.center_m)).collect();
    let mut pairs = Vec::new();
    for (annotation_idx, annotation) in scan.annotations.iter().enumerate() {
        let Some(at_m) = annotation.center_m(&scan.cloud).map(plan_m) else { continue };
        for (detection_idx, center_m) in centers_m.iter().enumerate() {
            // Most are far apart; this is decided without a root. A little farther, so that rounding never loses a pair.
            if is_apart(at_m, *center_m, 1.001 * max_distance_m) {
                continue;
            }
            let cost = (center_m[0] - at_m[0]).hypot(center_m[1] - at_m[1]);
            if cost < max_distance_m {
                pairs.push(AdmissiblePair { annotation_idx, detection_idx, cost });
            }
        }
    }
    pairs
}

fn plan_m([x_m, y_m, _]: [f32; 3]) -> [f64; 2] {
    [f64::from(x_m), f64::from(y_m)]
}

fn is_apart(first_m: [f64; 2], second_m: [f64; 2], distance_m: f64) -> bool {
    let [dx_m, dy_m] = [first_m[0] - second_m[0], first_m[1] - second_m[1]];
    dx_m * dx_m + dy_m * dy_m > distance_m * distance_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::drawn_labels::{annotation, labeled};
    use detector::{BoxDetails, DetectedClass, Detection};
    use proptest::prelude::*;
    use reports::vocabulary::class::AnnotationClass;
    use scans::annotation::points_inside;
    use scans::dataset::points_of_boxes::assign_points_in_boxes;

    fn any_box() -> impl Strategy<Value = OrientedBox> {
        let position = [-6.0_f32..6.0, -6.0..6.0, -1.0..1.0];
        (position, [0.0_f32..5.0, 0.0..3.0, 0.1..3.0], -4.0_f32..4.0).prop_map(
            |(center_m, length_width_height_m, yaw_rad)| OrientedBox {
                center_m,
                length_width_height_m,
                yaw_rad,
            },
        )
    }

    fn boxes() -> impl Strategy<Value = Vec<OrientedBox>> {
        prop::collection::vec(any_box(), 0..12)
    }

    fn scene(annotations: &[OrientedBox], detections: &[OrientedBox]) -> (LabeledScan, Detections) {
        let annotations = annotations.iter().map(|it| annotation(AnnotationClass::Car, Some(*it), []));
        let scan = labeled([], annotations);
        let class = DetectedClass::Object;
        let detection = |bounding_box: &OrientedBox| Detection::new(&[], *bounding_box, class, None);
        (scan, detections.iter().map(detection).collect())
    }

    proptest! {
        /// Pairs that are skipped because they are far apart are not admissible.
        #[test]
        fn pairs_are_those_that_asking_every_pair_finds(annotations in boxes(), detections in boxes()) {
            let (scan, all) = scene(&annotations, &detections);
            let overlap = PointOverlap::count(&scan, &all);
            let distance_m = |a: &OrientedBox, b: &OrientedBox| {
                let [dx_m, dy_m] = [0, 1].map(|axis| f64::from(b.center_m[axis]) - f64::from(a.center_m[axis]));
                dx_m.hypot(dy_m)
            };
            for min_iou in [0.01, 0.5] {
                for (criterion, iou) in [
                    (Criterion::BevIou { min_iou }, bev_iou as fn(&_, &_) -> f64),
                    (Criterion::Iou3d { min_iou }, iou_3d),
                    (Criterion::Centre { max_distance_m: 8.0 * min_iou }, |_, _| 0.0),
                ] {
                    let mut expected = Vec::new();
                    for (annotation_idx, a) in annotations.iter().enumerate() {
                        for (detection_idx, b) in detections.iter().enumerate() {
                            let (is_admissible, cost) = match criterion {
                                Criterion::Centre { max_distance_m } => {
                                    (distance_m(a, b) < max_distance_m, distance_m(a, b))
                                }
                                _ => (iou(a, b) >= min_iou, 1.0 - iou(a, b)),
                            };
                            if is_admissible {
                                expected.push(AdmissiblePair { annotation_idx, detection_idx, cost });
                            }
                        }
                    }
                    prop_assert_eq!(criterion.admissible_pairs(&scan, &all, &overlap), expected);
                }
            }
        }

        /// The box of a label, fed back, agrees with it in full, whatever other labels overlap it.
        #[test]
        fn boxes_of_labels_agree_with_their_labels(
            boxes in boxes(),
            points in prop::collection::vec(prop::array::uniform3(-4.0_f32..4.0), 0..60),
        ) {
            let mut scan = labeled(points, boxes.iter().map(|it| annotation(AnnotationClass::Car, Some(*it), [])));
            assign_points_in_boxes(&scan.cloud, &mut scan.annotations);
            let inside: Vec<Vec<u32>> = boxes.iter().map(|it| points_inside(&scan.cloud, it)).collect();
            let details = BoxDetails { has_points_of_box: true, ..BoxDetails::default() };
            let echo = |(points, it): (_, &OrientedBox)| Detection {
                box_details: details,
                ..Detection::new(points, *it, DetectedClass::Object, None)
            };
            let all: Detections = inside.iter().map(Vec::as_slice).zip(&boxes).map(echo).collect();
            let overlap = PointOverlap::count(&scan, &all);
            let pairs = Criterion::POINTS.admissible_pairs(&scan, &all, &overlap);
            for (idx, annotation) in scan.annotations.iter().enumerate() {
                let echoed = pairs.iter().find(|it| it.annotation_idx == idx && it.detection_idx == idx);
                let expected = (!annotation.point_indices.is_empty()).then_some(0.0);
                prop_assert_eq!(echoed.map(|it| it.cost), expected, "{}", idx);
            }
        }
    }

    /// A person beside a car, whose box reaches into the car's: three of its five points are the person's.
    #[test]
    fn what_labels_give_to_another_object_is_not_held_against_a_box() {
        let car =
            OrientedBox { center_m: [0.2, 0.0, 0.0], length_width_height_m: [0.5, 1.0, 1.0], yaw_rad: 0.0 };
        let person =
            OrientedBox { center_m: [0.3, 0.0, 0.0], length_width_height_m: [0.3, 0.5, 1.0], yaw_rad: 0.0 };
        let boxed = |it| annotation(AnnotationClass::Car, Some(it), []);
        let mut scan = labeled((0..5).map(|it| [it as f32 * 0.1, 0.0, 0.0]), [boxed(car), boxed(person)]);
        assign_points_in_boxes(&scan.cloud, &mut scan.annotations);
        let iou = |points: &[u32], has_points_of_box| {
            let box_details = BoxDetails { has_points_of_box, ..BoxDetails::default() };
            let detection =
                Detection { box_details, ..Detection::new(points, car, DetectedClass::Vehicle, None) };
            let detections = Detections::from_iter([detection]);
            let overlap = PointOverlap::count(&scan, &detections);
            let pairs = Criterion::Points { min_iou: 0.0 }.admissible_pairs(&scan, &detections, &overlap);
            1.0 - pairs[0].cost
        };
        assert_eq!(scan.annotations[0].point_indices, [0, 1]);
        assert_eq!(iou(&[0, 1, 2, 3, 4], true), 1.0);
        // A cluster is its points.
        assert_eq!(iou(&[0, 1, 2, 3, 4], false), 0.4);
        assert_eq!(iou(&[0, 2, 3, 4], true), 0.5);
    }
}
