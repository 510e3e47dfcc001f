//! Which annotations are to be found, which may be, and which detections can find them.

use super::rules::{Difficulty, KittiClass};
use super::scan::{KittiAnnotation, KittiDetection};

/// Role of an annotation or a detection in a question.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// An annotation that is to be found; a detection that is right or false.
    Counts,
    /// Neither found nor missed, neither right nor false; it can be matched all the same.
    Ignored,
    /// Of another class: as if it were not there.
    Absent,
}

/// Role of an annotation in questions about a class.
pub fn annotation_role(annotation: &KittiAnnotation, class: KittiClass, difficulty: Difficulty) -> Role {
    let limits = difficulty.limits();
    let is_within = annotation.occlusion <= limits.max_occlusion
        && annotation.truncation <= limits.max_truncation
        && annotation.object.height_px() > limits.min_height_px;
    if annotation.object.class == class.annotation_class() {
        return if is_within { Role::Counts } else { Role::Ignored };
    }
    if Some(annotation.object.class) == class.neighbor() { Role::Ignored } else { Role::Absent }
}

/// Role of a detection in questions about a class. One that is too low in the image is ignored whatever its class is, as the
/// makers' program has it.
pub fn detection_role(detection: &KittiDetection, class: KittiClass, difficulty: Difficulty) -> Role {
    if detection.object.height_px().abs() < difficulty.limits().min_height_px {
        Role::Ignored
    } else if detection.object.class == class.annotation_class() {
        Role::Counts
    } else {
        Role::Absent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocols::kitti_object::drawn_scan::{annotation, detection};
    use crate::vocabulary::class::AnnotationClass;

    #[track_caller]
    fn check(class: AnnotationClass, height_px: f64, levels: (i64, f64), expected: [Role; 3]) {
        let (occlusion, truncation) = levels;
        let mut it = KittiAnnotation { occlusion, truncation, ..annotation(class, 0.0) };
        it.object.left_top_right_bottom_px = [0.0, 100.0, 50.0, 100.0 + height_px];
        let found = Difficulty::ALL.map(|difficulty| annotation_role(&it, KittiClass::Car, difficulty));
        assert_eq!(found, expected);
    }

    #[test]
    fn each_difficulty_has_its_limits() {
        use Role::{Counts, Ignored};
        check(AnnotationClass::Car, 41.0, (0, 0.15), [Counts; 3]);
        check(AnnotationClass::Car, 40.0, (0, 0.0), [Ignored, Counts, Counts]);
        check(AnnotationClass::Car, 25.0, (0, 0.0), [Ignored; 3]);
        check(AnnotationClass::Car, 100.0, (1, 0.0), [Ignored, Counts, Counts]);
        check(AnnotationClass::Car, 100.0, (2, 0.0), [Ignored, Ignored, Counts]);
        check(AnnotationClass::Car, 100.0, (3, 0.0), [Ignored; 3]);
        check(AnnotationClass::Car, 100.0, (0, 0.31), [Ignored, Ignored, Counts]);
        check(AnnotationClass::Car, 100.0, (0, -1.0), [Counts; 3]);
    }

    #[test]
    fn neighbors_are_ignored_and_others_absent() {
        check(AnnotationClass::Van, 100.0, (0, 0.0), [Role::Ignored; 3]);
        check(AnnotationClass::Pedestrian, 100.0, (0, 0.0), [Role::Absent; 3]);
    }

    #[test]
    fn low_detections_are_ignored_whatever_they_are() {
        let role = |class, height_px| {
            let mut it = detection(class, 0.0, 1.0);
            it.object.left_top_right_bottom_px = [0.0, 100.0, 50.0, 100.0 + height_px];
            detection_role(&it, KittiClass::Car, Difficulty::Moderate)
        };
        assert_eq!(role(AnnotationClass::Car, 25.0), Role::Counts);
        assert_eq!(role(AnnotationClass::Car, 24.9), Role::Ignored);
        assert_eq!(role(AnnotationClass::Pedestrian, 24.9), Role::Ignored);
        assert_eq!(role(AnnotationClass::Pedestrian, 25.0), Role::Absent);
    }
}
