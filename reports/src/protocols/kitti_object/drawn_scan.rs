//! Scans for tests: objects in a row along the road, each placed by a number.

use super::rules::{Demand, Difficulty, KittiClass, Plane, Question};
use super::scan::{KittiAnnotation, KittiDetection, KittiScan};
use super::score_events::ScoreEvents;
use crate::rows::kitti_object_row::{KittiBox, KittiFact, KittiOverlap};
use crate::vocabulary::class::AnnotationClass;

/// The question about these scans.
pub const QUESTION: Question = Question {
    class: KittiClass::Car,
    difficulty: Difficulty::Moderate,
    plane: Plane::Volume,
    demand: Demand::Strict,
};

/// Changes of the numbers of right and false detections, as `(score, right, false)`, the best score first.
pub fn changes(events: &ScoreEvents) -> Vec<(f64, i32, i32)> {
    let falses = events.falses.iter().map(|(score, _)| (*score, 0, 1));
    let mut changes: Vec<_> = events.events.iter().map(|it| (it.score, it.tp, it.fp)).chain(falses).collect();
    changes.sort_by(|a, b| b.0.total_cmp(&a.0));
    changes
}

/// A box at `position`, 100 pixels high.
pub fn boxed(class: AnnotationClass, position: f64) -> KittiBox {
    KittiBox {
        class,
        left_top_right_bottom_px: [100.0 * position, 100.0, 100.0 * position + 80.0, 200.0],
        alpha_rad: 0.0,
        bottom_center_m: [10.0 * position, 1.7, 20.0],
        height_width_length_m: [1.5, 1.6, 4.0],
        rotation_y_rad: 0.0,
    }
}

/// An annotation that is easy to find.
pub fn annotation(class: AnnotationClass, position: f64) -> KittiAnnotation {
    KittiAnnotation { object: boxed(class, position), occlusion: 0, truncation: 0.0 }
}

/// A detection.
pub fn detection(class: AnnotationClass, position: f64, score: f64) -> KittiDetection {
    KittiDetection { object: boxed(class, position), score }
}

/// A scan in which these pairs overlap, by the same in every plane.
pub fn scan(
    annotations: &[KittiAnnotation],
    detections: &[KittiDetection],
    pairs: &[(u32, u32, f64)],
) -> KittiScan {
    let annotations = annotations.iter().zip(0..).map(|(it, annotation)| KittiFact::Annotation {
        annotation,
        object: it.object,
        occlusion: it.occlusion,
        truncation: it.truncation,
    });
    let detections = detections.iter().zip(0..).map(|(it, detection)| KittiFact::Detection {
        detection,
        object: it.object,
        score: it.score,
    });
    let pairs = pairs.iter().map(|&(annotation, detection, overlap)| KittiFact::Pair {
        annotation,
        detection,
        overlap: KittiOverlap { image: overlap, birds_eye: overlap, volume: overlap },
    });
    KittiScan::of(annotations.chain(detections).chain(pairs)).expect("all are there")
}
