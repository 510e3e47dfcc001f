//! Facts of one scan for KITTI's evaluation.

use reports::protocols::kitti_object::rules::{Demand, Difficulty, KittiClass, Plane};
use reports::protocols::kitti_object::scan::{KittiAnnotation, KittiDetection};
use reports::rows::kitti_object_row::{KittiFact, KittiOverlap};

use super::overlaps::{ImageRectangle, PlannedBox, overlap, share_in};

/// Facts of a scan: the annotations, the detections, the pairs of them that overlap enough for some question, and the
/// detections in regions without labels.
///
/// Indices are those in the slices.
pub fn scan_facts(
    annotations: &[KittiAnnotation],
    dont_care: &[ImageRectangle],
    detections: &[KittiDetection],
) -> Vec<KittiFact> {
    let mut facts = Vec::with_capacity(annotations.len() + 2 * detections.len());
    for (annotation, it) in (0..).zip(annotations) {
        let KittiAnnotation { object, occlusion, truncation } = *it;
        facts.push(KittiFact::Annotation { annotation, object, occlusion, truncation });
    }
    for (detection, it) in (0..).zip(detections) {
        facts.push(KittiFact::Detection { detection, object: it.object, score: it.score });
    }
    facts.extend(pairs(annotations, detections));
    for (detection, it) in (0..).zip(detections) {
        let shares = dont_care.iter().map(|region| share_in(&it.object.left_top_right_bottom_px, region));
        let share = shares.fold(0.0, f64::max);
        let class = KittiClass::ALL.into_iter().find(|class| class.annotation_class() == it.object.class);
        if class.is_some_and(|class| share > class.min_overlap(Plane::Image, Demand::Strict)) {
            facts.push(KittiFact::DontCare { detection, share });
        }
    }
    facts
}

/// The pairs that overlap enough for some question, in the order of annotations, then detections.
fn pairs(annotations: &[KittiAnnotation], detections: &[KittiDetection]) -> Vec<KittiFact> {
    let can_be_found = KittiClass::ALL.map(|class| -> Vec<(u32, PlannedBox<'_>)> {
        let found = (0..).zip(detections).filter(|(_, found)| can_find(found, class));
        found.map(|(detection, it)| (detection, PlannedBox::of(&it.object))).collect()
    });
    let mut pairs = Vec::new();
    for (annotation, it) in (0..).zip(annotations) {
        let Some(class) = class_beside(it) else { continue };
        let labelled = PlannedBox::of(&it.object);
        for (detection, found) in &can_be_found[class as usize] {
            let overlap = overlap(found, &labelled);
            if is_enough_somewhere(&overlap, class) {
                pairs.push(KittiFact::Pair { annotation, detection: *detection, overlap });
            }
        }
    }
    pairs
}

/// The class in whose evaluation an annotation is to be found, or ignored.
fn class_beside(annotation: &KittiAnnotation) -> Option<KittiClass> {
    let class = annotation.object.class;
    KittiClass::ALL.into_iter().find(|it| it.annotation_class() == class || it.neighbor() == Some(class))
}

/// Whether a detection can be matched in the evaluation of a class: as one of the class, or as one of any class that is too
/// low for some difficulty.
fn can_find(detection: &KittiDetection, class: KittiClass) -> bool {
    let height_px = detection.object.height_px().abs();
    detection.object.class == class.annotation_class()
        || Difficulty::ALL.iter().any(|it| height_px < it.limits().min_height_px)
}

fn is_enough_somewhere(overlap: &KittiOverlap, class: KittiClass) -> bool {
    let enough = |plane| class.min_overlap(plane, Demand::Loose);
    overlap.image > enough(Plane::Image)
        || overlap.birds_eye > enough(Plane::BirdsEye)
        || overlap.volume > enough(Plane::Volume)
}
