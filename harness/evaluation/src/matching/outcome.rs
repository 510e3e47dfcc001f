//! What became of every annotation and every detection of a scan.

use reports::vocabulary::reason::{FalseReason, IgnoredAnnotation, IgnoredDetection, MissReason};
use reports::vocabulary::task::Task;

/// The assignment of one scan for one task, and what follows from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// The task it was made for.
    pub task: Task,
    /// For every annotation of the scan, in order, what became of it.
    pub annotations: Vec<AnnotationOutcome>,
    /// For every detection of the scan, in order, what became of it.
    pub detections: Vec<DetectionOutcome>,
    /// Annotations that are ignored because they are tall, and the detections that found them nevertheless, by annotation.
    pub found_tall: Vec<FoundTall>,
}

impl Assignment {
    /// Says of what was missed, as nothing was found, that the detector gave no answer.
    pub fn say_that_detector_failed(&mut self) {
        for outcome in &mut self.annotations {
            if let AnnotationOutcome::Missed(reason) = outcome {
                *reason = MissReason::DetectorFailed;
            }
        }
    }
}

/// A tall annotation that a detection found which had found nothing that counts. Both are ignored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundTall {
    /// The annotation.
    pub annotation_idx: usize,
    /// The detection.
    pub detection_idx: usize,
    /// What matching them cost, as in [`AnnotationOutcome::Matched`].
    pub cost: f64,
}

/// What became of an annotation.
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

/// What became of a detection.
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
    /// Whether it is false cannot be known: it lies where the labels would not show its kind.
    Unknowable,
}
