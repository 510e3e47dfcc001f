//! Outcome of every annotation and every detection of a scan.

use reports::vocabulary::criterion::CriterionKind;
use reports::vocabulary::reason::{Agreement, FalseReason, IgnoredAnnotation, IgnoredDetection, MissReason};
use reports::vocabulary::task::Task;

/// Assignment of one scan for one task, and the outcomes that follow from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// The task it was made for.
    pub task: Task,
    /// The measure that it was made by.
    pub criterion: CriterionKind,
    /// Outcome of every annotation of the scan, in order.
    pub annotations: Vec<AnnotationOutcome>,
    /// Outcome of every detection of the scan, in order.
    pub detections: Vec<DetectionOutcome>,
    /// Annotations that are ignored because they are tall, and the detections that found them nevertheless, by annotation.
    pub found_tall: Vec<FoundTall>,
}

impl Assignment {
    /// Gives all missed annotations the reason that the detector gave no answer.
    pub fn say_that_detector_failed(&mut self) {
        for outcome in &mut self.annotations {
            if let AnnotationOutcome::Missed(reason) = outcome {
                *reason = MissReason::DetectorFailed;
            }
        }
    }
}

/// A tall annotation, and the detection that found it and that matches no annotation that counts. Both are ignored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundTall {
    /// The annotation.
    pub annotation_idx: usize,
    /// The detection.
    pub detection_idx: usize,
    /// Cost of matching them, as in [`AnnotationOutcome::Matched`].
    pub cost: f64,
}

/// Outcome of an annotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnnotationOutcome {
    /// Not asked for by the task: it belongs to the background.
    NotAsked,
    /// Neither found nor missed.
    Ignored(IgnoredAnnotation),
    /// Found.
    Matched {
        /// By this detection.
        detection_idx: usize,
        /// At this cost; lower is better, the unit is the criterion's.
        cost: f64,
    },
    /// Missed.
    Missed(MissReason),
}

/// Outcome of a detection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DetectionOutcome {
    /// Not of a class the task asks for.
    NotAsked,
    /// Neither right nor false.
    Ignored(IgnoredDetection),
    /// Right.
    Matched {
        /// It found this annotation.
        annotation_idx: usize,
        /// At this cost.
        cost: f64,
    },
    /// False.
    False(FalseReason),
    /// It cannot be known whether it is false: the labels do not cover all objects that it could be. Where nothing is
    /// labelled and there are other detectors, with how many of these have it.
    Unknowable(Option<Agreement>),
}
